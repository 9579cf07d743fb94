// The yardstick of the benches: a bare query of Embree.
#pragma once

#include <embree3/rtcore.h>

#include "kinematics/vector.h"
#include "tests/support/embree_triangles.h"

namespace thimble::test {

// Embree's own way with the same triangles: one rtcIntersect1 from where the surface was last touched to the
// tip.
class EmbreeScene {
 public:
  explicit EmbreeScene(const host::TriangleSoup& soup)
      : device_(rtcNewDevice("threads=1")), scene_(rtcNewScene(device_)) {
    add_triangles(device_, scene_, soup);
    rtcCommitScene(scene_);
  }
  ~EmbreeScene() {
    rtcReleaseScene(scene_);
    rtcReleaseDevice(device_);
  }
  EmbreeScene(const EmbreeScene&) = delete;
  EmbreeScene& operator=(const EmbreeScene&) = delete;

  [[nodiscard]] bool segment(const Vec3& from, const Vec3& to) const {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    const Vec3 way = to - from;
    RTCRayHit query;
    query.ray = {from.x(), from.y(), from.z(), 0.0F,        way.x(), way.y(),
                 way.z(),  0.0F,     1.0F,     0xFFFFFFFFU, 0,       0};
    query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    query.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    rtcIntersect1(scene_, &context, &query);
    return query.hit.geomID != RTC_INVALID_GEOMETRY_ID;
  }

 private:
  RTCDevice device_;
  RTCScene scene_;
};

}  // namespace thimble::test

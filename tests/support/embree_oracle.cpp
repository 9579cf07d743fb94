#include "tests/support/embree_oracle.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <limits>

#include "tests/support/embree_triangles.h"

namespace thimble::test {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

// The context of one ray that counts what it meets.
struct Count {
  RTCIntersectContext context;  // first: Embree hands its address to the filter
  const std::vector<Vector3f>* normals;
  Vector3f direction;
  int sum;
};

// Rejects each hit, so that the ray goes on.
void count_hit(const RTCFilterFunctionNArguments* arguments) {
  auto* const count = reinterpret_cast<Count*>(arguments->context);
  const unsigned face = RTCHitN_primID(arguments->hit, arguments->N, 0);
  count->sum += (*count->normals)[face].dot(count->direction) > 0.0F ? 1 : -1;
  arguments->valid[0] = 0;
}

RTCRay ray_from(const Vector3f& from, const Vector3f& way, float length) {
  return {from.x(), from.y(), from.z(), 0.0F, way.x(), way.y(), way.z(), 0.0F, length, 0xFFFFFFFFU, 0, 0};
}

}  // namespace

EmbreeOracle::EmbreeOracle(const host::TriangleSoup& soup)
    : device_(rtcNewDevice("threads=1")), scene_(rtcNewScene(device_)) {
  rtcSetSceneFlags(scene_, RTC_SCENE_FLAG_ROBUST | RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION);
  if (!soup.triangles.empty()) {
    add_triangles(device_, scene_, soup);
    for (const auto& t : soup.triangles) {
      const Vector3d a = soup.vertices_m[t[0]];
      normals_.push_back(
          (soup.vertices_m[t[1]] - a).cross(soup.vertices_m[t[2]] - a).normalized().cast<float>());
    }
  }
  rtcCommitScene(scene_);
}

EmbreeOracle::~EmbreeOracle() {
  rtcReleaseScene(scene_);
  rtcReleaseDevice(device_);
}

bool EmbreeOracle::crosses(const Vector3d& from, const Vector3d& to) const {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  RTCRay ray = ray_from(from.cast<float>(), (to - from).cast<float>(), 1.0F);
  rtcOccluded1(scene_, &context, &ray);
  return ray.tfar < 0.0F;
}

int EmbreeOracle::signed_hits(const Vector3f& from, const Vector3f& direction) const {
  Count count{{}, &normals_, direction, 0};
  rtcInitIntersectContext(&count.context);
  count.context.filter = count_hit;
  RTCRay ray = ray_from(from, direction, std::numeric_limits<float>::infinity());
  rtcOccluded1(scene_, &count.context, &ray);
  return count.sum;
}

int EmbreeOracle::winding(const Vector3d& p) const {
  static const std::array<Vector3f, 3> kWays = {Vector3f(0.532F, 0.217F, 0.818F),
                                                Vector3f(-0.331F, 0.917F, 0.223F),
                                                Vector3f(0.147F, -0.412F, -0.899F)};
  std::array<int, 3> counts{};
  std::transform(kWays.begin(), kWays.end(), counts.begin(),
                 [&](const Vector3f& way) { return signed_hits(p.cast<float>(), way); });
  std::sort(counts.begin(), counts.end());
  return counts[1];
}

bool EmbreeOracle::in_the_open(const Vector3d& p) const {
  constexpr double kFar_m = 100.0;
  for (int way = 0; way < 27; way += 2) {
    const Vector3d direction(way % 3 - 0.993, way / 3 % 3 - 1.004, way / 9 - 0.997);
    if (!crosses(p, p + kFar_m * direction)) return true;
  }
  return false;
}

}  // namespace thimble::test

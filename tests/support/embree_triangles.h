// A mesh as a scene of Embree.
#pragma once

#include <embree3/rtcore.h>

#include <cstdint>

#include "host-tools/compiler/mesh.h"

namespace thimble::test {

// Adds the triangles to the scene, which is to be committed afterwards. There is at least one.
inline void add_triangles(RTCDevice device, RTCScene scene, const host::TriangleSoup& soup) {
  const RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  auto* vertices = static_cast<float*>(rtcSetNewGeometryBuffer(
      geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float), soup.vertices_m.size()));
  for (const Eigen::Vector3d& vertex : soup.vertices_m) {
    for (int axis = 0; axis < 3; ++axis) *vertices++ = static_cast<float>(vertex[axis]);
  }
  auto* indices = static_cast<unsigned*>(rtcSetNewGeometryBuffer(
      geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(unsigned), soup.triangles.size()));
  for (const auto& triangle : soup.triangles) {
    for (const std::uint32_t index : triangle) *indices++ = index;
  }
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(scene, geometry);
  rtcReleaseGeometry(geometry);
}

}  // namespace thimble::test

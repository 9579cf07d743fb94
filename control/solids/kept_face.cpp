#include "control/solids/kept_face.h"

#include <algorithm>
#include <cstddef>

#include "control/scene/octahedral.h"
#include "control/solids/mesh_topology.h"

namespace thimble::control {

void keep_face(const ShapeData& shape, std::uint32_t triangle, KeptFace& face) {
  constexpr float kPoint_m4 = 1.0e-30F;
  const MeshView& mesh = shape.mesh;
  face.shape = &shape;
  face.triangle = triangle;
  face.slides = !topology::pierced(mesh, triangle);
  face.decoded = false;
  for (std::uint32_t i = 0; i < 3; ++i) face.corner[i] = topology::vertex(mesh, triangle, i);
  const auto& [a, b, c] = face.corner;
  face.normal = (b - a).cross(c - a);
  face.inwards = {face.normal.cross(b - a), face.normal.cross(c - b), face.normal.cross(a - c)};
  face.normal2 = face.normal.squaredNorm();
  face.is_point = face.normal2 <= kPoint_m4;
}

bool shaded_normal_on(KeptFace& face, const MeshView& mesh, std::int8_t side, const Vec3& place,
                      Vec3& normal) {
  if (!face.decoded) {
    const std::uint32_t* const corner = mesh.corner_normals + std::size_t{3} * face.triangle;
    face.smooth = {decode_octahedral(corner[0]), decode_octahedral(corner[1]), decode_octahedral(corner[2])};
    face.decoded = true;
  }
  const auto& [a, b, c] = face.corner;
  const float wb = std::max((place - a).cross(c - a).dot(face.normal), 0.0F);
  const float wc = std::max((b - a).cross(place - a).dot(face.normal), 0.0F);
  const float wa = std::max((b - place).cross(c - place).dot(face.normal), 0.0F);
  const Vec3 mean = wa * face.smooth[0] + wb * face.smooth[1] + wc * face.smooth[2];
  if (!(mean.squaredNorm() > 0.0F)) return false;
  normal = static_cast<float>(side) * mean.normalized();
  return true;
}

}  // namespace thimble::control

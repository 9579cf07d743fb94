// A face of a mesh that a point slides on, kept from tick to tick with what each slide over it and each shaded place on it needs.
// Copies of what is in the image: with or without them a tick gives the same bytes.
#pragma once

#include <array>
#include <cstdint>

#include "control/solids/solid.h"
#include "kinematics/vector.h"

namespace thimble::control {

struct KeptFace {
  const ShapeData* shape = nullptr;  // null: none
  std::uint32_t triangle = 0;
  bool slides = false;         // a slide over the face needs no sweep: nothing crosses it
  bool is_point = false;       // far smaller than the surface tolerance
  bool decoded = false;        // `smooth` is set
  std::array<Vec3, 3> corner;  // m
  // Square to each edge, in the face: normal x edge, as long as both.
  std::array<Vec3, 3> inwards;
  Vec3 normal;                 // twice the area times the unit normal, on the side of the winding
  float normal2 = 0.0F;        // its square
  std::array<Vec3, 3> smooth;  // the unit normals of force shading at the corners
};

void keep_face(const ShapeData& shape, std::uint32_t triangle, KeptFace& face);

// The height of a point over an edge, positive inwards, in units of |normal| |edge| m. Products of dot products would cancel
// on thin triangles.
[[nodiscard]] inline float height_over(const KeptFace& face, std::uint32_t edge, const Vec3& p) {
  return face.inwards[edge].dot(p - face.corner[edge]);
}

// As topology::in_front().
[[nodiscard]] inline bool in_front(const KeptFace& face, std::int8_t side, const Vec3& p) {
  return (face.normal.dot(p - face.corner[0]) >= 0.0F) == (side > 0);
}

// The place of a point in the face's plane.
[[nodiscard]] inline Vec3 project(const KeptFace& face, const Vec3& p) {
  if (face.is_point) return face.corner[0];
  return p - (face.normal.dot(p - face.corner[0]) / face.normal2) * face.normal;
}

// Whether a point lies over the face or under it: a slide towards it ends on the face.
[[nodiscard]] inline bool is_over(const KeptFace& face, const Vec3& p) {
  return !face.is_point && height_over(face, 0, p) >= 0.0F && height_over(face, 1, p) >= 0.0F &&
         height_over(face, 2, p) >= 0.0F;
}

// The interpolated normal at a place on it, by the weights of its corners. False: the shape is as it looks.
[[nodiscard]] bool shaded_normal_on(KeptFace& face, const MeshView& mesh, std::int8_t side, const Vec3& place,
                                    Vec3& normal);

}  // namespace thimble::control

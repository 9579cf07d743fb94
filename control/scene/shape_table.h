// The shapes that a scene image can hold: one row for each member of the union Shape
// (control/scene/scene.fbs). What depends on the kind of a shape asks its row; nothing compares kinds by
// their order. The table is complete, or it does not compile.
//
// A new solid: its struct in scene.fbs (at the end of the union), a file in control/solids/ and a row here. A
// new volume: the same in control/fields/.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "thimble_scene_schema/scene_generated.h"

namespace thimble::control {

struct SolidOps;      // control/solids/solid.h
struct CollisionOps;  // control/bodies/collide.h
struct VolumeOps;     // control/fields/volume.h

extern const SolidOps kPlaneSolid;
extern const SolidOps kSphereSolid;
extern const SolidOps kBoxSolid;
extern const SolidOps kCylinderSolid;
extern const SolidOps kCapsuleSolid;
extern const SolidOps kMeshSolid;
extern const SolidOps kConeSolid;

extern const CollisionOps kPlaneCollision;
extern const CollisionOps kSphereCollision;
extern const CollisionOps kBoxCollision;
extern const CollisionOps kCylinderCollision;
extern const CollisionOps kCapsuleCollision;
extern const CollisionOps kMeshCollision;
extern const CollisionOps kConeCollision;

extern const VolumeOps kVectorFieldVolume;
extern const VolumeOps kPotentialFieldVolume;
extern const VolumeOps kNeedleVolume;
extern const VolumeOps kTissueVolume;
extern const VolumeOps kForceFieldVolume;

enum class ShapeClass : std::uint8_t {
  kSolid,   // a surface that a god object rests on
  kVolume,  // no surface, but a force for every place inside
};

enum class Mobility : std::uint8_t {
  kFixed,
  kMovable,  // it has a mass, so it can be a body
};

struct ShapeRow {
  scene::Shape shape;
  ShapeClass form;
  Mobility mobility;
  const CollisionOps* collision;  // null: a volume
  const SolidOps* solid;          // null: a volume
  const VolumeOps* volume;        // null: a solid
};

namespace shape_table {

constexpr ShapeRow solid(scene::Shape shape, Mobility mobility, const CollisionOps* collision,
                         const SolidOps* ops) {
  return {shape, ShapeClass::kSolid, mobility, collision, ops, nullptr};
}
constexpr ShapeRow volume(scene::Shape shape, const VolumeOps* ops) {
  return {shape, ShapeClass::kVolume, Mobility::kFixed, nullptr, nullptr, ops};
}

}  // namespace shape_table

inline constexpr auto kShapeTable = [] {
  using enum Mobility;
  using scene::Shape;
  using shape_table::solid;
  using shape_table::volume;
  // clang-format off
  return std::to_array<ShapeRow>({
    //    shape            mobility  collision            operations
    solid(Shape::Plane,    kFixed,   &kPlaneCollision,    &kPlaneSolid),
    solid(Shape::Sphere,   kMovable, &kSphereCollision,   &kSphereSolid),
    solid(Shape::Box,      kMovable, &kBoxCollision,      &kBoxSolid),
    solid(Shape::Cylinder, kMovable, &kCylinderCollision, &kCylinderSolid),
    solid(Shape::Capsule,  kMovable, &kCapsuleCollision,  &kCapsuleSolid),
    solid(Shape::Mesh,     kMovable, &kMeshCollision,     &kMeshSolid),
    volume(Shape::VectorField,    &kVectorFieldVolume),
    volume(Shape::PotentialField, &kPotentialFieldVolume),
    volume(Shape::Needle,         &kNeedleVolume),
    volume(Shape::Tissue,         &kTissueVolume),
    solid(Shape::Cone,     kMovable, &kConeCollision,     &kConeSolid),
    volume(Shape::ForceField,     &kForceFieldVolume),
  });
  // clang-format on
}();

namespace shape_table {

// Row i belongs to member i + 1 of the union: member 0 is NONE.
constexpr bool complete() {
  for (std::size_t i = 0; i < kShapeTable.size(); ++i) {
    if (static_cast<std::size_t>(kShapeTable[i].shape) != i + 1) return false;
  }
  return kShapeTable.size() == static_cast<std::size_t>(scene::Shape::MAX);
}
static_assert(complete(), "every member of the union Shape has its row, in the union's order");

}  // namespace shape_table

// Null for NONE and for what a later image may hold: SceneView::check() refuses both.
[[nodiscard]] constexpr const ShapeRow* find_shape(scene::Shape shape) noexcept {
  const auto member = static_cast<std::size_t>(shape);
  return member == 0 || member > kShapeTable.size() ? nullptr : &kShapeTable[member - 1];
}

// Of an object in a checked image.
[[nodiscard]] constexpr const ShapeRow& shape_row(scene::Shape shape) noexcept {
  const ShapeRow* row = find_shape(shape);
  return row != nullptr ? *row : kShapeTable.front();
}

[[nodiscard]] constexpr bool is_volume(scene::Shape shape) noexcept {
  return shape_row(shape).form == ShapeClass::kVolume;
}

}  // namespace thimble::control

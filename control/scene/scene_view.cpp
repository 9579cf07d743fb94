#include "control/scene/scene_view.h"

#include <array>
#include <bit>
#include <cstdint>

#include "control/contact/world.h"
#include "control/scene/check.h"
#include "control/scene/limits.h"
#include "control/scene/mesh_leaf.h"
#include "thimble_scene_schema/scene_generated.h"

namespace thimble::control {
namespace {

constexpr std::uint32_t kNone = 0xFFFFFFFFU;

ImageVerdict check_material(const scene::Material& m) {
  return require(in_range(m.stiffness_n_per_m(), 0.0F, kMaxStiffness_N_m) &&
                     in_range(m.damping_n_s_per_m(), 0.0F, kMaxDamping_N_s_m) &&
                     in_range(m.static_friction(), 0.0F, kMaxFriction) &&
                     in_range(m.dynamic_friction(), 0.0F, m.static_friction()) &&
                     m.friction_mode() <= scene::FrictionMode::MAX,
                 ImageStatus::kBadNumber);
}

ImageVerdict check_pose(const scene::Pose& pose) {
  const scene::Quat& q = pose.rotation();
  return require(is_coordinate(pose.position_m()) &&
                     is_unit(q.w() * q.w() + q.x() * q.x() + q.y() * q.y() + q.z() * q.z()),
                 ImageStatus::kBadNumber);
}

ImageVerdict check_triangles(const scene::Mesh& mesh, Pauses& pauses) {
  const std::uint32_t vertices = mesh.vertices()->size();
  const std::uint32_t triangles = mesh.triangles()->size();
  for (std::uint32_t i = 0; i < triangles; ++i) {
    pauses.step();
    const scene::Triangle& triangle = *mesh.triangles()->Get(i);
    const auto& v = *triangle.vertex();
    for (std::uint16_t corner = 0; corner < 3; ++corner) {
      if (v[corner] >= vertices) return ImageStatus::kBadIndex;
    }
    if (v[0] == v[1] || v[1] == v[2] || v[2] == v[0]) return ImageStatus::kBadIndex;
  }
  // A neighbour shares the edge it is the neighbour across, so that a walk over the surface is never torn.
  for (std::uint32_t i = 0; i < triangles; ++i) {
    pauses.step();
    const scene::Triangle& triangle = *mesh.triangles()->Get(i);
    for (std::uint16_t edge = 0; edge < 3; ++edge) {
      const std::uint32_t neighbour = (*triangle.neighbour())[edge];
      if (neighbour == kNone) continue;
      const std::uint32_t there = neighbour & 3U;
      if ((neighbour >> 2U) >= triangles || (neighbour >> 2U) == i || there == 3U)
        return ImageStatus::kBadIndex;
      const auto& other = *mesh.triangles()->Get(neighbour >> 2U)->vertex();
      const std::uint32_t a = (*triangle.vertex())[edge];
      const std::uint32_t b =
          (*triangle.vertex())[edge == 2 ? std::uint16_t{0} : static_cast<std::uint16_t>(edge + 1)];
      const std::uint32_t c = other[static_cast<std::uint16_t>(there)];
      const std::uint32_t d = other[static_cast<std::uint16_t>(there == 2 ? 0 : there + 1)];
      if (!((a == c && b == d) || (a == d && b == c))) return ImageStatus::kBadIndex;
    }
  }
  return ImageStatus::kOk;
}

// Walks the whole tree: every node once, no deeper than a sweep's stack, every leaf inside the triangles.
ImageVerdict check_tree(const scene::Mesh& mesh, Pauses& pauses) {
  const std::uint32_t nodes = mesh.nodes()->size();
  const std::uint32_t triangles = mesh.triangles()->size();
  std::array<std::uint32_t, kMaxBvhDepth> stack{};
  std::size_t depth = 0;
  stack[depth++] = 0;
  for (std::uint32_t visited = 0; depth > 0; ++visited) {
    pauses.step();
    if (visited == nodes) return ImageStatus::kBadTree;
    const std::uint32_t at = stack[--depth];
    const auto& child = *mesh.nodes()->Get(at)->child();
    for (std::uint16_t c = 0; c < 2; ++c) {
      if (c == 1 && child[1] == child[0]) break;  // a node with one child repeats it
      if (is_leaf(child[c])) {
        const std::uint32_t first = first_triangle(child[c]);
        if (first >= triangles || triangle_count(child[c]) > triangles - first) return ImageStatus::kBadTree;
        continue;
      }
      if (child[c] <= at || child[c] >= nodes || depth == stack.size()) return ImageStatus::kBadTree;
      stack[depth++] = child[c];
    }
  }
  return ImageStatus::kOk;
}

ImageVerdict check_mesh(const scene::Mesh& mesh, std::size_t& triangles_in_scene, Pauses& pauses) {
  const std::uint32_t triangles = mesh.triangles()->size();
  triangles_in_scene += triangles;
  RETURN_IF_BAD(at_most(kMaxTriangles, triangles_in_scene, "triangles", ImageStatus::kTooManyTriangles));
  if (triangles == 0 || mesh.vertices()->size() == 0 || mesh.nodes()->size() == 0)
    return ImageStatus::kBadIndex;
  if (mesh.flags()->size() != triangles) return ImageStatus::kBadIndex;
  if (mesh.corner_normals() != nullptr && mesh.corner_normals()->size() != std::size_t{3} * triangles) {
    return ImageStatus::kBadIndex;
  }
  if (mesh.grid_origin_m() == nullptr || !is_coordinate(*mesh.grid_origin_m()))
    return ImageStatus::kBadNumber;
  constexpr float kSmallestStep_m = 1.0e-12F;
  if (!in_range(mesh.grid_step_m(), kSmallestStep_m, kMaxCoordinate_m)) return ImageStatus::kBadNumber;
  for (const scene::Vertex* vertex : *mesh.vertices()) {
    pauses.step();
    if (!is_coordinate(vertex->position_m()) || !is_coordinate(vertex->pseudonormal()))
      return ImageStatus::kBadNumber;
  }
  RETURN_IF_BAD(check_triangles(mesh, pauses));
  return check_tree(mesh, pauses);
}

ImageVerdict check_shape(const scene::Object& object, std::size_t& triangles_in_scene, Pauses& pauses) {
  switch (object.shape_type()) {
    case scene::Shape::NONE:
      return ImageStatus::kNoShape;
    case scene::Shape::Plane: {
      const scene::Plane& plane = *object.shape_as_Plane();
      return require(
          is_unit(plane.normal()) && in_range(plane.offset_m(), -kMaxCoordinate_m, kMaxCoordinate_m),
          ImageStatus::kBadNumber);
    }
    case scene::Shape::Sphere:
      return require(is_size(object.shape_as_Sphere()->radius_m()), ImageStatus::kBadNumber);
    case scene::Shape::Box: {
      const scene::Vec3& half = object.shape_as_Box()->half_size_m();
      return require(is_size(half.x()) && is_size(half.y()) && is_size(half.z()), ImageStatus::kBadNumber);
    }
    case scene::Shape::Cylinder: {
      const scene::Cylinder& c = *object.shape_as_Cylinder();
      return require(is_size(c.radius_m()) && is_size(c.half_height_m()), ImageStatus::kBadNumber);
    }
    case scene::Shape::Capsule: {
      const scene::Capsule& c = *object.shape_as_Capsule();
      return require(is_size(c.radius_m()) && in_range(c.half_height_m(), 0.0F, kMaxCoordinate_m),
                     ImageStatus::kBadNumber);
    }
    case scene::Shape::Mesh:
      return check_mesh(*object.shape_as_Mesh(), triangles_in_scene, pauses);
    case scene::Shape::VectorField:
    case scene::Shape::PotentialField:
    case scene::Shape::Needle:
    case scene::Shape::Tissue:
      return check_volume(object, pauses);
  }
  return ImageStatus::kNoShape;
}

}  // namespace

ImageVerdict SceneView::check(std::span<const std::byte> bytes, SceneView& view, Pause pause) noexcept {
  RETURN_IF_BAD(at_most(kMaxImageBytes, bytes.size(), "bytes", ImageStatus::kTooLarge));
  if (std::bit_cast<std::uintptr_t>(bytes.data()) % 8 != 0) return ImageStatus::kMisaligned;
  const auto* data = reinterpret_cast<const std::uint8_t*>(bytes.data());
  // Scene -> object -> surface -> texture is 4 tables deep; an object has at most itself, its shape with subvolumes, its surface
  // with texture and map, its body with a control.
  constexpr std::size_t kDepth = 8;
  constexpr std::size_t kTables = 1 + (7 + kMaxSubvolumes) * kMaxObjects;
  flatbuffers::Verifier verifier(data, bytes.size(), kDepth, kTables);
  if (bytes.size() < 2 * sizeof(std::uint32_t) || !scene::VerifySceneBuffer(verifier))
    return ImageStatus::kNotAScene;
  const scene::Scene* scene = scene::GetScene(data);
  RETURN_IF_BAD(at_most(kMaxObjects, scene->objects()->size(), "objects", ImageStatus::kTooManyObjects));
  Pauses pauses(pause);
  std::size_t triangles = 0;
  std::size_t bodies = 0;
  std::size_t volumes = 0;
  if (scene->gravity_m_per_s2() != nullptr) {
    RETURN_IF_BAD(require(is_coordinate(*scene->gravity_m_per_s2()), ImageStatus::kBadNumber));
  }
  for (const scene::Object* object : *scene->objects()) {
    if (object->shape() == nullptr) return ImageStatus::kNoShape;
    RETURN_IF_BAD(check_shape(*object, triangles, pauses));
    RETURN_IF_BAD(check_pose(*object->pose()));
    RETURN_IF_BAD(check_material(*object->material()));
    RETURN_IF_BAD(check_surface(*object, pauses));
    RETURN_IF_BAD(check_body(*object));
    if (object->body() != nullptr) ++bodies;
    if (is_volume(object->shape_type())) ++volumes;
    RETURN_IF_BAD(at_most(kMaxBodies, bodies, "objects that move", ImageStatus::kTooManyBodies));
    RETURN_IF_BAD(at_most(kMaxVolumes, volumes, "volumes", ImageStatus::kTooManyObjects));
  }
  view.scene_ = scene;
  return ImageStatus::kOk;
}

}  // namespace thimble::control

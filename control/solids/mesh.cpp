// A triangle mesh.
#include "control/solids/mesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "control/bodies/collide.h"
#include "control/scene/check.h"
#include "control/scene/octahedral.h"
#include "control/solids/mesh_topology.h"

namespace thimble::control {

using namespace topology;  // NOLINT(google-build-using-namespace): this file is about nothing else

Vec3 topology::pseudonormal(const MeshView& mesh, std::uint32_t triangle, std::uint32_t corner) {
  return decode_octahedral(mesh.vertices[vertex_index(mesh, triangle, corner)].pseudonormal());
}

Corner topology::next_in_fan(const MeshView& mesh, const Corner& at) {
  const Step step = across(mesh, at.triangle, at.side, fan_edge(at.corner, at.side));
  const std::uint32_t v = vertex_index(mesh, at.triangle, at.corner);
  const std::uint32_t corner =
      vertex_index(mesh, step.triangle, step.edge) == v ? step.edge : next(step.edge);
  return {step.triangle, corner, step.side};
}

MeshView view_mesh(const scene::Mesh& mesh) noexcept {
  MeshView view;
  view.vertices = mesh.vertices()->Get(0);
  view.triangles = mesh.triangles()->Get(0);
  view.flags = mesh.flags()->data();
  view.corner_normals = mesh.corner_normals() != nullptr ? mesh.corner_normals()->data() : nullptr;
  view.nodes = mesh.nodes()->Get(0);
  if (mesh.texture_weights() != nullptr) view.texture_weights = mesh.texture_weights()->data();
  if (mesh.texture_corners() != nullptr) {
    view.texture_corners = mesh.texture_corners()->data();
    view.texture_points = mesh.texture_points()->Get(0);
  }
  if (mesh.piece_ends() != nullptr && mesh.piece_ends()->size() > 0) {
    view.piece_corners = mesh.piece_corners()->Get(0);
    view.piece_ends = mesh.piece_ends()->data();
    view.piece_count = mesh.piece_ends()->size();
  }
  if (mesh.grid_origin_m() != nullptr) {
    view.grid_origin_m = {mesh.grid_origin_m()->x(), mesh.grid_origin_m()->y(), mesh.grid_origin_m()->z()};
  }
  view.grid_step_m = mesh.grid_step_m();
  view.seams = mesh.seams();
  view.rims = mesh.rims() != nullptr ? mesh.rims()->data() : nullptr;
  view.grid_scale = 1.0F / view.grid_step_m;
  return view;
}

namespace {

ImageVerdict check(const scene::Object& object, std::size_t& triangles_in_scene, Pauses& pauses) {
  return check_mesh(*object.shape_as_Mesh(), triangles_in_scene, pauses);
}

void view(const scene::Object& object, ShapeData& shape) { shape.mesh = view_mesh(*object.shape_as_Mesh()); }

// Whether the opposite vertex of the face beyond an edge lies in front of this face or in its plane.
bool opens_or_flat(const MeshView& mesh, std::uint32_t triangle, std::int8_t side, const Step& beyond) {
  if (beyond.triangle == triangle) return false;
  constexpr float kFlat = 1.0e-5F;
  const Vec3 normal = static_cast<float>(side) * area_normal(mesh, triangle);
  const Vec3 arm = vertex(mesh, beyond.triangle, previous(beyond.edge)) - vertex(mesh, triangle, 0);
  return normal.dot(arm) >= -kFlat * normal.norm() * arm.norm();
}

// At a concave vertex: the distinct planes of its faces. At every other vertex one plane represents them.
int vertex_normals(const MeshView& mesh, const Feature& f, std::span<Vec3, 3> out) {
  constexpr float kSame = 0.9999F;
  std::size_t count = 0;
  bool hollow = true;
  Corner at{f.index, f.corner, f.side};
  for (int n = 0; n < kMaxFan && hollow; ++n) {
    const Vec3 normal = static_cast<float>(at.side) * area_normal(mesh, at.triangle).normalized();
    bool seen = false;
    for (std::size_t i = 0; i < count; ++i) seen = seen || out[i].dot(normal) > kSame;
    if (!seen) {
      if (count == out.size()) {
        hollow = false;
        break;
      }
      out[count++] = normal;
    }
    hollow = opens_or_flat(mesh, at.triangle, at.side,
                           across(mesh, at.triangle, at.side, fan_edge(at.corner, at.side)));
    at = next_in_fan(mesh, at);
    if (at.triangle == f.index && at.side == f.side) break;
  }
  if (hollow) return static_cast<int>(count);
  out[0] = static_cast<float>(f.side) * pseudonormal(mesh, f.index, f.corner);
  return 1;
}

int normals(const ShapeData& shape, const Feature& f, const Vec3& /*point*/, std::span<Vec3, 3> out) {
  const MeshView& mesh = shape.mesh;
  if (f.kind == kVertex) return vertex_normals(mesh, f, out);
  out[0] = static_cast<float>(f.side) * area_normal(mesh, f.index).normalized();
  if (f.kind == kFace) return 1;
  const Step beyond = across(mesh, f.index, f.side, f.corner);
  if (!concave(mesh, f.index, f.side, beyond)) return 1;
  out[1] = static_cast<float>(beyond.side) * area_normal(mesh, beyond.triangle).normalized();
  return 2;
}

Vec3 reach(const ShapeData& shape) {
  constexpr float kGridSteps = 65536.0F;
  const Vec3 lo = shape.mesh.grid_origin_m;
  const Vec3 hi = lo + Vec3::Constant(kGridSteps * shape.mesh.grid_step_m);
  return lo.cwiseAbs().cwiseMax(hi.cwiseAbs());
}

}  // namespace

const SolidOps kMeshSolid{.check = check,
                          .view = view,
                          .sweep = sweep_mesh,
                          .slide = slide_on_mesh,
                          .separate = separate_mesh,
                          .touches = touches_mesh,
                          .roll = roll_on_mesh,
                          .contains = mesh_contains,
                          .normals = normals,
                          .reach = reach,
                          .chart = chart_on_mesh,
                          .blend = blend_on_mesh,
                          .walks = true};
const CollisionOps kMeshCollision{.form = CollisionForm::kMesh};

}  // namespace thimble::control

#include "control/bodies/pair_collision.h"

#include <algorithm>

#include "thimble_scene_schema/scene_generated.h"

namespace thimble::control {
namespace {

CollisionForm form_of(const PlacedObject& object) { return object.row->collision->form; }
bool is_mesh(const PlacedObject& object) { return form_of(object) == CollisionForm::kMesh; }

bool has_triangles_only(const PlacedObject& object) {
  return is_mesh(object) && object.shape.mesh.piece_count == 0;
}

// The convex parts of an object: the pieces of a moving mesh, or the solid itself.
std::size_t parts(const PlacedObject& object) { return is_mesh(object) ? object.shape.mesh.piece_count : 1; }

Convex part(const PlacedObject& object, std::size_t i, const Mat3& rotation, const Vec3& position_m,
            Work* work) {
  Convex convex = is_mesh(object) ? convex_hull(object.shape.mesh.piece(i), rotation, position_m)
                                  : convex_solid(object, rotation, position_m);
  constexpr std::size_t kPartCornersPerUnit = 8;
  convex.work = work;
  work->charge(2 + static_cast<std::uint32_t>(convex.corners.size() / kPartCornersPerUnit));
  return convex;
}

// Of a closed form, by what it does for each place of the surface that it looks at.
std::uint32_t closed_form_work(const PlacedObject& a, const PlacedObject& b) {
  constexpr std::uint32_t kBallWork = 2;
  constexpr std::uint32_t kCapsuleWork = 24;
  constexpr std::uint32_t kBoxesWork = 20;
  constexpr std::uint32_t kOthersWork = 6;
  const CollisionForm of_a = form_of(a);
  const CollisionForm of_b = form_of(b);
  if (of_a == CollisionForm::kBall || of_b == CollisionForm::kBall) return kBallWork;
  if (of_b == CollisionForm::kHalfSpace) return kOthersWork;
  if (of_a == CollisionForm::kCapsule || of_b == CollisionForm::kCapsule) return kCapsuleWork;
  return of_a == CollisionForm::kBox && of_b == CollisionForm::kBox ? kBoxesWork : kOthersWork;
}

}  // namespace

void PairCollision::begin(const PlacedObject& a, const PlacedObject& b) noexcept {
  i_ = j_ = 0;
  begun_ = false;
  if (!is_mesh(a) && !is_mesh(b)) {
    kind_ = Kind::kClosedForm;
  } else if (form_of(b) == CollisionForm::kHalfSpace) {
    kind_ = Kind::kCorners;
  } else if (has_triangles_only(b)) {
    kind_ = Kind::kTriangles;
  } else {
    kind_ = has_triangles_only(a) ? Kind::kTrianglesOfA : Kind::kParts;
  }
}

bool PairCollision::step(const PlacedObject& a, const PlacedObject& b, float margin_m, Work& work,
                         Manifold& out) noexcept {
  out.work = part_a_.work = part_b_.work = &work;
  switch (kind_) {
    case Kind::kClosedForm:
      work.charge(closed_form_work(a, b));
      if (collide_in_closed_form(a, b, margin_m, out)) return true;
      kind_ = Kind::kParts;
      return false;
    case Kind::kCorners:
      return meet_corners(a, b, margin_m, i_, j_, out);
    case Kind::kParts:
      return meet_parts(a, b, margin_m, out);
    case Kind::kTriangles:
      return meet_triangles(a, b, margin_m, out);
    case Kind::kTrianglesOfA:
      if (!meet_triangles(b, a, margin_m, out)) return false;
      flip_normals(out);
      return true;
  }
  return true;
}

bool meet_corners(const PlacedObject& a, const PlacedObject& plane, float margin_m, std::size_t& piece,
                  std::size_t& corner, Manifold& out) noexcept {
  constexpr std::size_t kAtOnce = 8;
  constexpr std::uint32_t kWork = 5;
  out.work->charge(kWork);
  if (piece == parts(a)) return true;
  const std::span<const scene::Vec3> corners = a.shape.mesh.piece(piece);
  const std::size_t end = std::min(corner + kAtOnce, corners.size());
  for (; corner < end; ++corner)
    collide_point_with_plane(plane, a.to_world(to_vec(corners[corner])), margin_m, out);
  if (corner < corners.size()) return false;
  corner = 0;
  return ++piece == parts(a);
}

bool PairCollision::meet_parts(const PlacedObject& a, const PlacedObject& b, float margin_m,
                               Manifold& out) noexcept {
  if (!begun_) {
    begun_ = true;
    if (j_ == 0) part_a_ = part(a, i_, a.rotation, Vec3::Zero(), out.work);
    part_b_ = part(b, j_, b.rotation, b.position_m - a.position_m, out.work);
    convex_.begin();
  }
  if (!convex_.step(part_a_, part_b_, margin_m, out)) return false;
  begun_ = false;
  if (++j_ < parts(b)) return false;
  j_ = 0;
  if (++i_ < parts(a)) return false;
  for (std::size_t i = 0; i < out.count; ++i) out.points[i].point_m += a.position_m;
  return true;
}

// b is a mesh without pieces.
bool PairCollision::meet_triangles(const PlacedObject& a, const PlacedObject& b, float margin_m,
                                   Manifold& out) noexcept {
  if (i_ == parts(a)) return true;
  const MeshView& mesh = b.shape.mesh;
  if (!begun_) {
    begun_ = true;
    const Vec3 position = b.rotation.transpose() * (a.position_m - b.position_m);
    part_a_ = part(a, i_, b.rotation.transpose() * a.rotation, position, out.work);
    mesh_.begin(part_a_, mesh, margin_m);
  }
  if (!mesh_.step(part_a_, mesh, margin_m, *out.work, out)) return false;
  begun_ = false;
  if (++i_ < parts(a)) return false;
  for (std::size_t i = 0; i < out.count; ++i) {
    ContactPoint& point = out.points[i];
    point.point_m = b.rotation * point.point_m + b.position_m;
    point.normal = b.rotation * point.normal;
  }
  return true;
}

bool meet_plane(const PlacedObject& a, const PlacedObject& plane, std::size_t& piece, std::size_t& corner,
                Manifold& out) noexcept {
  if (is_mesh(a)) {
    if (!meet_corners(a, plane, 0.0F, piece, corner, out)) return false;
    piece = 0;
    return true;
  }
  out.work->charge(closed_form_work(a, plane));
  static_cast<void>(collide_in_closed_form(a, plane, 0.0F, out));
  return true;
}

}  // namespace thimble::control

#include "control/bodies/collide_triangle.h"

#include <algorithm>
#include <cmath>

namespace thimble::control {

using namespace topology;  // NOLINT(google-build-using-namespace): this file is about nothing else

namespace {

constexpr int kMaxTried = 256;         // triangles whose plane and box the solid reaches
constexpr int kMaxMeshTriangles = 48;  // of these: that give contacts
constexpr int kMaxLevel = 8;           // triangles in one plane
constexpr int kMaxPassedOver = 16;     // triangles in one plane: the nodes that remain reach no deeper
// Sine of the angle by which a neighbour may rise in the direction of a contact: a ball that rolls over a level edge is
// nearer to it than to the face by 2e-6 of its radius there.
constexpr float kRise = 2.0e-3F;
constexpr float kLevel_m = 1.0e-6F;
// Cosine: a direction of contact that is the face's (above what kRise lets pass).
constexpr float kAlongFace = 1.0F - 8.0e-6F;

using TriangleCorners = std::array<scene::Vec3, 3>;

TriangleCorners corners_of(const std::array<Vec3, 3>& p) {
  TriangleCorners out;
  for (std::size_t i = 0; i < 3; ++i) out[i] = scene::Vec3(p[i].x(), p[i].y(), p[i].z());
  return out;
}

// A lambda: the algorithm calls it directly, not through a pointer.
constexpr auto shallower = [](const auto& x, const auto& y) { return x.depth_m < y.depth_m; };

}  // namespace

void TriangleCollision::begin(const Convex& a, const MeshView& mesh, const Vec3& free_m, float margin_m,
                              Manifold& out) {
  a_ = &a;
  mesh_ = &mesh;
  margin_m_ = margin_m;
  out_ = &out;
  free_m_ = free_m;
  centre_m_ = a.rotation.transpose() * (a.centre_m - a.position_m);
  inner_m_ = a.centre_m;
  ball_m_ = 0.0F;
  level_ = passed_over_ = tried_ = triangles_ = searches_ = 0;
  deferred_count_ = 0;
  met_all_ = true;
  lost_ = searches_one_ = false;
  normals_ = Vec3::Zero();
  if (a.corners.empty()) return;
  float radius2 = 0.0F;
  Vec3 sum = Vec3::Zero();
  for (const scene::Vec3& corner : a.corners) {
    const Vec3 p = to_vec(corner);
    sum += p;
    radius2 = std::max(radius2, (p - centre_m_).squaredNorm());
  }
  ball_m_ = std::sqrt(radius2);
  inner_m_ = a.rotation * (sum / static_cast<float>(a.corners.size())) + a.position_m;
}

bool TriangleCollision::at_bound() const {
  return triangles_ == kMaxMeshTriangles || tried_ == kMaxTried || passed_over_ == kMaxPassedOver;
}

// Where the triangle is. False when it is outside of the box about the solid, or has no area.
bool TriangleCollision::place(std::uint32_t triangle, Face& face) const {
  face.triangle = triangle;
  for (std::uint32_t i = 0; i < 3; ++i) {
    face.p[i] = vertex(*mesh_, triangle, i);
    face.of[i] = a_->rotation.transpose() * (face.p[i] - a_->position_m);
  }
  face.lo = face.of[0].cwiseMin(face.of[1]).cwiseMin(face.of[2]);
  face.hi = face.of[0].cwiseMax(face.of[1]).cwiseMax(face.of[2]);
  const Vec3 half = a_->half_m.array() + margin_m_;
  if (((face.lo - centre_m_).array() > half.array()).any() ||
      ((centre_m_ - face.hi).array() > half.array()).any())
    return false;
  const Vec3 area = (face.p[1] - face.p[0]).cross(face.p[2] - face.p[0]);
  const float length = area.norm();
  if (!(length > 0.0F)) return false;
  face.normal = area / length;
  face.side = 1.0F;
  if (two_sided(*mesh_, triangle) && face.normal.dot(free_m_ - face.p[0]) < 0.0F) {
    face.normal = -face.normal;
    face.side = -1.0F;
  }
  return true;
}

// Whether the only corner of the triangle that can touch is the place of a contact that is found already.
bool TriangleCollision::is_known(const Face& face) const {
  for (std::size_t i = 0; i < out_->count; ++i) {
    const ContactPoint& found = out_->points[i];
    const Vec3 place = found.point_m + (0.5F * found.depth_m) * found.normal;
    for (const Vec3& corner : face.p) {
      const Vec3 from = corner - place;
      if (std::abs(from.x()) < kLevel_m && from.squaredNorm() < kLevel_m * kLevel_m &&
          height_of(face.p, found.normal) - found.normal.dot(place) < kLevel_m)
        return is_alone(face, found.normal, found.depth_m);
    }
  }
  return false;
}

// Whether the triangle lies in the plane of contacts that are found already.
bool TriangleCollision::is_level(const Face& face) const {
  for (std::size_t i = 0; i < out_->count; ++i) {
    const ContactPoint& found = out_->points[i];
    if (found.normal.dot(face.normal) > kSameLine &&
        std::abs(face.normal.dot(face.p[0] - found.point_m) - 0.5F * found.depth_m) < kLevel_m)
      return true;
  }
  return false;
}

void TriangleCollision::offer(const Face& face, const Vec3& normal, Overlap& best) const {
  const float depth_m = height_of(face.p, normal) - normal.dot(a_->farthest(-normal).at_m) + a_->radius_m;
  if (depth_m >= best.depth_m - kSooner_m) return;
  best.depth_m = depth_m;
  best.normal = normal;
}

// The normals of the faces beyond the edges and at the corners: where the solid is deep below this face it is beside one of them.
void TriangleCollision::offer_neighbours(const Face& face, Overlap& best) const {
  const auto side = static_cast<std::int8_t>(face.side > 0.0F ? 1 : -1);
  for (std::uint32_t edge = 0; edge < 3; ++edge) {
    const Step beyond = across(*mesh_, face.triangle, side, edge);
    if (beyond.triangle == face.triangle || concave(*mesh_, face.triangle, side, beyond)) continue;
    const Vec3 area = static_cast<float>(beyond.side) * area_normal(*mesh_, beyond.triangle);
    const float length = area.norm();
    if (length > 0.0F) offer(face, area / length, best);
  }
  // A direction between the faces leads to the nearest of them, which one along a face does not.
  for (std::uint32_t corner = 0; corner < 3; ++corner)
    offer(face, face.side * pseudonormal(*mesh_, face.triangle, corner), best);
}

bool TriangleCollision::rises_round_corner(std::uint32_t triangle, std::uint32_t corner,
                                           const Vec3& normal) const {
  const Vec3 p = vertex(*mesh_, triangle, corner);
  Corner at{triangle, corner, 1};
  for (int n = 0; n < kMaxFan; ++n) {
    const Vec3 arm = vertex(*mesh_, at.triangle, next(at.corner)) - p;
    const Vec3 other = vertex(*mesh_, at.triangle, previous(at.corner)) - p;
    if (normal.dot(arm) > kRise * arm.norm() || normal.dot(other) > kRise * other.norm()) return true;
    at = next_in_fan(*mesh_, at);
    if (at.triangle == triangle && at.side > 0) return false;
  }
  return false;
}

// Whether the mesh goes on beyond the highest edge or corner of the triangle and rises there.
bool TriangleCollision::rises(std::uint32_t triangle, const Vec3& normal) const {
  std::array<Vec3, 3> p;
  std::array<float, 3> height;
  for (std::uint32_t i = 0; i < 3; ++i) {
    p[i] = vertex(*mesh_, triangle, i);
    height[i] = normal.dot(p[i]);
  }
  const auto top =
      static_cast<std::uint32_t>(std::max_element(height.begin(), height.end()) - height.begin());
  bool level = false;
  for (const std::uint32_t edge : {top, previous(top)}) {  // the two edges at the top
    const std::uint32_t from = edge;
    const std::uint32_t to = next(edge);
    const Vec3 along = p[to] - p[from];
    const float length = along.norm();
    if (std::abs(height[to] - height[from]) > kRise * length) continue;  // it falls off
    const Step beyond = across(*mesh_, triangle, 1, edge);
    level = true;
    if (beyond.triangle == triangle) continue;
    const Vec3 arm = vertex(*mesh_, beyond.triangle, previous(beyond.edge)) - p[from];
    const Vec3 off = arm - (arm.dot(along) / (length * length)) * along;
    if (normal.dot(off) > kRise * off.norm()) return true;
  }
  return !level && rises_round_corner(triangle, top, normal);
}

// Keeps a triangle for the search: of more than kMaxDeferred the deepest ones. Of a hull most of what comes here is beside
// it: the first direction is from the triangle to its middle, along which that is seen at once.
void TriangleCollision::defer(const Face& face, Overlap overlap) {
  if (a_->nearest == nullptr) {
    const Vec3 aside = a_->centre_m - nearest_on_triangle(face.p, a_->centre_m);
    if (aside.dot(face.normal) > 0.0F) offer(face, aside.normalized(), overlap);
    if (overlap.depth_m < -margin_m_) return;
  }
  Deferred* to = nullptr;
  if (deferred_count_ < deferred_.size()) {
    to = &deferred_[deferred_count_++];
  } else {
    lost_ = true;
    to = &*std::min_element(deferred_.begin(), deferred_.end(), shallower);
    if (to->depth_m >= overlap.depth_m) return;
  }
  *to = {face.triangle, overlap.depth_m, overlap.normal};
}

// False when they are apart, or no direction is found.
bool TriangleCollision::push_out_line(const Face& face, Overlap& overlap) const {
  const TriangleCorners corners = corners_of(face.p);
  NearestPair pair;
  const Distance distance =
      nearest_points(*a_, convex_triangle(corners), Vec3::Zero(), face.normal, margin_m_, pair);
  if (distance == Distance::kApart) return false;
  if (distance == Distance::kNearest && pair.apart_m.dot(face.normal) > 0.0F) {
    push_out(pair.of_a_m, pair.apart_m, overlap);
    return overlap.depth_m >= -margin_m_;
  }
  // The line of the capsule goes through the triangle.
  overlap.of_core_m = a_->farthest(-face.normal).at_m;
  overlap.normal = face.normal;
  overlap.depth_m = face.normal.dot(face.p[0] - overlap.of_core_m) + a_->radius_m;
  return true;
}

// One step of the search of the triangle `searched_`. True: it has ended, and what it found bounds the overlap of the others as well.
bool TriangleCollision::search() {
  if (a_->form == CollisionForm::kCapsule) {
    if (push_out_line(searched_, searched_overlap_)) add(searched_, searched_overlap_, false);
  } else {
    const TriangleCorners corners = corners_of(searched_.p);
    if (!search_.step(*a_, convex_triangle(corners), margin_m_)) return false;
    searched_overlap_ = search_.overlap();
    if (search_.found()) {
      lost_ = lost_ || !searched_overlap_.settled;
      if (searched_overlap_.settled) add(searched_, searched_overlap_, false);
    }
  }
  const Vec3& normal = searched_overlap_.normal;
  const float lowest_m = normal.dot(a_->farthest(-normal).at_m) - a_->radius_m;
  std::array<Vec3, 3> p;
  for (std::size_t i = 0; i < deferred_count_; ++i) {
    Deferred& other = deferred_[i];
    for (std::uint32_t corner = 0; corner < 3; ++corner) p[corner] = vertex(*mesh_, other.triangle, corner);
    const float depth_m = height_of(p, normal) - lowest_m;
    if (depth_m >= other.depth_m - kSooner_m) continue;
    other.depth_m = depth_m;
    other.normal = normal;
  }
  return true;
}

// The deepest one first.
bool TriangleCollision::finish() {
  if (searches_one_) {
    searches_one_ = !search();
    return false;
  }
  if (deferred_count_ == 0) return true;
  Deferred& at = *std::max_element(
      deferred_.begin(), deferred_.begin() + static_cast<std::ptrdiff_t>(deferred_count_), shallower);
  if (at.depth_m < -margin_m_) return true;
  if (searches_++ == kMaxSearches) {
    lost_ = true;
    return true;
  }
  searched_overlap_ = {};
  searched_overlap_.normal = at.normal;
  searched_overlap_.depth_m = at.depth_m;
  const bool placed = place(at.triangle, searched_);
  at = deferred_[--deferred_count_];
  searches_one_ = placed && !is_known(searched_);
  search_.begin(searched_overlap_);
  return false;
}

// Whether only one corner of the triangle can touch along the normal.
bool TriangleCollision::is_alone(const Face& face, const Vec3& normal, float depth_m) const {
  const float reach_m = height_of(face.p, normal) - std::max(depth_m, 0.0F) - margin_m_ - kLevel_m;
  int near = 0;
  for (const Vec3& corner : face.p) {
    if (normal.dot(corner) > reach_m) ++near;
  }
  return near == 1;
}

// corner: a corner of the triangle touches the solid, and none below it.
bool TriangleCollision::add(const Face& face, Overlap& overlap, bool corner) {
  if (overlap.normal.dot(face.normal) > kAlongFace) {
    overlap.normal = face.normal;
    if (is_level(face)) ++level_;
  } else if (overlap.normal.dot(face.normal) < -kRise || rises(face.triangle, overlap.normal)) {
    return false;
  }

  if (triangles_ == kMaxMeshTriangles) {
    lost_ = true;
    return true;
  }
  ++triangles_;
  constexpr std::uint32_t kAddWork = 6;
  if (a_->work != nullptr) a_->work->charge(kAddWork);

  // One point where the other corners are out of reach.
  if (corner && is_alone(face, overlap.normal, overlap.depth_m)) {
    out_->add_distinct(
        {overlap.of_core_m + (0.5F * overlap.depth_m) * overlap.normal, overlap.normal, overlap.depth_m});
    return true;
  }
  const TriangleCorners corners = corners_of(face.p);
  add_contacts(*a_, convex_triangle(corners), overlap, margin_m_, *out_);
  return true;
}

// A place of the core and the way from the triangle to it.
void TriangleCollision::push_out(const Vec3& of_core_m, const Vec3& apart_m, Overlap& overlap) const {
  const float length = apart_m.norm();
  overlap.of_core_m = of_core_m;
  overlap.normal = apart_m / length;
  overlap.depth_m = a_->radius_m - length;
}

// A ball or capsule: what is nearest to its core. Where the core goes through the triangle's plane, the face pushes it out.
void TriangleCollision::collide_round(const Face& face, float depth_m, const Vec3& lowest_m) {
  Overlap overlap;
  overlap.of_core_m = lowest_m;
  overlap.normal = face.normal;
  overlap.depth_m = depth_m;
  if (!is_over(face, lowest_m)) {
    if (a_->form == CollisionForm::kCapsule) {
      const Verdict verdict = at_corner(face, overlap);
      if (verdict == Verdict::kLeast) add(face, overlap, false);
      if (verdict == Verdict::kOpen) defer(face, overlap);
      return;
    }
    const Vec3 apart_m = lowest_m - nearest_on_triangle(face.p, lowest_m);
    if (!(apart_m.dot(face.normal) > 0.0F)) return;
    push_out(lowest_m, apart_m, overlap);
    if (overlap.depth_m < -margin_m_) return;
  }
  add(face, overlap, false);
}

void TriangleCollision::collide_flat(const Face& face, const Guess& guess, const Vec3& lowest_m) {
  Overlap overlap;
  overlap.depth_m = guess.depth_m;
  overlap.normal = guess.axis < 0 ? face.normal : Vec3(guess.sign * a_->rotation.col(guess.axis));
  constexpr float kDeepFlat_m = 3.0e-4F;
  const bool deep = guess.depth_m > kDeepFlat_m;
  bool least = !deep && is_least(face, guess, lowest_m, overlap);
  if (least && (add(face, overlap, guess.axis >= 0) || a_->form != CollisionForm::kBox)) return;
  // On ground that is fine or far below, most of what the solid's box holds is settled by this.
  if (a_->form != CollisionForm::kBox) {
    const Verdict verdict = at_corner(face, overlap);
    if (verdict == Verdict::kApart) return;
    if (verdict == Verdict::kLeast) {
      add(face, overlap, true);
      return;
    }
  }
  if (deep) {
    offer_neighbours(face, overlap);
    if (overlap.depth_m < -margin_m_) return;
    least = overlap.depth_m == guess.depth_m && is_least(face, guess, lowest_m, overlap);
    if (least && (add(face, overlap, guess.axis >= 0) || a_->form != CollisionForm::kBox)) return;
  }
  if (a_->form == CollisionForm::kBox) {
    // The mesh goes on beyond that direction: an edge of the box may lie across an edge of the mesh.
    Verdict verdict = along_edges(face, overlap);
    if (verdict == Verdict::kOpen && !least) verdict = at_corner(face, overlap);
    if (verdict == Verdict::kLeast) add(face, overlap, false);
    if (verdict != Verdict::kOpen || least) return;
  }
  defer(face, overlap);
}

void TriangleCollision::collide(std::uint32_t triangle) {
  constexpr std::uint32_t kPlaceWork = 2;
  constexpr std::uint32_t kMeetWork = 5;
  if (a_->work != nullptr) a_->work->charge(kPlaceWork);
  Face face;
  if (!place(triangle, face)) return;
  if (a_->work != nullptr) a_->work->charge(kMeetWork);
  // Of a hull each farthest point costs a product per corner: first the ball about it.
  if (a_->form == CollisionForm::kMesh && face.normal.dot(face.p[0] - a_->centre_m) + ball_m_ < -margin_m_)
    return;
  const Vec3 lowest_m = a_->farthest(-face.normal).at_m;
  const float depth_m = face.normal.dot(face.p[0] - lowest_m) + a_->radius_m;
  if (depth_m < -margin_m_) return;
  // Of a point, what is within its reach is not behind the face.
  const float above_m = a_->form == CollisionForm::kBall ? a_->half_m.x() : a_->radius_m;
  if (depth_m > margin_m_ && face.normal.dot(inner_m_ - face.p[0]) < 0.0F &&
      face.normal.dot(a_->farthest(face.normal).at_m - face.p[0]) + above_m < -margin_m_)
    return;  // behind the face
  const bool round = a_->form == CollisionForm::kBall || a_->form == CollisionForm::kCapsule;
  const Guess guess = round ? Guess{.depth_m = depth_m} : along_axes(face, depth_m);
  if (guess.depth_m < -margin_m_ || is_known(face)) return;
  if (level_ >= kMaxLevel && is_level(face)) {
    ++passed_over_;
    met_all_ = false;
    return;
  }
  if (tried_ == kMaxTried) {
    lost_ = true;
    return;
  }
  ++tried_;
  normals_ += face.normal;
  if (round) return collide_round(face, depth_m, lowest_m);
  collide_flat(face, guess, lowest_m);
}

}  // namespace thimble::control

// Planes between a ball and the triangles near it.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>

#include "control/scene/limits.h"
#include "control/scene/mesh_leaf.h"
#include "control/solids/mesh.h"
#include "control/solids/mesh_topology.h"

namespace thimble::control {

using namespace topology;  // NOLINT(google-build-using-namespace): this file is about nothing else

namespace {

constexpr int kMaxSeparationNodes = 512;

using GridPoint = flatbuffers::Array<std::uint16_t, 3>;

// The point of the triangle (a, a + ab, a + ac) nearest to a + ap, as a vector from a (Ericson 2005, 5.1.5).
Vec3 nearest_on_triangle(const Vec3& ab, const Vec3& ac, const Vec3& ap) {
  const float d1 = ab.dot(ap);
  const float d2 = ac.dot(ap);
  if (d1 <= 0.0F && d2 <= 0.0F) return Vec3::Zero();
  const float bb = ab.squaredNorm();
  const float cc = ac.squaredNorm();
  const float bc = ab.dot(ac);
  const float d3 = d1 - bb;
  const float d4 = d2 - bc;
  if (d3 >= 0.0F && d4 <= d3) return ab;
  const float d5 = d1 - bc;
  const float d6 = d2 - cc;
  if (d6 >= 0.0F && d5 <= d6) return ac;
  const float vc = d1 * d4 - d3 * d2;
  if (vc <= 0.0F && d1 >= 0.0F && d3 <= 0.0F) return (d1 / (d1 - d3)) * ab;
  const float vb = d5 * d2 - d1 * d6;
  if (vb <= 0.0F && d2 >= 0.0F && d6 <= 0.0F) return (d2 / (d2 - d6)) * ac;
  const float va = d3 * d6 - d5 * d4;
  if (va <= 0.0F && d4 - d3 >= 0.0F && d5 - d6 >= 0.0F)
    return ab + ((d4 - d3) / ((d4 - d3) + (d5 - d6))) * (ac - ab);
  return (vb * ab + vc * ac) / (va + vb + vc);
}

// False when the triangle cannot come into the ball's way: the ball is behind it, or beyond reach of it, or it stays in
// front of it all the way.
bool separate_triangle(const MeshView& mesh, std::uint32_t triangle, const BallQuery& ball, Separation& out) {
  const Vec3 a = vertex(mesh, triangle, 0);
  const Vec3 ab = vertex(mesh, triangle, 1) - a;
  const Vec3 ac = vertex(mesh, triangle, 2) - a;
  const Vec3 area = ab.cross(ac);
  const float length = area.norm();
  const Vec3 from = ball.centre_m - a;
  Vec3 normal = area / std::max(length, std::numeric_limits<float>::min());
  float height = normal.dot(from);
  std::int8_t side = 1;
  if (height < 0.0F) {
    if (!two_sided(mesh, triangle)) return false;
    normal = -normal;
    height = -height;
    side = -1;
  }
  const bool before_face = height >= ball.radius_m - kBehind_m;
  if (before_face && height > ball.radius_m + kTouchGap_m && !ball.meets(normal, height)) return false;
  const Vec3 apart = from - nearest_on_triangle(ab, ac, from);
  out.apart_m = apart.norm();
  out.feature = {triangle, kFace, 0, side};
  PlaneChoice choice(ball, out);
  choice.offer_direct(out.apart_m > 0.0F ? Vec3(apart / out.apart_m) : normal);
  choice.offer_face(normal, height);
  // A ball that slides over a face passes what lies below that face.
  const auto offer = [&](const Vec3& plane) {
    choice.offer(plane, plane.dot(from) - std::max({0.0F, plane.dot(ab), plane.dot(ac)}));
  };
  for (std::size_t i = 0; choice.blocks() && i < ball.held_count; ++i) offer(ball.held_by[i]);
  // A tip whose target is outside, and too near to the triangle, comes to lie over the place nearest to the target.
  if (ball.is_tip && choice.blocks()) {
    const Vec3 target = ball.target_m - a;
    const Vec3 over = target - nearest_on_triangle(ab, ac, target);
    const float over_m = over.norm();
    if (over_m > 0.0F && normal.dot(target) > 0.0F) offer(over / over_m);
  }
  return choice.matters();
}

// A plane of a face that the tip touches: the tip meets nothing behind it.
struct Cover {
  Vec3 normal;
  float offset_m;     // of the plane, from the mesh's origin
  Vec3 size;          // |normal|, for boxes
  float grid_offset;  // the same in the mesh's grid

  Cover() = default;
  Cover(const MeshView& mesh, const BallQuery& ball, const Separation& plane)
      : normal(plane.normal),
        offset_m(plane.normal.dot(ball.centre_m) - plane.height_m),
        size(plane.normal.cwiseAbs()),
        grid_offset((offset_m - plane.normal.dot(mesh.grid_origin_m)) * mesh.grid_scale) {}

  [[nodiscard]] bool hides(const Vec3& p) const { return normal.dot(p) <= offset_m + kSurfaceTolerance_m; }
  [[nodiscard]] bool hides(const GridPoint& lo, const GridPoint& hi) const {
    const Vec3 low(lo[0], lo[1], lo[2]);
    const Vec3 high(hi[0], hi[1], hi[2]);
    return normal.dot(low + high) + size.dot(high - low) <= 2.0F * grid_offset;
  }
};

// The planes that have been found, and what they hide.
class Found {
 public:
  Found(const MeshView& mesh, const BallQuery& ball, std::span<Separation> out, float& free_m)
      : mesh_(mesh), ball_(ball), out_(out), free_m_(free_m) {
    for (std::size_t i = 0; ball.is_tip && i < ball.held_feature_count && count_ < out.size(); ++i) {
      const std::uint32_t triangle = ball.held_features[i];
      if (is_first(triangle) || !separate_triangle(mesh, triangle, ball, out[count_])) continue;
      covers_[cover_count_++] = Cover(mesh, ball, out[count_]);
      ++count_;
    }
  }
  [[nodiscard]] bool hides(const GridPoint& lo, const GridPoint& hi) const {
    for (std::size_t i = 0; i < cover_count_; ++i)
      if (covers_[i].hides(lo, hi)) return true;
    return false;
  }
  // False when there is no room.
  bool add(std::uint32_t triangle) {
    if (is_hidden(triangle)) return true;
    if (count_ < out_.size()) {
      if (separate_triangle(mesh_, triangle, ball_, out_[count_])) ++count_;
      return true;
    }
    if (!ball_.is_tip || out_.size() <= cover_count_) return false;
    Separation one;
    if (!separate_triangle(mesh_, triangle, ball_, one)) return true;
    for (std::size_t i = 0; i < count_; ++i)
      if (is_same(one, out_[i])) return true;
    // The farthest one is left out.
    std::size_t farthest = cover_count_;
    for (std::size_t i = cover_count_ + 1; i < count_; ++i)
      if (out_[i].apart_m > out_[farthest].apart_m) farthest = i;
    if (one.apart_m < out_[farthest].apart_m) std::swap(one, out_[farthest]);
    free_m_ = std::min(free_m_, std::max(one.apart_m - ball_.radius_m, 0.0F));
    return true;
  }
  [[nodiscard]] std::size_t count() const { return count_; }

 private:
  // As of two faces at one edge or vertex.
  static bool is_same(const Separation& a, const Separation& b) {
    constexpr float kSameTurn2 = 1.0e-10F;
    constexpr float kSame_m = 1.0e-7F;
    return std::abs(a.height_m - b.height_m) <= kSame_m && (a.normal - b.normal).squaredNorm() <= kSameTurn2;
  }
  [[nodiscard]] bool is_first(std::uint32_t triangle) const {
    for (std::size_t i = 0; i < cover_count_; ++i)
      if (out_[i].feature.index == triangle) return true;
    return false;
  }
  [[nodiscard]] bool is_hidden(std::uint32_t triangle) const {
    for (std::size_t i = 0; i < cover_count_; ++i) {
      if (out_[i].feature.index == triangle) return true;
      if (covers_[i].hides(vertex(mesh_, triangle, 0)) && covers_[i].hides(vertex(mesh_, triangle, 1)) &&
          covers_[i].hides(vertex(mesh_, triangle, 2)))
        return true;
    }
    return false;
  }

  const MeshView& mesh_;
  const BallQuery& ball_;
  std::span<Separation> out_;
  float& free_m_;
  std::size_t count_ = 0;
  std::array<Cover, 3> covers_;
  std::size_t cover_count_ = 0;
};

// Every place that the ball can come to while it comes nearer to the target: the centre stays in the ball over the
// line between them. In steps of the mesh's grid: a ball, and the box about it.
struct BallOfWay {
  std::array<std::uint32_t, 3> lo, hi;
  Vec3 middle;
  float radius2;
  bool is_tip;

  // False when the mesh's grid is elsewhere.
  bool about(const MeshView& mesh, const BallQuery& ball) {
    const Vec3 way = ball.target_m - ball.centre_m;
    middle = (ball.centre_m + 0.5F * way - mesh.grid_origin_m) * mesh.grid_scale;
    const float half = (ball.half_way_m + ball.radius_m + kTouchGap_m) * mesh.grid_scale + 2.0F;
    radius2 = half * half;
    is_tip = ball.is_tip;
    constexpr float kGridEnd = 65535.0F;
    for (int axis = 0; axis < 3; ++axis) {
      const float from = middle[axis] - half;
      const float to = middle[axis] + half;
      if (!(to >= 0.0F && from <= kGridEnd)) return false;
      lo[static_cast<std::size_t>(axis)] = static_cast<std::uint32_t>(std::clamp(from, 0.0F, kGridEnd));
      hi[static_cast<std::size_t>(axis)] = static_cast<std::uint32_t>(std::clamp(to, 0.0F, kGridEnd));
    }
    return true;
  }
  // Of a tip, which can be larger than many boxes, the ball itself counts.
  [[nodiscard]] bool meets(const GridPoint& low, const GridPoint& high) const {
    for (std::uint16_t axis = 0; axis < 3; ++axis) {
      if (low[axis] > hi[axis] || high[axis] < lo[axis]) return false;
    }
    if (!is_tip) return true;
    const Vec3 least(low[0], low[1], low[2]);
    const Vec3 most(high[0], high[1], high[2]);
    return (middle - middle.cwiseMax(least).cwiseMin(most)).squaredNorm() <= radius2;
  }
};

}  // namespace

std::size_t separate_mesh(const ShapeData& shape, const BallQuery& ball, std::span<Separation> out,
                          float& free_m) {
  const MeshView& mesh = shape.mesh;
  BallOfWay way;
  if (!way.about(mesh, ball)) return 0;
  Found found(mesh, ball, out, free_m);
  std::array<std::uint32_t, kMaxBvhDepth + 1> stack;
  std::size_t depth = 0;
  std::uint32_t at = 0;
  for (int visits = 0; visits < kMaxSeparationNodes; ++visits) {
    const scene::BvhNode& node = mesh.nodes[at];
    std::array<std::uint32_t, 2> inner;
    std::size_t inner_count = 0;
    for (std::uint16_t c = 0; c < 2; ++c) {
      const GridPoint& lo = c == 0 ? *node.lo_a() : *node.lo_b();
      const GridPoint& hi = c == 0 ? *node.hi_a() : *node.hi_b();
      if (!way.meets(lo, hi) || found.hides(lo, hi)) continue;
      const std::uint32_t child = (*node.child())[c];
      if (!is_leaf(child)) {
        inner[inner_count++] = child;
        continue;
      }
      const std::uint32_t first = first_triangle(child);
      for (std::uint32_t i = first; i < first + triangle_count(child); ++i) {
        if (!found.add(i)) return out.size() + 1;
      }
    }
    if (inner_count == 0) {
      if (depth == 0) return found.count();
      at = stack[--depth];
    } else {
      at = inner[0];
      if (inner_count == 2) {
        if (depth == stack.size()) return out.size() + 1;
        stack[depth++] = inner[1];
      }
    }
  }
  return out.size() + 1;
}

}  // namespace thimble::control

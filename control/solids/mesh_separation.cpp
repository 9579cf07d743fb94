// Planes between a ball and the triangles near it.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>

#include "control/scene/limits.h"
#include "control/solids/mesh.h"
#include "control/solids/mesh_near.h"
#include "control/solids/mesh_topology.h"
#include "control/solids/near_triangles.h"

namespace thimble::control {

using namespace topology;  // NOLINT(google-build-using-namespace): this file is about nothing else

namespace {

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
  if (ball.is_tip && height > ball.radius_m + ball.reach_m + kTouchGap_m) return false;
  const bool before_face = height >= ball.radius_m - kBehind_m;
  if (before_face && height > ball.radius_m + kTouchGap_m && !ball.meets(normal, height)) return false;
  const Vec3 apart = from - nearest_on_triangle(ab, ac, from);
  out.apart_m = apart.norm();
  if (ball.is_tip && out.apart_m > ball.radius_m + ball.reach_m + kTouchGap_m) return false;
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
    if (over_m > kSurfaceTolerance_m && normal.dot(target) > 0.0F) offer(over / over_m);
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
    if (cover_count_ == 0) return false;
    const std::array<Vec3, 3> corners = {vertex(mesh_, triangle, 0), vertex(mesh_, triangle, 1),
                                         vertex(mesh_, triangle, 2)};
    for (std::size_t i = 0; i < cover_count_; ++i) {
      if (out_[i].feature.index == triangle) return true;
      if (covers_[i].hides(corners[0]) && covers_[i].hides(corners[1]) && covers_[i].hides(corners[2]))
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

}  // namespace

std::size_t separate_mesh(const ShapeData& shape, const BallQuery& ball, std::span<Separation> out,
                          float& free_m) {
  const MeshView& mesh = shape.mesh;
  const float distance_m = ball.radius_m + ball.reach_m + kTouchGap_m;
  GridBall grid;
  Found found(mesh, ball, out, free_m);
  if (ball.is_tip) {
    free_m = std::min(free_m, ball.reach_m);
    if (ball.triangles != nullptr) {
      const NearTriangles* const near = ball.triangles->near(shape, ball.work, ball.centre_m, ball.radius_m,
                                                             ball.reach_m + kTouchGap_m + kDiscRounding_m);
      if (near != nullptr) {
        for (const NearTriangle& one : near->list())
          if (one.within(ball.centre_m, distance_m + kDiscRounding_m, kDiscRounding_m) &&
              !found.add(one.triangle))
            return out.size() + 1;
        return found.count();
      }
    }
    if (!grid.about(mesh, ball.centre_m, distance_m)) return found.count();
  } else {
    const Vec3 middle = ball.centre_m + 0.5F * (ball.target_m - ball.centre_m);
    if (!grid.about(mesh, middle, ball.half_way_m + ball.radius_m + kTouchGap_m)) return 0;
  }
  const bool all = for_each_near(
      mesh, ball.work,
      [&](const GridPoint& lo, const GridPoint& hi) {
        return grid.meets(lo, hi) && (!ball.is_tip || grid.is_near(lo, hi)) && !found.hides(lo, hi);
      },
      [&](std::uint32_t triangle) { return found.add(triangle); });
  return all ? found.count() : out.size() + 1;
}

bool touches_mesh(const ShapeData& shape, const Feature& feature, const Vec3& centre, float radius_m,
                  const Vec3& normal) {
  constexpr float kSame_m = 1.0e-7F;
  const MeshView& mesh = shape.mesh;
  const Vec3 a = vertex(mesh, feature.index, 0);
  const Vec3 ab = vertex(mesh, feature.index, 1) - a;
  const Vec3 ac = vertex(mesh, feature.index, 2) - a;
  const Vec3 from = centre - a;
  const Vec3 apart = from - nearest_on_triangle(ab, ac, from);
  return (apart - radius_m * normal).squaredNorm() <= kSame_m * kSame_m;
}

}  // namespace thimble::control

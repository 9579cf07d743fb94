#include "control/solids/near_triangles.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "control/solids/mesh_near.h"
#include "control/solids/mesh_topology.h"

namespace thimble::control {

NearTriangle in_disc(const MeshView& mesh, std::uint32_t triangle) {
  using namespace topology;  // NOLINT(google-build-using-namespace)
  constexpr float kThird = 1.0F / 3.0F;
  const Vec3 a = vertex(mesh, triangle, 0);
  const Vec3 ab = vertex(mesh, triangle, 1) - a;
  const Vec3 ac = vertex(mesh, triangle, 2) - a;
  const Vec3 area = ab.cross(ac);
  const Vec3 middle = kThird * (ab + ac);
  NearTriangle disc;
  disc.normal = area / std::max(area.norm(), std::numeric_limits<float>::min());
  disc.middle_m = a + middle;
  disc.radius_m =
      std::sqrt(std::max({middle.squaredNorm(), (ab - middle).squaredNorm(), (ac - middle).squaredNorm()}));
  disc.triangle = triangle;
  disc.two_sided = two_sided(mesh, triangle);
  return disc;
}

TrianglePlane plane_of(const ShapeData& shape, std::uint32_t triangle) {
  using namespace topology;  // NOLINT(google-build-using-namespace)
  return {&shape, triangle, vertex(shape.mesh, triangle, 0), area_normal(shape.mesh, triangle),
          two_sided(shape.mesh, triangle)};
}

bool NearTriangles::fill(const ShapeData& shape, Work& work, const Vec3& centre_m, float radius_m,
                         float reach_m) {
  const MeshView& mesh = shape.mesh;
  shape_ = nullptr;
  count_ = 0;
  side_ = 0;
  GridBall grid;
  const float distance_m = radius_m + reach_m;
  const bool known =
      !grid.about(mesh, centre_m, distance_m) || for_each_near(
                                                     mesh, work,
                                                     [&](const GridPoint& lo, const GridPoint& hi) {
                                                       return grid.meets(lo, hi) && grid.is_near(lo, hi);
                                                     },
                                                     [&](std::uint32_t triangle) {
                                                       const NearTriangle one = in_disc(mesh, triangle);
                                                       if (!one.within(centre_m, distance_m, reach_m))
                                                         return true;
                                                       if (count_ == kMax) return false;
                                                       list_[count_++] = one;
                                                       return true;
                                                     },
                                                     kListWork);
  if (!known) return false;
  shape_ = &shape;
  centre_m_ = centre_m;
  radius_m_ = radius_m;
  reach_m_ = reach_m;
  return true;
}

std::span<const std::uint8_t> NearTriangles::before(const MeshView& mesh, std::uint32_t triangle,
                                                    std::int8_t side, const Vec3& normal) {
  if (side_ != side || face_ != triangle) {
    face_ = triangle;
    side_ = side;
    before_count_ = 0;
    const float offset_m = normal.dot(topology::vertex(mesh, triangle, 0));
    for (std::size_t i = 0; i < count_; ++i)
      if (list_[i].triangle != triangle && !lies_behind(mesh, list_[i].triangle, normal, offset_m))
        before_[before_count_++] = static_cast<std::uint8_t>(i);
  }
  return {before_.data(), before_count_};
}

TriangleCache::TriangleCache() noexcept = default;

void TriangleCache::clear() noexcept { of_.emplace<TrianglesOfPoint>(); }

NearTriangles* TriangleCache::near(const ShapeData& shape, Work& work, const Vec3& centre_m, float radius_m,
                                   float reach_m) {
  constexpr std::size_t kFew = 10;
  constexpr std::size_t kMany = 20;
  constexpr float kMore = 1.5F;
  constexpr float kLess = 0.6F;
  constexpr float kRecovery = 1.05F;
  auto& [lists, last, next_m, most_m] = of<TrianglesOfBall>();
  if (lists[last].hold(shape, centre_m, radius_m, reach_m)) return &lists[last];
  if (lists[1 - last].hold(shape, centre_m, radius_m, reach_m)) {
    last = 1 - last;
    return &lists[last];
  }
  most_m = std::min(kRecovery * most_m, TrianglesOfBall::kMost_m);
  if (reach_m > most_m) return nullptr;
  last = 1 - last;
  NearTriangles& list = lists[last];
  const float listed_m = std::max(reach_m, std::min(next_m, most_m));
  // So much is for the list: with it further looks cost nearly nothing.
  const std::uint32_t share = work.at_hand() - work.at_hand() / 4;
  Work some(share);
  const bool filled = list.fill(shape, some, centre_m, radius_m, listed_m);
  if (!work.spend(share - some.left()) || !filled) {
    last = 1 - last;  // the other list may hold the next place
    most_m = kLess * listed_m;
    return nullptr;
  }
  if (listed_m < next_m) return &list;
  if (list.list().size() > kMany) {
    next_m = kLess * listed_m;
  } else if (list.list().size() < kFew) {
    next_m = std::min(kMore * listed_m, TrianglesOfBall::kMost_m);
  }
  return &list;
}

bool NearLeaves::fill(const ShapeData& shape, Work& work, const GridBox& box) {
  shape_ = nullptr;
  count_ = 0;
  const auto meets = [&](const GridPoint& lo, const GridPoint& hi) {
    for (std::uint16_t axis = 0; axis < 3; ++axis)
      if (lo[axis] > box.hi[axis] || hi[axis] < box.lo[axis]) return false;
    return true;
  };
  const auto take = [&](std::uint32_t leaf, const GridPoint& lo, const GridPoint& hi) {
    if (count_ == kMax) return false;
    list_[count_++] = {{lo[0], lo[1], lo[2]}, {hi[0], hi[1], hi[2]}, leaf};
    return true;
  };
  if (!for_each_leaf(shape.mesh, work, meets, take)) return false;
  shape_ = &shape;
  box_ = box;
  return true;
}

const NearLeaves* TriangleCache::leaves(const ShapeData& shape, Work& work, const GridBox& box) {
  constexpr std::size_t kFew = 8;
  constexpr std::size_t kMany = 16;
  constexpr std::uint32_t kMost_steps = 4096;
  constexpr std::uint32_t kShare = 4;  // a list takes no more than a quarter of the work that is left
  auto& [lists, last, more_steps, planes, faces, flight] = of<TrianglesOfPoint>();
  if (lists[last].hold(shape, box)) return &lists[last];
  if (lists[1 - last].hold(shape, box)) {
    last = 1 - last;
    return &lists[last];
  }
  std::uint32_t size = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) size = std::max(size, box.hi[axis] - box.lo[axis]);
  if (size > kMost_steps) return nullptr;
  GridBox more = box;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    more.lo[axis] -= std::min(more.lo[axis], more_steps);
    more.hi[axis] += more_steps;
  }
  last = 1 - last;
  NearLeaves& list = lists[last];
  const std::uint32_t share = work.at_hand() / kShare;
  Work some(share);
  const bool filled = list.fill(shape, some, more);
  if (!work.spend(share - some.left()) || !filled) {
    list.clear();
    more_steps /= 2;
    return nullptr;
  }
  if (list.list().size() > kMany) {
    more_steps -= more_steps / 4;
  } else if (list.list().size() < kFew) {
    more_steps = std::min(more_steps + more_steps / 2 + 1, kMost_steps);
  }
  return &list;
}

float NearLeaves::away(const ShapeData& shape, const Vec3& place) const {
  if (shape_ != &shape) return 0.0F;
  float least = std::numeric_limits<float>::max();
  for (int axis = 0; axis < 3; ++axis) {  // what is beyond the box is not known
    const auto i = static_cast<std::size_t>(axis);
    least = std::min(
        {least, place[axis] - static_cast<float>(box_.lo[i]), static_cast<float>(box_.hi[i]) - place[axis]});
  }
  for (const Leaf& leaf : list()) {
    const Vec3 lo(leaf.lo[0], leaf.lo[1], leaf.lo[2]);
    const Vec3 hi(leaf.hi[0], leaf.hi[1], leaf.hi[2]);
    least = std::min(least, (place - place.cwiseMax(lo).cwiseMin(hi)).norm());
  }
  return std::max(least, 0.0F);
}

float TriangleCache::away_m(const ShapeData& shape, const Vec3& place_m) {
  const MeshView& mesh = shape.mesh;
  const Vec3 place = (place_m - mesh.grid_origin_m) * mesh.grid_scale;
  constexpr float kRounding_steps = 2.0F;  // of a box and of the place
  float away = 0.0F;
  for (const NearLeaves& list : of<TrianglesOfPoint>().lists) away = std::max(away, list.away(shape, place));
  return std::max(away - kRounding_steps, 0.0F) * mesh.grid_step_m;
}

bool TriangleCache::is_clear(const ShapeData& shape, Work& work, const Vec3& centre_m, float radius_m,
                             float reach_m) {
  const NearTriangles* const list = near(shape, work, centre_m, radius_m, reach_m + kDiscRounding_m);
  if (list == nullptr) return false;
  const float distance_m = radius_m + reach_m + kDiscRounding_m;
  for (const NearTriangle& one : list->list())
    if (one.within(centre_m, distance_m, kDiscRounding_m)) return false;
  return true;
}

}  // namespace thimble::control

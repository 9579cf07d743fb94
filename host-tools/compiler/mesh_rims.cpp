#include "host-tools/compiler/mesh_rims.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "host-tools/compiler/portable_math.h"
#include "host-tools/compiler/triangle_distance.h"

namespace thimble::host {
namespace {

using Eigen::Vector3d;
using Rim = std::array<std::uint8_t, 3>;  // of each edge

constexpr unsigned kWhole = 255;
constexpr std::uint8_t kNowhere = 255;
// The middle of the face stays free.
constexpr std::uint8_t kWidest = 85;
// What rises less over a face is in its plane: the renderer's surface tolerance (control/solids/solid.h).
constexpr double kLevel_m = 2.0e-7;
constexpr double kSharpest = 0.5;  // cosine of the angle between faces that it rolls over
constexpr double kArcStep_rad = 0.05;

constexpr std::size_t next(std::size_t corner) { return corner == 2 ? 0 : corner + 1; }

class Rims {
 public:
  Rims(const RimSurface& mesh, double radius_m)
      : mesh_(mesh), radius_m_(radius_m), rims_(mesh.surface.triangles.size(), Rim{kNowhere, 0, 0}) {}

  std::vector<std::uint8_t> find() {
    for (std::uint32_t t = 0; t < rims_.size(); ++t) rims_[t] = rim_of(t);
    for (std::uint32_t t = 0; t < rims_.size(); ++t)
      for (std::uint32_t e = 0; e < 3; ++e) close_edge_unless_free(t, e);
    std::vector<std::uint8_t> all;
    all.reserve(3 * rims_.size());
    for (const Rim& rim : rims_) all.insert(all.end(), rim.begin(), rim.end());
    return all;
  }

 private:
  struct Face {
    Triangle3 at_m;
    Vector3d normal;
    [[nodiscard]] double rises_m(const Triangle3& other) const {
      return std::max(
          {normal.dot(other[0] - at_m[0]), normal.dot(other[1] - at_m[0]), normal.dot(other[2] - at_m[0])});
    }
  };

  [[nodiscard]] Triangle3 corners(std::uint32_t t) const {
    const TriangleIndices& i = mesh_.surface.triangles[t];
    return {mesh_.surface.point(i[0]), mesh_.surface.point(i[1]), mesh_.surface.point(i[2])};
  }
  [[nodiscard]] Face face(std::uint32_t t) const { return {corners(t), mesh_.face_normals[t]}; }
  [[nodiscard]] bool is_plain(std::uint32_t t) const {
    constexpr auto kMeets = static_cast<unsigned>(scene::TriangleFlag::Pierced) |
                            static_cast<unsigned>(scene::TriangleFlag::Seam);
    return (mesh_.flags[t] & kMeets) == 0;
  }
  [[nodiscard]] std::uint32_t beyond(std::uint32_t t, std::uint32_t e) const {
    return mesh_.adjacency.neighbour[std::size_t{3} * t + e];
  }

  // Visits the triangles in front of a face that a ball can touch whose centre is in a box, until visit() returns false.
  template <typename Visit>
  void visit_in_front(const Face& face, const Vector3d& lo_m, const Vector3d& hi_m,
                      const Visit& visit) const {
    const MeshTree& tree = mesh_.tree;
    const Vector3d reach = Vector3d::Constant(radius_m_);
    const GridBox box = tree.grid_box(lo_m - reach, hi_m + reach);
    const Vector3d up = static_cast<double>(tree.grid_step_m) * face.normal;
    const double least = face.normal.dot(face.at_m[0] - tree.grid_origin_m.cast<double>());
    const auto meets = [&](const auto& lo, const auto& hi) {
      double highest = 0.0;
      for (std::uint16_t axis = 0; axis < 3; ++axis) {
        if (lo.Get(axis) > box.hi[axis] || hi.Get(axis) < box.lo[axis]) return false;
        highest += up[axis] * static_cast<double>(up[axis] > 0.0 ? hi.Get(axis) : lo.Get(axis));
      }
      return highest >= least;
    };
    visit_where(tree.nodes, meets, visit);
  }

  // The part of a face that keeps away from its edges, one radius above the face.
  [[nodiscard]] Triangle3 centres(const Face& face, const Rim& rim) const {
    std::array<double, 3> least;  // of each corner's weight
    for (std::size_t corner = 0; corner < 3; ++corner) least[corner] = rim[next(corner)] / double{kWhole};
    const double rest = std::max(1.0 - least[0] - least[1] - least[2], 0.0);
    const Vector3d middle =
        radius_m_ * face.normal + least[0] * face.at_m[0] + least[1] * face.at_m[1] + least[2] * face.at_m[2];
    return {middle + rest * face.at_m[0], middle + rest * face.at_m[1], middle + rest * face.at_m[2]};
  }

  // The least rim at one edge with which it does not touch the other triangle; none: there is no such rim.
  [[nodiscard]] std::optional<std::uint8_t> widened(const Face& face, const Rim& rim, std::size_t edge,
                                                    const Triangle3& other) const {
    const auto is_free = [&](std::uint8_t width) {
      Rim wider = rim;
      wider[edge] = width;
      return triangle_distance(centres(face, wider), other) >= radius_m_;
    };
    if (!is_free(kWidest)) return {};
    std::uint8_t low = rim[edge];
    std::uint8_t high = kWidest;
    while (low + 1 < high) {
      const auto middle = static_cast<std::uint8_t>((low + high) / 2);
      (is_free(middle) ? high : low) = middle;
    }
    return high;
  }

  [[nodiscard]] Rim rim_of(std::uint32_t t) const {
    constexpr Rim kNever{kNowhere, 0, 0};
    if (!is_plain(t)) return kNever;
    const Face here = face(t);
    Rim rim{};
    for (std::uint32_t e = 0; e < 3; ++e) rim[e] = rolls_over(t, e) ? 0 : 1;
    const Triangle3 above = centres(here, {});
    const Vector3d lo_m = above[0].cwiseMin(above[1]).cwiseMin(above[2]);
    const Vector3d hi_m = above[0].cwiseMax(above[1]).cwiseMax(above[2]);
    const Vector3d middle = (above[0] + above[1] + above[2]) / 3.0;
    const double size_m =
        std::max({(above[0] - middle).norm(), (above[1] - middle).norm(), (above[2] - middle).norm()});
    bool touches = false;
    visit_in_front(here, lo_m, hi_m, [&](std::uint32_t other) {
      if (other == t) return true;
      const Triangle3 there = corners(other);
      if (here.rises_m(there) <= kLevel_m) return true;
      const double apart_m = point_distance(middle, there);
      touches = apart_m < radius_m_;
      if (touches) return false;
      if (apart_m >= radius_m_ + size_m || triangle_distance(centres(here, rim), there) >= radius_m_)
        return true;
      std::size_t best = 3;
      std::uint8_t width = 0;
      for (std::size_t e = 0; e < 3; ++e) {
        const std::optional<std::uint8_t> one = widened(here, rim, e, there);
        if (one && (best == 3 || *one - rim[e] < width - rim[best])) {
          best = e;
          width = *one;
        }
      }
      touches = best == 3;
      if (!touches) rim[best] = width;
      return !touches;
    });
    if (touches) return kNever;
    // One step more, so that it is apart from what it must not touch.
    for (std::uint8_t& width : rim)
      if (width > 0) ++width;
    return rim;
  }

  // Whether the faces on either side of an edge lie behind each other.
  [[nodiscard]] bool rolls_over(std::uint32_t t, std::uint32_t e) const {
    const std::uint32_t across = beyond(t, e);
    if (across == kNoNeighbour || !is_plain(across / 4)) return false;
    const TriangleIndices& mine = mesh_.surface.triangles[t];
    const TriangleIndices& theirs = mesh_.surface.triangles[across / 4];
    const std::uint32_t edge = across % 4;
    return mine[e] == theirs[next_edge(edge)] && mine[next_edge(e)] == theirs[edge] &&
           mesh_.face_normals[t].dot(mesh_.face_normals[across / 4]) >= kSharpest &&
           face(t).rises_m(corners(across / 4)) <= kLevel_m &&
           face(across / 4).rises_m(corners(t)) <= kLevel_m;
  }

  // On its way round the edge it may touch what it does not touch on either face.
  void close_edge_unless_free(std::uint32_t t, std::uint32_t e) {
    if (rims_[t][0] == kNowhere || rims_[t][e] != 0) return;
    const std::uint32_t other = beyond(t, e) / 4;
    const std::uint32_t other_edge = beyond(t, e) % 4;
    if (rims_[other][0] != kNowhere && rims_[other][other_edge] == 0 && (other < t || is_free_round(t, e)))
      return;
    rims_[t][e] = 1;
    if (rims_[other][0] != kNowhere && rims_[other][other_edge] == 0) rims_[other][other_edge] = 1;
  }

  [[nodiscard]] bool is_free_round(std::uint32_t t, std::uint32_t e) const {
    const std::uint32_t other = beyond(t, e) / 4;
    const std::uint32_t other_edge = beyond(t, e) % 4;
    // The part of the edge that the other rims of both faces leave: the weight of its first corner falls along it.
    const auto least = [&](std::size_t mine, std::size_t theirs) {
      return std::max(rims_[t][mine], rims_[other][theirs]) / double{kWhole};
    };
    const double from = least(next(next(e)), next(other_edge));
    const double to = 1.0 - least(next(e), next(next(other_edge)));
    if (from > to) return false;
    const Face here = face(t);
    const Face there = face(other);
    const Vector3d& corner = here.at_m[e];
    const Vector3d along = here.at_m[next(e)] - corner;
    const Vector3d begin = corner + from * along;
    const Vector3d end = corner + to * along;
    const double angle =
        portable::atan2(here.normal.cross(there.normal).norm(), here.normal.dot(there.normal));
    if (radius_m_ * angle <= kLevel_m) return true;
    const int steps = static_cast<int>(std::ceil(angle / kArcStep_rad));
    const double sag_m = radius_m_ * (1.0 - portable::cos(0.5 * angle / steps));
    const auto normal = [&](int step) {
      const double part = static_cast<double>(step) / steps;
      return Vector3d(
          radius_m_ / portable::sin(angle) *
          (portable::sin((1.0 - part) * angle) * here.normal + portable::sin(part * angle) * there.normal));
    };
    Vector3d lo_m = begin.cwiseMin(end);
    Vector3d hi_m = begin.cwiseMax(end);
    const Vector3d round = Vector3d::Constant(radius_m_);
    lo_m -= round;
    hi_m += round;
    bool is_free = true;
    const auto visit = [&](const Face& front, const Face* behind) {
      visit_in_front(front, lo_m, hi_m, [&](std::uint32_t one) {
        if (one == t || one == other) return true;
        const Triangle3 obstacle = corners(one);
        if (front.rises_m(obstacle) <= kLevel_m ||
            (behind != nullptr && behind->rises_m(obstacle) > kLevel_m))
          return true;
        for (int step = 0; step < steps && is_free; ++step) {
          const Vector3d a = normal(step);
          const Vector3d b = normal(step + 1);
          is_free = triangle_distance({begin + a, end + a, end + b}, obstacle) >= radius_m_ + sag_m &&
                    triangle_distance({begin + a, end + b, begin + b}, obstacle) >= radius_m_ + sag_m;
        }
        return is_free;
      });
    };
    visit(here, nullptr);
    if (is_free) visit(there, &here);  // what is not in front of the first one
    return is_free;
  }

  RimSurface mesh_;
  double radius_m_;
  std::vector<Rim> rims_;
};

}  // namespace

std::vector<std::uint8_t> tip_rims(const RimSurface& mesh, double tip_radius_m) {
  return Rims(mesh, tip_radius_m).find();
}

}  // namespace thimble::host

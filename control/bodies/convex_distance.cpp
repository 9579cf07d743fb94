// Nearest points of two convex solids: the algorithm of Gilbert, Johnson and Keerthi (1988) with the closest points of
// a triangle and a tetrahedron after Ericson (2005, 5.1.5 and 5.1.6).
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>

#include "control/bodies/convex.h"

namespace thimble::control {
namespace {

constexpr int kMaxDistanceSteps = 24;

using Corners = std::array<Vec3, 4>;  // of the simplex in the difference a - b

// The point of a simplex that is nearest to the origin: the corners that span its feature, and their weights.
struct Nearest {
  std::array<std::uint8_t, 4> corner{};
  std::array<float, 4> weight{};
  std::size_t count = 0;

  void keep(std::uint8_t index, float part) {
    corner[count] = index;
    weight[count++] = part;
  }
  [[nodiscard]] Vec3 point(const Corners& of) const {
    Vec3 p = Vec3::Zero();
    for (std::size_t i = 0; i < count; ++i) p += weight[i] * of[corner[i]];
    return p;
  }
};

Nearest nearest_on_line(const Corners& of) {
  const Vec3& a = of[0];
  const Vec3& b = of[1];
  const Vec3 ab = b - a;
  const float length2 = ab.squaredNorm();
  const float t = -a.dot(ab);
  Nearest out;
  if (t <= 0.0F) {
    out.keep(0, 1.0F);
  } else if (t >= length2) {
    out.keep(1, 1.0F);
  } else {
    out.keep(0, 1.0F - t / length2);
    out.keep(1, t / length2);
  }
  return out;
}

Nearest nearest_on_face(const Corners& of, std::uint8_t ia, std::uint8_t ib, std::uint8_t ic) {
  const Vec3& a = of[ia];
  const Vec3& b = of[ib];
  const Vec3& c = of[ic];
  const Vec3 ab = b - a;
  const Vec3 ac = c - a;
  const float d1 = -ab.dot(a);
  const float d2 = -ac.dot(a);
  const float d3 = -ab.dot(b);
  const float d4 = -ac.dot(b);
  const float d5 = -ab.dot(c);
  const float d6 = -ac.dot(c);
  Nearest out;
  // From the normal rather than from products of the d: of a large face that passes near the origin these cancel.
  const Vec3 normal = ab.cross(ac);
  const float va = normal.dot(b.cross(c));
  const float vb = normal.dot(c.cross(a));
  const float vc = normal.dot(a.cross(b));
  if (d1 <= 0.0F && d2 <= 0.0F) {
    out.keep(ia, 1.0F);
  } else if (d3 >= 0.0F && d4 <= d3) {
    out.keep(ib, 1.0F);
  } else if (d6 >= 0.0F && d5 <= d6) {
    out.keep(ic, 1.0F);
  } else if (vc <= 0.0F && d1 >= 0.0F && d3 <= 0.0F) {
    out.keep(ia, -d3 / (d1 - d3));
    out.keep(ib, d1 / (d1 - d3));
  } else if (vb <= 0.0F && d2 >= 0.0F && d6 <= 0.0F) {
    out.keep(ia, -d6 / (d2 - d6));
    out.keep(ic, d2 / (d2 - d6));
  } else if (va <= 0.0F && d4 >= d3 && d5 >= d6) {
    const float sum = (d4 - d3) + (d5 - d6);
    out.keep(ib, (d5 - d6) / sum);
    out.keep(ic, (d4 - d3) / sum);
  } else {
    const float sum = va + vb + vc;
    out.keep(ia, va / sum);
    out.keep(ib, vb / sum);
    out.keep(ic, vc / sum);
  }
  return out;
}

// False when the origin is inside.
bool nearest_on_tetrahedron(const Corners& of, Nearest& out) {
  constexpr std::array<std::array<std::uint8_t, 4>, 4> kFaces = {
      {{0, 1, 2, 3}, {0, 2, 3, 1}, {0, 3, 1, 2}, {1, 3, 2, 0}}};
  float best = std::numeric_limits<float>::infinity();
  for (const auto& face : kFaces) {
    const Vec3& a = of[face[0]];
    const Vec3 ab = of[face[1]] - a;
    const Vec3 ac = of[face[2]] - a;
    const Vec3 normal = ab.cross(ac);
    const float origin = -normal.dot(a);
    const float other = normal.dot(of[face[3]] - a);
    // On the side of the fourth corner. Of a flat tetrahedron rounding decides on which side that is.
    constexpr float kFlat2 = 1.0e-10F;
    const float flat2 = kFlat2 * normal.squaredNorm() * std::max(ab.squaredNorm(), ac.squaredNorm());
    if (origin * other > 0.0F && other * other > flat2) continue;
    const Nearest candidate = nearest_on_face(of, face[0], face[1], face[2]);
    const float distance2 = candidate.point(of).squaredNorm();
    if (distance2 < best) {
      best = distance2;
      out = candidate;
    }
  }
  return best < std::numeric_limits<float>::infinity();
}

bool nearest_on_simplex(const Corners& of, std::size_t count, Nearest& out) {
  switch (count) {
    case 1:
      out = {};
      out.keep(0, 1.0F);
      return true;
    case 2:
      out = nearest_on_line(of);
      return true;
    case 3:
      out = nearest_on_face(of, 0, 1, 2);
      return true;
    default:
      return nearest_on_tetrahedron(of, out);
  }
}

}  // namespace

Vec3 nearest_on_triangle(const std::array<Vec3, 3>& corners, const Vec3& p) noexcept {
  Corners from_p;
  for (std::size_t i = 0; i < 3; ++i) from_p[i] = corners[i] - p;
  return p + nearest_on_face(from_p, 0, 1, 2).point(from_p);
}

void DistanceSearch::begin(const Vec3& towards_a) noexcept {
  count_ = 0;
  apart_m_ = towards_a;
  length2_ = std::numeric_limits<float>::infinity();
  steps_ = 0;
}

bool DistanceSearch::step(const Convex& a, const Convex& b, const Vec3& shift_m, float margin_m) noexcept {
  if (a.work != nullptr) a.work->charge(static_cast<std::uint32_t>(1 + 2 * count_));
  const float far_m = a.radius_m + b.radius_m + margin_m;
  distance_ = Distance::kNearest;
  Corner& found = corners_[count_];
  found.of_a = a.farthest(-apart_m_).at_m + shift_m;
  found.of_b = b.farthest(apart_m_).at_m;
  found.at = found.of_a - found.of_b;
  // Without the shift: both farthest points are known along the direction.
  const float gap = apart_m_.dot(found.at - shift_m);
  if (gap > 0.0F && gap * gap > far_m * far_m * apart_m_.squaredNorm()) {
    distance_ = Distance::kApart;
    return true;
  }
  // The origin is behind the plane through `found`, so no point of the difference is nearer than that plane.
  constexpr float kPart = 1.0e-5F;
  if (count_ > 0 && apart_m_.dot(apart_m_ - found.at) <= kPart * length2_) return true;
  for (std::size_t i = 0; i < count_; ++i)
    if (corners_[i].at == found.at) return true;  // known, by rounding
  Corners at;
  for (std::size_t i = 0; i <= count_; ++i) at[i] = corners_[i].at;
  Nearest next;
  if (!nearest_on_simplex(at, count_ + 1, next)) {
    distance_ = Distance::kTouching;
    return true;
  }
  const Vec3 point = next.point(at);
  const float now2 = point.squaredNorm();
  if (!(now2 < length2_)) {  // rounding: no progress
    if (count_ == 0) distance_ = Distance::kTouching;
    return true;
  }
  // The corners of its feature, to the front: their indices rise, except in the face of a tetrahedron.
  const std::array<Corner, 4> before = corners_;
  count_ = next.count;
  for (std::size_t i = 0; i < count_; ++i) {
    if (next.corner[i] != i) corners_[i] = before[next.corner[i]];
    weights_[i] = next.weight[i];
  }
  apart_m_ = point;
  const bool slow = now2 > (1.0F - kPart) * length2_;
  length2_ = now2;
  if (slow) return true;
  constexpr float kTouching_m = 1.0e-7F;
  if (length2_ < kTouching_m * kTouching_m) {
    distance_ = Distance::kTouching;
    return true;
  }
  return ++steps_ == kMaxDistanceSteps;
}

NearestPair DistanceSearch::pair() const noexcept {
  NearestPair out{Vec3::Zero(), Vec3::Zero(), apart_m_};
  for (std::size_t i = 0; i < count_; ++i) {
    out.of_a_m += weights_[i] * corners_[i].of_a;
    out.of_b_m += weights_[i] * corners_[i].of_b;
  }
  return out;
}

Distance nearest_points(const Convex& a, const Convex& b, const Vec3& shift_m, const Vec3& towards_a,
                        float margin_m, NearestPair& out) noexcept {
  DistanceSearch search;
  search.begin(towards_a);
  while (!search.step(a, b, shift_m, margin_m)) {
  }
  out = search.pair();
  return search.distance();
}

}  // namespace thimble::control

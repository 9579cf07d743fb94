// Nearest points of two convex solids: the algorithm of Gilbert, Johnson and Keerthi (1988) with the closest points of
// a triangle and a tetrahedron after Ericson (2005, 5.1.5 and 5.1.6).
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "control/bodies/convex.h"

namespace thimble::control {
namespace {

constexpr int kMaxSteps = 24;

// A corner of the simplex in the difference a - b.
struct SimplexCorner {
  Vec3 at;
  Vec3 of_a;
  Vec3 of_b;
  float weight = 1.0F;
};

struct Simplex {
  std::array<SimplexCorner, 4> corner;
  std::size_t count = 0;

  [[nodiscard]] Vec3 nearest() const {
    Vec3 p = Vec3::Zero();
    for (std::size_t i = 0; i < count; ++i) p += corner[i].weight * corner[i].at;
    return p;
  }
  void keep(const SimplexCorner& a, float weight) {
    corner[count] = a;
    corner[count++].weight = weight;
  }
};

Simplex nearest_on_line(const SimplexCorner& a, const SimplexCorner& b) {
  const Vec3 ab = b.at - a.at;
  const float length2 = ab.squaredNorm();
  const float t = -a.at.dot(ab);
  Simplex out;
  if (t <= 0.0F) {
    out.keep(a, 1.0F);
  } else if (t >= length2) {
    out.keep(b, 1.0F);
  } else {
    out.keep(a, 1.0F - t / length2);
    out.keep(b, t / length2);
  }
  return out;
}

Simplex nearest_on_face(const SimplexCorner& a, const SimplexCorner& b, const SimplexCorner& c) {
  const Vec3 ab = b.at - a.at;
  const Vec3 ac = c.at - a.at;
  const float d1 = -ab.dot(a.at);
  const float d2 = -ac.dot(a.at);
  const float d3 = -ab.dot(b.at);
  const float d4 = -ac.dot(b.at);
  const float d5 = -ab.dot(c.at);
  const float d6 = -ac.dot(c.at);
  Simplex out;
  // From the normal rather than from products of the d: of a large face that passes near the origin these cancel.
  const Vec3 normal = ab.cross(ac);
  const float va = normal.dot(b.at.cross(c.at));
  const float vb = normal.dot(c.at.cross(a.at));
  const float vc = normal.dot(a.at.cross(b.at));
  if (d1 <= 0.0F && d2 <= 0.0F) {
    out.keep(a, 1.0F);
  } else if (d3 >= 0.0F && d4 <= d3) {
    out.keep(b, 1.0F);
  } else if (d6 >= 0.0F && d5 <= d6) {
    out.keep(c, 1.0F);
  } else if (vc <= 0.0F && d1 >= 0.0F && d3 <= 0.0F) {
    out.keep(a, -d3 / (d1 - d3));
    out.keep(b, d1 / (d1 - d3));
  } else if (vb <= 0.0F && d2 >= 0.0F && d6 <= 0.0F) {
    out.keep(a, -d6 / (d2 - d6));
    out.keep(c, d2 / (d2 - d6));
  } else if (va <= 0.0F && d4 >= d3 && d5 >= d6) {
    const float sum = (d4 - d3) + (d5 - d6);
    out.keep(b, (d5 - d6) / sum);
    out.keep(c, (d4 - d3) / sum);
  } else {
    const float sum = va + vb + vc;
    out.keep(a, va / sum);
    out.keep(b, vb / sum);
    out.keep(c, vc / sum);
  }
  return out;
}

// False when the origin is inside.
bool nearest_on_tetrahedron(const Simplex& in, Simplex& out) {
  constexpr std::array<std::array<std::size_t, 4>, 4> kFaces = {
      {{0, 1, 2, 3}, {0, 2, 3, 1}, {0, 3, 1, 2}, {1, 3, 2, 0}}};
  float best = std::numeric_limits<float>::infinity();
  for (const auto& face : kFaces) {
    const SimplexCorner& a = in.corner[face[0]];
    const SimplexCorner& b = in.corner[face[1]];
    const SimplexCorner& c = in.corner[face[2]];
    const Vec3 normal = (b.at - a.at).cross(c.at - a.at);
    const float origin = -normal.dot(a.at);
    const float other = normal.dot(in.corner[face[3]].at - a.at);
    // On the side of the fourth corner. Of a flat tetrahedron rounding decides on which side that is.
    constexpr float kFlat2 = 1.0e-10F;
    const float flat2 =
        kFlat2 * normal.squaredNorm() * std::max((b.at - a.at).squaredNorm(), (c.at - a.at).squaredNorm());
    if (origin * other > 0.0F && other * other > flat2) continue;
    const Simplex candidate = nearest_on_face(a, b, c);
    const float distance2 = candidate.nearest().squaredNorm();
    if (distance2 < best) {
      best = distance2;
      out = candidate;
    }
  }
  return best < std::numeric_limits<float>::infinity();
}

bool reduce(const Simplex& in, Simplex& out) {
  switch (in.count) {
    case 1:
      out = in;
      out.corner[0].weight = 1.0F;
      return true;
    case 2:
      out = nearest_on_line(in.corner[0], in.corner[1]);
      return true;
    case 3:
      out = nearest_on_face(in.corner[0], in.corner[1], in.corner[2]);
      return true;
    default:
      return nearest_on_tetrahedron(in, out);
  }
}

}  // namespace

bool nearest_points(const Convex& a, const Convex& b, const Vec3& shift_m, const Vec3& towards_a,
                    NearestPair& out) noexcept {
  Simplex simplex;
  Vec3 apart = towards_a;
  float length2 = std::numeric_limits<float>::infinity();
  for (int step = 0; step < kMaxSteps; ++step) {
    SimplexCorner found;
    found.of_a = a.farthest(-apart).at_m + shift_m;
    found.of_b = b.farthest(apart).at_m;
    found.at = found.of_a - found.of_b;
    // The origin is behind the plane through `found`, so no point of the difference is nearer than that plane.
    constexpr float kPart = 1.0e-6F;
    if (simplex.count > 0 && apart.dot(apart - found.at) <= kPart * length2) break;
    bool known = false;  // by rounding
    for (std::size_t i = 0; i < simplex.count; ++i) known = known || simplex.corner[i].at == found.at;
    if (known) break;
    Simplex next = simplex;
    next.corner[next.count++] = found;
    Simplex kept;
    if (!reduce(next, kept)) return false;
    const Vec3 nearest = kept.nearest();
    const float now2 = nearest.squaredNorm();
    if (!(now2 < length2)) break;  // rounding: no progress
    simplex = kept;
    apart = nearest;
    const bool slow = now2 > (1.0F - kPart) * length2;
    length2 = now2;
    if (slow) break;
    constexpr float kTouching_m = 1.0e-7F;
    if (length2 < kTouching_m * kTouching_m) return false;
  }
  out.of_a_m = out.of_b_m = Vec3::Zero();
  for (std::size_t i = 0; i < simplex.count; ++i) {
    out.of_a_m += simplex.corner[i].weight * simplex.corner[i].of_a;
    out.of_b_m += simplex.corner[i].weight * simplex.corner[i].of_b;
  }
  out.apart_m = apart;
  return simplex.count > 0;
}

}  // namespace thimble::control

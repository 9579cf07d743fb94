#include "host-tools/compiler/triangle_distance.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

namespace thimble::host {
namespace {

using Eigen::Vector3d;

constexpr double kNever = std::numeric_limits<double>::infinity();

double share(double part, double whole) { return whole > 0.0 ? std::clamp(part / whole, 0.0, 1.0) : 0.0; }

// Squared, of the segments p + s u and q + t v, s and t in [0, 1].
double between_segments2(const Vector3d& p, const Vector3d& u, const Vector3d& q, const Vector3d& v) {
  const Vector3d r = p - q;
  const double uu = u.squaredNorm();
  const double uv = u.dot(v);
  const double vv = v.squaredNorm();
  double s = share(uv * v.dot(r) - u.dot(r) * vv, uu * vv - uv * uv);
  double t = share(uv * s + v.dot(r), vv);
  s = share(uv * t - u.dot(r), uu);
  t = share(uv * s + v.dot(r), vv);
  return (r + s * u - t * v).squaredNorm();
}

// Squared, from a point over the inside of the triangle to its plane; infinity for any other point, which an edge is nearest to.
double over_face2(const Vector3d& p, const Triangle3& t) {
  const Vector3d normal = (t[1] - t[0]).cross(t[2] - t[0]);
  for (std::size_t i = 0; i < 3; ++i) {
    const Vector3d& a = t[i];
    if (!((t[(i + 1) % 3] - a).cross(p - a).dot(normal) > 0.0)) return kNever;
  }
  const double height = normal.dot(p - t[0]);
  return height * height / normal.squaredNorm();
}

bool pierces(const Vector3d& from, const Vector3d& to, const Triangle3& t) {
  const Vector3d normal = (t[1] - t[0]).cross(t[2] - t[0]);
  if (normal.dot(from - t[0]) * normal.dot(to - t[0]) > 0.0) return false;
  const Vector3d way = to - from;
  std::array<double, 3> side;
  for (std::size_t i = 0; i < 3; ++i) side[i] = way.dot((t[i] - from).cross(t[(i + 1) % 3] - from));
  const auto [least, most] = std::minmax_element(side.begin(), side.end());
  return (*least > 0.0 || *most < 0.0) && normal.squaredNorm() > 0.0;
}

}  // namespace

double triangle_distance(const Triangle3& a, const Triangle3& b) {
  double least2 = kNever;
  for (std::size_t i = 0; i < 3; ++i) {
    const Vector3d& from = a[i];
    const Vector3d& to = a[(i + 1) % 3];
    if (pierces(from, to, b) || pierces(b[i], b[(i + 1) % 3], a)) return 0.0;
    for (std::size_t j = 0; j < 3; ++j)
      least2 = std::min(least2, between_segments2(from, to - from, b[j], b[(j + 1) % 3] - b[j]));
    least2 = std::min({least2, over_face2(a[i], b), over_face2(b[i], a)});
  }
  return std::sqrt(least2);
}

double point_distance(const Vector3d& p, const Triangle3& triangle) {
  double least2 = over_face2(p, triangle);
  for (std::size_t i = 0; i < 3; ++i) {
    const Vector3d& from = triangle[i];
    const Vector3d along = triangle[(i + 1) % 3] - from;
    least2 =
        std::min(least2, (p - from - share(along.dot(p - from), along.squaredNorm()) * along).squaredNorm());
  }
  return std::sqrt(least2);
}

}  // namespace thimble::host

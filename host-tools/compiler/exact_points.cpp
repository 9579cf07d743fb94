#include "host-tools/compiler/exact_points.h"

#include <Eigen/Geometry>
#include <bit>
#include <cmath>

namespace thimble::host {
namespace {

// A rounded coordinate is within three steps of a double of the exact one: 2^29 * 3 * 2^-53 = 1.8e-7.
constexpr double kNearError = 4.0e-7;

__extension__ using Wide = __int128;

int sign(double x) { return x > 0.0 ? 1 : -1; }

}  // namespace

int GridPlane::side(const GridPoint& p) const {
  Wide sum = 0;
  for (int i = 0; i < 3; ++i) sum += static_cast<Wide>(normal[i]) * (p[i] - through[i]);
  return sum > 0 ? 1 : sum < 0 ? -1 : 0;
}

GridPlane plane_of(const GridPoint& a, const GridPoint& b, const GridPoint& c) {
  return {(b - a).cross(c - a), a};
}

std::uint32_t ExactPoints::add(Homogeneous p) {
  if (p[3] < 0) {
    for (Integer& x : p) x = -x;
  }
  if (p[3] != 1) {
    const Integer divisor = gcd(gcd(p[0], p[1]), gcd(p[2], p[3]));
    if (divisor != 1) {
      for (Integer& x : p) x /= divisor;
    }
  }
  const auto w = p[3].convert_to<double>();
  Eigen::Vector3d near;
  std::uint64_t hash = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const double x = p[i].convert_to<double>() / w + 0.0;
    near[static_cast<Eigen::Index>(i)] = x;
    hash = (hash ^ std::bit_cast<std::uint64_t>(x)) * 0x9E3779B97F4A7C15ULL;
    hash ^= hash >> 29U;
  }
  const auto [begin, end] = index_.equal_range(hash);
  for (auto entry = begin; entry != end; ++entry) {
    if (exact_[entry->second] == p) return entry->second;
  }
  const auto id = static_cast<std::uint32_t>(exact_.size());
  exact_.push_back(std::move(p));
  near_.push_back(near);
  index_.emplace(hash, id);
  return id;
}

std::uint32_t ExactPoints::add(const GridPoint& p) { return add(Homogeneous{p.x(), p.y(), p.z(), 1}); }

std::uint32_t ExactPoints::add(const GridPoint& p, const GridPoint& q, const GridPlane& plane) {
  const auto height = [&plane](const GridPoint& at) {
    Integer sum = 0;
    for (int i = 0; i < 3; ++i) sum += Integer(plane.normal[i]) * (at[i] - plane.through[i]);
    return sum;
  };
  const Integer a = height(p);
  const Integer b = height(q);
  Homogeneous meet;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto axis = static_cast<Eigen::Index>(i);
    meet[i] = a * q[axis] - b * p[axis];
  }
  meet[3] = a - b;
  return add(std::move(meet));
}

std::uint32_t ExactPoints::add(const GridPlane& a, const GridPlane& b, const GridPlane& c) {
  using Triple = std::array<Integer, 3>;
  const auto cross = [](const GridPoint& u, const GridPoint& v) {
    Triple product;
    for (std::size_t i = 0; i < 3; ++i) {
      const auto j = static_cast<Eigen::Index>((i + 1) % 3);
      const auto k = static_cast<Eigen::Index>((i + 2) % 3);
      product[i] = Integer(u[j]) * v[k] - Integer(u[k]) * v[j];
    }
    return product;
  };
  const auto dot = [](const GridPoint& u, const auto& v) {
    return Integer(Integer(u[0]) * v[0] + Integer(u[1]) * v[1] + Integer(u[2]) * v[2]);
  };
  const Triple bc = cross(b.normal, c.normal);
  const Triple ca = cross(c.normal, a.normal);
  const Triple ab = cross(a.normal, b.normal);
  const Integer da = dot(a.normal, a.through);
  const Integer db = dot(b.normal, b.through);
  const Integer dc = dot(c.normal, c.through);
  Homogeneous meet;
  for (std::size_t i = 0; i < 3; ++i) meet[i] = da * bc[i] + db * ca[i] + dc * ab[i];
  meet[3] = dot(a.normal, bc);
  return add(std::move(meet));
}

int ExactPoints::turn(int axis, std::uint32_t a, std::uint32_t b, std::uint32_t c) const {
  const int u = (axis + 1) % 3;
  const int v = (axis + 2) % 3;
  const double bu = near_[b][u] - near_[a][u];
  const double bv = near_[b][v] - near_[a][v];
  const double cu = near_[c][u] - near_[a][u];
  const double cv = near_[c][v] - near_[a][v];
  const double left = bu * cv;
  const double right = bv * cu;
  const double error =
      2.0 * kNearError * (std::abs(bu) + std::abs(bv) + std::abs(cu) + std::abs(cv) + kNearError) +
      1.0e-15 * (std::abs(left) + std::abs(right));
  if (std::abs(left - right) > error) return sign(left - right);
  const auto at = [this](std::uint32_t p, int i) -> const Integer& {
    return exact_[p][static_cast<std::size_t>(i)];
  };
  const auto minor = [&](std::uint32_t p, std::uint32_t q, int i, int j) {
    return Integer(at(p, i) * at(q, j) - at(p, j) * at(q, i));
  };
  const Integer sum =
      at(a, u) * minor(b, c, v, 3) - at(a, v) * minor(b, c, u, 3) + at(a, 3) * minor(b, c, u, v);
  return sum.sign();
}

int ExactPoints::compare(int axis, std::uint32_t a, std::uint32_t b) const {
  const double difference = near_[a][axis] - near_[b][axis];
  if (std::abs(difference) > 2.0 * kNearError) return sign(difference);
  const auto i = static_cast<std::size_t>(axis);
  return Integer(exact_[a][i] * exact_[b][3] - exact_[b][i] * exact_[a][3]).sign();
}

}  // namespace thimble::host

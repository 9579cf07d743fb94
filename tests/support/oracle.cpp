#include "tests/support/oracle.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <unordered_set>
#include <utility>

#include "tests/support/random.h"

namespace thimble::test {

namespace {

constexpr std::uint32_t kLeafTriangles = 4;
constexpr int kMaxDepth = 64;

// Six times the signed volume of a tetrahedron.
double volume(const Vector3d& a, const Vector3d& b, const Vector3d& c, const Vector3d& d) {
  return (b - a).cross(c - a).dot(d - a);
}

// Ericson, Real-Time Collision Detection 2005, 5.1.5.
Vector3d closest_on_triangle(const Vector3d& p, const Vector3d& a, const Vector3d& b, const Vector3d& c) {
  const Vector3d ab = b - a;
  const Vector3d ac = c - a;
  const double d1 = ab.dot(p - a);
  const double d2 = ac.dot(p - a);
  if (d1 <= 0.0 && d2 <= 0.0) return a;
  const double d3 = ab.dot(p - b);
  const double d4 = ac.dot(p - b);
  if (d3 >= 0.0 && d4 <= d3) return b;
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0) return a + d1 / (d1 - d3) * ab;
  const double d5 = ab.dot(p - c);
  const double d6 = ac.dot(p - c);
  if (d6 >= 0.0 && d5 <= d6) return c;
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0) return a + d2 / (d2 - d6) * ac;
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0) return b + (d4 - d3) / ((d4 - d3) + (d5 - d6)) * (c - b);
  const double whole = va + vb + vc;
  return a + vb / whole * ab + vc / whole * ac;
}

double distance_to(const Eigen::AlignedBox3d& box, const Vector3d& p) {
  return std::sqrt(box.squaredExteriorDistance(p));
}

bool touches(const Eigen::AlignedBox3d& box, const Vector3d& from, const Vector3d& to) {
  double enter = 0.0;
  double leave = 1.0;
  for (int axis = 0; axis < 3; ++axis) {
    const double d = to[axis] - from[axis];
    if (d == 0.0) {
      if (from[axis] < box.min()[axis] || from[axis] > box.max()[axis]) return false;
      continue;
    }
    const double one = (box.min()[axis] - from[axis]) / d;
    const double other = (box.max()[axis] - from[axis]) / d;
    enter = std::max(enter, std::min(one, other) - 1e-12);
    leave = std::min(leave, std::max(one, other) + 1e-12);
  }
  return enter <= leave;
}

}  // namespace

MeshOracle::MeshOracle(const host::TriangleSoup& soup) {
  for (const auto& triangle : soup.triangles) {
    const std::array<Vector3d, 3> corners = {soup.vertices_m[triangle[0]], soup.vertices_m[triangle[1]],
                                             soup.vertices_m[triangle[2]]};
    corners_.push_back(corners);
    normals_.push_back((corners[1] - corners[0]).cross(corners[2] - corners[0]).normalized());
  }
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::pair<std::uint32_t, std::size_t>> open_edges;
  across_.resize(corners_.size());
  for (std::uint32_t t = 0; t < across_.size(); ++t) {
    for (std::size_t edge = 0; edge < 3; ++edge) {
      across_[t][edge] = t;
      const auto ends = std::minmax(soup.triangles[t][edge], soup.triangles[t][(edge + 1) % 3]);
      const auto [found, fresh] = open_edges.try_emplace({ends.first, ends.second}, t, edge);
      if (fresh) continue;
      const auto [other, other_edge] = found->second;
      across_[t][edge] = other;
      across_[other][other_edge] = t;
    }
  }
  order_.resize(corners_.size());
  std::iota(order_.begin(), order_.end(), 0U);
  nodes_.emplace_back();
  build(0, 0, static_cast<std::uint32_t>(order_.size()), 0);
}

Vector3d MeshOracle::corner(std::uint32_t triangle, int corner) const {
  return corners_[triangle][static_cast<std::size_t>(corner)];
}

void MeshOracle::build(std::uint32_t node, std::uint32_t first, std::uint32_t count, int depth) {
  Eigen::AlignedBox3d box;
  for (std::uint32_t i = first; i < first + count; ++i) {
    for (const Vector3d& corner : corners_[order_[i]]) box.extend(corner);
  }
  nodes_[node].box = box;
  nodes_[node].first = first;
  nodes_[node].count = count;
  if (count <= kLeafTriangles || depth >= kMaxDepth) return;
  int axis = 0;
  box.sizes().maxCoeff(&axis);
  const auto key = [&](std::uint32_t t) {
    const auto& c = corners_[t];
    return c[0][axis] + c[1][axis] + c[2][axis];
  };
  const auto begin = order_.begin() + first;
  const std::uint32_t half = count / 2;
  std::nth_element(begin, begin + half, begin + count, [&](auto a, auto b) { return key(a) < key(b); });
  const auto left = static_cast<std::uint32_t>(nodes_.size());
  nodes_.emplace_back();
  nodes_.emplace_back();
  nodes_[node].count = 0;
  nodes_[node].first = left;
  nodes_[node].right = left + 1;
  build(left, first, half, depth + 1);
  build(left + 1, first + half, count - half, depth + 1);
}

Vector3d MeshOracle::closest_on(std::uint32_t triangle, const Vector3d& p) const {
  const auto& c = corners_[triangle];
  return closest_on_triangle(p, c[0], c[1], c[2]);
}

Nearest MeshOracle::nearest(const Vector3d& p, double within_m) const {
  Nearest best;
  double bound = within_m;
  std::array<std::uint32_t, 2 * kMaxDepth + 2> stack{};
  std::size_t top = 0;
  stack[top++] = 0;
  while (top > 0) {
    const Node& node = nodes_[stack[--top]];
    if (distance_to(node.box, p) > bound) continue;
    if (node.count > 0) {
      for (std::uint32_t i = node.first; i < node.first + node.count; ++i) {
        const Vector3d point = closest_on(order_[i], p);
        const double distance = (point - p).norm();
        if (distance <= bound && distance < best.distance_m) {
          bound = distance;
          best = {distance, point, order_[i]};
        }
      }
      continue;
    }
    const bool left_first = distance_to(nodes_[node.first].box, p) < distance_to(nodes_[node.right].box, p);
    stack[top++] = left_first ? node.right : node.first;
    stack[top++] = left_first ? node.first : node.right;
  }
  return best;
}

double MeshOracle::signed_distance(const Vector3d& p, double within_m) const {
  const Nearest found = nearest(p, within_m);
  if (found.triangle == 0xFFFFFFFF) return within_m;
  std::vector<std::uint32_t> equal;
  near(p, found.distance_m * (1.0 + 1e-9) + 1e-12, equal);
  double side = 0.0;
  for (const std::uint32_t t : equal) {
    const double height = normals_[t].dot(p - corners_[t][0]);
    if (std::abs(height) > std::abs(side)) side = height;
  }
  return std::copysign(found.distance_m, side);
}

void MeshOracle::near(const Vector3d& p, double radius_m, std::vector<std::uint32_t>& triangles) const {
  triangles.clear();
  std::array<std::uint32_t, 2 * kMaxDepth + 2> stack{};
  std::size_t top = 0;
  stack[top++] = 0;
  while (top > 0) {
    const Node& node = nodes_[stack[--top]];
    if (distance_to(node.box, p) > radius_m) continue;
    if (node.count == 0) {
      stack[top++] = node.first;
      stack[top++] = node.right;
      continue;
    }
    for (std::uint32_t i = node.first; i < node.first + node.count; ++i) {
      if ((closest_on(order_[i], p) - p).norm() <= radius_m) triangles.push_back(order_[i]);
    }
  }
}

bool MeshOracle::way_over(const Vector3d& a, const Vector3d& b, const Vector3d& centre,
                          double radius_m) const {
  constexpr double kOn_m = 1e-7;
  std::vector<std::uint32_t> open;
  std::vector<std::uint32_t> ends;
  near(a, kOn_m, open);
  near(b, kOn_m, ends);
  std::unordered_set<std::uint32_t> seen(open.begin(), open.end());
  while (!open.empty()) {
    const std::uint32_t t = open.back();
    open.pop_back();
    if (std::find(ends.begin(), ends.end(), t) != ends.end()) return true;
    for (std::size_t edge = 0; edge < 3; ++edge) {
      const Vector3d& from = corners_[t][edge];
      const Vector3d along_edge = corners_[t][(edge + 1) % 3] - from;
      const double along = std::clamp((centre - from).dot(along_edge) / along_edge.squaredNorm(), 0.0, 1.0);
      if ((from + along * along_edge - centre).norm() > radius_m) continue;
      if (seen.insert(across_[t][edge]).second) open.push_back(across_[t][edge]);
    }
  }
  return false;
}

template <typename Visit>
void MeshOracle::along(const Vector3d& from, const Vector3d& to, const Visit& visit) const {
  std::array<std::uint32_t, 2 * kMaxDepth + 2> stack{};
  std::size_t top = 0;
  stack[top++] = 0;
  while (top > 0) {
    const Node& node = nodes_[stack[--top]];
    if (!touches(node.box, from, to)) continue;
    if (node.count == 0) {
      stack[top++] = node.first;
      stack[top++] = node.right;
      continue;
    }
    for (std::uint32_t i = node.first; i < node.first + node.count; ++i) {
      const auto& [a, b, c] = corners_[order_[i]];
      const double start = volume(a, b, c, from);
      const double end = volume(a, b, c, to);
      if ((start > 0.0) == (end > 0.0)) continue;
      // The line passes the three edges on the same side.
      const double u = volume(from, to, a, b);
      const double v = volume(from, to, b, c);
      const double w = volume(from, to, c, a);
      const bool hit = (u >= 0.0 && v >= 0.0 && w >= 0.0) || (u <= 0.0 && v <= 0.0 && w <= 0.0);
      if (hit && !visit(Crossing{start / (start - end), order_[i], start > 0.0})) return;
    }
  }
}

std::vector<Crossing> MeshOracle::crossings(const Vector3d& from, const Vector3d& to) const {
  std::vector<Crossing> found;
  along(from, to, [&](const Crossing& crossing) {
    found.push_back(crossing);
    return true;
  });
  std::sort(found.begin(), found.end(), [](const Crossing& a, const Crossing& b) { return a.t < b.t; });
  return found;
}

bool MeshOracle::crosses(const Vector3d& from, const Vector3d& to) const {
  bool found = false;
  along(from, to, [&](const Crossing&) {
    found = true;
    return false;
  });
  return found;
}

bool way_around(const MeshOracle& mesh, const Vector3d& a, const Vector3d& b, const Vector3d& centre,
                double radius_m, int samples, std::uint64_t seed) {
  Random random(seed);
  std::vector<Vector3d> points = {b};
  while (static_cast<int>(points.size()) < samples) {
    // Anywhere in the ball, about the straight line, and on the surface about the line.
    const Vector3d about =
        a + random.uniform(-0.2, 1.2) * (b - a) + 0.8 * (b - a).norm() * random.in_box(Vector3d::Ones());
    Vector3d p =
        points.size() % 4 == 0 ? Vector3d(centre + radius_m * random.in_box(Vector3d::Ones())) : about;
    if (points.size() % 4 > 1) {
      const Nearest nearest = mesh.nearest(p);
      const double lift = std::exp(random.uniform(std::log(1e-6), std::log(1e-3)));
      p = nearest.point + lift * mesh.normal(nearest.triangle);
    }
    if ((p - centre).norm() <= radius_m) points.push_back(p);
  }
  std::vector<Vector3d> open = {a};
  while (!open.empty()) {
    const Vector3d from = open.back();
    open.pop_back();
    for (std::size_t i = 0; i < points.size();) {
      if (mesh.crosses(from, points[i])) {
        ++i;
        continue;
      }
      if (i == 0 && points.front() == b) return true;
      open.push_back(points[i]);
      points[i] = points.back();
      points.pop_back();
    }
  }
  return false;
}

Vector3d project_on_cone(const Vector3d& wanted, const std::vector<Vector3d>& normals) {
  const double slack = 1e-12 * (wanted.norm() + 1e-9);
  const auto allowed = [&](const Vector3d& v) {
    return std::all_of(normals.begin(), normals.end(), [&](const Vector3d& n) { return v.dot(n) >= -slack; });
  };
  if (allowed(wanted)) return wanted;
  Vector3d best = Vector3d::Zero();
  double best_distance = wanted.squaredNorm();
  const auto offer = [&](const Vector3d& v) {
    const double distance = (v - wanted).squaredNorm();
    if (distance < best_distance && allowed(v)) {
      best = v;
      best_distance = distance;
    }
  };
  for (std::size_t i = 0; i < normals.size(); ++i) {
    offer(wanted - normals[i] * wanted.dot(normals[i]));
    for (std::size_t j = i + 1; j < normals.size(); ++j) {
      const Vector3d line = normals[i].cross(normals[j]);
      if (line.norm() > 1e-6) offer(line * (wanted.dot(line) / line.squaredNorm()));
    }
  }
  return best;  // zero: held by three constraints, or by none that permits descent
}

ReferenceGodObject::ReferenceGodObject(const MeshOracle& mesh, double step_m, double clearance_m)
    : mesh_(mesh), step_m_(step_m), clearance_m_(clearance_m) {}

bool ReferenceGodObject::follow(const Vector3d& tip, int max_steps) {
  const double active_m = 2.0 * clearance_m_;
  for (int step = 0; step < max_steps; ++step) {
    mesh_.near(g_, active_m, near_);
    std::vector<Vector3d> normals;
    for (const std::uint32_t t : near_) {
      const Vector3d away = g_ - mesh_.closest_on(t, g_);
      const double distance = away.norm();
      if (distance < clearance_m_) g_ += away * ((clearance_m_ - distance) / distance);
      const Vector3d n = away / distance;
      const auto same = [&](const Vector3d& other) { return other.dot(n) > 1.0 - 1e-12; };
      if (std::none_of(normals.begin(), normals.end(), same)) normals.push_back(n);
    }
    const Vector3d wanted = project_on_cone(tip - g_, normals);
    const double length = wanted.norm();
    if (length < 1e-3 * clearance_m_ || length < 1e-7 * (tip - g_).norm()) return true;
    // The longest step, up to step_m, that stays off everything that is not yet a wall.
    double reach = std::min(step_m_, length);
    const Vector3d direction = wanted / length;
    const auto blocked = [&](double s) {
      const Vector3d to = g_ + s * direction;
      if (mesh_.crosses(g_, to)) return true;
      return mesh_.nearest(to, 0.9 * clearance_m_).triangle != 0xFFFFFFFF;
    };
    if (blocked(reach)) {
      double free = 0.0;
      for (int i = 0; i < 40; ++i) {
        const double middle = 0.5 * (free + reach);
        (blocked(middle) ? reach : free) = middle;
      }
      reach = free;
      if (reach < 1e-3 * clearance_m_) return true;  // held
    }
    g_ += reach * direction;
  }
  return false;
}

}  // namespace thimble::test

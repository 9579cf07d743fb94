#include "host-tools/compiler/plane_graph.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <deque>
#include <unordered_set>

namespace thimble::host {
namespace {

using Eigen::Vector3d;

constexpr double kBoxSlack = 1.0e-5;  // grid steps: more than a rounded point is off

}  // namespace

PlaneGraph::PlaneGraph(ExactPoints& points, const GridPlane& plane, int axis)
    : points_(points), plane_(plane), axis_(axis) {}

// The points where two segments cross between their ends.
void PlaneGraph::find_crossings() {
  struct Box {
    std::array<double, 2> lo;
    std::array<double, 2> hi;
    std::size_t segment;
  };
  std::vector<Box> boxes;
  for (std::size_t i = 0; i < segments_.size(); ++i) {
    Box box{{}, {}, i};
    for (std::size_t k = 0; k < 2; ++k) {
      const int axis = (axis_ + 1 + static_cast<int>(k)) % 3;
      const auto [lo, hi] =
          std::minmax(points_.near(segments_[i].a)[axis], points_.near(segments_[i].b)[axis]);
      box.lo[k] = lo - kBoxSlack;
      box.hi[k] = hi + kBoxSlack;
    }
    boxes.push_back(box);
  }
  std::sort(boxes.begin(), boxes.end(), [](const Box& a, const Box& b) {
    return a.lo[0] != b.lo[0] ? a.lo[0] < b.lo[0] : a.segment < b.segment;
  });
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    const PlaneSegment& s = segments_[boxes[i].segment];
    for (std::size_t j = i + 1; j < boxes.size() && boxes[j].lo[0] <= boxes[i].hi[0]; ++j) {
      if (boxes[j].lo[1] > boxes[i].hi[1] || boxes[j].hi[1] < boxes[i].lo[1]) continue;
      const PlaneSegment& r = segments_[boxes[j].segment];
      if (turn(s.a, s.b, r.a) * turn(s.a, s.b, r.b) < 0 && turn(r.a, r.b, s.a) * turn(r.a, r.b, s.b) < 0)
        corners_.push_back(points_.add(plane_, s.line, r.line));
    }
  }
}

// Cuts each segment at the points that lie on it.
void PlaneGraph::split_segments() {
  const int u = (axis_ + 1) % 3;
  const int v = (axis_ + 2) % 3;
  std::sort(corners_.begin(), corners_.end(), [&](std::uint32_t a, std::uint32_t b) {
    const double x = points_.near(a)[u];
    const double y = points_.near(b)[u];
    return x != y ? x < y : a < b;
  });
  corners_.erase(std::unique(corners_.begin(), corners_.end()), corners_.end());
  for (const PlaneSegment& s : segments_) {
    const Vector3d& a = points_.near(s.a);
    const Vector3d& b = points_.near(s.b);
    const int along = std::abs(b[u] - a[u]) > std::abs(b[v] - a[v]) ? u : v;
    const auto [lo_u, hi_u] = std::minmax(a[u], b[u]);
    const auto [lo_v, hi_v] = std::minmax(a[v], b[v]);
    std::vector<std::uint32_t>& chain = chains_.emplace_back();
    auto at = std::lower_bound(corners_.begin(), corners_.end(), lo_u - kBoxSlack,
                               [&](std::uint32_t p, double x) { return points_.near(p)[u] < x; });
    for (; at != corners_.end() && points_.near(*at)[u] <= hi_u + kBoxSlack; ++at) {
      const double y = points_.near(*at)[v];
      if (*at == s.a || *at == s.b || y < lo_v - kBoxSlack || y > hi_v + kBoxSlack) continue;
      if (turn(s.a, s.b, *at) == 0 && points_.compare(along, *at, s.a) * points_.compare(along, *at, s.b) < 0)
        chain.push_back(*at);
    }
    const int direction = points_.compare(along, s.b, s.a);
    std::sort(chain.begin(), chain.end(),
              [&](std::uint32_t p, std::uint32_t q) { return points_.compare(along, p, q) * direction < 0; });
    chain.insert(chain.begin(), s.a);
    chain.push_back(s.b);
  }
}

void PlaneGraph::link(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
  apex_[edge(a, b)] = c;
  apex_[edge(b, c)] = a;
  apex_[edge(c, a)] = b;
  spoke_[a] = b;
  spoke_[b] = c;
  spoke_[c] = a;
  last_ = {a, b, c};
}

void PlaneGraph::unlink(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
  apex_.erase(edge(a, b));
  apex_.erase(edge(b, c));
  apex_.erase(edge(c, a));
}

void PlaneGraph::place_frame() {
  constexpr std::int64_t kFar = 4 * kGridHalf;
  constexpr std::array<std::array<std::int64_t, 2>, 3> kPlaces{{{-kFar, -kFar}, {kFar, -kFar}, {0, kFar}}};
  for (std::size_t i = 0; i < 3; ++i) {
    GridPoint p = GridPoint::Zero();
    p[(axis_ + 1) % 3] = kPlaces[i][0];
    p[(axis_ + 2) % 3] = kPlaces[i][1];
    frame_[i] = points_.add(p);
  }
  link(frame_[0], frame_[1], frame_[2]);
}

bool PlaneGraph::insert(std::uint32_t p) {
  if (spoke_.contains(p)) return true;
  std::array<std::uint32_t, 3> t = last_;
  std::array<int, 3> side{};
  for (std::size_t steps = 0;; ++steps) {
    if (steps > 2 * apex_.size() + 64) return false;
    bool moved = false;
    for (std::size_t k = 0; k < 3 && !moved; ++k) {
      const std::size_t i = (k + steps) % 3;  // another edge first each time: the walk cannot circle
      side[i] = turn(t[i], t[(i + 1) % 3], p);
      if (side[i] < 0) {
        const auto next = apex_.find(edge(t[(i + 1) % 3], t[i]));
        if (next == apex_.end()) return false;
        t = {t[(i + 1) % 3], t[i], next->second};
        moved = true;
      }
    }
    if (!moved) break;
  }
  std::vector<Edge> suspects;
  unlink(t[0], t[1], t[2]);
  const auto on = static_cast<std::size_t>(std::find(side.begin(), side.end(), 0) - side.begin());
  for (std::size_t i = 0; i < 3; ++i) {
    if (i == on) continue;
    link(t[i], t[(i + 1) % 3], p);
    suspects.push_back(edge(t[i], t[(i + 1) % 3]));
  }
  if (on < 3) {
    const std::uint32_t from = t[on];
    const std::uint32_t to = t[(on + 1) % 3];
    const auto beyond = apex_.find(edge(to, from));
    if (beyond == apex_.end()) return false;
    const std::uint32_t d = beyond->second;
    unlink(to, from, d);
    link(from, d, p);
    link(d, to, p);
    suspects.push_back(edge(from, d));
    suspects.push_back(edge(d, to));
  }
  legalise(suspects);
  return true;
}

// Whether the diagonal a-b of the quadrilateral a, d, b, c (c left of a-b, d right of it) can be replaced by c-d.
bool PlaneGraph::can_flip(std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) const {
  return turn(c, a, d) > 0 && turn(d, b, c) > 0;
}

void PlaneGraph::flip(std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
  unlink(a, b, c);
  unlink(b, a, d);
  link(c, a, d);
  link(d, b, c);
}

// In rounded arithmetic: only the shape of the triangles depends on it.
bool PlaneGraph::in_circle(std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) const {
  const GridPoint& n = plane_.normal;
  const Vector3d normal = n.cast<double>().normalized();
  const Vector3d at = points_.near(d);
  Eigen::Matrix3d rows;
  const std::array<std::uint32_t, 3> corners{a, b, c};
  // An orthonormal frame of the plane, so that the shape is the true one and not its projection.
  Vector3d x = Vector3d::Unit((axis_ + 1) % 3);
  x = (x - normal * normal.dot(x)).normalized();
  const Vector3d y = (n[axis_] > 0 ? normal : Vector3d(-normal)).cross(x);
  for (int i = 0; i < 3; ++i) {
    const Vector3d r = points_.near(corners[static_cast<std::size_t>(i)]) - at;
    const double s = r.dot(x);
    const double t = r.dot(y);
    rows.row(i) << s, t, s * s + t * t;
  }
  return rows.determinant() > 0.0;
}

void PlaneGraph::legalise(std::vector<Edge>& suspects) {
  const auto framed = [this](std::uint32_t p) {
    return std::find(frame_.begin(), frame_.end(), p) != frame_.end();
  };
  for (std::size_t budget = 1000; budget > 0 && !suspects.empty(); --budget) {
    const auto a = static_cast<std::uint32_t>(suspects.back() >> 32U);
    const auto b = static_cast<std::uint32_t>(suspects.back());
    suspects.pop_back();
    const auto left = apex_.find(edge(a, b));
    const auto right = apex_.find(edge(b, a));
    if (left == apex_.end() || right == apex_.end()) continue;
    const std::uint32_t c = left->second;
    const std::uint32_t d = right->second;
    if (framed(a) || framed(b) || framed(c) || framed(d)) {
      continue;  // the frame is far away, and not in the plane
    }
    if (!in_circle(a, b, c, d) || !can_flip(a, b, c, d)) continue;
    flip(a, b, c, d);
    suspects.push_back(edge(a, d));
    suspects.push_back(edge(d, b));
  }
}

// The edges that the segment a-b crosses, each from its right to its left. No point lies on the segment.
bool PlaneGraph::edges_across(std::uint32_t a, std::uint32_t b, std::vector<Edge>& across) const {
  const auto start = spoke_.find(a);
  if (start == spoke_.end()) return false;
  std::uint32_t x = start->second;
  std::uint32_t y = 0;
  for (std::size_t steps = 0;; ++steps) {
    const auto next = apex_.find(edge(a, x));
    if (next == apex_.end() || steps > apex_.size()) return false;
    y = next->second;
    if (turn(a, x, b) > 0 && turn(a, y, b) < 0) break;
    x = y;
  }
  for (std::size_t steps = 0; steps <= apex_.size(); ++steps) {
    across.push_back(edge(x, y));
    const auto next = apex_.find(edge(y, x));
    if (next == apex_.end()) return false;
    const std::uint32_t z = next->second;
    if (z == b) return true;
    (turn(a, b, z) > 0 ? y : x) = z;
  }
  return false;
}

// Makes a-b an edge by flips (Sloan 1993).
bool PlaneGraph::constrain(std::uint32_t a, std::uint32_t b) {
  if (apex_.contains(edge(a, b)) || apex_.contains(edge(b, a))) return true;
  std::vector<Edge> found;
  if (!edges_across(a, b, found)) return false;
  std::deque<Edge> across(found.begin(), found.end());
  std::size_t budget = 64 + 16 * across.size() * across.size();
  for (; !across.empty() && budget > 0; --budget) {
    const Edge crossing = across.front();
    across.pop_front();
    const auto x = static_cast<std::uint32_t>(crossing >> 32U);
    const auto y = static_cast<std::uint32_t>(crossing);
    const auto left = apex_.find(edge(x, y));
    const auto right = apex_.find(edge(y, x));
    if (left == apex_.end() || right == apex_.end()) return false;
    const std::uint32_t c = left->second;
    const std::uint32_t d = right->second;
    if (!can_flip(x, y, c, d)) {
      across.push_back(crossing);
      continue;
    }
    flip(x, y, c, d);
    if (c != a && c != b && d != a && d != b && turn(a, b, c) * turn(a, b, d) < 0)
      across.push_back(turn(a, b, c) < 0 ? edge(c, d) : edge(d, c));
  }
  return across.empty() && (apex_.contains(edge(a, b)) || apex_.contains(edge(b, a)));
}

bool PlaneGraph::triangulate() {
  for (const PlaneSegment& s : segments_) {
    corners_.push_back(s.a);
    corners_.push_back(s.b);
  }
  find_crossings();
  split_segments();
  place_frame();
  for (const std::uint32_t p : corners_) {
    if (!insert(p)) return false;
  }
  for (const std::vector<std::uint32_t>& chain : chains_) {
    for (std::size_t i = 1; i < chain.size(); ++i) {
      if (!constrain(chain[i - 1], chain[i])) return false;
    }
  }
  for (const auto& [key, c] : apex_) {
    const auto a = static_cast<std::uint32_t>(key >> 32U);
    const auto b = static_cast<std::uint32_t>(key);
    if (a < b && a < c) triangles_.push_back({a, b, c});
  }
  std::sort(triangles_.begin(), triangles_.end());  // the map has no order of its own
  return true;
}

std::vector<char> PlaneGraph::enclosed_by(std::size_t first, std::size_t count) const {
  std::unordered_set<Edge> walls;
  for (std::size_t s = first; s < first + count; ++s) {
    for (std::size_t i = 1; i < chains_[s].size(); ++i) {
      walls.insert(edge(chains_[s][i - 1], chains_[s][i]));
      walls.insert(edge(chains_[s][i], chains_[s][i - 1]));
    }
  }
  std::unordered_map<Edge, std::size_t> left_of;
  for (std::size_t t = 0; t < triangles_.size(); ++t) {
    for (std::size_t i = 0; i < 3; ++i) left_of[edge(triangles_[t][i], triangles_[t][(i + 1) % 3])] = t;
  }
  std::vector<char> enclosed(triangles_.size(), 1);
  std::vector<std::size_t> open;
  const auto reach = [&](std::size_t t) {
    if (enclosed[t] == 0) return;
    enclosed[t] = 0;
    open.push_back(t);
  };
  for (std::size_t t = 0; t < triangles_.size(); ++t) {
    for (const std::uint32_t corner : triangles_[t]) {
      if (std::find(frame_.begin(), frame_.end(), corner) != frame_.end()) reach(t);
    }
  }
  while (!open.empty()) {
    const std::size_t t = open.back();
    open.pop_back();
    for (std::size_t i = 0; i < 3; ++i) {
      const std::uint32_t a = triangles_[t][i];
      const std::uint32_t b = triangles_[t][(i + 1) % 3];
      const auto other = left_of.find(edge(b, a));
      if (!walls.contains(edge(a, b)) && other != left_of.end()) reach(other->second);
    }
  }
  return enclosed;
}

}  // namespace thimble::host

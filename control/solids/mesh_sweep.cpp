// Sweeps through a mesh: a segment against the tree, and against the triangles without gaps between them.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "control/scene/limits.h"
#include "control/scene/mesh_leaf.h"
#include "control/solids/mesh.h"
#include "control/solids/mesh_topology.h"
#include "control/solids/near_triangles.h"

namespace thimble::control {

using namespace topology;  // NOLINT(google-build-using-namespace): this file is about nothing else

namespace {

constexpr int kMaxNodeVisits = 2048;  // of one sweep

// A segment, prepared for the tests against the tree and the triangles.
struct Segment {
  Vec3 from;  // raised by `lift`
  Vec3 lift;  // off a sheet
  Vec3 to;
  int x, y, z;  // z: the axis along which the segment is longest (Woop, Benthin and Wald 2013)
  float shear_x, shear_y;
  // Of it as far as it is free, from `from` on:
  Vec3 lo_m, hi_m;    // its box, with a margin
  GridBox box;        // the same in the mesh's grid
  Vec3 middle, half;  // its middle and half vector, in grid steps
  bool misses;        // the mesh's grid altogether
  bool is_short;      // compared with most boxes
};

// Forgets what is behind the nearest hit.
void shorten(const MeshView& mesh, Segment& s, float t) {
  // Two grid steps for rounding, and the surface tolerance.
  const float margin = 2.0F + 2.0F * kSurfaceTolerance_m * mesh.grid_scale;
  constexpr float kGridEnd = 65535.0F;
  constexpr float kShort = 8.0F;
  const Vec3 to = s.from + std::min(t, 1.0F) * (s.to - s.from);
  const Vec3 a = (s.from - mesh.grid_origin_m) * mesh.grid_scale;
  const Vec3 b = (to - mesh.grid_origin_m) * mesh.grid_scale;
  for (int axis = 0; axis < 3; ++axis) {
    const float lo = std::min(a[axis], b[axis]) - margin;
    const float hi = std::max(a[axis], b[axis]) + margin;
    if (!(hi >= 0.0F && lo <= kGridEnd)) s.misses = true;
    s.box.lo[static_cast<std::size_t>(axis)] = static_cast<std::uint32_t>(std::clamp(lo, 0.0F, kGridEnd));
    s.box.hi[static_cast<std::size_t>(axis)] = static_cast<std::uint32_t>(std::clamp(hi, 0.0F, kGridEnd));
  }
  s.middle = 0.5F * (a + b);
  s.half = 0.5F * (b - a);
  s.is_short = s.half.cwiseAbs().maxCoeff() <= kShort;
  const Vec3 margin_m = Vec3::Constant(2.0F * margin * mesh.grid_step_m);
  s.lo_m = s.from.cwiseMin(to) - margin_m;
  s.hi_m = s.from.cwiseMax(to) + margin_m;
}

Segment prepare(const MeshView& mesh, const Vec3& from, const Vec3& lift, const Vec3& to, float t) {
  Segment s{};
  s.from = from;
  s.lift = lift;
  s.to = to;
  const Vec3 d = to - from;
  d.cwiseAbs().maxCoeff(&s.z);
  s.x = s.z == 2 ? 0 : s.z + 1;
  s.y = s.x == 2 ? 0 : s.x + 1;
  const float length = d[s.z];
  s.shear_x = length != 0.0F ? d[s.x] / length : 0.0F;
  s.shear_y = length != 0.0F ? d[s.y] / length : 0.0F;
  shorten(mesh, s, t);
  return s;
}

template <typename Place>
bool overlaps(const Segment& s, const Place& lo, const Place& hi) {
  for (std::uint16_t axis = 0; axis < 3; ++axis) {
    if (lo[axis] > s.box.hi[axis] || hi[axis] < s.box.lo[axis]) return false;
  }
  // Separating axes across the segment, for segments that are long compared with the boxes.
  if (s.is_short) return true;
  Vec3 centre;
  Vec3 extent;
  for (std::uint16_t axis = 0; axis < 3; ++axis) {
    const auto l = static_cast<float>(lo[axis]);
    const auto h = static_cast<float>(hi[axis]);
    centre[axis] = 0.5F * (l + h) - s.middle[axis];
    extent[axis] = 0.5F * (h - l) + 4.0F;
  }
  const Vec3 d = s.half.cwiseAbs();
  return std::abs(s.half.y() * centre.z() - s.half.z() * centre.y()) <=
             extent.y() * d.z() + extent.z() * d.y() &&
         std::abs(s.half.z() * centre.x() - s.half.x() * centre.z()) <=
             extent.z() * d.x() + extent.x() * d.z() &&
         std::abs(s.half.x() * centre.y() - s.half.y() * centre.x()) <=
             extent.x() * d.y() + extent.y() * d.x();
}

// Of the children of a node, by their middles along the longest axis of the segment.
bool first_is_nearer(const Segment& s, const scene::BvhNode& node) {
  const auto axis = static_cast<std::uint16_t>(s.z);
  const int first = (*node.lo_a())[axis] + (*node.hi_a())[axis];
  const int second = (*node.lo_b())[axis] + (*node.hi_b())[axis];
  return s.half[s.z] >= 0.0F ? first <= second : first >= second;
}

// Whether a segment along d from a corner of the triangle stays above or below the face, rather than beside it.
bool over_corner(const MeshView& mesh, std::uint32_t triangle, std::uint32_t corner, const Vec3& d) {
  const Vec3 at = vertex(mesh, triangle, corner);
  const Vec3 normal = area_normal(mesh, triangle);
  return normal.cross(vertex(mesh, triangle, next(corner)) - at).dot(d) > 0.0F &&
         normal.cross(vertex(mesh, triangle, previous(corner)) - at).dot(d) < 0.0F;
}

// Whether `from` is on this triangle: it belongs to a feature in `leaving`. Faces round a vertex can cross each other there: then a
// segment from the vertex along one of them, along d, meets another.
bool incident(const MeshView& mesh, std::uint32_t triangle, std::span<const Feature> leaving, const Vec3& d) {
  for (const Feature& f : leaving) {
    if (f.kind == kSideOnly) continue;
    if (f.kind == kVertex) {
      const std::uint32_t v = vertex_index(mesh, f.index, f.corner);
      for (std::uint32_t corner = 0; corner < 3; ++corner) {
        if (vertex_index(mesh, triangle, corner) == v &&
            !(pierced(mesh, triangle) && !two_sided(mesh, triangle) &&
              over_corner(mesh, triangle, corner, d)))
          return true;
      }
      continue;
    }
    if (f.index == triangle) return true;
    if (f.kind == kEdge && across(mesh, f.index, f.side, f.corner).triangle == triangle) return true;
  }
  return false;
}

// The side of a two-sided triangle that a point on the surface is on: that of this triangle in `leaving`, or of one there at
// an edge of it, else that of the first feature.
std::int8_t known_side(const MeshView& mesh, std::uint32_t triangle, std::span<const Feature> leaving) {
  for (const Feature& f : leaving) {
    if (f.index == triangle) return f.side;
  }
  for (const Feature& f : leaving) {
    for (std::uint32_t edge = 0; edge < 3; ++edge) {
      const Step beyond = across(mesh, f.index, f.side, edge);
      if (beyond.triangle == triangle) return beyond.side;
    }
  }
  return leaving.front().side;
}

// Away from the features of a sheet that `from` is on, on their side. A segment that leaves an edge along the next face
// is nearer to that face than rounding; where the face ends, it would meet another one from behind. It starts this much
// above the surface instead.
Vec3 lift_off_sheet(const MeshView& mesh, std::span<const Feature> leaving) {
  Vec3 out = Vec3::Zero();
  for (const Feature& f : leaving) {
    if (!two_sided(mesh, f.index)) continue;
    Vec3 normal = static_cast<float>(f.side) * area_normal(mesh, f.index).normalized();
    if (f.kind == kEdge) {
      const Step beyond = across(mesh, f.index, f.side, f.corner);
      normal += static_cast<float>(beyond.side) * area_normal(mesh, beyond.triangle).normalized();
    } else if (f.kind == kVertex) {
      normal = static_cast<float>(f.side) * pseudonormal(mesh, f.index, f.corner);
    }
    out += normal.normalized();
  }
  return kSurfaceTolerance_m * out.normalized();
}

// Corners, from where a segment begins, and twice the area times the unit normal.
struct Face {
  std::array<Vec3, 3> corner;
  Vec3 normal;
};

// Whether a segment along d is over the face where it meets the face's plane, at t. The smaller its angle to the plane,
// the less exact is that place. band: above 0 when the segment begins on the plane, by this height. Then it may go on
// along the plane to the face, and t becomes where it comes over the face. All heights are times the length of `normal`.
bool reaches(const Face& face, const Vec3& d, float height_from, float height_to, float band, float& t) {
  const float falls = height_from - height_to;
  const float blur = 0.2F * kSurfaceTolerance_m * d.norm() * face.normal.norm() / falls;
  const float allowed_m = 5.0F * kSurfaceTolerance_m + (band > 0.0F ? 0.0F : blur);
  std::array<float, 3> here;
  std::array<float, 3> gains;
  for (std::uint32_t edge = 0; edge < 3; ++edge) {
    const Vec3 inwards = face.normal.cross(face.corner[next(edge)] - face.corner[edge]).normalized();
    here[edge] = allowed_m - inwards.dot(face.corner[edge]);
    gains[edge] = inwards.dot(d);
    if (here[edge] + t * gains[edge] >= 0.0F) continue;
    if (band == 0.0F || gains[edge] <= 0.0F) return false;
    t = -here[edge] / gains[edge];
  }
  constexpr float kRounding_m = 1.0e-9F;
  for (std::uint32_t edge = 0; edge < 3; ++edge)
    if (here[edge] + t * gains[edge] < -kRounding_m) return false;
  return t <= 1.0F && (band == 0.0F || height_from - t * falls >= -2.0F * band);
}

// Whether `from`, in front of this side of a sheet's triangle, is behind the neighbour across an edge, which stands out on
// this side. A line from there that passes the edge on the outside has not met the sheet, whichever way the two are wound.
bool behind_neighbour(const MeshView& mesh, std::uint32_t triangle, std::int8_t side, std::uint32_t edge,
                      const Vec3& from) {
  const Step beyond = across(mesh, triangle, side, edge);
  return beyond.triangle != triangle &&
         in_front(mesh, triangle, side, vertex(mesh, beyond.triangle, previous(beyond.edge))) &&
         !in_front(mesh, beyond.triangle, beyond.side, from);
}

// Whether a line that misses the triangle of a sheet by rounding has not met the sheet. over: twice the areas that the line spans
// with the edges from corners 0, 1 and 2; wide: what they are widened by. Near a vertex the two faces at an edge do not tell.
bool passes_outside(const MeshView& mesh, std::uint32_t triangle, std::int8_t side, const Vec3& from,
                    const std::array<float, 3>& over, const std::array<float, 3>& wide) {
  constexpr float kNear = 4.0F;  // of the widening; where it is this near to two edges, it is at their vertex
  const float inside = over[0] + over[1] + over[2];
  int near = 0;
  for (std::uint32_t edge = 0; edge < 3; ++edge) {
    if (std::abs(over[edge]) <= kNear * wide[edge]) ++near;
    if (over[edge] * inside < 0.0F && behind_neighbour(mesh, triangle, side, edge, from)) return true;
  }
  return near > 1;
}

// Whether the boxes of the triangle and the segment touch.
bool is_near(const Segment& s, const std::array<Vec3, 3>& corner) {
  for (int axis = 0; axis < 3; ++axis) {
    const float a = corner[0][axis];
    const float b = corner[1][axis];
    const float c = corner[2][axis];
    if ((a > s.hi_m[axis] && b > s.hi_m[axis] && c > s.hi_m[axis]) ||
        (a < s.lo_m[axis] && b < s.lo_m[axis] && c < s.lo_m[axis]))
      return false;
  }
  return true;
}

// The ends of a segment over the plane of a triangle, on the side of its winding, times the length of its normal.
struct Heights {
  float from, to;
  float band;  // of what is on the surface

  // False where the segment crosses no side of it.
  [[gnu::always_inline]] bool find(const TrianglePlane& plane, const Segment& s, bool leaves) {
    to = plane.normal.dot(s.to - plane.corner);
    if (to > 0.0F && !plane.two_sided) return false;
    from = plane.normal.dot(s.from - plane.corner);
    band = kSurfaceTolerance_m *
           (std::abs(plane.normal.x()) + std::abs(plane.normal.y()) + std::abs(plane.normal.z()));
    if (!plane.two_sided) {
      from -= std::min(plane.normal.dot(s.lift), 0.0F);  // off the sheet is not into the solid
      return to < from && (std::abs(from) <= band ? to < -band : from >= 0.0F);
    }
    if (leaves && std::abs(from) <= band) return true;
    const float after = from >= 0.0F ? to : -to;
    return after < std::abs(from) && after <= (leaves ? band : 0.0F);
  }
};

[[gnu::noinline]] void hit_triangle(const MeshView& mesh, const TrianglePlane& plane, const Heights& heights,
                                    const Segment& s, std::span<const Feature> leaving, Hit& hit) {
  const std::uint32_t triangle = plane.triangle;
  const Vec3& normal = plane.normal;
  const float band = heights.band;
  float height_from = heights.from;
  float height_to = heights.to;
  const bool sheet = plane.two_sided;
  const bool leaves_sheet = sheet && !leaving.empty();
  const std::array<Vec3, 3> at = {plane.corner, vertex(mesh, triangle, 1), vertex(mesh, triangle, 2)};
  if (!is_near(s, at)) return;
  const Vec3 a = at[0] - s.from;
  const Vec3 b = at[1] - s.from;
  const Vec3 c = at[2] - s.from;

  // Sheared so that the segment runs along z. Both faces at an edge get the same edge function, so no line
  // passes between them. The test is slightly widened, because the side test below rounds differently.
  const float ax = a[s.x] - s.shear_x * a[s.z];
  const float ay = a[s.y] - s.shear_y * a[s.z];
  const float bx = b[s.x] - s.shear_x * b[s.z];
  const float by = b[s.y] - s.shear_y * b[s.z];
  const float cx = c[s.x] - s.shear_x * c[s.z];
  const float cy = c[s.y] - s.shear_y * c[s.z];
  const float u = cx * by - cy * bx;
  const float v = ax * cy - ay * cx;
  const float w = bx * ay - by * ax;
  constexpr float kWiden = kSurfaceTolerance_m;
  const float wu = kWiden * (std::abs(cx - bx) + std::abs(cy - by));
  const float wv = kWiden * (std::abs(ax - cx) + std::abs(ay - cy));
  const float ww = kWiden * (std::abs(bx - ax) + std::abs(by - ay));
  const bool all_up = u >= -wu && v >= -wv && w >= -ww;
  const bool all_down = u <= wu && v <= wv && w <= ww;
  // A segment that begins on the plane of a face, beside the face, can come under it, and its line passes through it nowhere. The god
  // object begins so in a corner with a part that crosses two faces at a flat concave edge.
  const bool beside = !all_up && !all_down;
  if (beside && (leaving.empty() || !pierced(mesh, triangle) || sheet)) return;
  if (incident(mesh, triangle, leaving, s.to - s.from)) return;

  std::int8_t side = 1;
  if (leaves_sheet && std::abs(height_from) <= band) {
    side = known_side(mesh, triangle, leaving);
  } else if (sheet) {
    if (leaving.empty() && (height_from >= 0.0F) == (height_to >= 0.0F)) return;
    side = height_from >= 0.0F ? std::int8_t{1} : std::int8_t{-1};
  }
  if (side < 0) {
    height_from = -height_from;
    height_to = -height_to;
  }
  const bool on_surface = std::abs(height_from) <= band;
  if (beside && !on_surface) return;
  bool crosses = height_from >= 0.0F && height_to <= 0.0F;
  if (leaves_sheet) {
    // A place behind a sheet by rounding would be in front of its other side in the next tick.
    crosses = on_surface ? height_to < 0.0F : height_from >= 0.0F && height_to <= band;
  } else if (on_surface && !sheet) {
    crosses = height_to < -band;
  }
  if (!crosses || height_to >= height_from) return;
  // Past the edge of a sheet, a widened test could meet the next face from behind.
  const bool misses = std::min({u, v, w}) < 0.0F && std::max({u, v, w}) > 0.0F;
  const bool widened = !sheet || (leaves_sheet && (on_surface || std::abs(height_to) <= band));
  if (misses && !widened) return;
  // Nor does the side that the point has not left meet it by rounding. Where parts cross or three faces share an edge, sides tell nothing.
  if ((misses || height_to >= 0.0F) && leaves_sheet && !pierced(mesh, triangle) &&
      side != known_side(mesh, triangle, leaving) &&
      (height_to >= 0.0F || passes_outside(mesh, triangle, side, s.from, {w, u, v}, {ww, wu, wv})))
    return;

  float t = std::clamp(height_from / (height_from - height_to), 0.0F, 1.0F);
  if (!reaches(Face{{a, b, c}, normal}, s.to - s.from, height_from, height_to, on_surface ? band : 0.0F, t) ||
      t > hit.t || (t == hit.t && triangle >= hit.feature.index))  // in whichever order they come
    return;
  hit = {t, {triangle, kFace, 0, side}};
}

bool is_known(const KnownFlight& flight, const ShapeData& shape, const SweepQuery& query) {
  if (flight.from != query.from || flight.to != query.to || flight.shape != &shape ||
      flight.leaving_count != query.leaving.size())
    return false;
  for (std::size_t i = 0; i < flight.leaving_count; ++i)
    if (flight.leaving[i] != query.leaving[i]) return false;
  return true;
}

// False where the work is spent.
[[gnu::noinline]] bool meet_leaf(const ShapeData& shape, std::uint32_t leaf, const Segment& s,
                                 const SweepQuery& query, Hit& hit) {
  const std::uint32_t first = first_triangle(leaf);
  TrianglePlane own;
  if (!query.work.spend(kTriangleWork * triangle_count(leaf))) return false;
  for (std::uint32_t i = first; i < first + triangle_count(leaf); ++i) {
    const TrianglePlane& plane = query.triangles != nullptr ? query.triangles->plane(shape, i) : own;
    if (query.triangles == nullptr) own = plane_of(shape, i);
    // Most triangles near a segment do not have its ends on both sides of them.
    Heights heights;
    if (heights.find(plane, s, !query.leaving.empty()))
      hit_triangle(shape.mesh, plane, heights, s, query.leaving, hit);
  }
  return true;
}

bool meet_leaves(const ShapeData& shape, const NearLeaves& near, const Segment& s, const SweepQuery& query,
                 Hit& hit) {
  constexpr std::size_t kLeavesAUnit = 4;
  if (!query.work.spend(kNodeWork * static_cast<std::uint32_t>(near.list().size() / kLeavesAUnit)))
    return false;
  for (const NearLeaves::Leaf& one : near.list())
    if (overlaps(s, one.lo, one.hi) && !meet_leaf(shape, one.leaf, s, query, hit)) return false;
  return true;
}

[[gnu::noinline]] bool sweep(const ShapeData& shape, const SweepQuery& query, Hit& hit) {
  const MeshView& mesh = shape.mesh;
  Work& work = query.work;
  const Vec3 lift = query.leaving.empty() ? Vec3(Vec3::Zero()) : lift_off_sheet(mesh, query.leaving);
  Segment s = prepare(mesh, query.from + lift, lift, query.to, hit.t);
  if (s.misses) return true;
  if (query.triangles != nullptr) {
    if (const NearLeaves* const near = query.triangles->leaves(shape, work, s.box))
      return meet_leaves(shape, *near, s, query, hit);
  }
  std::array<std::uint32_t, kMaxBvhDepth + 1> stack;
  std::size_t depth = 0;
  std::uint32_t at = 0;
  for (int visits = 0; visits < kMaxNodeVisits && work.spend(kNodeWork); ++visits) {
    const scene::BvhNode& node = mesh.nodes[at];
    std::array<std::uint32_t, 2> inner;
    std::size_t count = 0;
    for (const bool second : first_is_nearer(s, node) ? std::array{false, true} : std::array{true, false}) {
      if (!(second ? overlaps(s, *node.lo_b(), *node.hi_b()) : overlaps(s, *node.lo_a(), *node.hi_a())))
        continue;
      const std::uint32_t child = (*node.child())[second ? 1 : 0];
      if (!is_leaf(child)) {
        inner[count++] = child;
        continue;
      }
      const float before = hit.t;
      if (!meet_leaf(shape, child, s, query, hit)) return false;
      if (hit.t < before) shorten(mesh, s, hit.t);
    }
    if (count == 0) {
      if (depth == 0) return true;
      at = stack[--depth];
    } else {
      at = inner[0];
      if (count == 2) {
        if (depth == stack.size()) return false;
        stack[depth++] = inner[1];
      }
    }
  }
  return false;
}

}  // namespace

bool sweep_mesh(const ShapeData& shape, const SweepQuery& query, Hit& hit) {
  if (query.triangles == nullptr || hit.t <= 1.0F) return sweep(shape, query, hit);
  KnownFlight& flight = query.triangles->flight();
  if (is_known(flight, shape, query)) {
    hit = flight.hit;
    return query.work.spend(kTriangleWork);
  }
  if (!sweep(shape, query, hit)) return false;
  if (query.leaving.size() <= flight.leaving.size()) {
    flight = {&shape, query.from, query.to, {}, query.leaving.size(), hit};
    std::copy(query.leaving.begin(), query.leaving.end(), flight.leaving.begin());
  }
  return true;
}

}  // namespace thimble::control

// Planes between a ball and the triangles near it.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>

#include "control/scene/limits.h"
#include "control/scene/mesh_leaf.h"
#include "control/solids/mesh.h"
#include "control/solids/mesh_topology.h"

namespace thimble::control {

using namespace topology;  // NOLINT(google-build-using-namespace): this file is about nothing else

namespace {

constexpr int kMaxSeparationNodes = 512;

// The point of the triangle (a, a + ab, a + ac) nearest to a + ap, as a vector from a (Ericson 2005, 5.1.5).
Vec3 nearest_on_triangle(const Vec3& ab, const Vec3& ac, const Vec3& ap) {
  const float d1 = ab.dot(ap);
  const float d2 = ac.dot(ap);
  if (d1 <= 0.0F && d2 <= 0.0F) return Vec3::Zero();
  const float bb = ab.squaredNorm();
  const float cc = ac.squaredNorm();
  const float bc = ab.dot(ac);
  const float d3 = d1 - bb;
  const float d4 = d2 - bc;
  if (d3 >= 0.0F && d4 <= d3) return ab;
  const float d5 = d1 - bc;
  const float d6 = d2 - cc;
  if (d6 >= 0.0F && d5 <= d6) return ac;
  const float vc = d1 * d4 - d3 * d2;
  if (vc <= 0.0F && d1 >= 0.0F && d3 <= 0.0F) return (d1 / (d1 - d3)) * ab;
  const float vb = d5 * d2 - d1 * d6;
  if (vb <= 0.0F && d2 >= 0.0F && d6 <= 0.0F) return (d2 / (d2 - d6)) * ac;
  const float va = d3 * d6 - d5 * d4;
  if (va <= 0.0F && d4 - d3 >= 0.0F && d5 - d6 >= 0.0F)
    return ab + ((d4 - d3) / ((d4 - d3) + (d5 - d6))) * (ac - ab);
  return (vb * ab + vc * ac) / (va + vb + vc);
}

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
  const bool before_face = height >= ball.radius_m - kBehind_m;
  if (before_face && height > ball.radius_m + kTouchGap_m && !ball.meets(normal, height)) return false;
  const Vec3 apart = from - nearest_on_triangle(ab, ac, from);
  out.apart_m = apart.norm();
  out.feature = {triangle, kFace, 0, side};
  PlaneChoice choice(ball, out);
  choice.offer_direct(out.apart_m > 0.0F ? Vec3(apart / out.apart_m) : normal);
  choice.offer_face(normal, height);
  // A ball that slides over a face passes what lies below that face.
  for (std::size_t i = 0; choice.blocks() && i < ball.held_count; ++i) {
    const Vec3& held = ball.held_by[i];
    choice.offer(held, held.dot(from) - std::max({0.0F, held.dot(ab), held.dot(ac)}));
  }
  return choice.matters();
}

struct GridBox {
  std::array<std::uint32_t, 3> lo, hi;
};

using GridPoint = flatbuffers::Array<std::uint16_t, 3>;

bool overlaps(const GridBox& box, const GridPoint& lo, const GridPoint& hi) {
  for (std::uint16_t axis = 0; axis < 3; ++axis) {
    if (lo[axis] > box.hi[axis] || hi[axis] < box.lo[axis]) return false;
  }
  return true;
}

// Every place that the ball can come to while it comes nearer to the target: the centre stays in the ball over the
// line between them. False when the mesh's grid is elsewhere.
bool box_of_way(const MeshView& mesh, const BallQuery& ball, GridBox& box) {
  const Vec3 way = ball.target_m - ball.centre_m;
  const Vec3 middle = (ball.centre_m + 0.5F * way - mesh.grid_origin_m) * mesh.grid_scale;
  const float half = (ball.half_way_m + ball.radius_m + kTouchGap_m) * mesh.grid_scale + 2.0F;
  constexpr float kGridEnd = 65535.0F;
  for (int axis = 0; axis < 3; ++axis) {
    const float lo = middle[axis] - half;
    const float hi = middle[axis] + half;
    if (!(hi >= 0.0F && lo <= kGridEnd)) return false;
    box.lo[static_cast<std::size_t>(axis)] = static_cast<std::uint32_t>(std::clamp(lo, 0.0F, kGridEnd));
    box.hi[static_cast<std::size_t>(axis)] = static_cast<std::uint32_t>(std::clamp(hi, 0.0F, kGridEnd));
  }
  return true;
}

}  // namespace

std::size_t separate_mesh(const ShapeData& shape, const BallQuery& ball, std::span<Separation> out) {
  const MeshView& mesh = shape.mesh;
  GridBox box;
  if (!box_of_way(mesh, ball, box)) return 0;
  std::size_t count = 0;
  std::array<std::uint32_t, kMaxBvhDepth + 1> stack;
  std::size_t depth = 0;
  std::uint32_t at = 0;
  for (int visits = 0; visits < kMaxSeparationNodes; ++visits) {
    const scene::BvhNode& node = mesh.nodes[at];
    std::array<std::uint32_t, 2> inner;
    std::size_t inner_count = 0;
    for (std::uint16_t c = 0; c < 2; ++c) {
      if (!(c == 0 ? overlaps(box, *node.lo_a(), *node.hi_a()) : overlaps(box, *node.lo_b(), *node.hi_b())))
        continue;
      const std::uint32_t child = (*node.child())[c];
      if (!is_leaf(child)) {
        inner[inner_count++] = child;
        continue;
      }
      const std::uint32_t first = first_triangle(child);
      for (std::uint32_t i = first; i < first + triangle_count(child); ++i) {
        if (count == out.size()) return out.size() + 1;
        if (separate_triangle(mesh, i, ball, out[count])) ++count;
      }
    }
    if (inner_count == 0) {
      if (depth == 0) return count;
      at = stack[--depth];
    } else {
      at = inner[0];
      if (inner_count == 2) {
        if (depth == stack.size()) return out.size() + 1;
        stack[depth++] = inner[1];
      }
    }
  }
  return out.size() + 1;
}

}  // namespace thimble::control

// Where a texture is on a mesh. The compiler gives each corner of a triangle what a place near it takes: weights of the
// object's axes (control/scene/blend.h), or coordinates with their gradients. Between the corners they are blended
// so that the height and its gradient go on over the edges.
#include <algorithm>
#include <array>
#include <cstdint>

#include "control/scene/blend.h"
#include "control/solids/mesh.h"
#include "control/solids/mesh_topology.h"
#include "control/surfaces/chart.h"

namespace thimble::control {

using namespace topology;  // NOLINT(google-build-using-namespace): this file is about nothing else

namespace {

using Slope = Eigen::Vector2f;

// What each corner counts at a place on the triangle; their sum is 1.
struct Shares {
  std::array<float, 3> share{};
  // Their gradients, by the barycentric coordinates of corners 1 and 2, and the gradients of these, 1/m.
  std::array<Slope, 3> slope{Slope::Zero(), Slope::Zero(), Slope::Zero()};
  std::array<Vec3, 2> coordinate_slope{Vec3::Zero(), Vec3::Zero()};

  [[nodiscard]] Vec3 in_space(const Slope& by) const {
    return by[0] * coordinate_slope[0] + by[1] * coordinate_slope[1];
  }
};

// With the barycentric coordinates b, and t the foot of the perpendicular to edge k (opposite corner k, from corner i
// to j) as a part of its length:
//   on edge k    i: 1 - s(t), j: s(t), k: 0, s(t) = t^2 (3 - 2 t)
//   inside       the mean of these over the edges, edge k counting (b_i b_j)^2
// Across an edge the slope is 0 and at a corner too, so the shares have continuous slopes from face to face (after the
// side-vertex method of Nielson 1979).
Shares corner_shares(const std::array<Vec3, 3>& corner, const Vec3& at) {
  std::array<Vec3, 3> edge;  // opposite each corner
  for (std::uint32_t k = 0; k < 3; ++k) edge[k] = corner[previous(k)] - corner[next(k)];
  const Vec3 normal = edge[2].cross(-edge[1]);
  const float area2 = normal.squaredNorm();
  Shares out;
  if (!(area2 > 0.0F)) {
    out.share[0] = 1.0F;
    return out;
  }
  const float per_area2 = 1.0F / area2;
  out.coordinate_slope = {per_area2 * normal.cross(edge[1]), per_area2 * normal.cross(edge[2])};
  const std::array<Slope, 3> db{Slope(-1.0F, -1.0F), Slope(1.0F, 0.0F), Slope(0.0F, 1.0F)};
  const Vec3 from = at - corner[0];
  std::array<float, 3> b{0.0F, out.coordinate_slope[0].dot(from), out.coordinate_slope[1].dot(from)};
  b[0] = 1.0F - b[1] - b[2];
  for (float& coordinate : b) coordinate = std::max(coordinate, 0.0F);
  float sum = 0.0F;
  Slope sum_slope = Slope::Zero();
  for (std::uint32_t k = 0; k < 3; ++k) {
    const std::uint32_t i = next(k);
    const std::uint32_t j = previous(k);
    const float both = b[i] * b[j];
    const float count = both * both;
    const Slope count_slope = 2.0F * both * (b[j] * db[i] + b[i] * db[j]);
    const float foot = -edge[k].dot(edge[j]) / edge[k].squaredNorm();  // t at corner k
    const float t = std::clamp(b[j] + foot * b[k], 0.0F, 1.0F);
    const float s = t * t * (3.0F - 2.0F * t);
    const Slope counted_slope = count * 6.0F * t * (1.0F - t) * (db[j] + foot * db[k]);
    out.share[i] += count * (1.0F - s);
    out.share[j] += count * s;
    out.slope[i] += (1.0F - s) * count_slope - counted_slope;
    out.slope[j] += s * count_slope + counted_slope;
    sum += count;
    sum_slope += count_slope;
  }
  constexpr float kAtCorner = 1.0e-30F;
  if (!(sum > kAtCorner)) {
    out = {};
    out.share[static_cast<std::size_t>(std::max_element(b.begin(), b.end()) - b.begin())] = 1.0F;
    return out;
  }
  const float per_sum = 1.0F / sum;
  for (std::uint32_t k = 0; k < 3; ++k) {
    out.share[k] *= per_sum;
    out.slope[k] = per_sum * (out.slope[k] - out.share[k] * sum_slope);
  }
  return out;
}

Shares corner_shares(const MeshView& mesh, const SurfacePoint& place) {
  const std::uint32_t triangle = place.feature.index;
  return corner_shares({vertex(mesh, triangle, 0), vertex(mesh, triangle, 1), vertex(mesh, triangle, 2)},
                       place.at_m);
}

Vec3 axis_weights(std::uint32_t code) {
  constexpr float kStep = 1.0F / 65535.0F;
  const std::uint32_t x = code & 0xFFFFU;
  const std::uint32_t y = code >> 16U;
  return {kStep * static_cast<float>(x), kStep * static_cast<float>(y),
          kStep * static_cast<float>(0xFFFFU - x - y)};
}

}  // namespace

bool blend_on_mesh(const ShapeData& shape, const SurfacePoint& place, Blend& blend) {
  const MeshView& mesh = shape.mesh;
  if (mesh.texture_weights == nullptr) return false;
  const std::uint32_t* code = mesh.texture_weights + std::size_t{3} * place.feature.index;
  if (code[0] == kOwnAxes) return false;
  blend.weight = axis_weights(code[0]);
  if (code[1] == code[0] && code[2] == code[0]) return true;
  const Shares shares = corner_shares(mesh, place);
  blend.weight.setZero();
  std::array<Slope, 3> slope{Slope::Zero(), Slope::Zero(), Slope::Zero()};
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec3 weight = axis_weights(code[k]);
    blend.weight += shares.share[k] * weight;
    for (std::size_t axis = 0; axis < 3; ++axis)
      slope[axis] += weight[static_cast<Eigen::Index>(axis)] * shares.slope[k];
  }
  for (std::size_t axis = 0; axis < 3; ++axis) blend.slope[axis] = shares.in_space(slope[axis]);
  return true;
}

Chart chart_on_mesh(const ShapeData& shape, const SurfacePoint& place) {
  const MeshView& mesh = shape.mesh;
  if (mesh.texture_corners == nullptr) {
    const Vec3 normal = area_normal(mesh, place.feature.index).normalized();
    Chart chart = plane_chart(static_cast<float>(place.feature.side) * normal, place.at_m);
    chart.in_space = mesh.corner_normals != nullptr;
    return chart;
  }
  const Shares shares = corner_shares(mesh, place);
  const std::uint32_t* corners = mesh.texture_corners + std::size_t{3} * place.feature.index;
  const scene::TexturePoint& first = mesh.texture_points[corners[0]];
  Chart chart;
  chart.in_space = true;
  chart.strength = 0.0F;
  Slope u_slope = Slope::Zero();
  Slope v_slope = Slope::Zero();
  Slope strength_slope = Slope::Zero();
  for (std::uint32_t k = 0; k < 3; ++k) {
    const scene::TexturePoint& corner = mesh.texture_points[corners[k]];
    const Vec3 du = to_vec(corner.du());
    const Vec3 dv = to_vec(corner.dv());
    const Vec3 from_corner = place.at_m - vertex(mesh, place.feature.index, k);
    const float u_m = corner.u_m() - first.u_m() + du.dot(from_corner);
    const float v_m = corner.v_m() - first.v_m() + dv.dot(from_corner);
    chart.u_m += shares.share[k] * u_m;
    chart.v_m += shares.share[k] * v_m;
    chart.du += shares.share[k] * du;
    chart.dv += shares.share[k] * dv;
    chart.strength += shares.share[k] * corner.strength();
    u_slope += u_m * shares.slope[k];
    v_slope += v_m * shares.slope[k];
    strength_slope += corner.strength() * shares.slope[k];
  }
  chart.du += shares.in_space(u_slope);
  chart.dv += shares.in_space(v_slope);
  chart.strength_slope = shares.in_space(strength_slope);
  chart.u_m += first.u_m();
  chart.v_m += first.v_m();
  return chart;
}

}  // namespace thimble::control

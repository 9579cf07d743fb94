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

// What each corner counts at a place on the triangle; their sum is 1.
struct Shares {
  std::array<float, 3> share{};
  std::array<Vec3, 3> slope{Vec3::Zero(), Vec3::Zero(), Vec3::Zero()};  // gradient, in the triangle's plane
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
  std::array<float, 3> b;
  std::array<Vec3, 3> db;
  for (std::uint32_t k = 0; k < 3; ++k) {
    db[k] = normal.cross(edge[k]) / area2;
    b[k] = std::max(db[k].dot(at - corner[next(k)]), 0.0F);
  }
  float sum = 0.0F;
  Vec3 sum_slope = Vec3::Zero();
  for (std::uint32_t k = 0; k < 3; ++k) {
    const std::uint32_t i = next(k);
    const std::uint32_t j = previous(k);
    const float both = b[i] * b[j];
    const float count = both * both;
    const Vec3 count_slope = 2.0F * both * (b[j] * db[i] + b[i] * db[j]);
    const Vec3 along = edge[k] / edge[k].squaredNorm();
    const float t = std::clamp(along.dot(at - corner[i]), 0.0F, 1.0F);
    const float s = t * t * (3.0F - 2.0F * t);
    const Vec3 counted_slope = count * 6.0F * t * (1.0F - t) * along;
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
  for (std::uint32_t k = 0; k < 3; ++k) {
    out.share[k] /= sum;
    out.slope[k] = (out.slope[k] - out.share[k] * sum_slope) / sum;
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
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec3 weight = axis_weights(code[k]);
    blend.weight += shares.share[k] * weight;
    for (int axis = 0; axis < 3; ++axis)
      blend.slope[static_cast<std::size_t>(axis)] += weight[axis] * shares.slope[k];
  }
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
  for (std::uint32_t k = 0; k < 3; ++k) {
    const scene::TexturePoint& corner = mesh.texture_points[corners[k]];
    const Vec3 du = to_vec(corner.du());
    const Vec3 dv = to_vec(corner.dv());
    const Vec3 from_corner = place.at_m - vertex(mesh, place.feature.index, k);
    const float u_m = corner.u_m() - first.u_m() + du.dot(from_corner);
    const float v_m = corner.v_m() - first.v_m() + dv.dot(from_corner);
    chart.u_m += shares.share[k] * u_m;
    chart.v_m += shares.share[k] * v_m;
    chart.du += shares.share[k] * du + u_m * shares.slope[k];
    chart.dv += shares.share[k] * dv + v_m * shares.slope[k];
    chart.strength += shares.share[k] * corner.strength();
    chart.strength_slope += corner.strength() * shares.slope[k];
  }
  chart.u_m += first.u_m();
  chart.v_m += first.v_m();
  return chart;
}

}  // namespace thimble::control

// The way of a ball over faces on which it touches nothing else, as the compiler has shown (Mesh.rims). It needs no look at
// the triangles nearby.
#include <array>
#include <cmath>
#include <cstdint>

#include "control/solids/mesh.h"
#include "control/solids/mesh_topology.h"

namespace thimble::control {

using namespace topology;  // NOLINT(google-build-using-namespace): this file is about nothing else

namespace {

constexpr int kMaxRolledFaces = 4;  // of one way

using Weights = std::array<float, 3>;  // of the corners: 1 at the corner, 0 at the edge opposite to it

struct FaceWeights {
  Vec3 a, normal;
  Vec3 to_b, to_c;  // gradients of the weights

  // False for a triangle without area.
  bool see(const MeshView& mesh, std::uint32_t triangle) {
    a = vertex(mesh, triangle, 0);
    const Vec3 ab = vertex(mesh, triangle, 1) - a;
    const Vec3 ac = vertex(mesh, triangle, 2) - a;
    const Vec3 area = ab.cross(ac);
    const float area2 = area.squaredNorm();
    if (!(area2 > 0.0F)) return false;
    const float inverse2 = 1.0F / area2;
    normal = std::sqrt(inverse2) * area;
    to_b = inverse2 * ac.cross(area);
    to_c = inverse2 * area.cross(ab);
    return true;
  }
  [[nodiscard]] Weights weights(const Vec3& from_a) const {
    const float b = to_b.dot(from_a);
    const float c = to_c.dot(from_a);
    return {1.0F - b - c, b, c};
  }
};

// The weight of the corner opposite to an edge must be at least this.
float rim(const MeshView& mesh, std::uint32_t triangle, std::uint32_t edge) {
  return static_cast<float>(mesh.rims[std::size_t{3} * triangle + edge]) * (1.0F / 255.0F);
}

bool is_within_rims(const MeshView& mesh, std::uint32_t triangle, const Weights& at) {
  for (std::uint32_t edge = 0; edge < 3; ++edge)
    if (at[previous(edge)] < rim(mesh, triangle, edge)) return false;
  return true;
}

}  // namespace

bool roll_within_rims(const MeshView& mesh, BallRoll& ball) {
  if (mesh.rims == nullptr || ball.feature.side < 0) return false;
  std::uint32_t triangle = ball.feature.index;
  FaceWeights face;
  if (!face.see(mesh, triangle)) return false;
  const Vec3 from = ball.centre_m - face.a;
  Weights at = face.weights(from);
  if (std::abs(face.normal.dot(from) - ball.radius_m) > kTouchGap_m || !is_within_rims(mesh, triangle, at))
    return false;
  for (int faces = 0; faces < kMaxRolledFaces && ball.work.spend(kFaceWork); ++faces) {
    const Vec3 target = ball.target_m - face.a;
    const float height_m = face.normal.dot(target);
    if (!ball.hold && height_m >= ball.radius_m) return false;
    const Weights to = face.weights(target);
    // The edge over which it leaves first.
    float part = 1.0F;
    std::uint32_t over = 3;
    for (std::uint32_t edge = 0; edge < 3; ++edge) {
      const std::uint32_t corner = previous(edge);
      const float least = rim(mesh, triangle, edge);
      if (to[corner] >= least) continue;
      const float leaves = (at[corner] - least) / (at[corner] - to[corner]);
      if (over != 3 && leaves >= part) continue;
      part = leaves;
      over = edge;
    }
    if (over == 3) {
      ball.centre_m = ball.target_m + (ball.radius_m - height_m) * face.normal;
      ball.normal = face.normal;
      ball.feature = {triangle, kFace, 0, 1};
      return true;
    }
    if (mesh.rims[std::size_t{3} * triangle + over] != 0) return false;
    // On the other side it begins at the same place of the edge, and must not be drawn back.
    const Step beyond = across(mesh, triangle, 1, over);
    const float of_first = at[over] + part * (to[over] - at[over]);
    at[previous(beyond.edge)] = 0.0F;
    at[next(beyond.edge)] = of_first;
    at[beyond.edge] = 1.0F - of_first;
    triangle = beyond.triangle;
    if (beyond.side < 0 || !is_within_rims(mesh, triangle, at) || !face.see(mesh, triangle)) return false;
    if (face.weights(ball.target_m - face.a)[previous(beyond.edge)] < 0.0F) return false;
  }
  return false;
}

}  // namespace thimble::control

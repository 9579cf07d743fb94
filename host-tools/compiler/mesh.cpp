#include "host-tools/compiler/mesh.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "control/scene/octahedral.h"
#include "host-tools/compiler/disjoint_sets.h"
#include "host-tools/compiler/mesh_cross.h"
#include "host-tools/compiler/mesh_orient.h"
#include "host-tools/compiler/mesh_surface.h"
#include "host-tools/compiler/mesh_tree.h"
#include "host-tools/compiler/to_scene.h"

namespace thimble::host {
namespace {

using Eigen::Vector3d;

// Triangles closer than this cross: of the mesh's size, by the rounding of its vertices, and by what the renderer allows
// a place to be behind a face beside it before it slides on over the next (the surface tolerance, control/solids/
// solid.h, of up to sqrt(3) * 2e-7 m in a face's normal).
constexpr double kTouchTolerance = 1.0e-7;
constexpr double kTouch_m = 1.0e-6;
constexpr double kCreaseSlack_deg = 1.0e-3;  // a 90 degree edge is not sharper than 90 degrees
// A triangle that has met this many others without a proven crossing counts as crossed: the search stays
// bounded.
constexpr unsigned kMaxCrossTests = 4096;

// Joins the corners on either side of each edge that `passes`: a set is then a fan of triangles round a
// vertex.
template <typename Passes>
DisjointSets join_corners(const Adjacency& adjacency, Passes&& passes) {
  DisjointSets fans(adjacency.neighbour.size());
  for (std::uint32_t corner = 0; corner < adjacency.neighbour.size(); ++corner) {
    const std::uint32_t code = adjacency.neighbour[corner];
    if (code == kNoNeighbour || !passes(corner / 3, code >> 2U)) {
      continue;
    }
    // Edge e runs from corner e; the neighbour's edge runs the other way.
    const std::uint32_t other = 3 * (code >> 2U);
    fans.join(corner, other + next_edge(code & 3U));
    fans.join(3 * (corner / 3) + next_edge(corner % 3), other + (code & 3U));
  }
  return fans;
}

// The angle-weighted sum of the faces' normals over each set of corners, as a unit vector at the set's name.
std::vector<Vector3d> mean_normals(const Surface& surface, const std::vector<Vector3d>& face_normals,
                                   DisjointSets& sets) {
  std::vector<Vector3d> sum(face_normals.size() * 3, Vector3d::Zero());
  for (std::uint32_t corner = 0; corner < sum.size(); ++corner) {
    const TriangleIndices& t = surface.triangles[corner / 3];
    const Vector3d at = surface.point(t[corner % 3]);
    const Vector3d a = surface.point(t[next_edge(corner % 3)]) - at;
    const Vector3d b = surface.point(t[next_edge(next_edge(corner % 3))]) - at;
    sum[sets.find(corner)] += face_normals[corner / 3] * std::atan2(a.cross(b).norm(), a.dot(b));
  }
  for (std::uint32_t corner = 0; corner < sum.size(); ++corner) {
    if (sets.find(corner) == corner) {
      const double length = sum[corner].norm();
      // Faces whose normals cancel (a folded sheet) have no mean; the normal of one face is used.
      sum[corner] = length > 1.0e-6 ? (sum[corner] / length).eval() : face_normals[corner / 3];
    }
  }
  return sum;
}

void flag_crossings(const Surface& surface, const MeshTree& tree, std::vector<std::uint8_t>& flags) {
  constexpr auto kPierced = static_cast<std::uint8_t>(scene::TriangleFlag::Pierced);
  const double tolerance = std::max(kTouchTolerance * surface.size_m, kTouch_m);
  const Vector3d reach = Vector3d::Constant(tolerance);
  const auto corners = [&surface](std::uint32_t t) {
    const TriangleIndices& i = surface.triangles[t];
    return TriangleCorners{i, {surface.point(i[0]), surface.point(i[1]), surface.point(i[2])}};
  };
  for (std::uint32_t t = 0; t < surface.triangles.size(); ++t) {
    if ((flags[t] & kPierced) != 0) {
      continue;  // a triangle that crosses it finds it in its own search
    }
    const TriangleCorners mine = corners(t);
    const Vector3d lo = mine.at_m[0].cwiseMin(mine.at_m[1]).cwiseMin(mine.at_m[2]) - reach;
    const Vector3d hi = mine.at_m[0].cwiseMax(mine.at_m[1]).cwiseMax(mine.at_m[2]) + reach;
    unsigned tests = 0;
    visit_box(tree.nodes, tree.grid_box(lo, hi), [&](std::uint32_t other) {
      if (other == t) {
        return true;
      }
      const TriangleCorners theirs = corners(other);
      const Vector3d other_lo = theirs.at_m[0].cwiseMin(theirs.at_m[1]).cwiseMin(theirs.at_m[2]);
      const Vector3d other_hi = theirs.at_m[0].cwiseMax(theirs.at_m[1]).cwiseMax(theirs.at_m[2]);
      if ((other_lo.array() > hi.array()).any() || (other_hi.array() < lo.array()).any()) {
        return true;
      }
      if (++tests > kMaxCrossTests) {
        flags[t] |= kPierced;
        return false;
      }
      if (!triangles_cross(mine, theirs, tolerance)) {
        return true;
      }
      flags[t] |= kPierced;
      flags[other] |= kPierced;
      return false;
    });
  }
}

void put_in_leaf_order(Surface& surface, const MeshTree& tree) {
  std::vector<TriangleIndices> sorted(surface.triangles.size());
  for (std::size_t i = 0; i < sorted.size(); ++i) {
    sorted[i] = surface.triangles[tree.order[i]];
  }
  surface.triangles = std::move(sorted);
}

}  // namespace

CompiledMesh compile_mesh(const TriangleSoup& soup, const MeshOptions& options, const std::string& name) {
  CompiledMesh mesh;
  Surface surface = clean_surface(soup, name, mesh.report);
  MeshTree tree = build_tree(surface.at_m, surface.triangles);
  put_in_leaf_order(surface, tree);
  const Adjacency adjacency = orient(surface, tree, options.side == MeshSide::kInside, mesh.report);
  const std::size_t count = surface.triangles.size();

  mesh.flags.resize(count);
  for (std::size_t t = 0; t < count; ++t) {
    const bool two_sided = options.side == MeshSide::kBoth || adjacency.open[t] != 0;
    mesh.flags[t] = static_cast<std::uint8_t>(
        (two_sided ? static_cast<unsigned>(scene::TriangleFlag::TwoSided) : 0U) |
        (adjacency.crowded[t] != 0 ? static_cast<unsigned>(scene::TriangleFlag::Pierced) : 0U));
  }
  flag_crossings(surface, tree, mesh.flags);

  std::vector<Vector3d> face_normals(count);
  for (std::size_t t = 0; t < count; ++t) {
    face_normals[t] = surface.area_vector(t).normalized();
  }
  // One vertex a fan, in the order of first use.
  DisjointSets fans = join_corners(adjacency, [](std::uint32_t, std::uint32_t) { return true; });
  const std::vector<Vector3d> pseudonormals = mean_normals(surface, face_normals, fans);
  std::vector<std::uint32_t> vertex_of(3 * count, kNoNeighbour);
  mesh.triangles.reserve(count);
  for (std::uint32_t t = 0; t < count; ++t) {
    TriangleIndices corners{};
    for (std::uint32_t i = 0; i < 3; ++i) {
      const std::uint32_t fan = fans.find(3 * t + i);
      if (vertex_of[fan] == kNoNeighbour) {
        vertex_of[fan] = static_cast<std::uint32_t>(mesh.vertices.size());
        mesh.vertices.emplace_back(to_scene(surface.at_m[surface.triangles[t][i]]),
                                   to_scene(pseudonormals[fan]));
      }
      corners[i] = vertex_of[fan];
    }
    const std::uint32_t* const neighbour = &adjacency.neighbour[std::size_t{3} * t];
    const TriangleIndices across{neighbour[0], neighbour[1], neighbour[2]};
    using Three = flatbuffers::span<const std::uint32_t, 3>;
    mesh.triangles.emplace_back(Three(corners), Three(across));
  }

  if (options.crease_deg) {
    const double least_cosine = std::cos((*options.crease_deg + kCreaseSlack_deg) * std::numbers::pi / 180.0);
    DisjointSets smooth = join_corners(adjacency, [&](std::uint32_t a, std::uint32_t b) {
      if (options.height_field && !(face_normals[a].z() > 0.0 && face_normals[b].z() > 0.0)) return false;
      return *options.crease_deg >= 180.0 || face_normals[a].dot(face_normals[b]) >= least_cosine;
    });
    const std::vector<Vector3d> shading = mean_normals(surface, face_normals, smooth);
    mesh.corner_normals.resize(3 * count);
    for (std::uint32_t corner = 0; corner < mesh.corner_normals.size(); ++corner) {
      mesh.corner_normals[corner] = control::encode_octahedral(shading[smooth.find(corner)].cast<float>());
    }
  }

  mesh.nodes = std::move(tree.nodes);
  mesh.grid_origin_m = to_scene(tree.grid_origin_m);
  mesh.grid_step_m = tree.grid_step_m;
  mesh.depth = static_cast<std::uint8_t>(tree.depth);
  MeshReport& report = mesh.report;
  report.triangles = count;
  report.vertices = mesh.vertices.size();
  report.pierced_triangles =
      static_cast<std::size_t>(std::count_if(mesh.flags.begin(), mesh.flags.end(), [](auto flag) {
        return (flag & static_cast<unsigned>(scene::TriangleFlag::Pierced)) != 0;
      }));
  report.bytes = mesh.vertices.size() * sizeof(scene::Vertex) + count * (sizeof(scene::Triangle) + 1) +
                 mesh.corner_normals.size() * sizeof(std::uint32_t) +
                 mesh.nodes.size() * sizeof(scene::BvhNode);
  report.depth = tree.depth;
  return mesh;
}

}  // namespace thimble::host

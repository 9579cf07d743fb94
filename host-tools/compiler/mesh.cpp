#include "host-tools/compiler/mesh.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "control/scene/limits.h"
#include "control/scene/mesh_triangle.h"
#include "control/scene/octahedral.h"
#include "host-tools/compiler/mesh_corners.h"
#include "host-tools/compiler/mesh_cross.h"
#include "host-tools/compiler/mesh_orient.h"
#include "host-tools/compiler/mesh_rims.h"
#include "host-tools/compiler/mesh_surface.h"
#include "host-tools/compiler/mesh_texture.h"
#include "host-tools/compiler/mesh_tree.h"
#include "host-tools/compiler/portable_math.h"
#include "host-tools/compiler/to_scene.h"
#include "host-tools/error.h"

namespace thimble::host {
namespace {

using Eigen::Vector3d;

// Triangles closer than this cross: of the mesh's size, by the rounding of its vertices, and by what the renderer allows
// a place to be behind a face beside it before it slides on over the next (the surface tolerance, control/solids/
// solid.h, of up to sqrt(3) * 2e-7 m in a face's normal).
constexpr double kTouchTolerance = 1.0e-7;
constexpr double kTouch_m = 1.0e-6;
// The renderer closes gaps up to this width (control/solids/solid.h).
constexpr auto kSeam_m = static_cast<double>(control::kFaceMargin_m);
constexpr double kAlong = 0.9;               // cosine of the angle between faces that lie along each other
constexpr double kCreaseSlack_deg = 1.0e-3;  // a 90 degree edge is not sharper than 90 degrees
// A triangle that has met this many others without a proven crossing counts as crossed: the search stays
// bounded.
constexpr unsigned kMaxCrossTests = 4096;

// Flags the triangles for which `meets` another one whose box is within `reach`. A triangle that meets too many others without a
// proven answer is flagged too.
template <typename Candidate, typename Meets>
void flag_meetings(const Surface& surface, const MeshTree& tree, double reach_m, std::uint8_t flag,
                   std::vector<std::uint8_t>& flags, Candidate&& candidate, Meets&& meets) {
  const Vector3d reach = Vector3d::Constant(reach_m);
  const auto corners = [&surface](std::uint32_t t) {
    const TriangleIndices& i = surface.triangles[t];
    return TriangleCorners{i, {surface.point(i[0]), surface.point(i[1]), surface.point(i[2])}};
  };
  for (std::uint32_t t = 0; t < surface.triangles.size(); ++t) {
    if ((flags[t] & flag) != 0) {
      continue;  // a triangle that meets it finds it in its own search
    }
    const TriangleCorners mine = corners(t);
    const Vector3d lo = mine.at_m[0].cwiseMin(mine.at_m[1]).cwiseMin(mine.at_m[2]) - reach;
    const Vector3d hi = mine.at_m[0].cwiseMax(mine.at_m[1]).cwiseMax(mine.at_m[2]) + reach;
    unsigned tests = 0;
    visit_box(tree.nodes, tree.grid_box(lo, hi), [&](std::uint32_t other) {
      if (other == t || !candidate(t, other)) {
        return true;
      }
      const TriangleCorners theirs = corners(other);
      const Vector3d other_lo = theirs.at_m[0].cwiseMin(theirs.at_m[1]).cwiseMin(theirs.at_m[2]);
      const Vector3d other_hi = theirs.at_m[0].cwiseMax(theirs.at_m[1]).cwiseMax(theirs.at_m[2]);
      if ((other_lo.array() > hi.array()).any() || (other_hi.array() < lo.array()).any()) {
        return true;
      }
      if (++tests > kMaxCrossTests) {
        flags[t] |= flag;
        return false;
      }
      if (!meets(mine, theirs)) {
        return true;
      }
      flags[t] |= flag;
      flags[other] |= flag;
      return false;
    });
  }
}

void flag_crossings(const Surface& surface, const MeshTree& tree, std::vector<std::uint8_t>& flags) {
  constexpr auto kPierced = static_cast<std::uint8_t>(scene::TriangleFlag::Pierced);
  const double tolerance = std::max(kTouchTolerance * surface.size_m, kTouch_m);
  flag_meetings(
      surface, tree, tolerance, kPierced, flags, [](std::uint32_t, std::uint32_t) { return true; },
      [tolerance](const TriangleCorners& a, const TriangleCorners& b) {
        return triangles_cross(a, b, tolerance);
      });
}

Vector3d normal(const TriangleCorners& t) {
  return (t.at_m[1] - t.at_m[0]).cross(t.at_m[2] - t.at_m[0]).normalized();
}

// Where closed parts of the mesh lie along each other, with the triangles around. True if there are any. Parts that cross at an angle leave
// no gap.
bool flag_seams(const Surface& surface, const MeshTree& tree, const Adjacency& adjacency,
                std::vector<std::uint8_t>& flags) {
  constexpr auto kSeam = static_cast<std::uint8_t>(scene::TriangleFlag::Seam);
  const std::size_t count = surface.triangles.size();
  const std::vector<std::uint32_t>& part = adjacency.part;
  const bool several = std::any_of(part.begin(), part.end(), [&](std::uint32_t p) { return p != part[0]; });
  if (several) {
    flag_meetings(
        surface, tree, kSeam_m, kSeam, flags,
        [&](std::uint32_t a, std::uint32_t b) {
          return part[a] != part[b] && part[a] != kOpenPart && part[b] != kOpenPart;
        },
        [](const TriangleCorners& a, const TriangleCorners& b) {
          if (std::abs(normal(a).dot(normal(b))) < kAlong) return false;
          for (const std::uint32_t i : a.index)
            if (std::find(b.index.begin(), b.index.end(), i) != b.index.end()) return true;
          return triangles_cross(a, b, kSeam_m);
        });
  }
  std::vector<bool> at_seam(surface.at_m.size(), false);
  bool any = false;
  for (std::size_t t = 0; t < count; ++t) {
    if ((flags[t] & kSeam) == 0) continue;
    any = true;
    for (const std::uint32_t corner : surface.triangles[t]) at_seam[corner] = true;
  }
  for (std::size_t t = 0; any && t < count; ++t) {
    const TriangleIndices& corners = surface.triangles[t];
    if (std::any_of(corners.begin(), corners.end(), [&](std::uint32_t corner) { return at_seam[corner]; }))
      flags[t] |= kSeam;
  }
  return any;
}

void put_in_leaf_order(Surface& surface, const MeshTree& tree) {
  std::vector<TriangleIndices> sorted(surface.triangles.size());
  for (std::size_t i = 0; i < sorted.size(); ++i) {
    sorted[i] = surface.triangles[tree.order[i]];
  }
  surface.triangles = std::move(sorted);
}

std::size_t count_flagged(const std::vector<std::uint8_t>& flags, scene::TriangleFlag which) {
  return static_cast<std::size_t>(std::ranges::count_if(
      flags, [which](auto flag) { return (flag & static_cast<unsigned>(which)) != 0; }));
}

std::size_t bytes_in_image(const CompiledMesh& mesh) {
  return mesh.vertices.size() * sizeof(scene::Vertex) +
         mesh.triangles.size() * (sizeof(scene::Triangle) + 1) +
         mesh.corner_normals.size() * sizeof(std::uint32_t) +
         (mesh.texture_weights.size() + mesh.texture_corners.size()) * sizeof(std::uint32_t) +
         mesh.texture_points.size() * sizeof(scene::TexturePoint) + mesh.rims.size() +
         mesh.nodes.size() * sizeof(scene::BvhNode);
}

// The normals of smooth shading, at each corner of each triangle.
template <typename MayJoin>
std::vector<std::uint32_t> shading_normals(const Surface& surface, const Adjacency& adjacency,
                                           const std::vector<Vector3d>& face_normals, double crease_deg,
                                           MayJoin&& may_join) {
  const double least_cosine = portable::cos((crease_deg + kCreaseSlack_deg) * std::numbers::pi / 180.0);
  DisjointSets smooth = join_corners(adjacency, [&](std::uint32_t a, std::uint32_t b) {
    return may_join(a, b) && (crease_deg >= 180.0 || face_normals[a].dot(face_normals[b]) >= least_cosine);
  });
  const std::vector<Vector3d> shading = mean_normals(surface, face_normals, smooth);
  std::vector<std::uint32_t> at_corner(3 * surface.triangles.size());
  for (std::uint32_t corner = 0; corner < at_corner.size(); ++corner)
    at_corner[corner] = control::encode_octahedral(shading[smooth.find(corner)].cast<float>());
  return at_corner;
}

// The triangles with their references. One vertex a fan, in the order of first use.
void add_triangles(const Surface& surface, const Adjacency& adjacency,
                   const std::vector<Vector3d>& face_normals, const std::string& name, CompiledMesh& mesh) {
  const std::size_t count = surface.triangles.size();
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
                                   control::encode_octahedral(pseudonormals[fan].cast<float>()));
      }
      corners[i] = vertex_of[fan];
    }
    TriangleIndices beyond{};
    for (std::uint32_t i = 0; i < 3; ++i) {
      const std::uint32_t neighbour = adjacency.neighbour[3 * t + i];
      beyond[i] = neighbour == kNoNeighbour ? control::kNoEdge : 3 * (neighbour >> 2U) + (neighbour & 3U);
    }
    mesh.triangles.push_back(control::pack_triangle(corners, beyond));
  }
  if (mesh.vertices.size() > control::kMaxVertices) {
    throw Error(ExitCode::kBadInput, "too-many-vertices",
                name + ": " + std::to_string(mesh.vertices.size()) + " vertices, at most " +
                    std::to_string(control::kMaxVertices) + " are allowed",
                "join triangles that have corners in common, or simplify the mesh");
  }
}

}  // namespace

CompiledMesh compile_mesh(const TriangleSoup& soup, const MeshOptions& options, const std::string& name) {
  // Shares as of a height field of 724 x 724.
  const auto tell = [&options](double share) {
    if (options.progress) options.progress(share);
  };
  CompiledMesh mesh;
  Surface surface = clean_surface(soup, name, mesh.report);
  tell(0.25);
  MeshTree tree = build_tree(surface.at_m, surface.triangles);
  tell(0.5);
  put_in_leaf_order(surface, tree);
  const Adjacency adjacency = orient(surface, tree, options.side == MeshSide::kInside, mesh.report);
  tell(0.6);
  const std::size_t count = surface.triangles.size();

  mesh.flags.resize(count);
  for (std::size_t t = 0; t < count; ++t) {
    const bool two_sided = options.side == MeshSide::kBoth || adjacency.open[t] != 0;
    mesh.flags[t] = static_cast<std::uint8_t>(
        (two_sided ? static_cast<unsigned>(scene::TriangleFlag::TwoSided) : 0U) |
        (adjacency.crowded[t] != 0 ? static_cast<unsigned>(scene::TriangleFlag::Pierced) : 0U));
  }
  flag_crossings(surface, tree, mesh.flags);
  mesh.seams = flag_seams(surface, tree, adjacency, mesh.flags);
  tell(0.85);

  std::vector<Vector3d> face_normals(count);
  for (std::size_t t = 0; t < count; ++t) {
    face_normals[t] = surface.area_vector(t).normalized();
  }
  if (options.tip_radius_m > 0.0)
    mesh.rims = tip_rims({surface, tree, adjacency, mesh.flags, face_normals}, options.tip_radius_m);
  add_triangles(surface, adjacency, face_normals, name, mesh);
  // Of a height field, the top hangs together, and each wall alone.
  const auto may_join = [&](std::uint32_t a, std::uint32_t b) {
    return !options.height_field || (face_normals[a].z() > 0.0 && face_normals[b].z() > 0.0);
  };
  if (options.crease_deg)
    mesh.corner_normals = shading_normals(surface, adjacency, face_normals, *options.crease_deg, may_join);
  if (options.texture) {
    const auto joins = [&](std::uint32_t a, std::uint32_t b) {
      return may_join(a, b) && face_normals[a].dot(face_normals[b]) > kTextureCorner;
    };
    lay_texture(soup, {surface, adjacency, face_normals, joins}, *options.texture, name, mesh);
  }

  mesh.nodes = std::move(tree.nodes);
  mesh.grid_origin_m = to_scene(tree.grid_origin_m);
  mesh.grid_step_m = tree.grid_step_m;
  mesh.depth = static_cast<std::uint8_t>(tree.depth);
  MeshReport& report = mesh.report;
  report.triangles = count;
  report.vertices = mesh.vertices.size();
  report.pierced_triangles = count_flagged(mesh.flags, scene::TriangleFlag::Pierced);
  report.seam_triangles = count_flagged(mesh.flags, scene::TriangleFlag::Seam);
  report.bytes = bytes_in_image(mesh);
  report.depth = tree.depth;
  return mesh;
}

}  // namespace thimble::host

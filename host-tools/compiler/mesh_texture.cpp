#include "host-tools/compiler/mesh_texture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <optional>
#include <tuple>

#include "control/scene/blend.h"
#include "control/scene/limits.h"
#include "host-tools/compiler/mesh_corners.h"
#include "host-tools/compiler/to_scene.h"
#include "host-tools/error.h"

namespace thimble::host {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kNoCoordinate = std::numeric_limits<double>::quiet_NaN();
constexpr double kSameCoordinate = 1.0e-3;  // of a tile
constexpr double kMostFaded = 0.25;         // of the area; more: not by itself by coordinates

std::uint32_t weights_code(const Vector3d& normal) {
  constexpr double kSteps = 65535.0;
  const Vector3d share = control::blend_shares<double>(normal).cwiseAbs2();
  const auto steps = [&](double part) {
    return static_cast<std::uint32_t>(std::floor(kSteps * part / share.sum() + 0.5));
  };
  const std::uint32_t x = steps(share.x());
  return x | (std::min(steps(share.y()), 0xFFFFU - x) << 16U);
}

// Of each triangle: whether all triangles that it hangs together with lie in one plane.
std::vector<char> flat_patches(const OrientedSurface& faces) {
  const std::size_t count = faces.surface.triangles.size();
  DisjointSets patches(count);
  for (std::uint32_t corner = 0; corner < 3 * count; ++corner) {
    const std::uint32_t code = faces.adjacency.neighbour[corner];
    if (code != kNoNeighbour && faces.joins(corner / 3, code >> 2U)) patches.join(corner / 3, code >> 2U);
  }
  constexpr double kInPlane = 1.0e-4;  // rad
  std::vector<char> flat(count, 1);
  for (std::uint32_t t = 0; t < count; ++t) {
    const std::uint32_t patch = patches.find(t);
    if ((faces.face_normals[t] - faces.face_normals[patch]).norm() > kInPlane) flat[patch] = 0;
  }
  for (std::uint32_t t = 0; t < count; ++t) flat[t] = flat[patches.find(t)];
  return flat;
}

void lay_blended(const OrientedSurface& faces, CompiledMesh& mesh) {
  const std::vector<char> flat = flat_patches(faces);
  if (std::ranges::all_of(flat, [](char is_flat) { return is_flat != 0; })) return;
  DisjointSets sets = join_corners(faces.adjacency, faces.joins);
  const std::vector<Vector3d> normals = mean_normals(faces.surface, faces.face_normals, sets);
  mesh.texture_weights.resize(3 * flat.size());
  for (std::uint32_t corner = 0; corner < mesh.texture_weights.size(); ++corner) {
    mesh.texture_weights[corner] =
        flat[corner / 3] != 0 ? control::kOwnAxes : weights_code(normals[sets.find(corner)]);
  }
}

// The coordinates of each corner of the surface, NaN where the file has none or where the face is not in the file.
std::vector<Vector2d> corner_coordinates(const TriangleSoup& soup, const Surface& surface) {
  std::vector<Vector2d> at(3 * surface.triangles.size(), Vector2d(kNoCoordinate, kNoCoordinate));
  if (soup.vertices_uv.size() != soup.vertices_m.size()) return at;
  std::map<TriangleIndices, std::uint32_t> faces;
  for (std::uint32_t t = 0; t < soup.triangles.size(); ++t) {
    TriangleIndices key{};
    for (std::size_t i = 0; i < 3; ++i) key[i] = surface.of_soup[soup.triangles[t][i]];
    std::ranges::sort(key);
    faces.try_emplace(key, t);
  }
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
    TriangleIndices key = surface.triangles[t];
    std::ranges::sort(key);
    const auto face = faces.find(key);
    if (face == faces.end()) continue;
    for (const std::uint32_t v : soup.triangles[face->second]) {
      for (std::size_t i = 0; i < 3; ++i)
        if (surface.triangles[t][i] == surface.of_soup[v]) at[3 * t + i] = soup.vertices_uv[v];
    }
  }
  return at;
}

// Gradients of u and v on a face, 1/m; not finite where it has no coordinates.
std::array<Vector3d, 2> face_gradients(const Surface& surface, const std::vector<Vector2d>& at,
                                       std::size_t t) {
  const Vector3d normal = surface.area_vector(t);
  std::array<Vector3d, 2> gradient{Vector3d::Zero(), Vector3d::Zero()};
  for (std::uint32_t k = 0; k < 3; ++k) {
    const TriangleIndices& corner = surface.triangles[t];
    const Vector3d opposite =
        surface.point(corner[next_edge(next_edge(k))]) - surface.point(corner[next_edge(k)]);
    const Vector3d slope = normal.cross(opposite) / normal.squaredNorm();
    gradient[0] += at[3 * t + k].x() * slope;
    gradient[1] += at[3 * t + k].y() * slope;
  }
  return gradient;
}

// Lays the texture by coordinates. Tiles fill a unit of the coordinates, so that it goes on where the coordinates of
// neighbouring faces differ by whole units.
class Coordinates {
 public:
  Coordinates(const TriangleSoup& soup, const OrientedSurface& faces, const std::array<double, 2>& tile_m)
      : faces_(faces), at_(corner_coordinates(soup, faces.surface)), tile_m_(tile_m) {}

  // False where the file has no coordinates that can be used.
  bool scale(MeshReport& report) {
    Vector2d lo = Vector2d::Constant(std::numeric_limits<double>::infinity());
    Vector2d hi = -lo;
    Vector2d length = Vector2d::Zero();  // of the gradients, weighted by area
    double area = 0.0;
    for (std::size_t t = 0; t < faces_.surface.triangles.size(); ++t) {
      gradient_.push_back(face_gradients(faces_.surface, at_, t));
      if (!usable(t)) continue;
      const double weight = faces_.surface.area_vector(t).norm();
      area += weight;
      for (int i = 0; i < 2; ++i) length[i] += weight * gradient_[t][static_cast<std::size_t>(i)].norm();
      for (std::size_t k = 0; k < 3; ++k) {
        lo = lo.cwiseMin(at_[3 * t + k]);
        hi = hi.cwiseMax(at_[3 * t + k]);
      }
    }
    if (!(area > 0.0) || !(length.minCoeff() > 0.0)) return false;
    for (std::size_t i = 0; i < 2; ++i) {
      const auto axis = static_cast<Eigen::Index>(i);
      const double unit_m = area / length[axis];
      constexpr double kMostTiles = 1.0e6;
      const double tiles = std::clamp(std::round(unit_m / tile_m_[i]), 1.0, kMostTiles);
      report.texture_tiles[i] = static_cast<std::size_t>(tiles);
      report.texture_tile_m[i] = unit_m / tiles;
      origin_[axis] = std::floor(lo[axis]);
      scale_m_[axis] = tiles * tile_m_[i];
    }
    const Vector2d most_m = (hi - origin_).cwiseProduct(scale_m_);
    return most_m.maxCoeff() <= static_cast<double>(control::kMaxCoordinate_m);
  }

  void lay(CompiledMesh& mesh) {
    DisjointSets sets = join_corners(faces_.adjacency, [this](std::uint32_t a, std::uint32_t b) {
      return faces_.joins(a, b) && go_on(a, b);
    });
    find_strengths(sets);
    find_gradients(sets);
    std::map<std::tuple<std::uint32_t, double, double>, std::uint32_t> points;
    double faded = 0.0;
    double area = 0.0;
    for (std::uint32_t corner = 0; corner < at_.size(); ++corner) {
      const std::uint32_t set = sets.find(corner);
      const bool known = usable(corner / 3);
      const Vector2d at =
          known ? Vector2d((at_[corner] - origin_).cwiseProduct(scale_m_)) : Vector2d(0.0, 0.0);
      const auto [entry, is_new] =
          points.try_emplace({set, at.x(), at.y()}, static_cast<std::uint32_t>(mesh.texture_points.size()));
      const float strength = strength_[set] != 0 ? 1.0F : 0.0F;
      if (is_new) {
        mesh.texture_points.emplace_back(static_cast<float>(at.x()), static_cast<float>(at.y()),
                                         to_scene(mean_[set][0]), to_scene(mean_[set][1]), strength);
      }
      mesh.texture_corners.push_back(entry->second);
      const double weight = faces_.surface.area_vector(corner / 3).norm();
      area += weight;
      faded += weight * (1.0 - static_cast<double>(strength));
    }
    mesh.report.texture_faded = faded / area;
  }

 private:
  [[nodiscard]] bool usable(std::size_t t) const {
    return gradient_[t][0].allFinite() && gradient_[t][1].allFinite();
  }

  // Whether the texture goes on from one triangle to its neighbour: whole tiles lie between their coordinates.
  [[nodiscard]] bool go_on(std::uint32_t a, std::uint32_t b) const {
    if (!usable(a) || !usable(b)) return false;
    std::optional<Vector2d> between;
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t j = 0; j < 3; ++j) {
        if (faces_.surface.triangles[a][i] != faces_.surface.triangles[b][j]) continue;
        const Vector2d tiles = (at_[3 * b + j] - at_[3 * a + i])
                                   .cwiseProduct(scale_m_)
                                   .cwiseQuotient(Vector2d(tile_m_[0], tile_m_[1]));
        const Vector2d rounded = tiles.array().round();
        if ((tiles - between.value_or(rounded)).cwiseAbs().maxCoeff() > kSameCoordinate) return false;
        between = rounded;
      }
    }
    return true;
  }

  // No texture at the corners on a seam.
  void find_strengths(DisjointSets& sets) {
    strength_.assign(at_.size(), 1);
    for (std::uint32_t corner = 0; corner < at_.size(); ++corner) {
      const std::uint32_t t = corner / 3;
      const std::uint32_t code = faces_.adjacency.neighbour[corner];
      const bool seam = code != kNoNeighbour && faces_.joins(t, code >> 2U) && !go_on(t, code >> 2U);
      if (seam) strength_[sets.find(corner)] = strength_[sets.find(3 * t + next_edge(corner % 3))] = 0;
      if (!usable(t)) strength_[sets.find(corner)] = 0;
    }
  }

  // Mean gradients round each vertex, in metres per metre.
  void find_gradients(DisjointSets& sets) {
    mean_.assign(at_.size(), {Vector3d::Zero(), Vector3d::Zero()});
    std::vector<double> area(at_.size());
    for (std::uint32_t corner = 0; corner < at_.size(); ++corner) {
      if (!usable(corner / 3)) continue;
      const std::uint32_t set = sets.find(corner);
      const double weight = faces_.surface.area_vector(corner / 3).norm();
      area[set] += weight;
      for (std::size_t i = 0; i < 2; ++i)
        mean_[set][i] += weight * scale_m_[static_cast<Eigen::Index>(i)] * gradient_[corner / 3][i];
    }
    for (std::uint32_t set = 0; set < at_.size(); ++set) {
      if (!(area[set] > 0.0)) continue;
      for (Vector3d& gradient : mean_[set]) {
        gradient /= area[set];
        const double length = gradient.norm();
        constexpr double kMost = 0.999 * static_cast<double>(control::kMaxTextureGradient);
        if (length <= kMost) continue;
        gradient *= kMost / length;  // squeezed, as at the pole of a globe
        strength_[set] = 0;
      }
    }
  }

  const OrientedSurface& faces_;
  std::vector<Vector2d> at_;
  std::array<double, 2> tile_m_;
  Vector2d origin_ = Vector2d::Zero();
  Vector2d scale_m_ = Vector2d::Zero();
  std::vector<std::array<Vector3d, 2>> gradient_;  // of each face, per unit of the coordinates
  std::vector<std::array<Vector3d, 2>> mean_;      // of each set of corners
  std::vector<char> strength_;
};

}  // namespace

void lay_texture(const TriangleSoup& soup, const OrientedSurface& faces, const MeshTexture& texture,
                 const std::string& name, CompiledMesh& mesh) {
  if (texture.mapping != TextureMapping::kBlended && !soup.vertices_uv.empty()) {
    MeshReport report;
    Coordinates coordinates(soup, faces, texture.tile_m);
    if (coordinates.scale(report)) {
      coordinates.lay(mesh);
      if (texture.mapping == TextureMapping::kCoordinates || mesh.report.texture_faded <= kMostFaded) {
        mesh.report.texture_tiles = report.texture_tiles;
        mesh.report.texture_tile_m = report.texture_tile_m;
        return;
      }
      mesh.texture_corners.clear();
      mesh.texture_points.clear();
      mesh.report.texture_faded = 0.0;
    }
  }
  if (texture.mapping == TextureMapping::kCoordinates) {
    throw Error(ExitCode::kBadInput, "no-coordinates",
                name + ": the mesh has no texture coordinates, or they span more than 10 m",
                R"(leave the texture's "mapping" out, or give it larger tiles)");
  }
  lay_blended(faces, mesh);
}

}  // namespace thimble::host

#include "tests/support/meshes.h"

#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <assimp/Importer.hpp>
#include <cmath>
#include <fstream>
#include <map>
#include <numbers>
#include <stdexcept>
#include <utility>

#include "tests/support/random.h"

namespace thimble::test {

using Eigen::Vector2d;
using Eigen::Vector3d;
using host::TriangleSoup;

namespace {

using Index = std::uint32_t;

Index last_index(const TriangleSoup& soup) { return static_cast<Index>(soup.vertices_m.size() - 1); }

Index as_index(int value) { return static_cast<Index>(value); }

void add_quad(TriangleSoup& soup, Index a, Index b, Index c, Index d) {
  soup.triangles.push_back({a, b, c});
  soup.triangles.push_back({a, c, d});
}

}  // namespace

TriangleSoup icosphere(int subdivisions, double radius_m) {
  const double g = std::numbers::phi;
  TriangleSoup soup;
  soup.vertices_m = {{-1, g, 0},  {1, g, 0},  {-1, -g, 0}, {1, -g, 0}, {0, -1, g},  {0, 1, g},
                     {0, -1, -g}, {0, 1, -g}, {g, 0, -1},  {g, 0, 1},  {-g, 0, -1}, {-g, 0, 1}};
  soup.triangles = {{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
                    {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
                    {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}};
  for (Vector3d& vertex : soup.vertices_m) vertex.normalize();
  for (int level = 0; level < subdivisions; ++level) {
    std::map<std::pair<Index, Index>, Index> middles;
    const auto middle = [&](Index a, Index b) {
      const auto [found, fresh] = middles.try_emplace(std::minmax(a, b), 0);
      if (fresh) {
        soup.vertices_m.push_back((soup.vertices_m[a] + soup.vertices_m[b]).normalized());
        found->second = last_index(soup);
      }
      return found->second;
    };
    std::vector<std::array<Index, 3>> finer;
    finer.reserve(soup.triangles.size() * 4);
    for (const auto& [a, b, c] : soup.triangles) {
      const Index ab = middle(a, b);
      const Index bc = middle(b, c);
      const Index ca = middle(c, a);
      finer.insert(finer.end(), {{a, ab, ca}, {b, bc, ab}, {c, ca, bc}, {ab, bc, ca}});
    }
    soup.triangles = std::move(finer);
  }
  for (Vector3d& vertex : soup.vertices_m) vertex *= radius_m;
  return soup;
}

TriangleSoup uv_sphere(int slices, int stacks, double radius_m) {
  TriangleSoup soup;
  soup.vertices_m = {{0, 0, radius_m}, {0, 0, -radius_m}};
  for (int stack = 1; stack < stacks; ++stack) {
    const double polar = std::numbers::pi * stack / stacks;
    for (int slice = 0; slice < slices; ++slice) {
      const double around = 2.0 * std::numbers::pi * slice / slices;
      soup.vertices_m.push_back(radius_m * Vector3d(std::sin(polar) * std::cos(around),
                                                    std::sin(polar) * std::sin(around), std::cos(polar)));
    }
  }
  const auto at = [&](int stack, int slice) { return as_index(2 + (stack - 1) * slices + slice % slices); };
  for (int slice = 0; slice < slices; ++slice) {
    soup.triangles.push_back({0, at(1, slice), at(1, slice + 1)});
    for (int stack = 1; stack + 1 < stacks; ++stack) {
      add_quad(soup, at(stack, slice), at(stack + 1, slice), at(stack + 1, slice + 1), at(stack, slice + 1));
    }
    soup.triangles.push_back({1, at(stacks - 1, slice + 1), at(stacks - 1, slice)});
  }
  return soup;
}

TriangleSoup torus(double ring_radius_m, double tube_radius_m, int around, int across) {
  TriangleSoup soup;
  for (int i = 0; i < around; ++i) {
    const double u = 2.0 * std::numbers::pi * i / around;
    for (int j = 0; j < across; ++j) {
      const double v = 2.0 * std::numbers::pi * j / across;
      const double r = ring_radius_m + tube_radius_m * std::cos(v);
      soup.vertices_m.emplace_back(r * std::cos(u), r * std::sin(u), tube_radius_m * std::sin(v));
    }
  }
  const auto at = [&](int i, int j) { return as_index((i % around) * across + j % across); };
  for (int i = 0; i < around; ++i) {
    for (int j = 0; j < across; ++j) add_quad(soup, at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
  }
  return soup;
}

TriangleSoup box_mesh(const Vector3d& size_m, int cells) {
  TriangleSoup soup;
  std::map<std::array<int, 3>, Index> lattice;
  const auto at = [&](const std::array<int, 3>& p) {
    const auto [found, fresh] = lattice.try_emplace(p, 0);
    if (fresh) {
      soup.vertices_m.push_back(
          size_m.cwiseProduct(Vector3d(p[0], p[1], p[2]) / cells - Vector3d::Constant(0.5)));
      found->second = last_index(soup);
    }
    return found->second;
  };
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::size_t u = (axis + 1) % 3;
    const std::size_t v = (axis + 2) % 3;
    for (int i = 0; i < cells; ++i) {
      for (int j = 0; j < cells; ++j) {
        const auto corner = [&](int side, int di, int dj) {
          std::array<int, 3> p{};
          p[axis] = side;
          p[u] = i + di;
          p[v] = j + dj;
          return at(p);
        };
        add_quad(soup, corner(cells, 0, 0), corner(cells, 1, 0), corner(cells, 1, 1), corner(cells, 0, 1));
        add_quad(soup, corner(0, 0, 0), corner(0, 0, 1), corner(0, 1, 1), corner(0, 1, 0));
      }
    }
  }
  return soup;
}

TriangleSoup sheet(double width_m, int cells) {
  TriangleSoup soup;
  for (int i = 0; i <= cells; ++i) {
    for (int j = 0; j <= cells; ++j) {
      soup.vertices_m.emplace_back(width_m * (1.0 * i / cells - 0.5), width_m * (1.0 * j / cells - 0.5), 0.0);
    }
  }
  const auto at = [&](int i, int j) { return as_index(i * (cells + 1) + j); };
  for (int i = 0; i < cells; ++i) {
    for (int j = 0; j < cells; ++j) add_quad(soup, at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
  }
  return soup;
}

TriangleSoup prism(const std::vector<Vector2d>& polygon_m, double length_m, int cells) {
  TriangleSoup soup;
  const int corners = static_cast<int>(polygon_m.size());
  for (int row = 0; row <= cells; ++row) {
    const double y = length_m * (1.0 * row / cells - 0.5);
    for (const Vector2d& corner : polygon_m) soup.vertices_m.emplace_back(corner.x(), y, corner.y());
  }
  const auto at = [&](int row, int corner) { return as_index(row * corners + corner % corners); };
  for (int row = 0; row < cells; ++row) {
    for (int c = 0; c < corners; ++c)
      add_quad(soup, at(row, c), at(row, c + 1), at(row + 1, c + 1), at(row + 1, c));
  }
  for (int c = 1; c + 1 < corners; ++c) {
    soup.triangles.push_back({at(0, 0), at(0, c + 1), at(0, c)});
    soup.triangles.push_back({at(cells, 0), at(cells, c), at(cells, c + 1)});
  }
  // The strips and fans above look inwards.
  for (auto& triangle : soup.triangles) std::swap(triangle[1], triangle[2]);
  return soup;
}

TriangleSoup v_groove(double angle_deg, double half_width_m, double length_m, int cells) {
  const double depth = half_width_m / std::tan(angle_deg / 360.0 * std::numbers::pi);
  const double margin = 2.0 * half_width_m;
  // From the groove's bottom every other corner is in sight only if the block reaches far below it.
  return prism({{0.0, 0.0},
                {-half_width_m, depth},
                {-margin, depth},
                {-margin, -margin},
                {margin, -margin},
                {margin, depth},
                {half_width_m, depth}},
               length_m, cells);
}

TriangleSoup knife(double angle_deg, double height_m, double length_m, int cells) {
  const double half = height_m * std::tan(angle_deg / 360.0 * std::numbers::pi);
  return prism({{0.0, 0.0}, {-half, -height_m}, {half, -height_m}}, length_m, cells);
}

TriangleSoup hostile_terrain(int cells, double cell_m, double height_m, std::uint64_t seed) {
  Random random(seed);
  TriangleSoup soup;
  const int side = cells + 1;
  for (int i = 0; i < side; ++i) {
    for (int j = 0; j < side; ++j) {
      const double spike = random.below(16) == 0 ? 3.0 : 1.0;
      soup.vertices_m.emplace_back(cell_m * (i - cells / 2.0), cell_m * (j - cells / 2.0),
                                   spike * random.uniform(-0.5, 0.5) * height_m);
    }
  }
  const auto top = [&](int i, int j) { return as_index(i * side + j); };
  const auto bottom = [&](int i, int j) { return as_index(side * side + i * side + j); };
  for (int k = 0; k < side * side; ++k) {
    Vector3d below = soup.vertices_m[static_cast<std::size_t>(k)];
    below.z() = -8.0 * height_m;
    soup.vertices_m.push_back(below);
  }
  for (int i = 0; i < cells; ++i) {
    for (int j = 0; j < cells; ++j) {
      if (random.below(2) == 0) {
        add_quad(soup, top(i, j), top(i + 1, j), top(i + 1, j + 1), top(i, j + 1));
      } else {
        add_quad(soup, top(i + 1, j), top(i + 1, j + 1), top(i, j + 1), top(i, j));
      }
      add_quad(soup, bottom(i, j), bottom(i, j + 1), bottom(i + 1, j + 1), bottom(i + 1, j));
    }
    add_quad(soup, top(i + 1, 0), top(i, 0), bottom(i, 0), bottom(i + 1, 0));
    add_quad(soup, top(i, cells), top(i + 1, cells), bottom(i + 1, cells), bottom(i, cells));
    add_quad(soup, top(0, i), top(0, i + 1), bottom(0, i + 1), bottom(0, i));
    add_quad(soup, top(cells, i + 1), top(cells, i), bottom(cells, i), bottom(cells, i + 1));
  }
  return soup;
}

std::filesystem::path test_model_path(const std::string& file) {
  return std::filesystem::path(THIMBLE_TEST_MODELS) / file;
}

TriangleSoup test_model(const std::string& file, double size_m) {
  Assimp::Importer importer;
  const aiScene* scene =
      importer.ReadFile(test_model_path(file).string(),
                        aiProcess_Triangulate | aiProcess_PreTransformVertices | aiProcess_SortByPType);
  if (scene == nullptr) throw std::runtime_error(file + ": " + importer.GetErrorString());
  TriangleSoup soup;
  for (unsigned m = 0; m < scene->mNumMeshes; ++m) {
    const aiMesh& mesh = *scene->mMeshes[m];
    const auto base = static_cast<Index>(soup.vertices_m.size());
    for (unsigned v = 0; v < mesh.mNumVertices; ++v) {
      soup.vertices_m.emplace_back(static_cast<double>(mesh.mVertices[v].x),
                                   static_cast<double>(mesh.mVertices[v].y),
                                   static_cast<double>(mesh.mVertices[v].z));
    }
    for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
      const aiFace& face = mesh.mFaces[f];
      if (face.mNumIndices == 3) {
        soup.triangles.push_back({base + face.mIndices[0], base + face.mIndices[1], base + face.mIndices[2]});
      }
    }
  }
  Eigen::AlignedBox3d box;
  for (const Vector3d& vertex : soup.vertices_m) box.extend(vertex);
  const double scale = size_m / box.sizes().maxCoeff();
  return transformed(std::move(soup), Eigen::Matrix3d::Identity() * scale, -scale * box.center());
}

TriangleSoup transformed(TriangleSoup soup, const Eigen::Matrix3d& matrix, const Vector3d& offset) {
  for (Vector3d& vertex : soup.vertices_m) vertex = matrix * vertex + offset;
  if (matrix.determinant() < 0.0) {
    for (auto& triangle : soup.triangles) std::swap(triangle[1], triangle[2]);
  }
  return soup;
}

void write_obj(const TriangleSoup& soup, double units_per_m, const std::filesystem::path& file) {
  std::ofstream out(file);
  out.precision(17);
  for (const Vector3d& vertex : soup.vertices_m) {
    out << "v " << vertex.x() * units_per_m << ' ' << vertex.y() * units_per_m << ' '
        << vertex.z() * units_per_m << '\n';
  }
  for (const auto& [a, b, c] : soup.triangles) out << "f " << a + 1 << ' ' << b + 1 << ' ' << c + 1 << '\n';
  if (!out.flush()) throw std::runtime_error("cannot write " + file.string());
}

}  // namespace thimble::test

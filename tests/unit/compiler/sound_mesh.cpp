#include "tests/unit/compiler/sound_mesh.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstring>

#include "control/scene/limits.h"
#include "control/scene/octahedral.h"

namespace thimble::test {
namespace {

constexpr std::uint32_t kNone = 0x3FFFFFU;
constexpr std::uint32_t kLeaf = 0x80000000U;  // read from scene.fbs anew, not from the code under test

std::uint32_t vertex(const host::CompiledMesh& mesh, std::uint32_t triangle, std::uint32_t corner) {
  return mesh.triangles[triangle].bits()->Get(static_cast<std::uint16_t>(corner % 3)) % (1U << 20U);
}
std::uint32_t neighbour(const host::CompiledMesh& mesh, std::uint32_t triangle, std::uint32_t edge) {
  const auto& bits = *mesh.triangles[triangle].bits();
  return (bits[static_cast<std::uint16_t>(edge)] >> 20U) + 4096U * ((bits[3] >> (10U * edge)) % 1024U);
}

std::string at(const char* what, std::size_t index) {
  return std::string(what) + " " + std::to_string(index);
}

std::string wrong_adjacency(const host::CompiledMesh& mesh) {
  const auto triangles = static_cast<std::uint32_t>(mesh.triangles.size());
  std::size_t open = 0;
  for (std::uint32_t t = 0; t < triangles; ++t) {
    for (std::uint32_t e = 0; e < 3; ++e) {
      if (vertex(mesh, t, e) >= mesh.vertices.size()) return at("vertex out of range in triangle", t);
      if (vertex(mesh, t, e) == vertex(mesh, t, e + 1)) return at("repeated vertex in triangle", t);
      const std::uint32_t code = neighbour(mesh, t, e);
      if (code == kNone) {
        ++open;
        continue;
      }
      const std::uint32_t other = code / 3;
      const std::uint32_t edge = code % 3;
      if (other >= triangles || other == t) return at("no such neighbour at triangle", t);
      if (neighbour(mesh, other, edge) != 3 * t + e) return at("one-sided adjacency at triangle", t);
      if (vertex(mesh, t, e) != vertex(mesh, other, edge + 1) ||
          vertex(mesh, t, e + 1) != vertex(mesh, other, edge)) {
        return at("neighbours wound unlike at triangle", t);
      }
    }
  }
  return open == mesh.report.open_edges ? "" : at("open edges, found", open);
}

// Walks round each vertex from one of its corners; every corner of the vertex must be met.
std::string wrong_fans(const host::CompiledMesh& mesh) {
  std::vector<std::size_t> corners(mesh.vertices.size());
  std::vector<std::uint32_t> some(mesh.vertices.size(), kNone);
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    for (std::uint32_t c = 0; c < 3; ++c) {
      ++corners[vertex(mesh, t, c)];
      some[vertex(mesh, t, c)] = 3 * t + c;
    }
  }
  for (std::size_t v = 0; v < corners.size(); ++v) {
    if (corners[v] == 0) return at("unused vertex", v);
    std::size_t met = 1;
    bool closed = false;
    for (std::uint32_t t = some[v] / 3, c = some[v] % 3;;) {  // across the edge that leaves the vertex
      const std::uint32_t code = neighbour(mesh, t, c);
      if (code == kNone) break;
      t = code / 3;
      c = (code % 3 + 1) % 3;
      if (3 * t + c == some[v]) {
        closed = true;
        break;
      }
      if (++met > corners[v]) return at("endless fan at vertex", v);
    }
    for (std::uint32_t t = some[v] / 3, c = some[v] % 3; !closed;) {  // and the other way from there
      const std::uint32_t code = neighbour(mesh, t, (c + 2) % 3);
      if (code == kNone) break;
      t = code / 3;
      c = code % 3;
      if (++met > corners[v]) return at("endless fan at vertex", v);
    }
    if (met != corners[v]) return at("more than one fan at vertex", v);
  }
  return "";
}

std::string wrong_tree(const host::CompiledMesh& mesh) {
  const Eigen::Vector3d origin(static_cast<double>(mesh.grid_origin_m.x()),
                               static_cast<double>(mesh.grid_origin_m.y()),
                               static_cast<double>(mesh.grid_origin_m.z()));
  const auto step = static_cast<double>(mesh.grid_step_m);
  std::vector<char> in_leaf(mesh.triangles.size());
  std::vector<char> reached(mesh.nodes.size());
  std::vector<unsigned> height(mesh.nodes.size(), 1);
  std::vector<Eigen::AlignedBox3d> bounds(mesh.nodes.size());  // of the vertices below each node
  for (std::size_t n = mesh.nodes.size(); n-- > 0;) {          // children come after their parents
    const scene::BvhNode& node = mesh.nodes[n];
    for (std::uint16_t c = 0; c < 2; ++c) {
      const std::uint32_t child = node.child()->Get(c);
      if (c == 1 && child == node.child()->Get(0)) break;
      Eigen::AlignedBox3d below;
      if ((child & kLeaf) != 0) {
        const std::uint32_t first = (child & ~kLeaf) >> 3U;
        for (std::uint32_t t = first; t <= first + (child & 7U); ++t) {
          if (t >= mesh.triangles.size()) return at("leaf out of range in node", n);
          if (in_leaf[t]++ != 0) return at("in two leaves: triangle", t);
          for (std::uint32_t i = 0; i < 3; ++i) below.extend(position(mesh, vertex(mesh, t, i)));
        }
      } else {
        if (child <= n || child >= mesh.nodes.size()) return at("child before its parent, node", n);
        if (reached[child]++ != 0) return at("reached twice: node", child);
        below = bounds[child];
        height[n] = std::max(height[n], height[child] + 1);
      }
      Eigen::AlignedBox3d box;
      for (std::uint16_t axis = 0; axis < 3; ++axis) {
        box.min()[axis] = origin[axis] + step * (c == 0 ? node.lo_a() : node.lo_b())->Get(axis);
        box.max()[axis] = origin[axis] + step * (c == 0 ? node.hi_a() : node.hi_b())->Get(axis);
      }
      if (!box.contains(below)) return at("a triangle is outside its box, below node", n);
      bounds[n].extend(below);
    }
  }
  if (std::count(in_leaf.begin(), in_leaf.end(), 1) != std::ssize(in_leaf)) return "a triangle is in no leaf";
  if (reached[0] != 0 || std::count(reached.begin(), reached.end(), 1) + 1 != std::ssize(reached)) {
    return "a node is out of reach";
  }
  if (height[0] != mesh.depth || height[0] > control::kMaxBvhDepth) return at("depth", height[0]);
  return "";
}

}  // namespace

Eigen::Vector3d position(const host::CompiledMesh& mesh, std::uint32_t v) {
  const scene::Vec3& p = mesh.vertices[v].position_m();
  return {static_cast<double>(p.x()), static_cast<double>(p.y()), static_cast<double>(p.z())};
}

std::string unsound(const host::CompiledMesh& mesh) {
  if (mesh.triangles.empty()) return "no triangle";
  if (mesh.flags.size() != mesh.triangles.size()) return "flags";
  if (!mesh.corner_normals.empty() && mesh.corner_normals.size() != 3 * mesh.triangles.size())
    return "corner normals";
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
    if (!position(mesh, static_cast<std::uint32_t>(v)).allFinite()) return at("not finite: vertex", v);
  }
  const host::MeshReport& report = mesh.report;
  const std::size_t bytes = mesh.vertices.size() * 16 + mesh.triangles.size() * 17 +
                            mesh.corner_normals.size() * 4 + mesh.nodes.size() * 32;
  if (report.bytes != bytes || report.triangles != mesh.triangles.size() ||
      report.vertices != mesh.vertices.size() || report.depth != mesh.depth ||
      report.pierced_triangles != count_flag(mesh, scene::TriangleFlag::Pierced)) {
    return "report";
  }
  for (const std::string& wrong : {wrong_adjacency(mesh), wrong_fans(mesh), wrong_tree(mesh)}) {
    if (!wrong.empty()) return wrong;
  }
  return "";
}

double volume_m3(const host::CompiledMesh& mesh) {
  double six = 0;
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    six += position(mesh, vertex(mesh, t, 0))
               .dot(position(mesh, vertex(mesh, t, 1)).cross(position(mesh, vertex(mesh, t, 2))));
  }
  return six / 6.0;
}

std::size_t count_flag(const host::CompiledMesh& mesh, scene::TriangleFlag flag) {
  return static_cast<std::size_t>(
      std::count_if(mesh.flags.begin(), mesh.flags.end(),
                    [flag](std::uint8_t flags) { return (flags & static_cast<unsigned>(flag)) != 0; }));
}

bool same_bytes(const host::CompiledMesh& a, const host::CompiledMesh& b) {
  const auto same = [](const auto& x, const auto& y) {
    return x.size() == y.size() && std::memcmp(x.data(), y.data(), x.size() * sizeof(x[0])) == 0;
  };
  return same(a.vertices, b.vertices) && same(a.triangles, b.triangles) && same(a.flags, b.flags) &&
         same(a.corner_normals, b.corner_normals) && same(a.nodes, b.nodes) && a.depth == b.depth &&
         a.grid_origin_m.x() == b.grid_origin_m.x() && a.grid_origin_m.y() == b.grid_origin_m.y() &&
         a.grid_origin_m.z() == b.grid_origin_m.z() && a.grid_step_m == b.grid_step_m;
}

}  // namespace thimble::test

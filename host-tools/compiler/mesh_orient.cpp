#include "host-tools/compiler/mesh_orient.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>

#include "host-tools/compiler/portable_math.h"

namespace thimble::host {
namespace {

using Eigen::Vector3d;

// Below this share of (area times size) the sign of a volume is not reliable, and the file's winding is kept.
constexpr double kFlatVolume = 1.0e-9;
constexpr double kAngleSlack =
    1.0e-9;  // radians: faces closer than this around an edge keep the triangles' order

// A face at an edge. code = 4 * triangle + edge. Uses with the same key are the faces of one edge.
struct EdgeUse {
  std::uint64_t key;
  std::uint32_t code;
};

struct Component {
  bool closed = true;
  double volume = 0;  // six times the signed volume, under the present winding
  double area = 0;
  double flipped_area = 0;  // of the triangles that are wound against the file
  std::uint32_t first = 0;  // its first triangle

  [[nodiscard]] bool mostly_flipped() const { return flipped_area > (0.5 + 1.0e-9) * area; }
  [[nodiscard]] bool flat(double size_m) const { return std::abs(volume) <= kFlatVolume * area * size_m; }
};

class Orienter {
 public:
  Orienter(Surface& surface, const MeshTree& tree) : surface_(surface), tree_(tree) {
    const std::size_t count = surface.triangles.size();
    flipped_.assign(count, 0);
    mate_.assign(3 * count, kNoNeighbour);
    crowded_.assign(count, 0);
    collect_edges();
  }

  Adjacency run(bool inside_out, MeshReport& report) {
    join_pairs();
    std::size_t patches = spread_winding();
    cut_twisted_edges();
    if (!crowded_edges_.empty()) {
      orient_patches(patches);
    }
    pair_crowded_edges();
    find_components();
    if (orient_components() && !crowded_edges_.empty()) {
      pair_crowded_edges();
      find_components();
    }
    report.non_manifold_edges = crowded_edges_.size();
    report.components = components_.size();
    for (const Component& component : components_) {
      report.flipped_components += component.closed && component.mostly_flipped() ? 1U : 0U;
    }
    report.open_edges = static_cast<std::size_t>(std::count(mate_.begin(), mate_.end(), kNoNeighbour));
    return finish(inside_out);
  }

 private:
  using EdgeFaces = std::span<const EdgeUse>;

  [[nodiscard]] std::uint32_t corner(std::uint32_t code, std::uint32_t offset) const {
    const std::uint32_t e = code & 3U;
    return surface_.triangles[code >> 2U][offset == 0   ? e
                                          : offset == 1 ? next_edge(e)
                                                        : next_edge(next_edge(e))];
  }
  // The face runs along its edge from the lower to the higher vertex, as it is wound now.
  [[nodiscard]] bool forward(std::uint32_t code) const {
    return (corner(code, 0) < corner(code, 1)) != (flipped_[code >> 2U] != 0);
  }
  std::uint32_t& mate(std::uint32_t code) {
    return mate_[3 * static_cast<std::size_t>(code >> 2U) + (code & 3U)];
  }

  void collect_edges() {
    edges_.reserve(mate_.size());
    for (std::uint32_t t = 0; t < surface_.triangles.size(); ++t) {
      for (std::uint32_t e = 0; e < 3; ++e) {
        const std::uint32_t code = 4 * t + e;
        const auto [lo, hi] = std::minmax({corner(code, 0), corner(code, 1)});
        edges_.push_back({(static_cast<std::uint64_t>(lo) << 32U) | hi, code});
      }
    }
    std::sort(edges_.begin(), edges_.end(), [](const EdgeUse& a, const EdgeUse& b) {
      return a.key != b.key ? a.key < b.key : a.code < b.code;
    });
  }

  // Edges with exactly two faces join them; the others are remembered.
  void join_pairs() {
    for (std::size_t begin = 0, end = 0; begin < edges_.size(); begin = end) {
      while (end < edges_.size() && edges_[end].key == edges_[begin].key) {
        ++end;
      }
      if (end - begin == 2) {
        mate(edges_[begin].code) = edges_[begin + 1].code;
        mate(edges_[begin + 1].code) = edges_[begin].code;
      } else if (end - begin > 2) {
        crowded_edges_.push_back(EdgeFaces(edges_).subspan(begin, end - begin));
        for (const EdgeUse& use : crowded_edges_.back()) {
          crowded_[use.code >> 2U] = 1;
        }
      }
    }
  }

  // Walks each patch (what hangs together by edges with two faces) and winds it alike; returns the number of
  // patches.
  std::size_t spread_winding() {
    constexpr std::uint32_t kUnseen = 0xFFFFFFFFU;
    patch_of_.assign(surface_.triangles.size(), kUnseen);
    std::uint32_t patches = 0;
    std::vector<std::uint32_t> members;
    for (std::uint32_t seed = 0; seed < surface_.triangles.size(); ++seed) {
      if (patch_of_[seed] != kUnseen) {
        continue;
      }
      members.assign(1, seed);
      patch_of_[seed] = patches;
      double area = 0;
      double flipped_area = 0;
      for (std::size_t i = 0; i < members.size(); ++i) {
        const std::uint32_t t = members[i];
        const double a = surface_.area_vector(t).norm();
        area += a;
        flipped_area += flipped_[t] != 0 ? a : 0.0;
        for (std::uint32_t e = 0; e < 3; ++e) {
          const std::uint32_t other = mate(4 * t + e);
          if (other != kNoNeighbour && patch_of_[other >> 2U] == kUnseen) {
            flipped_[other >> 2U] = forward(4 * t + e) == forward(other) ? 1 : 0;
            patch_of_[other >> 2U] = patches;
            members.push_back(other >> 2U);
          }
        }
      }
      if (flipped_area > (0.5 + 1.0e-9) * area) {
        flip(members);
      }
      ++patches;
    }
    return patches;
  }

  void flip(const std::vector<std::uint32_t>& triangles) {
    for (const std::uint32_t t : triangles) {
      flipped_[t] = flipped_[t] != 0 ? 0 : 1;
    }
  }

  // Where a one-sided surface (a Moebius strip) comes back to itself the other way round, the sheet is taken
  // to end.
  void cut_twisted_edges() {
    for (std::uint32_t t = 0; t < surface_.triangles.size(); ++t) {
      for (std::uint32_t e = 0; e < 3; ++e) {
        const std::uint32_t other = mate(4 * t + e);
        if (other != kNoNeighbour && forward(4 * t + e) == forward(other)) {
          mate(other) = kNoNeighbour;
          mate(4 * t + e) = kNoNeighbour;
        }
      }
    }
  }

  // Patches that are closed in themselves but meet others at crowded edges: outwards, so that the pairing
  // there is right.
  void orient_patches(std::size_t count) {
    std::vector<Component> patches(count);
    std::vector<std::vector<std::uint32_t>> members(count);
    closed_patch_.assign(count, 0);
    for (std::uint32_t t = 0; t < surface_.triangles.size(); ++t) {
      members[patch_of_[t]].push_back(t);
      add_to(patches[patch_of_[t]], t, members[patch_of_[t]].front());
      for (std::uint32_t e = 0; e < 3; ++e) {
        if (mate(4 * t + e) == kNoNeighbour) {
          patches[patch_of_[t]].closed = patches[patch_of_[t]].closed && crowded_[t] != 0;
        }
      }
    }
    std::vector<std::pair<std::uint32_t, int>> runs;  // patch, direction along the edge
    for (const EdgeFaces& faces : crowded_edges_) {
      runs.clear();
      for (const EdgeUse& use : faces) {
        runs.emplace_back(patch_of_[use.code >> 2U], forward(use.code) ? 1 : -1);
      }
      std::sort(runs.begin(), runs.end());
      for (std::size_t begin = 0, end = 0; begin < runs.size(); begin = end) {
        int sum = 0;
        while (end < runs.size() && runs[end].first == runs[begin].first) {
          sum += runs[end++].second;
        }
        patches[runs[begin].first].closed = patches[runs[begin].first].closed && sum == 0;
      }
    }
    for (std::size_t patch = 0; patch < count; ++patch) {
      closed_patch_[patch] = patches[patch].closed ? 1 : 0;
      if (patches[patch].closed && patches[patch].volume < 0 && !patches[patch].flat(surface_.size_m)) {
        flip(members[patch]);
      }
    }
  }

  // Around each crowded edge, from a face that runs forwards its free side lies towards growing angle, from
  // one that runs backwards towards falling angle: a forward face and the backward face that follows it look
  // at each other. Such neighbours are joined and taken out until none is left (as brackets are matched,
  // around the circle).
  void pair_crowded_edges() {
    struct Around {
      double angle;
      std::uint32_t code;
    };
    std::vector<Around> ring;
    std::vector<std::uint32_t> waiting;
    for (const EdgeFaces& faces : crowded_edges_) {
      const auto lo = static_cast<std::uint32_t>(faces[0].key >> 32U);
      const auto hi = static_cast<std::uint32_t>(faces[0].key & 0xFFFFFFFFU);
      const Vector3d origin = surface_.point(lo);
      const Vector3d axis = (surface_.point(hi) - origin).normalized();
      const auto across = [&](std::uint32_t code) {
        const Vector3d to = surface_.point(corner(code, 2)) - origin;
        return (to - axis * axis.dot(to)).eval();
      };
      const Vector3d zero = across(faces[0].code).normalized();
      const Vector3d quarter = axis.cross(zero);
      ring.clear();
      for (const EdgeUse& use : faces) {
        mate(use.code) = kNoNeighbour;
        const Vector3d u = across(use.code);
        double angle = portable::atan2(u.dot(quarter), u.dot(zero));
        angle += angle < -kAngleSlack ? 2.0 * std::numbers::pi : 0.0;
        ring.push_back({std::round(angle / kAngleSlack), use.code});
      }
      std::sort(ring.begin(), ring.end(), [](const Around& a, const Around& b) {
        return a.angle != b.angle ? a.angle < b.angle : a.code < b.code;
      });
      waiting.clear();
      for (std::size_t i = 0; i < 2 * ring.size(); ++i) {  // twice round: the circle has no beginning
        const std::uint32_t code = ring[i % ring.size()].code;
        if (mate(code) != kNoNeighbour) {
          continue;
        }
        if (forward(code)) {
          if (i < ring.size()) {
            waiting.push_back(code);
          }
        } else if (!waiting.empty()) {
          mate(code) = waiting.back();
          mate(waiting.back()) = code;
          waiting.pop_back();
        }
      }
    }
  }

  void add_to(Component& component, std::uint32_t t, std::uint32_t first) const {
    const Vector3d base = surface_.point(surface_.triangles[first][0]);
    const double turn = flipped_[t] != 0 ? -1.0 : 1.0;
    const Vector3d area = surface_.area_vector(t);
    component.first = first;
    component.volume += turn * area.dot(surface_.point(surface_.triangles[t][0]) - base);
    component.area += area.norm();
    component.flipped_area += flipped_[t] != 0 ? area.norm() : 0.0;
  }

  void find_components() {
    constexpr std::uint32_t kUnseen = 0xFFFFFFFFU;
    components_.clear();
    component_of_.assign(surface_.triangles.size(), kUnseen);
    std::vector<std::uint32_t> members;
    for (std::uint32_t seed = 0; seed < surface_.triangles.size(); ++seed) {
      if (component_of_[seed] != kUnseen) {
        continue;
      }
      const auto id = static_cast<std::uint32_t>(components_.size());
      Component& component = components_.emplace_back();
      members.assign(1, seed);
      component_of_[seed] = id;
      for (std::size_t i = 0; i < members.size(); ++i) {
        add_to(component, members[i], seed);
        for (std::uint32_t e = 0; e < 3; ++e) {
          const std::uint32_t other = mate(4 * members[i] + e);
          component.closed = component.closed && other != kNoNeighbour;
          if (other != kNoNeighbour && component_of_[other >> 2U] == kUnseen) {
            component_of_[other >> 2U] = id;
            members.push_back(other >> 2U);
          }
        }
      }
    }
  }

  // Turns closed components outwards and cavities inwards. Returns whether any was turned.
  bool orient_components() {
    std::vector<char> turn(components_.size());
    bool any = false;
    bool mixed = false;  // cavities exist only where the file winds its closed components both ways
    int seen_sign = 0;
    for (const Component& component : components_) {
      if (component.closed && !component.flat(surface_.size_m)) {
        const int sign = file_sign(component);
        mixed = mixed || seen_sign * sign < 0;
        seen_sign = sign;
      }
    }
    for (std::uint32_t id = 0; id < components_.size(); ++id) {
      const Component& component = components_[id];
      if (component.closed && !component.flat(surface_.size_m)) {
        const bool outward = !mixed || !is_cavity(id);
        turn[id] = (component.volume > 0) != outward ? 1 : 0;
        any = any || turn[id] != 0;
      }
    }
    for (std::size_t t = 0; any && t < flipped_.size(); ++t) {
      flipped_[t] = (flipped_[t] != 0) != (turn[component_of_[t]] != 0) ? 1 : 0;
    }
    for (std::size_t id = 0; id < components_.size(); ++id) {
      Component& component = components_[id];
      if (turn[id] != 0) {
        component.volume = -component.volume;
        component.flipped_area = component.area - component.flipped_area;
      }
    }
    return any;
  }

  // The sign of the volume as the file winds it.
  static int file_sign(const Component& component) {
    return (component.volume > 0) != component.mostly_flipped() ? 1 : -1;
  }

  // Inside an odd number of closed components, and wound in the file against the innermost of them.
  [[nodiscard]] bool is_cavity(std::uint32_t id) const {
    const TriangleIndices& first = surface_.triangles[components_[id].first];
    const Vector3d origin =
        (surface_.point(first[0]) + surface_.point(first[1]) + surface_.point(first[2])) / 3.0;
    std::vector<std::uint32_t> crossed;  // the component of each face that a ray along +x passes
    const Vector3d far(origin.x() + 2.0 * surface_.size_m, origin.y(), origin.z());
    visit_box(tree_.nodes, tree_.grid_box(origin, far), [&](std::uint32_t t) {
      const std::uint32_t other = component_of_[t];
      if (other != id && components_[other].closed && !components_[other].flat(surface_.size_m) &&
          ray_hits(origin, t)) {
        crossed.push_back(other);
      }
      return true;
    });
    std::sort(crossed.begin(), crossed.end());
    std::size_t containers = 0;
    std::uint32_t innermost = id;
    for (std::size_t begin = 0, end = 0; begin < crossed.size(); begin = end) {
      while (end < crossed.size() && crossed[end] == crossed[begin]) {
        ++end;
      }
      if ((end - begin) % 2 == 1) {
        ++containers;
        const double volume = std::abs(components_[crossed[begin]].volume);
        if (innermost == id || volume < std::abs(components_[innermost].volume)) {
          innermost = crossed[begin];
        }
      }
    }
    return containers % 2 == 1 && file_sign(components_[id]) != file_sign(components_[innermost]);
  }

  // Even-odd in the yz plane, each edge judged from its lower vertex, so that no ray slips between two faces.
  [[nodiscard]] bool ray_hits(const Vector3d& origin, std::uint32_t t) const {
    const TriangleIndices& corners = surface_.triangles[t];
    bool inside = false;
    for (std::uint32_t e = 0; e < 3; ++e) {
      const auto [lo, hi] = std::minmax(corners[e], corners[next_edge(e)]);
      const Vector3d a = surface_.point(lo) - origin;
      const Vector3d b = surface_.point(hi) - origin;
      if ((a.z() > 0.0) != (b.z() > 0.0) && a.y() - a.z() * (b.y() - a.y()) / (b.z() - a.z()) > 0.0) {
        inside = !inside;
      }
    }
    if (!inside) {
      return false;
    }
    const Vector3d normal = surface_.area_vector(t);
    return normal.dot(surface_.point(corners[0]) - origin) * normal.x() > 0.0;
  }

  // Reverses the triangles that turned (vertices 0 and 2 change places, and so do edges 0 and 1).
  Adjacency finish(bool inside_out) {
    const auto turned = [&](std::uint32_t t) { return (flipped_[t] != 0) != inside_out; };
    for (std::uint32_t& code : mate_) {
      if (code != kNoNeighbour && turned(code >> 2U) && (code & 3U) != 2) {
        code ^= 1U;
      }
    }
    Adjacency adjacency;
    adjacency.open.resize(surface_.triangles.size());
    adjacency.part.assign(surface_.triangles.size(), kOpenPart);
    for (std::uint32_t t = 0; t < surface_.triangles.size(); ++t) {
      if (turned(t)) {
        std::swap(surface_.triangles[t][0], surface_.triangles[t][2]);
        std::swap(mate_[3 * static_cast<std::size_t>(t)], mate_[3 * static_cast<std::size_t>(t) + 1]);
      }
      adjacency.open[t] = components_[component_of_[t]].closed ? 0 : 1;
      if (crowded_edges_.empty() ? adjacency.open[t] == 0 : closed_patch_[patch_of_[t]] != 0)
        adjacency.part[t] = patch_of_[t];
    }
    adjacency.neighbour = std::move(mate_);
    adjacency.crowded = std::move(crowded_);
    return adjacency;
  }

  Surface& surface_;
  const MeshTree& tree_;
  std::vector<EdgeUse> edges_;
  std::vector<EdgeFaces> crowded_edges_;  // edges with more than two faces
  std::vector<char> crowded_;
  std::vector<char> closed_patch_;   // with crowded edges: of each patch, whether it is closed in itself
  std::vector<char> flipped_;        // against the file
  std::vector<std::uint32_t> mate_;  // 3 a triangle, in the file's winding
  std::vector<std::uint32_t> patch_of_;
  std::vector<std::uint32_t> component_of_;
  std::vector<Component> components_;
};

}  // namespace

Adjacency orient(Surface& surface, const MeshTree& tree, bool inside_out, MeshReport& report) {
  return Orienter(surface, tree).run(inside_out, report);
}

}  // namespace thimble::host

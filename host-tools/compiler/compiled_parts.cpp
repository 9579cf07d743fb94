#include "host-tools/compiler/compiled_parts.h"

#include <algorithm>
#include <cmath>

namespace thimble::host {

bool is_same(const TriangleSoup& a, const TriangleSoup& b) {
  const auto is_same_coordinate = [](const Eigen::Vector2d& u, const Eigen::Vector2d& v) {
    return u == v || (std::isnan(u.x()) && std::isnan(v.x()));  // NaN: none
  };
  return a.triangles == b.triangles && a.vertices_m == b.vertices_m &&
         std::ranges::equal(a.vertices_uv, b.vertices_uv, is_same_coordinate);
}

bool is_same(const MeshOptions& a, const MeshOptions& b) {
  const auto is_same_texture = [](const MeshTexture& s, const MeshTexture& t) {
    return s.mapping == t.mapping && s.tile_m == t.tile_m;
  };
  return a.side == b.side && a.crease_deg == b.crease_deg && a.height_field == b.height_field &&
         a.tip_radius_m == b.tip_radius_m && a.texture.has_value() == b.texture.has_value() &&
         (!a.texture || is_same_texture(*a.texture, *b.texture));
}

}  // namespace thimble::host

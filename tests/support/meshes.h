// Meshes for tests: triangles in metres, counter-clockwise seen from the free side, identical on every
// machine. Neighbours share vertex indices unless stated.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "host-tools/compiler/mesh.h"

namespace thimble::test {

// 20 * 4^subdivisions triangles, vertices on the sphere: 1 -> 80, 3 -> 1280, 5 -> 20 480, 7 -> 327 680.
[[nodiscard]] host::TriangleSoup icosphere(int subdivisions, double radius_m);

// With two poles, each a vertex of `slices` triangles.
[[nodiscard]] host::TriangleSoup uv_sphere(int slices, int stacks, double radius_m);

[[nodiscard]] host::TriangleSoup torus(double ring_radius_m, double tube_radius_m, int around, int across);

// A closed box with each face cut into cells x cells squares, centre at the origin.
[[nodiscard]] host::TriangleSoup box_mesh(const Eigen::Vector3d& size_m, int cells);

// An open sheet at z = 0, centre at the origin, free side up.
[[nodiscard]] host::TriangleSoup sheet(double width_m, int cells);

// A polygon in the x-z plane, counter-clockwise with x to the right and z up, extruded along y from -length/2
// to length/2 in `cells` strips; the ends are triangle fans around the first corner of the polygon, from
// which all other corners must be visible.
[[nodiscard]] host::TriangleSoup prism(const std::vector<Eigen::Vector2d>& polygon_m, double length_m,
                                       int cells);

// A closed block with a groove along y in its top: bottom line on the y axis, walls `angle_deg` apart that
// rise to the rims at x = +-half_width_m, mirror plane x = 0.
[[nodiscard]] host::TriangleSoup v_groove(double angle_deg, double half_width_m, double length_m, int cells);

// A closed blade along y whose edge, `angle_deg` sharp, lies on the y axis and points up.
[[nodiscard]] host::TriangleSoup knife(double angle_deg, double height_m, double length_m, int cells);

// A closed block with a random height field of cells x cells squares on top, steps of up to height_m between
// neighbours, and a spike of 3 height_m on one vertex in 16. Its mean height is about 0, the bottom is at -8
// height_m.
[[nodiscard]] host::TriangleSoup hostile_terrain(int cells, double cell_m, double height_m,
                                                 std::uint64_t seed);

// The triangles of a file of Debian's assimp-testmodels ("OFF/Wuson.off"), centred on the origin and scaled
// to a largest extent of size_m. Vertices are not shared.
[[nodiscard]] host::TriangleSoup test_model(const std::string& file, double size_m);
[[nodiscard]] std::filesystem::path test_model_path(const std::string& file);

[[nodiscard]] host::TriangleSoup transformed(host::TriangleSoup soup, const Eigen::Matrix3d& matrix,
                                             const Eigen::Vector3d& offset);

// Writes a Wavefront OBJ file in which one unit is 1/units_per_m metres.
void write_obj(const host::TriangleSoup& soup, double units_per_m, const std::filesystem::path& file);

}  // namespace thimble::test

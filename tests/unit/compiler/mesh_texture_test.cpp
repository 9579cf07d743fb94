// What the corners of a mesh have for a texture: weights of the axes, or the coordinates of the file.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "control/scene/blend.h"
#include "control/scene/mesh_triangle.h"
#include "host-tools/compiler/mesh.h"
#include "host-tools/error.h"
#include "tests/support/figure.h"
#include "tests/support/meshes.h"
#include "tests/support/random.h"

namespace thimble::test::mesh_texture {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using host::CompiledMesh;
using host::TextureMapping;

CompiledMesh with_texture(const host::TriangleSoup& soup, TextureMapping mapping = TextureMapping::kAuto) {
  host::MeshOptions options;
  options.texture = host::MeshTexture{mapping, {0.004, 0.004}};
  return host::compile_mesh(soup, options, "soup");
}

Vector3d at(const scene::Vec3& v) { return Vector3d(Eigen::Vector3f(v.x(), v.y(), v.z()).cast<double>()); }

// Corners of its own for each triangle, with coordinates from a function of corner and middle.
template <typename Function>
host::TriangleSoup unwrapped(const host::TriangleSoup& soup, Function&& coordinates) {
  host::TriangleSoup apart;
  for (const auto& t : soup.triangles) {
    const auto base = static_cast<std::uint32_t>(apart.vertices_m.size());
    const Vector3d middle = (soup.vertices_m[t[0]] + soup.vertices_m[t[1]] + soup.vertices_m[t[2]]) / 3.0;
    for (const std::uint32_t v : t) {
      apart.vertices_m.push_back(soup.vertices_m[v]);
      apart.vertices_uv.push_back(coordinates(soup.vertices_m[v], middle));
    }
    apart.triangles.push_back({base, base + 1, base + 2});
  }
  return apart;
}

TEST(MeshTexture, FlatPartsBetweenCornersHaveTheAxesOfTheirFaces) {
  EXPECT_TRUE(with_texture(box_mesh({0.02, 0.03, 0.04}, 3)).texture_weights.empty());
  EXPECT_TRUE(with_texture(sheet(0.02, 4)).texture_weights.empty());
  // A prism of eight sides: its corners are of 45 degrees, and its ends are flat.
  std::vector<Vector2d> polygon;
  for (int i = 0; i < 8; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / 8;
    polygon.emplace_back(0.01 * std::cos(angle), 0.01 * std::sin(angle));
  }
  const CompiledMesh mesh = with_texture(prism(polygon, 0.03, 2));
  ASSERT_EQ(mesh.texture_weights.size(), 3 * mesh.triangles.size());
  std::size_t own = 0;
  for (const std::uint32_t code : mesh.texture_weights) own += code == control::kOwnAxes ? 1U : 0U;
  EXPECT_EQ(own, 3U * 2U * 6U);
}

TEST(MeshTexture, WeightsAreThoseOfTheMeanNormal) {
  const CompiledMesh mesh = with_texture(icosphere(3, 0.02));
  ASSERT_EQ(mesh.texture_weights.size(), 3 * mesh.triangles.size());
  double worst = 0;
  std::size_t on_one_axis = 0;
  for (std::size_t corner = 0; corner < mesh.texture_weights.size(); ++corner) {
    const std::uint32_t v =
        control::vertex_of(mesh.triangles[corner / 3], static_cast<std::uint32_t>(corner % 3));
    const Vector3d square = at(mesh.vertices[v].position_m()).normalized().cwiseAbs2();
    const Vector3d share = (square.array() - 0.2).max(0.0).square();
    const std::uint32_t code = mesh.texture_weights[corner];
    const double x = (code & 0xFFFFU) / 65535.0;
    const double y = (code >> 16U) / 65535.0;
    worst = std::max({worst, std::abs(x - share.x() / share.sum()), std::abs(y - share.y() / share.sum())});
    on_one_axis += code == 0 || code == 0xFFFFU || code == 0xFFFF0000U ? 1U : 0U;
  }
  figure("weights of an icosphere's corners, largest difference from the closed form", worst, "0.01");
  EXPECT_LT(worst, 0.01);
  EXPECT_GT(on_one_axis, mesh.texture_weights.size() / 6);
}

TEST(MeshTexture, CoordinatesAreKeptInMetresWithTheirGradients) {
  const auto flat = [](const Vector3d& p, const Vector3d&) {
    return Vector2d(50.0 * p.x(), 25.0 * p.y() + 10.0 * p.x());
  };
  const CompiledMesh mesh = with_texture(unwrapped(sheet(0.04, 5), flat));
  EXPECT_TRUE(mesh.texture_weights.empty());
  ASSERT_EQ(mesh.texture_corners.size(), 3 * mesh.triangles.size());
  EXPECT_EQ(mesh.texture_points.size(), mesh.vertices.size());
  EXPECT_EQ(mesh.report.texture_tiles[0], 5U);  // a unit is 20 mm
  EXPECT_EQ(mesh.report.texture_tiles[1], 9U);  // and 37 mm: 1 / |(25, 10)|
  EXPECT_EQ(mesh.report.texture_faded, 0.0);
  double worst = 0;
  for (const scene::TexturePoint& point : mesh.texture_points) {
    worst = std::max({worst, (at(point.du()) - 5 * 0.004 * Vector3d(50, 0, 0)).norm(),
                      (at(point.dv()) - 9 * 0.004 * Vector3d(10, 25, 0)).norm()});
    EXPECT_EQ(point.strength(), 1.0F);
  }
  EXPECT_LT(worst, 1e-5);
}

TEST(MeshTexture, FadesTowardsSeamsOnly) {
  const host::TriangleSoup ball = icosphere(4, 0.02);
  const auto halves = [](double shift) {
    return [shift](const Vector3d& p, const Vector3d& middle) {
      return Vector2d(20.0 * p.x() + (middle.z() > 0 ? shift : 0.0), 20.0 * p.y() + 5.0 * p.z());
    };
  };
  EXPECT_EQ(with_texture(unwrapped(ball, halves(0.0))).report.texture_faded, 0.0);
  EXPECT_EQ(with_texture(unwrapped(ball, halves(3.0))).report.texture_faded, 0.0) << "whole units";
  const double seam = with_texture(unwrapped(ball, halves(0.43))).report.texture_faded;
  figure("part of a ball where the texture fades towards a seam round its middle", seam, "0.02 to 0.15");
  EXPECT_GT(seam, 0.02);
  EXPECT_LT(seam, 0.15);
  // A seam at every edge: blended, unless coordinates are asked for.
  Random random(1);
  const host::TriangleSoup shreds = unwrapped(ball, [&](const Vector3d&, const Vector3d&) {
    return Vector2d(random.uniform(0, 1), random.uniform(0, 1));
  });
  EXPECT_FALSE(with_texture(shreds).texture_weights.empty());
  EXPECT_EQ(with_texture(shreds, TextureMapping::kCoordinates).report.texture_faded, 1.0);
  EXPECT_FALSE(with_texture(unwrapped(ball, halves(0.0)), TextureMapping::kBlended).texture_weights.empty());
}

TEST(MeshTexture, CoordinatesThatAreNotThereAreRefused) {
  const auto name = [](const host::TriangleSoup& soup) -> std::string {
    try {
      static_cast<void>(with_texture(soup, TextureMapping::kCoordinates));
    } catch (const host::Error& error) {
      return error.name;
    }
    return "";
  };
  const host::TriangleSoup ball = icosphere(1, 0.02);
  EXPECT_EQ(name(ball), "no-coordinates");
  EXPECT_EQ(name(unwrapped(ball, [](const Vector3d&, const Vector3d&) { return Vector2d(0.5, 0.5); })),
            "no-coordinates");
}

}  // namespace
}  // namespace thimble::test::mesh_texture

// The box around each shape of a scene, and the point of it that is nearest.
#include "host-tools/compiler/object_regions.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "host-tools/compiler/compile.h"

namespace thimble::test {
namespace {

using Eigen::Vector3d;

host::ObjectRegion region_of(const std::string& shape, const std::string& pose = "{}") {
  const auto regions = host::object_regions(
      host::compile_scene_text(
          R"({"thimble_scene": 1, "name": "test", "objects": [{"name": "it", "shape": {)" + shape +
              R"(}, "pose": )" + pose + R"(, "material": {"stiffness_N_m": 500}}]})",
          "test", ".")
          .image);
  EXPECT_EQ(regions.size(), 1U);
  return regions.empty() ? host::ObjectRegion{} : regions.front();
}

void expect_nearest(const host::ObjectRegion& region, const Vector3d& from, const Vector3d& there) {
  EXPECT_LT((region.nearest(from) - there).norm(), 1e-6)
      << region.nearest(from).transpose() << " instead of " << there.transpose();
}

TEST(ObjectRegions, HaveTheBoxOfEachShape) {
  const Vector3d above(0.5, -0.5, 0.5), below(0, 0, -0.5);
  expect_nearest(region_of(R"("sphere": {"radius_m": 0.02})"), above, {0.02, -0.02, 0.02});
  expect_nearest(region_of(R"("box": {"size_m": [0.02, 0.04, 0.06]})"), above, {0.01, -0.02, 0.03});
  expect_nearest(region_of(R"("cylinder": {"radius_m": 0.01, "height_m": 0.06})"), above,
                 {0.01, -0.01, 0.03});
  expect_nearest(region_of(R"("capsule": {"radius_m": 0.01, "height_m": 0.06})"), below, {0, 0, -0.04});
  expect_nearest(region_of(R"("cone": {"radius_m": 0.01, "height_m": 0.04})"), above, {0.01, -0.01, 0.03});
  expect_nearest(region_of(R"("cone": {"radius_m": 0.01, "height_m": 0.04})"), below, {0, 0, -0.01});
  expect_nearest(
      region_of(R"("needle": {"layers": [{"thickness_m": 0.01, "stiffness_N_m": 500, "tear_N": 1}]})"), above,
      {0, 0, 0});
}

TEST(ObjectRegions, APlaneHasNoEnds) {
  const double part = std::sqrt(0.5);
  const auto region = region_of(R"("plane": {"normal": [1, 0, 1], "offset_m": 0.1})");
  expect_nearest(region, {0.3 * part, 5, 0.3 * part}, {0.1 * part, 5, 0.1 * part});
  expect_nearest(region, {-7, 3, -1}, {-7, 3, -1});
}

TEST(ObjectRegions, TurnAndMoveWithTheObject) {
  const auto region = region_of(R"("box": {"size_m": [0.2, 0.02, 0.02]})",
                                R"({"position_m": [0, 0, 0.1], "rotation_deg": [0, 0, 90]})");
  expect_nearest(region, {0, 1, 0.1}, {0, 0.1, 0.1});
  expect_nearest(region, {1, 0, 0.1}, {0.01, 0, 0.1});
}

TEST(ObjectRegions, AnImageThatIsNotValidHasNone) { EXPECT_TRUE(host::object_regions({}).empty()); }

}  // namespace
}  // namespace thimble::test

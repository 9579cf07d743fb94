// Vector fields (paper, section 4): where they agree with the god object, and where they do not.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "tests/closed_loop/fields/support.h"
#include "tests/support/figure.h"
#include "tests/support/random.h"

namespace thimble::test {
namespace {

using Eigen::Vector3d;

constexpr double kStep_m = 1.0e-5;
constexpr double kHalf_m = 0.02;

const std::string kCube = R"({"box": {"size_m": [0.04, 0.04, 0.04]}})";
const std::string kTurned = R"("position_m": [0.01, -0.02, 0.03], "rotation_deg": [30, -20, 50])";

SceneImage field(const std::string& of, const std::string& material, const std::string& pose = "") {
  return one_object("\"vector_field\": " + of, material, pose);
}

TEST(VectorField, TheCubesTwoMethodsAgreeAwayFromItsEdges) {
  // Pressed and stroked on every face, deeper than never more than a third of the way to the nearest edge,
  // with damping.
  for (const std::string& pose : {std::string(), kTurned}) {
    const std::string material = R"("stiffness_N_m": 500, "damping_N_s_m": 2)";
    const SceneImage by_field = field(kCube, material, pose);
    const SceneImage by_god = one_object(kCube.substr(1, kCube.size() - 2), material, pose);
    const Vector3d centre = pose.empty() ? Vector3d::Zero() : Vector3d(0.01, -0.02, 0.03);
    const auto turn = [&](double deg, const Vector3d& axis) {
      return Eigen::AngleAxisd(deg * M_PI / 180.0, axis);
    };
    const Eigen::Quaterniond rotation =
        pose.empty() ? Eigen::Quaterniond::Identity()
                     : Eigen::Quaterniond(turn(50, Vector3d::UnitZ()) * turn(-20, Vector3d::UnitY()) *
                                          turn(30, Vector3d::UnitX()));
    Random random(11);
    double worst = 0;
    double worst_proxy_m = 0;
    double most_N = 0;
    for (int face = 0; face < 6; ++face) {
      const Vector3d out = (face % 2 == 0 ? 1.0 : -1.0) * Vector3d::Unit(face / 2);
      IdealRun a(by_field);
      IdealRun b(by_god);
      for (int stroke = 0; stroke < 20; ++stroke) {
        Vector3d on_face = random.in_box(Vector3d::Constant(0.012));
        on_face -= on_face.dot(out) * out;
        const double depth = stroke % 4 == 0 ? -0.002 : random.uniform(0.0, 0.004);
        const Vector3d to = centre + rotation * (on_face + (kHalf_m - depth) * out);
        const Vector3d from = stroke == 0 ? to : a.felt().tip_m;
        const int count = 1 + static_cast<int>((to - from).norm() / 2.0e-5);
        for (int i = 1; i <= count; ++i) {
          const Vector3d p = from + (to - from) * i / count;
          const Felt& f = a.step(p);
          const Felt& g = b.step(p);
          // Rounding moves the surface by 1e-8 m, which turns the god object's short arm by as much over its
          // length.
          if (std::abs((rotation.conjugate() * (p - centre)).dot(out) - kHalf_m) < 2.0e-5) continue;
          ASSERT_EQ(f.contacts > 0, g.contacts > 0) << p.transpose();
          worst = std::max(worst, (f.force_N - g.force_N).norm() / std::max(g.force_N.norm(), 0.01));
          if (f.contacts > 0)
            worst_proxy_m = std::max(worst_proxy_m, (f.god_object_m - g.god_object_m).norm());
          most_N = std::max(most_N, g.force_N.norm());
        }
      }
    }
    const std::string name = pose.empty() ? "cube: " : "turned cube: ";
    EXPECT_LT(figure(name + "field against god object, relative, of up to " + std::to_string(most_N) + " N",
                     worst, "1e-4"),
              1.0e-4);
    EXPECT_LT(figure(name + "proxy against god object, m", worst_proxy_m, "1e-6"), 1.0e-6);
  }
}

TEST(VectorField, JumpsAtTheEdgeWhereTheGodObjectDoesNot) {
  // Presses the top 6 mm deep and goes sideways out through the edge. The nearest face changes at 6 mm from
  // the side.
  ForceStep by_field;
  ForceStep by_god;
  for (const bool god : {false, true}) {
    const SceneImage image =
        god ? one_object(kCube.substr(1, kCube.size() - 2)) : field(kCube, "\"stiffness_N_m\": 500");
    IdealRun run(image);
    ForceStep& step = god ? by_god : by_field;
    run.step({0.004, 0.001, 0.025});
    add_largest_step(run, {0.004, 0.001, kHalf_m - 0.006}, kStep_m, step);
    add_largest_step(run, {kHalf_m - 0.001, 0.001, kHalf_m - 0.006}, kStep_m, step);
  }
  figure("the same path, field: largest force step per 10 um, N", by_field.most_N, "K depth sqrt(2) = 4.24");
  figure("the same path, field: where, x, m", by_field.at_m.x(),
         "0.014: as far from the side as from the top");
  figure("the same path, god object: largest force step per 10 um, N", by_god.most_N, "K 10 um = 0.005");
  EXPECT_NEAR(by_field.most_N, kStiffness_N_m * 0.006 * std::sqrt(2.0), 0.01);
  EXPECT_NEAR(by_field.at_m.x(), kHalf_m - 0.006, 2.0 * kStep_m);
  EXPECT_LT(by_god.most_N, 1.05 * kStiffness_N_m * kStep_m);
}

TEST(VectorField, AThinPlateIsPushedThroughAndTheGodObjectNever) {
  // 200 ways straight through a plate of 2 mm, from either side and aslant.
  constexpr double kThick_m = 0.002;
  const std::string plate = R"("box": {"size_m": [0.08, 0.08, 0.002]})";
  const SceneImage by_field = field("{" + plate + "}", "\"stiffness_N_m\": 500");
  const SceneImage by_god = one_object(plate);
  Random random(12);
  int through_field = 0;
  int through_god = 0;
  double most_field_N = 0;
  double least_god_N = 1e9;
  constexpr int kWays = 200;
  for (int way = 0; way < kWays; ++way) {
    const double side = way % 2 == 0 ? 1.0 : -1.0;
    const Vector3d from(random.uniform(-0.02, 0.02), random.uniform(-0.02, 0.02), side * 0.004);
    const Vector3d to =
        from + Vector3d(random.uniform(-0.01, 0.01), random.uniform(-0.01, 0.01), -side * 0.012);
    for (const bool god : {false, true}) {
      IdealRun run(god ? by_god : by_field);
      run.step(from);
      double most_N = 0;
      constexpr int kSteps = 240;
      for (int i = 1; i <= kSteps; ++i) {
        run.step(from + (to - from) * i / kSteps);
        most_N = std::max(most_N, run.felt().force_N.norm());
      }
      const bool through = side * run.felt().god_object_m.z() < 0.0;
      (god ? through_god : through_field) += through ? 1 : 0;
      if (god) {
        least_god_N = std::min(least_god_N, run.felt().force_N.z() * side);
      } else {
        most_field_N = std::max(most_field_N, most_N);
        EXPECT_EQ(run.felt().force_N.norm(), 0.0);
      }
    }
  }
  figure("2 mm plate, field: ways pushed through, of 200", through_field, "200");
  figure("2 mm plate, field: the most it resisted with, N", most_field_N, "K 1 mm = 0.5");
  figure("2 mm plate, god object: ways pushed through, of 200", through_god, "0");
  figure("2 mm plate, god object: its force 7 mm or more past the far side, N", least_god_N, "K 9 mm = 4.5");
  EXPECT_EQ(through_field, kWays);
  EXPECT_NEAR(most_field_N, kStiffness_N_m * kThick_m / 2.0, 0.03);
  EXPECT_EQ(through_god, 0);
  EXPECT_NEAR(least_god_N, kStiffness_N_m * 0.009, 0.01);
}

TEST(VectorField, TheSpherePushesAlongItsRadius) {
  constexpr double kRadius_m = 0.03;
  for (const bool ball : {false, true}) {
    const SceneImage image =
        ball ? field(R"({"subvolumes": [{"ball": {"centre_m": [0.01, 0.02, -0.01], "radius_m": 0.03}}]})",
                     "\"stiffness_N_m\": 500")
             : field(R"({"sphere": {"radius_m": 0.03}})", "\"stiffness_N_m\": 500", kTurned);
    const Vector3d centre = ball ? Vector3d(0.01, 0.02, -0.01) : Vector3d(0.01, -0.02, 0.03);
    IdealRun run(image);
    Random random(13);
    double worst = 0;
    for (int i = 0; i < 2000; ++i) {
      const Felt& felt = run.step(centre + random.uniform(0.002, 0.04) * random.direction());
      const Vector3d arm = felt.tip_m - centre;
      const Vector3d expected = kStiffness_N_m * std::max(kRadius_m - arm.norm(), 0.0) * arm.normalized();
      worst = std::max(worst, (felt.force_N - expected).norm());
    }
    EXPECT_LT(figure("sphere field: |F - K (R - r) r^|, N, of 15 N", worst, "1e-4"), 1.0e-4);
    run.step(centre);
    EXPECT_TRUE(run.felt().force_N.allFinite());
  }
}

TEST(VectorField, DampingNeverPulls) {
  const SceneImage image = field(kCube, R"("stiffness_N_m": 500, "damping_N_s_m": 50)");
  IdealRun run(image);
  run.step({0, 0, 0.021});
  double least_N = 0;
  double most_N = 0;
  for (int i = 0; i < 4000; ++i) {
    const Felt& felt = run.step({0, 0, kHalf_m + 0.001 - 0.004 * std::sin(1.0e-2 * i)});
    least_N = std::min(least_N, felt.force_N.z());
    most_N = std::max(most_N, felt.force_N.z());
  }
  figure("cube field, B = 50: most force, N", most_N, "above K x alone, 1.5");
  EXPECT_GT(most_N, 2.0);
  EXPECT_GE(figure("cube field, B = 50: least force along the normal, N", least_N, "0"), 0.0);
}

TEST(VectorField, HandMadeSubvolumesPushAsTheySay) {
  // A wedge of two half spaces made by hand, the second one above the first where both hold; and a body of
  // planes.
  const SceneImage image = field(R"({"subvolumes": [
      {"sides": [{"normal": [-1, 0, 0], "offset_m": 0}], "plane": {"normal": [0, 0, 1], "offset_m": 0.01}},
      {"plane": {"normal": [0, 0, 3], "offset_m": 0}}]})",
                                 "\"stiffness_N_m\": 500");
  IdealRun run(image);
  EXPECT_NEAR(run.step({0.01, 0, 0.004}).force_N.z(), 3.0, 1e-4);
  EXPECT_NEAR(run.step({0.01, 0, -0.004}).force_N.z(), 7.0, 1e-4);
  EXPECT_NEAR(run.step({-0.01, 0, 0.004}).force_N.z(), 0.0, 0.0);
  EXPECT_NEAR(run.step({-0.01, 0, -0.004}).force_N.z(), 2.0, 1e-4);
  EXPECT_NEAR(run.felt().god_object_m.z(), 0.0, 1e-7);

  const SceneImage tetrahedron = field(R"({"planes": [
      {"normal": [1, 1, 1], "offset_m": 0.01}, {"normal": [1, -1, -1], "offset_m": 0.01},
      {"normal": [-1, 1, -1], "offset_m": 0.01}, {"normal": [-1, -1, 1], "offset_m": 0.01},
      {"normal": [-1, -1, 1], "offset_m": 0.5}]})",
                                       "\"stiffness_N_m\": 500");
  IdealRun body(tetrahedron);
  Random random(14);
  double worst = 0;
  int inside = 0;
  for (int i = 0; i < 5000; ++i) {
    const Felt& felt = body.step(random.in_box(Vector3d::Constant(0.02)));
    Vector3d expected = Vector3d::Zero();
    double least = 1.0;
    for (const Vector3d& n :
         {Vector3d(1, 1, 1), Vector3d(1, -1, -1), Vector3d(-1, 1, -1), Vector3d(-1, -1, 1)}) {
      const double depth = 0.01 - n.normalized().dot(felt.tip_m);
      if (depth < least) {
        least = depth;
        expected = kStiffness_N_m * depth * n.normalized();
      }
    }
    if (least < 0.0) expected.setZero();
    inside += least > 0.0 ? 1 : 0;
    worst = std::max(worst, (felt.force_N - expected).norm());
  }
  figure("tetrahedron of planes: places inside, of 5000", inside, "some hundreds");
  EXPECT_GT(inside, 300);
  EXPECT_LT(figure("tetrahedron of planes: F off K (least depth) n, N", worst, "1e-4"), 1.0e-4);
}

}  // namespace
}  // namespace thimble::test

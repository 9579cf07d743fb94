// Bodies turn about their centre of mass, wherever the origin of their frame is, and with the inertia of their shape in any direction.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "tests/closed_loop/bodies/mesh_bodies.h"
#include "tests/support/figure.h"
#include "tests/support/meshes.h"
#include "tests/support/units.h"

namespace thimble::test {
namespace {

using Eigen::Matrix3d;
using Eigen::Quaterniond;

constexpr const char* kRough =
    R"("materials": {"m": {"stiffness_N_m": 1000, "static_friction": 0.4, "dynamic_friction": 0.3}}, )";
constexpr const char* kFloor =
    R"({"name": "floor", "material": "m", "shape": {"plane": {"normal": [0, 0, 1], "offset_m": 0}}}, )";
constexpr const char* kSlippery = R"("materials": {"m": {"stiffness_N_m": 1000}}, )";

// An object with a body; `body` has the keys beside the mass.
std::string thing(const std::string& shape, const Vector3d& at_m, const Vector3d& angles_deg,
                  const std::string& body, double mass_kg = .1) {
  return R"({"name": "thing", "material": "m", "shape": {)" + shape + R"(}, "pose": {"position_m": )" +
         list(at_m) + R"(, "rotation_deg": )" + list(angles_deg) + R"(}, "body": {"mass_kg": )" +
         std::to_string(mass_kg) + ", " + body + "}}";
}

Quaterniond rotation_of(const Vector3d& angles_deg) {
  const Vector3d a = angles_deg * std::numbers::pi / 180;
  return Eigen::AngleAxisd(a.z(), Vector3d::UnitZ()) * Eigen::AngleAxisd(a.y(), Vector3d::UnitY()) *
         Eigen::AngleAxisd(a.x(), Vector3d::UnitX());
}

Matrix3d of_point(const Vector3d& p) { return p.squaredNorm() * Matrix3d::Identity() - p * p.transpose(); }

// Of a box of 1 kg.
Matrix3d of_box(const Vector3d& size_m) {
  const Vector3d s = size_m.cwiseAbs2();
  return Matrix3d(Vector3d(s.y() + s.z(), s.z() + s.x(), s.x() + s.y()).asDiagonal()) / 12;
}

class CentreOfMass : public MeshBodies {};

// An angle of two boxes, (0.04, 0.02, 0.01) and (0.01, 0.02, 0.05) large, whose file has its origin 0.1 m away.
const Vector3d kOffset_m(.1, .02, -.03);
const Vector3d kAngleCentre_m = (4 * Vector3d(.02, 0, .005) + 5 * Vector3d(.005, 0, .035)) / 9 + kOffset_m;
host::TriangleSoup angle() {
  return transformed(prism({{0, 0}, {.04, 0}, {.04, .01}, {.01, .01}, {.01, .06}, {0, .06}}, .02, 1),
                     Matrix3d::Identity(), kOffset_m);
}
Matrix3d angle_inertia(double mass_kg) {
  const Vector3d of_foot = Vector3d(.02, 0, .005) + kOffset_m - kAngleCentre_m;
  const Vector3d of_leg = Vector3d(.005, 0, .035) + kOffset_m - kAngleCentre_m;
  return mass_kg *
         (4 * (of_box({.04, .02, .01}) + of_point(of_foot)) +
          5 * (of_box({.01, .02, .05}) + of_point(of_leg))) /
         9;
}

TEST_F(CentreOfMass, FliesStraightWhileTheMeshTumbles) {
  const Vector3d angles(25, -50, 110);
  const Vector3d velocity(.05, -.03, .02);
  BodyRun run(std::string(kSlippery) + R"("objects": [)" +
              thing(mesh(angle()), {.05, 0, .01}, angles,
                    R"("motion": "free", "velocity_m_s": [0.05, -0.03, 0.02], "spin_rad_s": [9, 4, -7])") +
              "]");
  const Matrix3d inertia = angle_inertia(.1);
  const auto centre_m = [&] { return Vector3d(run.position_m(0) + run.rotation(0) * kAngleCentre_m); };
  const auto momentum = [&] {
    const Matrix3d turn = run.rotation(0).toRotationMatrix();
    return Vector3d(turn * inertia * turn.transpose() * run.body(0).spin_rad_s.cast<double>());
  };
  const Vector3d start_m = Vector3d(.05, 0, .01) + rotation_of(angles) * kAngleCentre_m;
  const Vector3d first = momentum();
  double off_line = 0, off_momentum = 0, off_energy = 0, off_velocity = 0, turned = 0;
  while (run.time_s() < 3) {
    const Vector3d before_m = run.position_m(0);
    const Vector3d velocity_before = run.velocity_m_s(0);
    const Quaterniond before = run.rotation(0);
    run.tick();
    off_line = std::max(off_line, (centre_m() - start_m - velocity * run.time_s()).norm());
    off_momentum = std::max(off_momentum, (momentum() - first).norm() / first.norm());
    const Vector3d spin = run.body(0).spin_rad_s.cast<double>();
    off_energy = std::max(off_energy, std::abs(spin.dot(momentum()) / Vector3d(9, 4, -7).dot(first) - 1));
    // The reported velocity is that of the reported position.
    off_velocity = std::max(off_velocity, ((run.position_m(0) - before_m) / run.period_s() -
                                           .5 * (velocity_before + run.velocity_m_s(0)))
                                              .norm());
    turned += before.angularDistance(run.rotation(0));
  }
  figure("angle in flight: turns in 3 s", turned / (2 * std::numbers::pi), "> 3");
  // Each of the 12 000 ticks rounds a position of 0.13 m to a float.
  figure("angle in flight over 185 mm: centre of mass off its line, um", 1e6 * off_line, "< 80");
  figure("angle in flight: angular momentum off", off_momentum, "< 2e-5");
  figure("angle in flight: energy of the rotation off", off_energy, "< 2e-5");
  figure("angle in flight: velocity off the change of the position, mm/s", 1e3 * off_velocity, "< 1");
  EXPECT_GT(turned, 3 * 2 * std::numbers::pi);
  EXPECT_LT(off_line, 80e-6);
  EXPECT_LT(off_momentum, 2e-5);
  EXPECT_LT(off_energy, 2e-5);
  EXPECT_LT(off_velocity, 1e-3);
}

TEST_F(CentreOfMass, APushThroughItDoesNotTurnTheBodyAndOneBesideItDoes) {
  const std::string box =
      mesh(transformed(box_mesh({.04, .03, .02}, 1), Matrix3d::Identity(), {.06, -.04, .02}));
  constexpr double kBeside_m = .008;
  const double inertia = .1 * (.04 * .04 + .03 * .03) / 12;
  for (const double beside : {0.0, kBeside_m}) {
    // The centre of mass is at the origin; a finger pushes along x.
    BodyRun run(std::string(kSlippery) + R"("objects": [)" +
                    thing(box, {-.06, .04, -.02}, Vector3d::Zero(), R"("motion": "free")") + "]",
                {{-.025, beside, 0}});
    Vector3d impulse = Vector3d::Zero();
    Vector3d angular = Vector3d::Zero();
    for (int tick = 1; tick <= 800; ++tick) {
      run.tick({{-.025 + std::min(.008, 4e-5 * tick), beside, 0}});
      impulse -= run.period_s() * run.force_N(0);
      angular -= run.period_s() * run.god_m(0).cross(run.force_N(0));
    }
    const Vector3d spin = run.body(0).spin_rad_s.cast<double>();
    const Vector3d arm = run.rotation(0) * Vector3d(.06, -.04, .02);  // to the centre of mass
    const Vector3d velocity = run.velocity_m_s(0) + spin.cross(arm);
    angular -= .1 * (run.position_m(0) + arm).cross(velocity);  // what is left is spin
    figure("pushed " + std::to_string(1e3 * beside) + " mm beside the centre: impulse, N s", impulse.norm(),
           "> 0.003");
    figure("pushed: momentum less impulse, N s", (.1 * velocity - impulse).norm(), "< 1e-6");
    figure("pushed: spin, rad/s", spin.z(), beside > 0 ? std::to_string(angular.z() / inertia) : "0");
    EXPECT_GT(impulse.norm(), .003);
    EXPECT_LT((.1 * velocity - impulse).norm(), 1e-6);
    if (beside == 0) {
      EXPECT_LT(spin.norm(), 1e-5);
    } else {
      EXPECT_GT(std::abs(spin.z()), .5);
      EXPECT_LT((spin - Vector3d(0, 0, angular.z() / inertia)).norm(), 1e-4 * spin.norm());
    }
  }
}

TEST_F(CentreOfMass, ABoxAsAMeshFarFromItsOriginAndAskewMovesAsTheShapeBox) {
  // In its file the box is turned by `askew` and lies 0.15 m from the origin, so its principal axes are not those of the object.
  const Vector3d size(.05, .03, .02);
  const Vector3d askew_deg(40, -25, 70);
  const Quaterniond askew = rotation_of(askew_deg);
  const Vector3d off(.12, -.07, .05);
  const Vector3d at(.01, .02, .045);
  const std::string more = R"("motion": "free", "restitution": 0.5, "spin_rad_s": [3, -5, 4])";
  for (const bool falls : {true, false}) {
    // It falls on a floor and bounces; or a finger pushes it beside its centre, in free space.
    const std::string world =
        std::string(falls ? kGravity : "") + kRough + R"("objects": [)" + (falls ? kFloor : "");
    const std::vector<Vector3d> tips{falls ? Vector3d(.3, 0, .1) : Vector3d(at + Vector3d(.05, .004, .003))};
    BodyRun primitive(world + thing("\"box\": {\"size_m\": " + list(size) + "}", at, askew_deg, more) + "]",
                      tips);
    BodyRun as_mesh(world +
                        thing(mesh(transformed(box_mesh(size, 1), askew.toRotationMatrix(), off)), at - off,
                              Vector3d::Zero(), more) +
                        "]",
                    tips);
    double apart = 0, turned_apart = 0, force_apart = 0, pushed = 0;
    for (int tick = 0; tick < 2000; ++tick) {
      const Vector3d way(falls ? 0 : -2e-5 * std::min(tick, 1500), 0, 0);
      primitive.tick({tips[0] + way});
      as_mesh.tick({tips[0] + way});
      const Vector3d centre = as_mesh.position_m(0) + as_mesh.rotation(0) * off;
      apart = std::max(apart, (centre - primitive.position_m(0)).norm());
      turned_apart =
          std::max(turned_apart, (as_mesh.rotation(0) * askew).angularDistance(primitive.rotation(0)));
      force_apart = std::max(force_apart, (as_mesh.force_N(0) - primitive.force_N(0)).norm());
      pushed = std::max(pushed, primitive.force_N(0).norm());
    }
    const std::string what = falls ? "box and mesh fall and bounce: " : "box and mesh are pushed: ";
    figure(what + "hardest push, N", pushed, falls ? "0" : "> 0.2");
    figure(what + "apart at most, um", 1e6 * apart, "< 20");
    figure(what + "turned apart at most, mrad", 1e3 * turned_apart, "< 0.5");
    figure(what + "forces apart, N", force_apart, "< 0.002");
    EXPECT_GT(pushed, falls ? -1 : .2);
    EXPECT_LT(apart, 20e-6);
    EXPECT_LT(turned_apart, 5e-4);
    EXPECT_LT(force_apart, .002);
  }
}

// The small swing of a body about a horizontal axis: its period is 2 pi sqrt(I / (m g d)).
TEST_F(CentreOfMass, ALeverOfAMeshSwingsAboutItsPivotWithTheMomentOfItsShape) {
  const Vector3d pivot = kOffset_m + Vector3d(.005, 0, .055);  // near the end of the leg
  const std::string body = R"("motion": "turn", "axis": [0, 1, 0], "pivot_m": )";
  BodyRun run(kGravity + std::string(kSlippery) + R"("objects": [)" +
              thing(mesh(angle()), {.01, .02, .03}, Vector3d::Zero(),
                    body + list(pivot + Vector3d(.01, .02, .03)) + R"(, "spin_rad_s": [0, 0.05, 0])") +
              "]");
  const Vector3d arm = kAngleCentre_m - pivot;
  const double length = std::hypot(arm.x(), arm.z());
  const double moment = angle_inertia(.1)(1, 1) + .1 * length * length;
  // It hangs still where its centre of mass is below the pivot; it begins beside that, so it swings by the angle between.
  const double amplitude = std::atan2(arm.x(), -arm.z());
  const double small = 2 * std::numbers::pi * std::sqrt(moment / (.1 * 9.81 * length));
  const double omega0 = .05;
  const double most = std::sqrt(amplitude * amplitude + std::pow(omega0 * small / (2 * std::numbers::pi), 2));
  const double expected = small * (1 + most * most / 16 + 11 * std::pow(most, 4) / 3072);
  std::vector<double> crossings;
  double before = 0;
  while (run.time_s() < 5) {
    run.tick();
    const Vector3d hangs = run.rotation(0) * arm;
    const double angle = std::atan2(hangs.x(), -hangs.z());
    if (before < 0 && angle >= 0)
      crossings.push_back(run.time_s() - run.period_s() * angle / (angle - before));
    before = angle;
  }
  ASSERT_GT(crossings.size(), 3U);
  const double period = (crossings.back() - crossings.front()) / static_cast<double>(crossings.size() - 1);
  figure("lever of a mesh: period, s", period, std::to_string(expected) + ", 0.1 %");
  EXPECT_NEAR(period, expected, 1e-3 * expected);
}

TEST_F(CentreOfMass, AWeightedBallStandsUp) {
  // A ball whose centre of mass is below its middle swings about the upright position as it rolls to and fro: with the contact
  // under it, the period is 2 pi sqrt((I + m (r - h)^2) / (m g h)).
  constexpr double kRadius = .02, kLow = .008;
  const double inertia = .1 * (.4 * kRadius * kRadius + kLow * kLow);  // of the ball about the key's centre
  BodyRun run(
      R"("gravity_m_s2": [0, 0, -9.81], "materials": {"m": {"stiffness_N_m": 1000, "static_friction": 1}},
      "objects": [{"name": "floor", "material": "m", "shape": {"plane": {"normal": [0, 0, 1], "offset_m": 0}}}, )" +
      thing(R"("sphere": {"radius_m": 0.02})", {0, 0, kRadius}, {0, 8, 0},
            R"("motion": "free", "centre_m": [0, 0, -0.008])") +
      "]");
  const double expected =
      2 * std::numbers::pi * std::sqrt((inertia + .1 * std::pow(kRadius - kLow, 2)) / (.1 * 9.81 * kLow));
  std::vector<double> crossings;
  double before = 0;
  double tilt = 0;
  while (run.time_s() < 3) {
    run.tick();
    const double angle = (run.rotation(0) * Vector3d::UnitZ()).x();
    tilt = std::max(tilt, std::abs(angle));
    if (before < 0 && angle >= 0)
      crossings.push_back(run.time_s() - run.period_s() * angle / (angle - before));
    before = angle;
  }
  ASSERT_GT(crossings.size(), 3U);
  const double period = (crossings.back() - crossings.front()) / static_cast<double>(crossings.size() - 1);
  figure("weighted ball: period, s", period, std::to_string(expected) + ", 1 %");
  figure("weighted ball: widest tilt, rad", tilt, "0.14, < 0.15");
  EXPECT_NEAR(period, expected, .01 * expected);
  EXPECT_LT(tilt, .15);
}

// A symmetric top in free flight: its axis goes round the angular momentum at the rate L / I across.
TEST_F(CentreOfMass, CylindersCapsulesAndConesAskewPrecessAsTheyMust) {
  constexpr double r = .012, h = .05, m = .1;
  const double ball = 4.0 / 3.0 * r / (h + 4.0 / 3.0 * r);  // the share of the ends of the capsule
  const auto cylinder = std::pair(m * (r * r / 4 + h * h / 12), m * r * r / 2);
  const auto capsule = std::pair(m * ((1 - ball) * (r * r / 4 + h * h / 12) +
                                      ball * (83.0 / 320 * r * r + std::pow(h / 2 + 3.0 / 8 * r, 2))),
                                 m * ((1 - ball) * r * r / 2 + ball * .4 * r * r));
  const auto cone = std::pair(m * (3.0 / 20 * r * r + 3.0 / 80 * h * h), .3 * m * r * r);
  const Vector3d angles(35, 50, -20);
  const Vector3d axis = rotation_of(angles) * Vector3d::UnitZ();
  const Vector3d across = axis.cross(Vector3d::UnitX()).normalized();
  const Vector3d spin = 20 * axis + 6 * across;
  for (const auto& [word, moments] :
       {std::pair("cylinder", cylinder), std::pair("capsule", capsule), std::pair("cone", cone)}) {
    BodyRun run(std::string(kSlippery) + R"("objects": [)" +
                thing("\"" + std::string(word) + R"(": {"radius_m": 0.012, "height_m": 0.05})",
                      {.01, .02, .03}, angles, R"("motion": "free", "spin_rad_s": )" + list(spin)) +
                "]");
    const Vector3d momentum = moments.second * 20 * axis + moments.first * 6 * across;
    const double rate = momentum.norm() / moments.first;
    constexpr double kTime_s = 2;
    run.run(kTime_s);
    const Vector3d expected = Eigen::AngleAxisd(rate * kTime_s, momentum.normalized()) * axis;
    const Vector3d is = run.rotation(0) * Vector3d::UnitZ();
    const double off = std::acos(std::clamp(expected.dot(is), -1.0, 1.0));
    figure(std::string(word) + " askew: turns of its axis in 2 s", rate * kTime_s / (2 * std::numbers::pi),
           "> 1");
    figure(std::string(word) + " askew: axis off the closed form, mrad", 1e3 * off, "< 5");
    EXPECT_LT(off, 5e-3) << word;
    EXPECT_LT((run.position_m(0) - Vector3d(.01, .02, .03)).norm(), 1e-6) << word;
  }
}

}  // namespace
}  // namespace thimble::test

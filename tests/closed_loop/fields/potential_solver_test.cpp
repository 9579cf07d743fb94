// The compiler's solver against closed forms, and its order of convergence.
#include "host-tools/compiler/potential_solver.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>

#include "tests/support/figure.h"

namespace thimble::test {
namespace {

using Eigen::Vector3d;
using host::Potential;
using host::PotentialProblem;
using host::Solid;

Solid sphere(double radius_m, const Vector3d& at = Vector3d::Zero()) {
  Solid solid;
  solid.radius_m = radius_m;
  solid.position_m = at;
  return solid;
}

Solid box(const Vector3d& size_m, const Vector3d& at = Vector3d::Zero()) {
  Solid solid;
  solid.kind = Solid::Kind::kBox;
  solid.half_size_m = 0.5 * size_m;
  solid.position_m = at;
  return solid;
}

Solid round(Solid::Kind kind, double radius_m, double height_m) {
  Solid solid = sphere(radius_m);
  solid.kind = kind;
  solid.half_height_m = 0.5 * height_m;
  return solid;
}

// |u - expected| over the points where `counts` holds, over the largest expected.
struct Error {
  double worst = 0;
  double rms = 0;
};
Error error_of(const Potential& potential, const std::function<double(const Vector3d&)>& expected,
               const std::function<bool(const Vector3d&)>& counts) {
  Error error;
  double most = 0;
  double points = 0;
  for (std::size_t i = 0; i < potential.grid.size(); ++i) {
    const Vector3d p = potential.grid.point(i);
    if (potential.inside[i] == 0 || !counts(p)) continue;
    const double off = std::abs(potential.samples[i] - expected(p));
    error.worst = std::max(error.worst, off);
    error.rms += off * off;
    points += 1.0;
    most = std::max(most, std::abs(expected(p)));
  }
  return {error.worst / most, std::sqrt(error.rms / points) / most};
}

const auto kEverywhere = [](const Vector3d&) { return true; };

PotentialProblem problem(const Solid& shape, double step_m, double source = 0) {
  PotentialProblem p;
  p.shape = shape;
  p.step_m = step_m;
  p.source = source;
  p.place = "test";
  return p;
}

TEST(PotentialSolver, PoissonInASphere) {
  // u = s (R^2 - r^2) / 6. The stencil is exact for it, wherever the surface cuts the grid.
  constexpr double kRadius_m = 0.03;
  const Potential potential = host::solve_potential(problem(sphere(kRadius_m), 0.0023, 100));
  const auto expected = [](const Vector3d& p) {
    return 100.0 * (kRadius_m * kRadius_m - p.squaredNorm()) / 6.0;
  };
  EXPECT_LT(figure("Poisson, sphere: worst error, relative", error_of(potential, expected, kEverywhere).worst,
                   "1e-6"),
            1e-6);
}

TEST(PotentialSolver, PoissonInALongCylinderAndASlab) {
  // Halfway between the ends, which fade as exp(-2.405 H / R) and exp(-pi H / L).
  const Potential rod =
      host::solve_potential(problem(round(Solid::Kind::kCylinder, 0.012, 0.08), 0.0017, 100));
  const auto in_rod = [](const Vector3d& p) { return 25.0 * (0.012 * 0.012 - p.head<2>().squaredNorm()); };
  const auto middle = [](const Vector3d& p) { return std::abs(p.z()) < 0.01; };
  EXPECT_LT(figure("Poisson, cylinder: worst error, relative", error_of(rod, in_rod, middle).worst, "0.01"),
            0.01);
  const Potential slab = host::solve_potential(problem(box({0.1, 0.1, 0.02}), 0.0017, 100));
  const auto in_slab = [](const Vector3d& p) { return 50.0 * (0.01 * 0.01 - p.z() * p.z()); };
  const auto inner = [](const Vector3d& p) { return p.head<2>().norm() < 0.01; };
  EXPECT_LT(figure("Poisson, slab: worst error, relative", error_of(slab, in_slab, inner).worst, "0.01"),
            0.01);
}

TEST(PotentialSolver, LaplaceBetweenPlates) {
  // A slab with a plate in its middle: the potential falls evenly from the plate to the surface.
  PotentialProblem p = problem(box({0.1, 0.1, 0.03}), 0.002);
  p.inclusions.push_back({box({0.09, 0.09, 0.01}), 0.02, "plate"});
  const Potential potential = host::solve_potential(p);
  const auto expected = [](const Vector3d& at) { return 2.0 * (0.015 - std::abs(at.z())); };
  const auto inner = [](const Vector3d& at) {
    return at.head<2>().norm() < 0.015 && std::abs(at.z()) > 0.005;
  };
  EXPECT_LT(
      figure("Laplace, plates: worst error, relative", error_of(potential, expected, inner).worst, "0.01"),
      0.01);
}

TEST(PotentialSolver, LaplaceBetweenSpheresConvergesInTheSecondOrder) {
  constexpr double kShell_m = 0.04;
  constexpr double kCore_m = 0.015;
  const auto expected = [](const Vector3d& p) {
    return 0.02 * (1.0 / p.norm() - 1.0 / kShell_m) / (1.0 / kCore_m - 1.0 / kShell_m);
  };
  const auto between = [](const Vector3d& p) { return p.norm() > kCore_m; };
  Error coarser;
  double order = 0;
  for (const double step_m : {0.004, 0.0028, 0.002}) {
    PotentialProblem p = problem(sphere(kShell_m), step_m);
    p.inclusions.push_back({sphere(kCore_m), 0.02, "core"});
    const Error error = error_of(host::solve_potential(p), expected, between);
    const std::string name = "Laplace, spheres, step " + std::to_string(step_m) + " m: ";
    figure(name + "error, root mean square, relative", error.rms, "");
    EXPECT_LT(figure(name + "worst error, relative", error.worst, "0.01"), 0.01);
    if (step_m == 0.0028) order = std::log(coarser.rms / error.rms) / std::log(4.0 / 2.8);
    if (step_m == 0.002) order = std::min(order, std::log(coarser.rms / error.rms) / std::log(2.8 / 2.0));
    coarser = error;
  }
  EXPECT_GT(figure("Laplace, spheres: order of convergence", order, "2, at least 1.7"), 1.7);
}

TEST(PotentialSolver, IsNotAboveZeroOutside) {
  for (const auto& [name, shape] :
       {std::pair("sphere", sphere(0.02)), std::pair("box", box({0.04, 0.03, 0.02})),
        std::pair("cylinder", round(Solid::Kind::kCylinder, 0.02, 0.02)),
        std::pair("capsule", round(Solid::Kind::kCapsule, 0.01, 0.02))}) {
    const Potential potential = host::solve_potential(problem(shape, 0.0017, 100));
    double most = -1;
    double least = 1;
    for (std::size_t i = 0; i < potential.grid.size(); ++i) {
      (potential.inside[i] != 0 ? least : most) = potential.inside[i] != 0
                                                      ? std::min(least, potential.samples[i])
                                                      : std::max(most, potential.samples[i]);
    }
    EXPECT_LE(figure(std::string(name) + ": highest sample outside, m", most, "0"), 0.0);
    EXPECT_GT(figure(std::string(name) + ": lowest sample inside, m", least, "above 0"), 0.0);
  }
}

}  // namespace
}  // namespace thimble::test

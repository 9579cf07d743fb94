// Random stacks and swarms of unlike boxes, solids and meshes by turns, at every rate: the judge knows only their closed forms.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "tests/closed_loop/bodies/mesh_bodies.h"
#include "tests/support/figure.h"
#include "tests/support/random.h"
#include "tests/support/sanitizers.h"

namespace thimble::test {
namespace {

constexpr double kWeight_N_kg = 9.81;

struct Block {
  Vector3d half_m;
  double mass_kg = 0;
  Vector3d inertia_kg_m2;
};

class Stacks : public MeshBodies {
 protected:
  // Its object; masses are as unlike as 1 to 10.
  std::string block(Random& random, const Vector3d& at_m, const Vector3d& angles_deg,
                    const std::string& motion, const Vector3d& size_m) {
    Block block;
    block.half_m = .5 * size_m;
    block.mass_kg = std::exp(random.uniform(std::log(.05), std::log(.5)));
    const Vector3d square = size_m.cwiseAbs2();
    block.inertia_kg_m2 = block.mass_kg / 12 * (Vector3d::Constant(square.sum()) - square);
    const double friction = random.uniform(.3, .9);
    const std::string shape =
        random.below(3) == 0 ? mesh(box_mesh(size_m, 1)) : R"("box": {"size_m": )" + list(size_m) + "}";
    blocks_.push_back(block);
    return R"({"name": "block )" + std::to_string(blocks_.size()) + R"(", "shape": {)" + shape +
           R"(}, "pose": {"position_m": )" + list(at_m) + R"(, "rotation_deg": )" + list(angles_deg) +
           R"(}, "material": {"stiffness_N_m": 1000, "static_friction": )" + std::to_string(friction) +
           R"(, "dynamic_friction": )" + std::to_string(random.uniform(.5, 1) * friction) +
           R"(}, "body": {"motion": "free", "mass_kg": )" + std::to_string(block.mass_kg) +
           R"(, "restitution": )" + std::to_string(random.below(2) == 0 ? 0 : random.uniform(0, .5)) +
           motion + "}}";
  }

  [[nodiscard]] double energy_J(const BodyRun& run, double gravity) const {
    double energy_J = 0;
    for (std::size_t i = 0; i < blocks_.size(); ++i) {
      const Vector3d spin = run.rotation(i).conjugate() * run.body(i).spin_rad_s.cast<double>();
      energy_J +=
          blocks_[i].mass_kg * (.5 * run.velocity_m_s(i).squaredNorm() + gravity * run.position_m(i).z()) +
          .5 * blocks_[i].inertia_kg_m2.dot(spin.cwiseAbs2());
    }
    return energy_J;
  }

  // The deepest corner of a block in another one or below the floor.
  [[nodiscard]] double deepest_m(const BodyRun& run, bool floor) const {
    double deepest_m = 0;
    for (std::size_t i = 0; i < blocks_.size(); ++i) {
      for (int corner = 0; corner < 8; ++corner) {
        const Vector3d sign((corner & 1) != 0 ? 1 : -1, (corner & 2) != 0 ? 1 : -1,
                            (corner & 4) != 0 ? 1 : -1);
        const Vector3d p = run.rotation(i) * blocks_[i].half_m.cwiseProduct(sign) + run.position_m(i);
        if (floor) deepest_m = std::max(deepest_m, -p.z());
        for (std::size_t j = 0; j < blocks_.size(); ++j) {
          const Vector3d local = run.rotation(j).conjugate() * (p - run.position_m(j));
          if (j != i) deepest_m = std::max(deepest_m, (blocks_[j].half_m - local.cwiseAbs()).minCoeff());
        }
      }
    }
    return deepest_m;
  }

  std::vector<Block> blocks_;
};

constexpr double kRates_Hz[] = {1000, 2000, 4000, 10000, 20000};

// Of `most`: as many ticks of each are enough.
int count_at(double rate_Hz, int most) {
  return kUnderSanitizers ? 1 : std::max(1, most * 4000 / std::max(4000, static_cast<int>(rate_Hz)));
}

TEST_F(Stacks, UnlikeBlocksStandWithoutGainingEnergy) {
  for (const double rate_Hz : kRates_Hz) {
    Random random(51);
    double gained = 0;
    double lifted_m = 0;
    double deepest_m = 0;
    double moved_m = 0;
    for (int stack = 0; stack < count_at(rate_Hz, 8); ++stack) {
      blocks_.clear();
      const std::size_t count = 2 + random.below(7);
      std::string text =
          kGravity + std::string(R"("objects": [{"name": "floor", "shape": {"plane": {"normal": [0, 0, 1]}},
        "material": {"stiffness_N_m": 1000, "static_friction": 0.5, "dynamic_friction": 0.4}})");
      double top_m = 0;
      for (std::size_t i = 0; i < count; ++i) {
        const Vector3d size_m(random.uniform(.025, .05), random.uniform(.025, .05), random.uniform(.01, .04));
        const double gap_m = random.uniform(0, 1e-4);
        text += ", " + block(random,
                             random.in_box({.001, .001, 0}) + Vector3d(0, 0, top_m + gap_m + .5 * size_m.z()),
                             random.in_box({0, 0, 45}), "", size_m);
        top_m += gap_m + size_m.z();
      }
      BodyRun run(text + "]", {}, rate_Hz);
      const double start_J = energy_J(run, kWeight_N_kg);
      double least_J = start_J;
      double weight_N = 0;
      for (const Block& block : blocks_) weight_N += kWeight_N_kg * block.mass_kg;
      std::vector<Vector3d> settled_m;
      while (run.time_s() < (kUnderSanitizers ? .05 : 3)) {
        run.tick();
        const double now_J = energy_J(run, kWeight_N_kg);
        gained = std::max(gained, now_J / start_J - 1);
        lifted_m = std::max(lifted_m, (now_J - least_J) / weight_N);
        least_J = std::min(least_J, now_J);
        if (settled_m.empty() && run.time_s() >= 1) {
          for (std::size_t i = 0; i < count; ++i) settled_m.push_back(run.position_m(i));
        }
      }
      deepest_m = std::max(deepest_m, this->deepest_m(run, true));
      for (std::size_t i = 0; i < settled_m.size(); ++i)
        moved_m = std::max(moved_m, (run.position_m(i) - settled_m[i]).norm());
    }
    const std::string what = "stacks at " + std::to_string(static_cast<int>(rate_Hz)) + " Hz: ";
    const double softer = (4000 / rate_Hz) * (4000 / rate_Hz);  // the springs of contacts
    const double bound_m = 1e-5 * softer + 5e-6;
    figure(what + "energy above that of the start, of all", gained, "< 1e-6");
    figure(what + "energy regained, as a height of all weight, um", 1e6 * lifted_m,
           "< " + std::to_string(1e6 * bound_m));
    figure(what + "deepest point, um", 1e6 * deepest_m, "< " + std::to_string(1e6 * bound_m));
    figure(what + "moved in 2 s, um", 1e6 * moved_m, "< 5");
    EXPECT_LT(gained, 1e-6);
    EXPECT_LT(lifted_m, bound_m);
    EXPECT_LT(deepest_m, bound_m);
    EXPECT_LT(moved_m, 5e-6);
  }
}

TEST_F(Stacks, ASwarmKeepsItsMomentumAndGainsNoEnergy) {
  for (const double rate_Hz : kRates_Hz) {
    Random random(52);
    double drift = 0;
    double gained = 0;
    double deepest_m = 0;
    for (int swarm = 0; swarm < count_at(rate_Hz, 4); ++swarm) {
      blocks_.clear();
      std::string text = R"("objects": [)";
      for (int i = 0; i < 16; ++i) {
        const int row = i / 3;
        const int layer = i / 9;
        const Vector3d at_m(.07 * (i % 3 - 1), .07 * (row % 3 - 1), .07 * (layer - 1));
        const Vector3d speed_m_s = -2 * at_m + random.in_box(Vector3d::Constant(.2));
        text += (i > 0 ? ", " : "") +
                block(random, at_m, random.in_box(Vector3d::Constant(180)),
                      R"(, "velocity_m_s": )" + list(speed_m_s) + R"(, "spin_rad_s": )" +
                          list(random.in_box(Vector3d::Constant(5))),
                      Vector3d(random.uniform(.01, .04), random.uniform(.01, .04), random.uniform(.01, .04)));
      }
      BodyRun run(text + "]", {}, rate_Hz);
      const auto momentum = [&](double& scale) {
        Vector3d sum = Vector3d::Zero();
        for (std::size_t i = 0; i < blocks_.size(); ++i) {
          sum += blocks_[i].mass_kg * run.velocity_m_s(i);
          scale += blocks_[i].mass_kg * run.velocity_m_s(i).norm();
        }
        return sum;
      };
      double scale = 0;
      const Vector3d start = momentum(scale);
      const double start_J = energy_J(run, 0);
      double least_J = start_J;
      while (run.time_s() < (kUnderSanitizers ? .02 : 1)) {
        run.tick();
        double unused = 0;
        drift = std::max(drift, (momentum(unused) - start).norm() / scale);
        const double now_J = energy_J(run, 0);
        gained = std::max(gained, (now_J - least_J) / start_J);
        least_J = std::min(least_J, now_J);
        deepest_m = std::max(deepest_m, this->deepest_m(run, false));
      }
      EXPECT_LT(least_J, .98 * start_J) << "they have not met";
    }
    const std::string what = "swarms at " + std::to_string(static_cast<int>(rate_Hz)) + " Hz: ";
    figure(what + "change of momentum, of all", drift, "< 2e-6");
    figure(what + "energy gained, of all", gained, "< 2e-6");
    figure(what + "deepest point, um", 1e6 * deepest_m, "< 100");
    EXPECT_LT(drift, 2e-6);
    EXPECT_LT(gained, 2e-6);
    EXPECT_LT(deepest_m, 1e-4);
  }
}

}  // namespace
}  // namespace thimble::test

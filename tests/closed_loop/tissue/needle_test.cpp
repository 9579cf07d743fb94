// Needle layers against their table: closed forms of peak, drop and work, layer by layer; holes; energy.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "host-tools/compiler/compile.h"
#include "tests/support/figure.h"
#include "tests/support/ideal_run.h"
#include "tests/support/random.h"
#include "tests/support/scene.h"

namespace thimble::test {
namespace {

using Eigen::Vector3d;

struct Layer {
  double thickness_m, stiffness_N_m, tear_N, friction_N, viscosity_N_s_m2;
  [[nodiscard]] double gives_m() const { return stiffness_N_m > 0 ? tear_N / stiffness_N_m : 0; }
};
// The third tears only after the tip has pushed it past its own lower end; the fourth is a gap.
const std::vector<Layer> kTable{{0.004, 800, 2.0, 0.2, 10},
                                {0.012, 300, 0.6, 0.1, 5},
                                {0.002, 500, 1.5, 0.3, 20},
                                {0.005, 0, 0, 0, 0},
                                {0.015, 900, 2.5, 0.4, 30}};

SceneImage needle_scene(const std::vector<Layer>& layers, bool rubbing, double damping_N_s_m = 0.0) {
  std::string list;
  for (const Layer& l : layers) {
    const auto key = [&](const char* before, const char* name, double value) {
      list.append(before).append("\"").append(name).append("\":").append(std::to_string(value));
    };
    key(list.empty() ? "{" : ",{", "thickness_m", l.thickness_m);
    key(",", "stiffness_N_m", l.stiffness_N_m);
    key(",", "tear_N", l.tear_N);
    if (rubbing) {
      key(",", "friction_N", l.friction_N);
      key(",", "viscosity_N_s_m2", l.viscosity_N_s_m2);
    }
    list += "}";
  }
  const std::string text =
      R"({"thimble_scene":1,"name":"needle","objects":[{"name":"way","shape":{"needle":{"layers":[)" + list +
      R"(]}},"material":{"stiffness_N_m":1000,"damping_N_s_m":)" + std::to_string(damping_N_s_m) + "}}]}";
  return SceneImage(host::compile_scene_text(text, "needle", {}).image);
}

// Where each layer begins to push: at its top, or where the one before gave way.
std::vector<double> meets(const std::vector<Layer>& layers) {
  std::vector<double> at{0.0};
  double bottom = 0;
  for (const Layer& l : layers) {
    bottom += l.thickness_m;
    at.push_back(std::max(bottom, at.back() + l.gives_m()));
  }
  return at;
}

// What rubs on the shaft at this depth when the first `torn` layers are pierced: Coulomb force, and viscosity
// times length.
Eigen::Vector2d rubbing(const std::vector<Layer>& layers, std::size_t torn, double depth_m) {
  Eigen::Vector2d sum(0, 0);
  double top = 0;
  for (std::size_t i = 0; i < torn; ++i) {
    const double shaft = std::clamp(depth_m - top, 0.0, layers[i].thickness_m);
    sum += Eigen::Vector2d(layers[i].friction_N * shaft / layers[i].thickness_m,
                           layers[i].viscosity_N_s_m2 * shaft);
    top += layers[i].thickness_m;
  }
  return sum;
}

constexpr double kStep_m = 2.0e-6;
constexpr double kSpeed_m_s = kStep_m * kRate_Hz;

TEST(Needle, PeakDropAndWorkOfEachLayerAreThoseOfTheTable) {
  for (const bool rub : {false, true}) {
    const SceneImage scene = needle_scene(kTable, rub);
    IdealRun run(scene);
    run.step({0.003, -0.002, 0.001});
    const std::vector<double> begins = meets(kTable);
    for (std::size_t i = 0; i < kTable.size(); ++i) {
      if (kTable[i].stiffness_N_m == 0) continue;
      const std::string name = "layer " + std::to_string(i + 1) + (rub ? ", with friction: " : ": ");
      run.move({0.003, -0.002, -begins[i]}, kStep_m);
      const double work_before = run.work_mean_force_J();
      double peak = 0, drop = 0, popped_at = 0;
      const double end = begins[i + 1] + 2 * kStep_m;  // where one layer ends as it tears, the next begins
      while (-run.felt().tip_m.z() < end - 1e-8) {
        const double force = run.felt().force_N.z();
        const double next = std::min(-run.felt().tip_m.z() + kStep_m, end);
        run.step({0.003, -0.002, -next});
        peak = std::max(peak, force);
        if (force - run.felt().force_N.z() > drop) {
          drop = force - run.felt().force_N.z();
          popped_at = next;
        }
      }
      const double gives = kTable[i].gives_m();
      Eigen::Vector2d at_peak(0, 0);
      double loss = 0.5 * kTable[i].tear_N * gives;
      if (rub) {
        at_peak = rubbing(kTable, i, begins[i] + gives);
        constexpr int kParts = 4000;  // of the integral of what rubs, over the table alone
        const double length = begins[i + 1] - begins[i];
        for (int part = 0; part < kParts; ++part) {
          const double depth = begins[i] + length * (part + 0.5) / kParts;
          const Eigen::Vector2d rubs = rubbing(kTable, depth < begins[i] + gives ? i : i + 1, depth);
          loss += (rubs[0] + rubs[1] * kSpeed_m_s) * length / kParts;
        }
      }
      const double expected_peak = kTable[i].tear_N + at_peak[0] + at_peak[1] * kSpeed_m_s;
      const double work = work_before - run.work_mean_force_J();
      figure(name + "peak, N", peak, "1 % of " + std::to_string(expected_peak));
      figure(name + "drop, N", drop, "1 % of " + std::to_string(kTable[i].tear_N));
      figure(name + "work of the hand, mJ", 1e3 * work, "1 % of " + std::to_string(1e3 * loss));
      EXPECT_NEAR(peak, expected_peak, 0.01 * expected_peak);
      EXPECT_NEAR(drop, kTable[i].tear_N, 0.01 * kTable[i].tear_N);
      EXPECT_NEAR(work, loss, 0.01 * loss);
      EXPECT_NEAR(popped_at, begins[i] + gives, 0.01 * gives);
    }
  }
}

// Pops, and the greatest force against the hand, on the way straight down at this place.
struct Descent {
  int pops = 0;
  double most_N = 0;
};
Descent descend(IdealRun& run, double x, double y, double depth_m) {
  run.move({x, y, 0.002}, 1e-4);
  Descent seen;
  double last = 0;
  for (double z = 0.002; z > -depth_m; z -= 1e-5) {
    const double force = run.step({x, y, z}).force_N.z();
    if (last - force > 0.2) ++seen.pops;
    seen.most_N = std::max(seen.most_N, force);
    last = force;
  }
  run.move({x, y, 0.002}, 1e-5);
  return seen;
}

TEST(Needle, AHoleStaysAHole) {
  const SceneImage scene = needle_scene(kTable, true);
  IdealRun run(scene);
  run.step({0, 0, 0.002});
  EXPECT_EQ(descend(run, 0, 0, 0.037).pops, 4);
  const Descent again = descend(run, 0.0, 0.0, 0.037);
  const Descent beside = descend(run, 0.0015, 0.0, 0.037);
  const double rubs =
      rubbing(kTable, kTable.size(), 0.037)[0] + rubbing(kTable, kTable.size(), 0.037)[1] * 1e-5 * kRate_Hz;
  figure("pops on the second way through the same hole", again.pops, "0");
  figure("pops 1.5 mm beside it, within the 2 mm that a hole reaches", beside.pops, "0");
  figure("greatest force there, N", again.most_N, "1 % of the friction " + std::to_string(rubs));
  EXPECT_EQ(again.pops, 0);
  EXPECT_EQ(beside.pops, 0);
  EXPECT_NEAR(again.most_N, rubs, 0.01 * rubs);
  EXPECT_EQ(descend(run, 0.005, 0.0, 0.037).pops, 4) << "elsewhere the tissue is whole";
  EXPECT_EQ(descend(run, 0.0, 0.0, 0.037).pops, 0) << "the first hole is still there";

  // A hole half way goes on where it ended.
  EXPECT_EQ(descend(run, 0.01, 0.0, 0.012).pops, 2);
  EXPECT_EQ(descend(run, 0.01, 0.0, 0.037).pops, 2);
}

TEST(Needle, HolesAreBoundedAndTheOldestHeals) {
  const SceneImage scene = needle_scene(kTable, false);
  IdealRun run(scene);
  run.step({0, 0, 0.002});
  constexpr int kHoles = 8;  // control/fields/volume.h
  for (int i = 0; i < kHoles; ++i) EXPECT_EQ(descend(run, 0.01 * i, 0.01, 0.037).pops, 4);
  for (int i = 0; i < kHoles; ++i) EXPECT_EQ(descend(run, 0.01 * i, 0.01, 0.037).pops, 0) << i;
  EXPECT_EQ(descend(run, 0.01 * kHoles, 0.01, 0.037).pops, 4) << "one more";
  for (int i = 1; i <= kHoles; ++i) EXPECT_EQ(descend(run, 0.01 * i, 0.01, 0.037).pops, 0) << i;
  EXPECT_EQ(descend(run, 0.0, 0.01, 0.037).pops, 4) << "the oldest has healed";
}

TEST(Needle, WithdrawalRubsAndNothingElse) {
  const SceneImage scene = needle_scene(kTable, true);
  IdealRun run(scene);
  run.step({0, 0, 0.001});
  run.move({0, 0, -0.035}, 1e-5);
  run.move({0, 0, -0.032}, kStep_m);  // past the turn of the stiction point
  double worst = 0;
  for (double depth = 0.032; depth > 0.001; depth -= kStep_m) {
    const double force = run.step({0, 0, -depth}).force_N.z();
    const Eigen::Vector2d rubs = rubbing(kTable, kTable.size(), depth);
    const double expected = -(rubs[0] + rubs[1] * kSpeed_m_s);
    worst = std::max(worst, std::abs(force - expected) / std::abs(expected));
  }
  figure("withdrawal: worst difference from Coulomb + viscous friction of the table", worst, "1 %");
  EXPECT_LT(worst, 0.01);
  run.move({0, 0, 0.001}, 1e-5);
  EXPECT_EQ(run.felt().force_N.norm(), 0.0);
}

TEST(Needle, IsHeldToItsTrackAndDoesNotCreep) {
  const SceneImage scene = needle_scene(kTable, true);
  IdealRun run(scene);
  run.step({0.001, 0.002, 0.001});
  run.move({0.001, 0.002, -0.02}, 1e-5);
  run.move({0.003, 0.001, -0.02}, 1e-5);
  const Vector3d force = run.felt().force_N;
  figure("force sideways 2 mm off the track, N", force.x(), "-2 +- 1 %");
  EXPECT_NEAR(force.x(), -2.0, 0.02);
  EXPECT_NEAR(force.y(), 1.0, 0.01);
  run.step({0.003, 0.001, -0.02});  // at rest
  const Vector3d held = run.felt().force_N;
  for (int i = 0; i < 40000; ++i) run.step({0.003, 0.001, -0.02});
  figure("force that 10 s at rest change, N", (run.felt().force_N - held).norm(), "0");
  EXPECT_EQ(run.felt().force_N, held);

  IdealRun inside(scene);  // first seen inside: nothing pushes it out
  EXPECT_LT(inside.step({0, 0, -0.01}).force_N.norm(), 1e-9);
  EXPECT_GT(inside.move({0, 0, -0.0105}, 1e-6).force_N.z(), 0.1) << "it meets the tissue where it is";
}

TEST(Needle, NeverGivesEnergyHoweverItIsPushed) {
  double most = -1, longest = 0;
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    Random random(seed);
    const SceneImage scene = needle_scene(kTable, seed % 2 == 0, seed % 3 == 0 ? 2.0 : 0.0);
    IdealRun run(scene);
    Vector3d p(0, 0, 0.001);
    run.step(p);
    for (int leg = 0; leg < 60; ++leg) {
      const Vector3d to(random.uniform(-0.01, 0.01), random.uniform(-0.01, 0.01),
                        random.uniform(-0.04, 0.004));
      // In and out mostly along the needle, now and then sideways while in.
      const Vector3d next = random.below(3) == 0 ? to : Vector3d(p.x(), p.y(), to.z());
      const double step = random.uniform(1e-6, 2e-5);
      const int steps = static_cast<int>((next - p).norm() / step) + 1;
      const Vector3d from = p;
      for (int i = 1; i <= steps; ++i) {
        p = from + (next - from) * (1.0 * i / steps);
        run.step(p);
        most = std::max(most, run.work_mean_force_J());
      }
      longest = std::max(longest, run.longest_step_m());
    }
  }
  // A tick is a finite step: a spring of K may end half a step beside where it began.
  const double slack = 2000.0 * longest * longest;
  figure("most energy the hand ever had from the needle, J", most,
         "at most K step^2 = " + std::to_string(slack));
  EXPECT_LE(most, slack);
}

}  // namespace
}  // namespace thimble::test

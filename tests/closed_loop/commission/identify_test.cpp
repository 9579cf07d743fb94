// What step 9 finds of simulated arms, with quantisation, friction and delay, against what is true of them: within the accuracies that estimate.h promises.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <numbers>
#include <string>
#include <vector>

#include "host-tools/commission/sim_bench.h"
#include "host-tools/commission/steps.h"
#include "tests/support/figure.h"

namespace thimble::host {
namespace {

ArmFile read_arm(const std::string& name) {
  std::ifstream in(std::filesystem::path(THIMBLE_SOURCE_DIR) / "arms" / (name + ".arm.json"));
  return read_arm_file({std::istreambuf_iterator<char>(in), {}}, name);
}

const Measure* measure_of(const std::vector<Measure>& measures, const char* name, std::size_t axis) {
  for (const Measure& measure : measures)
    if (measure.name == name && measure.axis == static_cast<int>(axis)) return &measure;
  return nullptr;
}

TEST(Identify, FindsWhatIsTrue) {
  // wooden is of the Premium's family: only with THIMBLE_COMMISSION_ARMS.
  std::vector<const char*> names{"premium-1.5", "paddle"};
  if (std::getenv("THIMBLE_COMMISSION_ARMS") != nullptr) names.push_back("wooden");
  for (const char* name : names) {
    const ArmFile arm = read_arm(name);
    SimBench bench(arm, {}, {.seed = 5});
    const Expectation expected(arm);
    Known known;
    StepContext context{bench, expected, known};
    ASSERT_TRUE(prove_encoders(context).passed);
    ASSERT_TRUE(prove_currents(context).passed);
    const StepResult result = identify(context);
    for (const std::string& note : result.notes) std::printf("%s: %s\n", name, note.c_str());
    for (std::size_t j = 0; j < arm.axes.size(); ++j) {
      const board::AxisTruth& axis = bench.truth().axis[j];
      board::AnyPlant plant(bench.truth());
      plant.place(expected.balanced(j));
      const auto row = static_cast<Eigen::Index>(j);
      const double link = plant.mass_matrix()(row, row);
      const double locked_Hz = std::sqrt(axis.stiffness_N_m_rad / link) / (2 * std::numbers::pi);
      const double ratio = axis.damping_N_m_s_rad / (2 * std::sqrt(axis.stiffness_N_m_rad * link));
      const auto check = [&](const char* what, double truth, double promise, double floor = 0) {
        const Measure* seen = measure_of(result.measures, what, j);
        if (seen == nullptr) {
          ADD_FAILURE() << name << " " << j << ": no " << what;
          return;
        }
        const double off = std::abs(seen->value - truth);
        std::printf("%-12s %zu %-20s true %-11.5g found %-11.5g +- %-9.2g off %5.1f %%  (%.0f %%)\n", name, j,
                    what, truth, seen->value, seen->spread, 100 * off / std::abs(truth), 100 * promise);
        EXPECT_LT(off, promise * std::abs(truth) + floor) << name << " " << j << " " << what;
      };
      check("coulomb_N_m", axis.coulomb_N_m, .2);
      check("viscous_N_m_s_rad", axis.viscous_N_m_s_rad, .3, .04 * axis.coulomb_N_m / 2);
      check("stiction_ratio", axis.stiction_ratio, .2);
      check("inertia_kg_m2", link + axis.rotor_kg_m2, .1);
      check("stiffness_N_m_rad", axis.stiffness_N_m_rad, .1);
      check("first_resonance_Hz", locked_Hz, .03);
      check("damping_ratio", ratio, .3);
    }
  }
}

TEST(Identify, FindsTheDelayOfADrive) {
  constexpr double kTick_s = 1.0 / 4000;
  const ArmFile arm = read_arm("paddle");
  std::array<double, 2> found{};
  for (std::size_t i = 0; i < 2; ++i) {
    SimBench bench(arm, {}, {.seed = 3, .drive_delay_s = 2 * static_cast<double>(i) * kTick_s});
    const Expectation expected(arm);
    Known known;
    StepContext context{bench, expected, known};
    ASSERT_TRUE(prove_encoders(context).passed);
    const StepResult result = identify(context);
    const Measure* delay = measure_of(result.measures, "delay_s", 0);
    ASSERT_NE(delay, nullptr);
    found.at(i) = delay->value / kTick_s;
  }
  test::figure("delay of a drive at once, ticks", found[0], "current loop and steps of the simulation");
  test::figure("of one that takes two ticks longer", found[1] - found[0], "2 +- 0.1");
  EXPECT_NEAR(found[1] - found[0], 2, .1);
}

}  // namespace
}  // namespace thimble::host

// The scenes needle and deform with the firmware's controller and the simulated arm, along their strokes.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "board/sim/hand_path_file.h"
#include "board/sim/simulation.h"
#include "host-tools/compiler/compile.h"
#include "tests/support/figure.h"

namespace thimble::test {
namespace {

namespace fs = std::filesystem;
using board::LogRow;

const fs::path kScenes = fs::path(THIMBLE_SOURCE_DIR) / "scenes";

std::vector<LogRow> play(const std::string& name) {
  const fs::path folder = kScenes / name;
  const host::CompiledScene scene = host::compile_scene(folder / (name + ".scene.json"));
  std::vector<LogRow> log;
  const board::SimulationResult result =
      board::simulate(scene.image, board::read_hand_path(folder / "stroke.csv"),
                      {.sensors = {.line_loss = true}}, [&log](const LogRow& row) { log.push_back(row); });
  EXPECT_EQ(result.status, board::SimulationStatus::kOk) << result.detail;
  return log;
}

constexpr double kSkin_m = -0.02;
constexpr double kTick_s = 1.0 / 4000;

struct Pop {
  double time_s, depth_m, peak_N, drop_N, x_m;
};

// Where the force falls by more than 0.15 N within a tick while the needle goes in.
std::vector<Pop> pops_of(const std::vector<LogRow>& log) {
  std::vector<Pop> pops;
  for (std::size_t i = 1; i < log.size(); ++i) {
    const double drop = log[i - 1].force_N.z() - log[i].force_N.z();
    if (drop > 0.15 && log[i].contacts > 0)
      pops.push_back(
          {log[i].time_s, kSkin_m - log[i - 1].tip_m.z(), log[i - 1].force_N.z(), drop, log[i].tip_m.x()});
  }
  return pops;
}

TEST(NeedleScene, EachLayerTearsAtItsStrengthAndOnlyOnceInAHole) {
  const std::vector<LogRow> log = play("needle");
  ASSERT_FALSE(log.empty());
  std::ifstream stream(kScenes / "needle" / "needle.scene.json");
  const auto layers = nlohmann::json::parse(stream)["objects"][0]["shape"]["needle"]["layers"];
  const std::vector<Pop> pops = pops_of(log);
  ASSERT_EQ(pops.size(), 2 * layers.size())
      << "each layer, in two holes; the second way through the first hole tears nothing";
  double worst_drop = 0, worst_peak = 0;
  for (std::size_t hole = 0; hole < 2; ++hole) {
    double meets = 0, bottom = 0;
    for (std::size_t i = 0; i < layers.size(); ++i) {
      const Pop& pop = pops[hole * layers.size() + i];
      const double tear = layers[i]["tear_N"];
      const double gives = tear / layers[i]["stiffness_N_m"].get<double>();
      // The shaft sticks or slides in what is pierced already: at most its friction either way.
      double rubs = 0, viscous = 0, top = 0;
      for (std::size_t j = 0; j < i; ++j) {
        const double thick = layers[j]["thickness_m"];
        const double shaft = std::clamp(meets + gives - top, 0.0, thick);
        rubs += layers[j]["friction_N"].get<double>() * shaft / thick;
        viscous += layers[j]["viscosity_N_s_m2"].get<double>() * shaft;
        top += thick;
      }
      worst_drop = std::max(worst_drop, std::abs(pop.drop_N - tear) / tear);
      // The material's damping and the viscous part, at the 0.2 m/s with which the hand falls through a
      // layer.
      constexpr double kFall_m_s = 0.2;
      EXPECT_LT(pop.peak_N, 1.01 * tear + rubs + (viscous + 1.0) * kFall_m_s);
      EXPECT_GT(pop.peak_N, 0.99 * tear - rubs);
      if (i == 0) worst_peak = std::max(worst_peak, std::abs(pop.peak_N - tear) / tear);
      EXPECT_NEAR(pop.depth_m, meets + gives, 8e-4) << i << ": the true tip, cables stretched";
      figure("hole " + std::to_string(hole + 1) + ", layer " + std::to_string(i + 1) + ": drop, N",
             pop.drop_N, "table: " + std::to_string(tear));
      bottom += layers[i]["thickness_m"].get<double>();
      meets = std::max(bottom, meets + gives);
    }
  }
  figure("worst drop, from its table", worst_drop, "8 %");
  figure("worst peak at the skin, from its table", worst_peak, "1 %");
  EXPECT_LT(worst_drop, 0.08);  // friction and damping answer in the same tick
  EXPECT_LT(worst_peak, 0.01);
}

// Without friction the loop shows the table itself. Soft layers: a count of an encoder is 0.03 mm, so 0.01 N
// at 300 N/m.
TEST(NeedleLoop, PeakDropAndWorkOfEachLayerAreThoseOfTheTable) {
  struct Layer {
    double thickness_m, stiffness_N_m, tear_N;
  };
  const std::vector<Layer> table{{0.02, 300, 2.0}, {0.02, 400, 2.5}, {0.02, 250, 1.5}};
  constexpr double kMaterial_N_m = 1000;
  nlohmann::json scene = nlohmann::json::parse(
      R"({"thimble_scene":1,"name":"needle","objects":[{"name":"way","shape":{"needle":{"layers":[]}},)"
      R"("pose":{"position_m":[0,0,-0.02]},"material":{"stiffness_N_m":1000}}]})");
  for (const Layer& layer : table) {
    scene["objects"][0]["shape"]["needle"]["layers"].push_back({{"thickness_m", layer.thickness_m},
                                                                {"stiffness_N_m", layer.stiffness_N_m},
                                                                {"tear_N", layer.tear_N}});
  }
  const std::vector<board::PathPoint> path{
      {0, {0, 0, 0}, 0}, {0.5, {0, 0, -0.018}, 0}, {6.5, {0, 0, -0.08}, 0}, {7.5, {0, 0, 0}, 0}};
  std::vector<LogRow> log;
  const board::SimulationResult result =
      board::simulate(host::compile_scene_text(scene.dump(), "t", {}).image, path, {},
                      [&log](const LogRow& row) { log.push_back(row); });
  ASSERT_EQ(result.status, board::SimulationStatus::kOk) << result.detail;
  // Where the controller takes the tip to be: the true one differs by what the cables stretch.
  const auto depth_m = [](const LogRow& row) {
    return kSkin_m - (row.proxy_m.z() - row.force_N.z() / kMaterial_N_m);
  };
  std::size_t layer = 0;
  double work = 0;
  for (std::size_t i = 1; i < log.size(); ++i) {
    const double force = log[i].force_N.z();
    const double before = log[i - 1].force_N.z();
    if (before - force > 0.5) {
      ASSERT_LT(layer, table.size()) << "a pop too many";
      const std::string name = "loop, layer " + std::to_string(layer + 1) + ": ";
      const double tear = table[layer].tear_N;
      const double stored = 0.5 * tear * tear / table[layer].stiffness_N_m;
      figure(name + "peak, N", before, "1 % of " + std::to_string(tear));
      figure(name + "drop, N", before - force, "1 % of " + std::to_string(tear));
      figure(name + "work, mJ", 1e3 * work, "1 % of " + std::to_string(1e3 * stored));
      EXPECT_NEAR(before, tear, 0.01 * tear);
      EXPECT_NEAR(before - force, tear, 0.01 * tear);
      EXPECT_NEAR(work, stored, 0.01 * stored);
      ++layer;
      work = 0;
    } else if (log[i].contacts > 0 && log[i - 1].contacts > 0) {
      work += 0.5 * (force + before) * (depth_m(log[i]) - depth_m(log[i - 1]));
    }
  }
  EXPECT_EQ(layer, table.size());
}

TEST(NeedleScene, TheHandIsNeverGivenEnergy) {
  const std::vector<LogRow> log = play("needle");
  double work = 0, most = -1;
  for (std::size_t i = 1; i < log.size(); ++i) {
    work += log[i - 1].force_N.dot(log[i].tip_m - log[i - 1].tip_m);  // as held by the device
    most = std::max(most, work);
  }
  figure("work of the device on the hand at its highest, mJ", 1e3 * most, "at most 0.05");
  figure("work of the device on the hand at the end, mJ", 1e3 * work, "below -20: the tissue keeps it");
  EXPECT_LT(most, 5e-5);
  EXPECT_LT(work, -0.02);
}

TEST(DeformScene, GivesRelaxesAndIsFeltLowerDownWhenPressedAgain) {
  const std::vector<LogRow> log = play("deform");
  ASSERT_FALSE(log.empty());
  const auto at = [&](double t) {
    return log[static_cast<std::size_t>(std::lround((t - log[0].time_s) / kTick_s))];
  };
  // Contacts begin at these depths.
  std::vector<std::pair<double, double>> begins;
  bool touching = false;
  double last_s = -1;
  for (const LogRow& row : log) {
    if (row.contacts > 0 && !touching && row.time_s - last_s > 0.05)
      begins.emplace_back(row.time_s, kSkin_m - row.tip_m.z());
    touching = row.contacts > 0;
    if (touching) last_s = row.time_s;
  }
  ASSERT_EQ(begins.size(), 3U);
  figure("first press meets the skin at, mm", 1e3 * begins[0].second, "0 +- 0.15");
  figure("pressed again at once it meets it at, mm", 1e3 * begins[1].second, "above 3");
  figure("after 2.4 s of rest it meets it at, mm", 1e3 * begins[2].second, "below 0.4");
  EXPECT_NEAR(begins[0].second, 0.0, 1.5e-4);
  EXPECT_GT(begins[1].second, 3e-3);
  EXPECT_LT(begins[2].second, 4e-4);
  // Held, it relaxes towards K_relaxed depth.
  const LogRow held = at(2.35);
  const double depth = kSkin_m - held.tip_m.z();
  figure("force after 1.4 s of pressing, N", held.force_N.z(),
         "3 % of K_relaxed depth = " + std::to_string(150 * depth));
  EXPECT_NEAR(held.force_N.z(), 150 * depth, 0.03 * 150 * depth);
  const LogRow early = at(1.0);
  EXPECT_GT(early.force_N.z() / (kSkin_m - early.tip_m.z()), 1.2 * held.force_N.z() / depth);

  double work = 0, most = -1;
  for (std::size_t i = 1; i < log.size(); ++i) {
    work += log[i - 1].force_N.dot(log[i].tip_m - log[i - 1].tip_m);
    most = std::max(most, work);
  }
  figure("work of the device on the hand at its highest, mJ", 1e3 * most, "at most 0.05");
  EXPECT_LT(most, 5e-5);
}

}  // namespace
}  // namespace thimble::test

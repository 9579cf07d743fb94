// Runs of plans: the same as direct calls of the simulation, and the same bytes with any number of threads and any interruption.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

#include "board/sim/hand_path_file.h"
#include "host-tools/sweep/sweep.h"
#include "host-tools/sweep/sweep_runs.h"
#include "host-tools/sweep/sweep_table.h"
#include "tests/support/figure.h"
#include "tests/support/random.h"
#include "tests/unit/sweep/plans.h"

namespace thimble::test {
namespace {

namespace fs = std::filesystem;
using host::SweepPlan;
using host::SweepResults;
using host::SweepRuns;

std::vector<std::string> cells_of(const std::string& line) {
  std::vector<std::string> cells;
  std::istringstream in(line + ",");
  for (std::string cell; std::getline(in, cell, ',');) cells.push_back(cell);
  return cells;
}
double cell(const SweepRuns& runs, const std::string& line, const std::string& name) {
  const std::string head = runs.head();
  std::vector<std::string> names = cells_of(head.substr(head.find('\n') + 1));
  names.back().pop_back();
  const auto found = std::ranges::find(names, name);
  EXPECT_NE(found, names.end()) << name;
  return std::stod(cells_of(line).at(static_cast<std::size_t>(found - names.begin())));
}

// Plans at random; each run against the scene that a person would have written by hand.
TEST(SweepRuns, AreTheSimulationsThatThePlanNames) {
  const PlanFolder folder;
  Random random(18);
  const std::vector<board::PathPoint> path = board::read_hand_path(folder.path() / "press.csv");
  double peaks = 0;
  for (int i = 0; i < 6; ++i) {
    const double soft = std::round(random.uniform(200, 900)), stiff = std::round(random.uniform(1000, 3000));
    const double damping = random.uniform(0, 3), rate = 500.0 * static_cast<double>(2 + random.below(10));
    const bool ideal = random.below(2) == 0;
    const std::size_t seed = random.below(1000);
    std::ostringstream keys;
    keys.precision(17);
    keys << "\"ideal\": " << (ideal ? "true" : "false") << ", \"set\": {\"rate_Hz\": " << rate
         << ", \"/materials/wood/damping_N_s_m\": " << damping << ", \"seed\": " << seed
         << R"(}, "steady_s": 0.02, "vary": [
      {"what": "/materials/wood/stiffness_N_m", "values": [)"
         << soft << ", " << stiff << R"(]}, {"what": "arm", "values": ["premium-1.5", "wooden"]}])";
    const SweepRuns runs(folder.floor(keys.str()));
    ASSERT_EQ(runs.count(), 4U);
    const std::size_t run = random.below(4);
    std::ostringstream scene;
    scene.precision(17);
    scene
        << R"({"thimble_scene": 1, "name": "x", "objects": [{"name": "f", "shape": {"plane": {"normal": [0, 0, 1]}},
      "material": {"stiffness_N_m": )"
        << (run < 2 ? soft : stiff) << ", \"damping_N_s_m\": " << damping << "}}]}";
    board::SimulationOptions options;
    options.ideal = ideal;
    options.rate_Hz = rate;
    options.arm = run % 2 == 0 ? "premium-1.5" : "wooden";
    options.seed = seed;
    double peak_N = 0, low_m = 1, high_m = -1, touching = 0;
    const auto result = board::simulate(host::compile_scene_text(scene.str(), "x", {}).image, path, options,
                                        [&](const board::LogRow& row) {
                                          peak_N = std::max(peak_N, row.force_N.norm());
                                          touching += row.contacts > 0 ? 1 / rate : 0;
                                          if (row.time_s < .2 - .02) return;
                                          low_m = std::min(low_m, row.tip_m.z());
                                          high_m = std::max(high_m, row.tip_m.z());
                                        });
    ASSERT_EQ(result.status, board::SimulationStatus::kOk) << result.detail;
    const std::string line = runs.line(run);
    EXPECT_NEAR(cell(runs, line, "peak_force_N"), peak_N, 1e-8 * peak_N) << line;
    EXPECT_NEAR(cell(runs, line, "contact_s"), touching, 1e-8);
    EXPECT_GE(cell(runs, line, "tip_swing_m"), (high_m - low_m) * (1 - 1e-8));
    EXPECT_EQ(runs.line(run), line);
    peaks += peak_N;
  }
  EXPECT_GT(figure("sum of the largest forces, N", peaks, "> 1"), 1);
}

const std::string kSmall = R"("steady_s": 0.02, "vary": [
  {"what": "/objects/0/material", "values": ["wood", "steel"]},
  {"what": "rate_Hz", "values": [1000, 4000]},
  {"what": "seed", "from": 1, "to": 3, "count": 3}],
  "table": {"rows": "rate_Hz", "columns": "/objects/0/material", "value": "peak_force_N", "digits": 2})";

// Stops after so many runs; kRuns: never.
std::size_t go(const SweepRuns& runs, const fs::path& out, std::size_t jobs, std::size_t most,
               host::SweepPart part = {}) {
  SweepResults results(out, runs.head(), runs.columns(), runs.count());
  results.open(part.parts == 1 ? "" : std::to_string(part.part + 1) + "-of-" + std::to_string(part.parts));
  const std::size_t before = results.done();
  const host::SweepTimes times = host::run_sweep(
      runs, results, part, jobs, [&](const host::SweepProgress& now) { return now.done < before + most; });
  EXPECT_EQ(times.runs, results.done() - before);
  EXPECT_GT(times.run_s, 0);
  if (results.is_whole()) results.finish();
  return times.runs;
}

TEST(SweepRuns, AreTheSameBytesInAnyWay) {
  const PlanFolder folder;
  const SweepRuns runs(folder.floor(kSmall));
  ASSERT_EQ(runs.count(), 12U);
  std::string meant = runs.head();
  for (std::size_t run = 0; run < runs.count(); ++run) meant += runs.line(run) + "\n";
  const auto file = [&folder](const char* name) { return folder.path() / name; };
  EXPECT_EQ(go(runs, file("one.csv"), 1, 100), 12U);
  EXPECT_EQ(text_of(file("one.csv")), meant);
  EXPECT_EQ(go(runs, file("four.csv"), 4, 100), 12U);
  EXPECT_EQ(text_of(file("four.csv")), meant);
  for (const std::size_t part : {2U, 0U, 1U}) EXPECT_EQ(go(runs, file("parts.csv"), 2, 100, {part, 3}), 4U);
  EXPECT_EQ(text_of(file("parts.csv")), meant);
  // Stopped again and again: what is whole is kept, the rest is run once more.
  std::size_t tries = 0, run = 0;
  while (!fs::exists(file("stopped.csv")) && ++tries < 100) run += go(runs, file("stopped.csv"), 2, 1);
  EXPECT_EQ(text_of(file("stopped.csv")), meant);
  EXPECT_EQ(run, 12U) << "each run is done once";
}

// One number of a hand holds for each hand, in whatever order the plan has them.
TEST(SweepRuns, ANumberOfAHandIsNotUndoneByTheHand) {
  const PlanFolder folder;
  const std::string hand =
      R"({"what": "hand", "values": [{"name": "h", "mass_kg": 0.1, "stiffness_N_m": 300}]})";
  const std::string number = R"({"what": "hand_stiffness_N_m", "values": [200, 2000]})";
  const SweepRuns after(folder.floor("\"vary\": [" + hand + ", " + number + "]"));
  const SweepRuns before(folder.floor("\"vary\": [" + number + ", " + hand + "]"));
  const SweepRuns set(folder.floor(R"("set": {"hand_stiffness_N_m": 2000}, "vary": [)" + hand + "]"));
  const double soft_N = cell(before, before.line(0), "peak_force_N"),
               stiff_N = cell(before, before.line(1), "peak_force_N");
  EXPECT_GT(stiff_N, soft_N * 1.1);
  EXPECT_EQ(cell(after, after.line(0), "peak_force_N"), soft_N);
  EXPECT_EQ(cell(after, after.line(1), "peak_force_N"), stiff_N);
  EXPECT_EQ(cell(set, set.line(0), "peak_force_N"), stiff_N);
}

TEST(SweepRuns, HaveAStatus) {
  const PlanFolder folder;
  folder.write("far.csv", "time_s,x_m,y_m,z_m\n0,0,0,0\n0.1,0,0,2\n");
  const SweepRuns far(folder.plan(
      R"({"thimble_sweep": 1, "name": "x", "scene": "floor.scene.json", "path": "far.csv", "vary": [{"what": "seed", "values": [1]}]})"));
  EXPECT_EQ(far.line(0), "0,1,out-of-reach,,,,,,,,,,");
  const SweepRuns far_steady(folder.plan(
      R"({"thimble_sweep": 1, "name": "x", "scene": "floor.scene.json", "path": "far.csv", "steady_s": 0.01, "vary": [{"what": "seed", "values": [1]}]})"));
  EXPECT_EQ(far_steady.line(0), "0,1,out-of-reach,,,,,,,,,,") << "nothing was measured";
  folder.write("fast.csv", "time_s,x_m,y_m,z_m\n0,0,0,0.01\n0.004,0,0,-0.02\n0.1,0,0,-0.02\n");
  const SweepRuns fast(folder.plan(
      R"({"thimble_sweep": 1, "name": "x", "scene": "floor.scene.json", "path": "fast.csv", "steady_s": 0.01,
          "set": {"hand_stiffness_N_m": 20000, "hand_damping_N_s_m": 20}, "vary": [{"what": "seed", "values": [1]}]})"));
  EXPECT_THAT(fast.line(0), testing::StartsWith("0,1,faulted,"));
  EXPECT_THAT(fast.line(0), testing::EndsWith(",,,,,0")) << "no steady part, and not stable";
  EXPECT_EQ(cells_of(far.line(0)).size(), far.columns());
}

TEST(SweepTable, HasTheFirstDigitsOfItsCells) {
  const PlanFolder folder;
  const SweepRuns runs(folder.floor(kSmall));
  ASSERT_EQ(go(runs, folder.path() / "out.csv", 2, 100), 12U);
  const SweepResults results(folder.path() / "out.csv", runs.head(), runs.columns(), runs.count());
  const std::string page = host::table_page(runs.plan(), runs.head(), results, "thimble sweep");
  EXPECT_THAT(page,
              testing::StartsWith("# test\n\nMade by `thimble sweep`; every run gives the same figures.\n"));
  for (const char* seed : {"\n## 1\n", "\n## 2\n", "\n## 3\n"}) EXPECT_THAT(page, testing::HasSubstr(seed));
  std::smatch row;
  ASSERT_TRUE(std::regex_search(page, row,
                                std::regex("\\| rate_Hz \\| wood \\| steel \\|\n\\|---\\|---\\|---\\|\n"
                                           "\\| 1000 \\| ([0-9.]+) \\| ([0-9.]+) \\|\n")));
  const double wood = cell(runs, results.line(0), "peak_force_N"),
               steel = cell(runs, results.line(6), "peak_force_N");
  EXPECT_LE(std::stod(row[1]), wood);
  EXPECT_GT(std::stod(row[1]), .9 * wood);
  EXPECT_LE(std::stod(row[2]), steel);
  EXPECT_LE(row[2].str().size(), 3U);
}

TEST(SweepTable, CellsAreNotCutByTheirText) {
  const PlanFolder folder;
  const SweepRuns runs(folder.floor(
      R"("vary": [{"what": "seed", "values": [1], "label": "a|b"}, {"what": "rate_Hz", "values": [1000], "unit": "|"}],
         "table": {"rows": "seed", "columns": "rate_Hz", "value": "contact_s"})"));
  ASSERT_EQ(go(runs, folder.path() / "out.csv", 1, 100), 1U);
  const SweepResults results(folder.path() / "out.csv", runs.head(), runs.columns(), runs.count());
  EXPECT_THAT(host::table_page(runs.plan(), runs.head(), results, "thimble sweep"),
              testing::HasSubstr("\n| a\\|b | 1000 \\| |\n|---|---|\n| 1 | "));
}

// The plan of docs/stability.md: its shortest searches give the page's figures. All of them: stability.page, long.
TEST(SweepTable, ThePageOfStabilityIsOfThisPlan) {
  const SweepRuns runs(host::read_sweep_plan(THIMBLE_SOURCE_DIR "/docs/examples/sweep/stability.plan.json"));
  const std::string page = text_of(THIMBLE_SOURCE_DIR "/docs/stability.md");
  int compared = 0;
  for (std::size_t run = 0; run < runs.count(); ++run) {
    const std::vector<std::size_t> place = runs.plan().place(run);
    const auto text = [&](std::size_t axis) { return runs.plan().axes[axis].values[place[axis]].text; };
    if (text(2) != "5" || text(3) != "1000") continue;
    const double found = cell(runs, runs.line(run), "largest_stable");
    const std::size_t table = page.find("## " + text(0) + ", " + text(1) + "\n");
    ASSERT_NE(table, std::string::npos);
    const std::size_t row = page.find("\n| 5 | ", table);
    const double shown = std::stod(page.substr(row + 7));
    figure(text(0) + ", " + text(1) + ": N/m", found, std::to_string(shown));
    EXPECT_LE(shown, found);
    EXPECT_GE(shown, .9 * found);
    ++compared;
  }
  EXPECT_EQ(compared, 4);
}

}  // namespace
}  // namespace thimble::test

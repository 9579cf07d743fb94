// The demonstrations of surfaces along their strokes: exactly on the path, and through the firmware core with
// the simulated arm.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <span>
#include <sstream>
#include <string>
#include <vector>

#include "board/sim/simulation.h"
#include "host-tools/compiler/compile.h"
#include "tests/closed_loop/surfaces/rig.h"
#include "tests/support/figure.h"
#include "tests/support/sanitizers.h"

namespace thimble::test {
namespace {

using board::LogRow;

std::vector<board::PathPoint> stroke(const std::string& name) {
  std::ifstream file(THIMBLE_SCENES "/" + name + "/stroke.csv");
  std::vector<board::PathPoint> path;
  std::string line;
  std::getline(file, line);
  while (std::getline(file, line)) {
    std::replace(line.begin(), line.end(), ',', ' ');
    std::istringstream numbers(line);
    board::PathPoint point;
    numbers >> point.time_s >> point.position_m.x() >> point.position_m.y() >> point.position_m.z();
    path.push_back(point);
  }
  return path;
}

std::vector<LogRow> play(const std::string& name, bool ideal) {
  const host::CompiledScene scene =
      host::compile_scene(THIMBLE_SCENES "/" + name + "/" + name + ".scene.json");
  std::vector<LogRow> rows;
  // No probes of the encoders: they would be in the spectrum of stick and slip.
  const board::SimulationResult result =
      board::simulate(scene.image, stroke(name), {.ideal = ideal, .sensors = {.line_loss = true}},
                      [&](const LogRow& row) { rows.push_back(row); });
  EXPECT_EQ(result.status, board::SimulationStatus::kOk) << name << ": " << result.detail;
  return rows;
}

std::vector<LogRow> between(const std::vector<LogRow>& rows, double from_s, double to_s) {
  std::vector<LogRow> part;
  for (const LogRow& row : rows) {
    if (row.time_s >= from_s && row.time_s < to_s) part.push_back(row);
  }
  return part;
}

std::vector<double> column(const std::vector<LogRow>& rows, int axis) {
  std::vector<double> values;
  values.reserve(rows.size());
  for (const LogRow& row : rows) values.push_back(row.force_N[axis]);
  return values;
}

double mean(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

TEST(Scenes, EachRunsThroughTheFirmwareCoreAndTheArm) {
  const std::vector<std::string> names{"walls", "textures", "ice", "stick-slip", "spline-tissue"};
  for (const std::string& name : std::span(names).first(kUnderSanitizers ? 2 : names.size())) {
    const std::vector<LogRow> rows = play(name, false);
    double most_N = 0;
    double touching = 0;
    for (const LogRow& row : rows) {
      most_N = std::max(most_N, row.force_N.norm());
      touching += row.contacts > 0 ? 1 : 0;
    }
    figure(name + ": largest force, N", most_N, "0.5 to 8.5");
    figure(name + ": share of the time in contact", touching / static_cast<double>(rows.size()), "> 0.3");
    EXPECT_GT(most_N, 0.5);
    EXPECT_LT(most_N, 8.5);
    EXPECT_GT(touching, 0.3 * static_cast<double>(rows.size()));
  }
}

TEST(Scenes, WallsClickOnTheLeftAndBrakeInFront) {
  const std::vector<LogRow> rows = play("walls", true);
  double free_N = 0;
  for (const LogRow& row : between(rows, 4.6, 5.3)) free_N = std::max(free_N, row.force_N.norm());
  figure("walls: force between the walls, N", free_N, "0");
  EXPECT_EQ(free_N, 0.0);
  // The left wall is met at 0.13 m/s: less spring and damping, the click's 0.8 N per 0.1 m/s, of 150 Hz.
  std::vector<double> click_N;
  for (const LogRow& row : between(rows, 5.8, 6.05)) {
    if (row.contacts == 0) continue;
    const double depth_m = -0.04 - row.tip_m.x();
    const double speed_m_s = row.time_s < 5.9 ? 0.13 : 0.0;
    click_N.push_back(row.force_N.x() - 800 * depth_m - 2 * speed_m_s);
  }
  ASSERT_GT(click_N.size(), 100U);
  const double peak_N = *std::max_element(click_N.begin(), click_N.end());
  const double wanted_N = 0.8 * 1.3 * std::exp(-90.0 / 600.0);  // a quarter of a swing after contact
  figure("walls: first swing of the click, N", peak_N, std::to_string(wanted_N) + " within 3 %");
  figure("walls: its frequency, Hz", peak_frequency(click_N, kRate_Hz, 80, 300), "150 within 3 %");
  EXPECT_NEAR(peak_N, wanted_N, 0.03 * wanted_N);
  EXPECT_NEAR(peak_frequency(click_N, kRate_Hz, 80, 300), 150.0, 4.5);
  const std::vector<LogRow> braked = between(rows, 7.2, 8.2);
  const double ratio = -mean(column(braked, 0)) / mean(column(braked, 1));
  figure("walls: F_t / F_n along the front wall, which has no friction of its own", ratio, "0.7, the brake");
  EXPECT_NEAR(ratio, 0.7, 0.01);
}

TEST(Scenes, IcePushesAlongItsNormalAlone) {
  const std::vector<LogRow> rows = play("ice", true);
  const Vector3d dome(0.03, 0.02, -0.055);
  double aside_N = 0;
  std::size_t dome_ticks = 0;
  constexpr double kCrease_m = 6e-5;
  for (const LogRow& row : rows) {
    if (row.contacts != 1) continue;
    // In the crease between them either may be the one that holds.
    const auto beside = [&](const Vector3d& normal) {
      return (row.force_N - normal * normal.dot(row.force_N)).norm();
    };
    const Vector3d from_centre = row.proxy_m - dome;
    const bool on_floor = std::abs(row.proxy_m.z() + 0.03) < 1e-6;
    const bool on_dome = std::abs(from_centre.norm() - 0.04) < 1e-6;
    ASSERT_TRUE(on_floor || on_dome) << row.time_s;
    // In the crease a ball keeps the god object off the surface that does not hold it (control/contact/ball.h).
    if (std::abs(row.proxy_m.z() + 0.03) < kCrease_m && std::abs(from_centre.norm() - 0.04) < kCrease_m)
      continue;
    aside_N = std::max(aside_N, std::min(on_floor ? beside(Vector3d::UnitZ()) : 1e9,
                                         on_dome ? beside(from_centre.normalized()) : 1e9));
    dome_ticks += on_dome && !on_floor ? 1U : 0U;
  }
  figure("ice: largest force beside the normal, N", aside_N, "1e-4, of 2");
  figure("ice: ticks on the dome", static_cast<double>(dome_ticks), "> 1000");
  EXPECT_LT(aside_N, 1e-4);
  EXPECT_GT(dome_ticks, 1000U);
}

TEST(Scenes, StickSlipSingsThroughTheArm) {
  const std::vector<LogRow> rows = between(play("stick-slip", false), 1.5, 4.7);
  const double press_N = mean(column(rows, 2));
  const double fall_N = 0.4 * press_N;
  double slips = 0;
  double first_s = 0;
  double last_s = 0;
  for (std::size_t i = 1; i < rows.size(); ++i) {  // the stiction point stands but for slips
    if (rows[i].proxy_m.x() - rows[i - 1].proxy_m.x() < 0.5 * fall_N / 800.0) continue;
    if (slips == 0) first_s = rows[i].time_s;
    last_s = rows[i].time_s;
    ++slips;
  }
  const double slips_Hz = (slips - 1) / (last_s - first_s);
  const double speed_m_s =
      (rows.back().tip_m.x() - rows.front().tip_m.x()) / (rows.back().time_s - rows.front().time_s);
  const double closed_Hz = speed_m_s * 800.0 / fall_N;
  const std::vector<double> drag_N = column(rows, 0);
  const double peak_Hz = peak_frequency(drag_N, kRate_Hz, 0.7 * closed_Hz, 1.4 * closed_Hz, 300);
  figure("stick-slip through the arm: press, N", press_N, "reported");
  figure("stick-slip through the arm: slips, Hz", slips_Hz,
         "V K / ((mu_s - mu_d) F_n) = " + std::to_string(closed_Hz) + " within 5 %");
  // Against the median of the spectrum from 5 to 200 Hz.
  std::vector<double> spectrum;
  for (double f = 5; f < 200; f += 1) spectrum.push_back(amplitude(drag_N, kRate_Hz, f));
  std::nth_element(spectrum.begin(), spectrum.begin() + 97, spectrum.end());
  const double stands_out = amplitude(drag_N, kRate_Hz, peak_Hz) / spectrum[97];
  figure("stick-slip through the arm: peak of the force's spectrum, Hz", peak_Hz, "the same within 5 %");
  figure("stick-slip through the arm: its amplitude, N", amplitude(drag_N, kRate_Hz, peak_Hz), "> 0.03");
  figure("stick-slip through the arm: its amplitude over the spectrum's median", stands_out, "> 5");
  EXPECT_NEAR(slips_Hz, closed_Hz, 0.05 * closed_Hz);
  EXPECT_NEAR(peak_Hz, closed_Hz, 0.05 * closed_Hz);
  EXPECT_GT(amplitude(drag_N, kRate_Hz, peak_Hz), 0.03);
  EXPECT_GT(stands_out, 5.0);
}

TEST(Scenes, TexturesAreSixDifferentThings) {
  // Strokes of 24 mm in 0.4 s: 60 mm/s, so 4 mm are 15 Hz, 2 mm 30 Hz, 1 mm 60 Hz. The way there, y being in
  // the middle.
  const std::vector<LogRow> rows = play("textures", true);
  const auto over = [&](int patch) { return between(rows, 0.82 + 1.4 * patch, 1.18 + 1.4 * patch); };
  struct Expected {
    const char* name;
    int patch;
    double frequency_Hz;
  };
  for (const Expected& e :
       {Expected{"egg boxes", 0, 15}, Expected{"ridges", 1, 30}, Expected{"grater", 5, 60}}) {
    const double peak_Hz = peak_frequency(column(over(e.patch), 2), kRate_Hz, 8, 100);
    figure(std::string("textures: ") + e.name + ", Hz at 60 mm/s", peak_Hz,
           std::to_string(e.frequency_Hz) + " within 10 %");
    EXPECT_NEAR(peak_Hz, e.frequency_Hz, 0.1 * e.frequency_Hz);
  }
  const auto drag = [&](int patch) { return -mean(column(over(patch), 0)) / mean(column(over(patch), 2)); };
  figure("textures: mean drag of the ridges over their push", drag(1), "0 within 0.05");
  figure("textures: mean drag of the rough ridges over their push", drag(2), "0.3 within 0.05");
  EXPECT_NEAR(drag(1), 0.0, 0.05);
  EXPECT_NEAR(drag(2), 0.3, 0.05);
  for (const int patch : {3, 4}) {
    const std::vector<LogRow> part = over(patch);
    double aside_N = 0;
    for (const LogRow& row : part) aside_N = std::max(aside_N, row.force_N.head<2>().norm());
    figure(std::string("textures: ") + (patch == 3 ? "turned normals" : "sandpaper") +
               ", largest force along the surface, N",
           aside_N, "> 0.3");
    EXPECT_GT(aside_N, 0.3);
  }
}

TEST(Scenes, SplineTissueShowsItsLump) {
  const std::vector<LogRow> rows = play("spline-tissue", true);
  std::vector<double> felt;  // at each dab's deepest
  for (int dab = 0; dab < 7; ++dab) {
    const LogRow deepest = between(rows, 0.7 + 0.6 * dab, 0.71 + 0.6 * dab).front();
    felt.push_back(deepest.force_N.z() / (-0.03 - deepest.tip_m.z()));
    figure("spline-tissue: stiffness felt at x = " + std::to_string(-0.03 + 0.01 * dab), felt.back(), "N/m");
  }
  EXPECT_EQ(std::max_element(felt.begin(), felt.end()) - felt.begin(), 4);
  EXPECT_GT(felt[4], 2.5 * felt[2]);
  EXPECT_GT(felt[0], 1.3 * felt[2]);
  // Once round, edge and flank of the lump, at constant depth.
  const std::vector<LogRow> round = between(rows, 6.8, 8.8001);
  double work_J = 0;
  double way_J = 0;
  for (std::size_t i = 1; i < round.size(); ++i) {
    const double step_J =
        0.5 * (round[i].force_N + round[i - 1].force_N).dot(round[i].tip_m - round[i - 1].tip_m);
    work_J += step_J;
    way_J += std::abs(step_J);
  }
  figure("spline-tissue: closed-path work over the work to and fro", std::abs(work_J) / way_J, "0.01");
  EXPECT_LT(std::abs(work_J), 0.01 * way_J);
}

}  // namespace
}  // namespace thimble::test

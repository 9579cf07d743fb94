// The limits of stable stiffness are those of docs/stability.md, and what is stiffer in a scene is told with its figures.
#include "host-tools/compiler/stable_stiffness.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <map>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

#include "host-tools/compiler/compile.h"
#include "tests/support/figure.h"

namespace thimble::test {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

// Rows of numbers by arm, the least of both hands.
std::map<std::string, std::vector<std::vector<double>>> tables_of_page() {
  std::ifstream page(THIMBLE_SOURCE_DIR "/docs/stability.md");
  std::map<std::string, std::vector<std::vector<double>>> tables;
  std::string arm;
  std::size_t row = 0;
  const std::regex head("## ([^,]+), .*");
  const std::regex cells("\\| ([0-9]+) \\| ([0-9]+) \\| ([0-9]+) \\| ([0-9]+) \\|");
  for (std::string line; std::getline(page, line);) {
    std::smatch found;
    if (std::regex_match(line, found, head)) {
      arm = found[1];
      row = 0;
    } else if (std::regex_match(line, found, cells)) {
      const std::vector<double> numbers = {std::stod(found[1]), std::stod(found[2]), std::stod(found[3]),
                                           std::stod(found[4])};
      std::vector<std::vector<double>>& table = tables[arm];
      if (row == table.size()) {
        table.push_back(numbers);
      } else {
        EXPECT_EQ(table[row][0], numbers[0]);
        for (std::size_t i = 1; i < numbers.size(); ++i) table[row][i] = std::min(table[row][i], numbers[i]);
      }
      ++row;
    }
  }
  return tables;
}

TEST(StableStiffness, IsThatOfThePage) {
  const auto page = tables_of_page();
  ASSERT_EQ(page.size(), host::stable_stiffness().size());
  int compared = 0;
  for (const host::StableStiffness& table : host::stable_stiffness()) {
    const auto rows = page.find(std::string(table.arm));
    ASSERT_NE(rows, page.end()) << table.arm;
    ASSERT_EQ(rows->second.size(), host::kStableDampings_N_s_m.size());
    for (std::size_t row = 0; row < rows->second.size(); ++row) {
      EXPECT_EQ(rows->second[row][0], host::kStableDampings_N_s_m[row]);
      for (std::size_t column = 0; column < host::kStableRates_Hz.size(); ++column) {
        const double page_N_m = rows->second[row][column + 1];
        EXPECT_EQ(table.most_N_m[row][column], page_N_m)
            << table.arm << ", row " << row << ", column " << column;
        EXPECT_EQ(host::stable_stiffness_N_m(table.arm, host::kStableRates_Hz[column],
                                             host::kStableDampings_N_s_m[row]),
                  page_N_m);
        ++compared;
      }
    }
  }
  EXPECT_GE(figure("figures compared with the page", compared, "24"), 24);
}

TEST(StableStiffness, IsInterpolated) {
  const auto at = [](double rate_Hz, double damping) {
    return host::stable_stiffness_N_m("premium-1.5", rate_Hz, damping).value_or(-1.0);
  };
  EXPECT_NEAR(at(2500, 0), 0.5 * (4600 + 11000), 1e-9);
  EXPECT_NEAR(at(7000, 0), 0.5 * (11000 + 23000), 1e-9);
  EXPECT_NEAR(at(1000, 3.5), 0.5 * (3800 + 1000), 1e-9);
  EXPECT_NEAR(at(2500, 3.5), 0.25 * (3800 + 1000 + 13000 + 6600), 1e-9);
  EXPECT_NEAR(at(500, 0), 2300, 1e-9) << "in proportion to the rate";
  EXPECT_EQ(at(20000, 0), 23000) << "as at 10 kHz";
  EXPECT_EQ(at(4000, 100), 6600) << "as at 5 N s/m";
  EXPECT_EQ(at(0, 0), -1) << "the rate is not known";
  EXPECT_FALSE(host::stable_stiffness_N_m("wooden", 4000, 0));
  double last = 0;
  for (double rate_Hz = 100; rate_Hz <= 20000; rate_Hz += 100) {
    EXPECT_GE(at(rate_Hz, 0), last);
    last = at(rate_Hz, 0);
  }
}

TEST(StableStiffness, WallsOfAnArmNeedNotBeATable) {
  using host::HeldWall;
  const std::vector<HeldWall> walls{{4000, 2, 500}, {4000, 0, 900}, {1000, 1, 100}};
  const auto at = [&walls](double rate_Hz, double damping) {
    return host::stable_stiffness_N_m(walls, rate_Hz, damping).value_or(-1.0);
  };
  EXPECT_EQ(at(4000, 0), 900);
  EXPECT_EQ(at(4000, 1), 700);
  EXPECT_EQ(at(4000, 5), 500) << "as at the largest damping";
  EXPECT_EQ(at(8000, 2), 500) << "as at the highest rate";
  EXPECT_EQ(at(1000, 0), 100) << "one damping is known there";
  EXPECT_EQ(at(500, 0), 50) << "in proportion to the rate";
  EXPECT_EQ(at(2500, 0), 500);
  EXPECT_EQ(host::stable_stiffness_N_m(std::span<const HeldWall>(), 4000, 0), std::nullopt);
}

std::vector<std::string> warnings_of(const std::string& objects, const std::string& arms, double rate_Hz) {
  return host::stiffness_warnings(
      host::compile_scene_text(R"({"thimble_scene": 1, "name": "test", "objects": [)" + objects + "]}",
                               "test", ".")
          .image,
      arms, rate_Hz);
}

TEST(StableStiffness, WhatIsStifferIsAWarning) {
  const std::string soft =
      R"({"name": "soft", "shape": {"sphere": {"radius_m": 0.01}}, "material": {"stiffness_N_m": 11000}})";
  const std::string stiff =
      R"({"name": "stiff", "shape": {"plane": {"normal": [0, 0, 1]}}, "material": {"stiffness_N_m": 12000, "damping_N_s_m": 0.5}})";
  EXPECT_THAT(warnings_of(soft, "premium-1.5", 4000), IsEmpty());
  EXPECT_THAT(
      warnings_of(soft + "," + stiff, "premium-1.5", 4000),
      ElementsAre(
          "stiff: 12000 N/m with a damping of 0.5 N s/m can oscillate; premium-1.5 at 4000 Hz holds up to "
          "11000 N/m (docs/stability.md)"));
  EXPECT_EQ(warnings_of(soft + "," + stiff, "premium-1.5", 1000).size(), 2U);
  EXPECT_THAT(warnings_of(soft + "," + stiff, "premium-1.5", 10000), IsEmpty());
  EXPECT_EQ(warnings_of(stiff, "premium-1.5,premium-1.5", 4000).size(), 1U) << "two arms of a kind";
  EXPECT_EQ(warnings_of(stiff, "premium-1.5,wooden", 4000).size(), 1U);
  EXPECT_THAT(warnings_of(stiff, "wooden", 4000), IsEmpty()) << "there is no table for it";
  const std::string damped =
      R"({"name": "damped", "shape": {"plane": {"normal": [0, 0, 1]}}, "material": {"stiffness_N_m": 1000, "damping_N_s_m": 10}})";
  EXPECT_THAT(
      warnings_of(damped, "premium-1.5", 4000),
      ElementsAre("damped: a damping of 10 N s/m can oscillate; premium-1.5 is known to hold up to 5 N s/m "
                  "(docs/stability.md)"));
  EXPECT_THAT(warnings_of(damped, "wooden", 4000), IsEmpty());
  const std::vector<host::ArmWalls> none{{.arm = "own", .walls = {{4000, 2, 0}}, .source = "its file"}};
  EXPECT_THAT(host::stiffness_warnings(
                  host::compile_scene_text(
                      R"({"thimble_scene": 1, "name": "test", "objects": [)" + soft + "]}", "test", ".")
                      .image,
                  none, 4000),
              ElementsAre("soft: 11000 N/m with a damping of 0 N s/m can oscillate; own at 4000 Hz holds up "
                          "to 0 N/m (its file)"))
      << "an arm that holds no wall";
  EXPECT_THAT(host::stiffness_warnings({}, "premium-1.5", 4000), IsEmpty());
}

TEST(StableStiffness, MapsBodiesAndControlsCount) {
  const auto first = [](const std::string& object) {
    const std::vector<std::string> all = warnings_of(object, "premium-1.5", 4000);
    return all.empty() ? "" : all.front();
  };
  EXPECT_THAT(
      first(
          R"({"name": "map", "shape": {"box": {"size_m": [0.1, 0.1, 0.1]}}, "material": {"stiffness_N_m": 500,
      "stiffness_map": {"stiffness_N_m": [[500, 500], [500, 20000]], "damping_N_s_m": [[1, 1], [1, 5]], "cell_m": 0.01}}})"),
      testing::HasSubstr(
          "map: 20000 N/m with a damping of 5 N s/m can oscillate; premium-1.5 at 4000 Hz holds up to 6600"));
  EXPECT_THAT(
      first(R"({"name": "body", "shape": {"sphere": {"radius_m": 0.01}}, "material": {"stiffness_N_m": 15000},
      "body": {"motion": "free", "mass_kg": 0.1}})"),
      testing::HasSubstr("body: 15000"));
  EXPECT_THAT(
      first(
          R"({"name": "key", "shape": {"box": {"size_m": [0.02, 0.02, 0.01]}}, "material": {"stiffness_N_m": 15000},
      "body": {"motion": "slide", "mass_kg": 0.1, "axis": [0, 0, 1], "control": {"stiffness_N_m": 300}}})"),
      testing::HasSubstr("key: 15000"));
  EXPECT_THAT(first(R"({"name": "skin", "material": {"stiffness_N_m": 600}, "shape": {"needle": {"layers": [
      {"thickness_m": 0.005, "stiffness_N_m": 500, "tear_N": 1},
      {"thickness_m": 0.005, "stiffness_N_m": 90000, "tear_N": 5}]}}})"),
              testing::HasSubstr("skin: 90000 N/m with a damping of 0 N s/m"));
  EXPECT_EQ(first(R"({"name": "field", "material": {"stiffness_N_m": 50000}, "shape": {"potential_field": {
      "shape": {"sphere": {"radius_m": 0.01}}, "step_m": 0.002, "source_per_m": 100}}})"),
            "");
}

}  // namespace
}  // namespace thimble::test

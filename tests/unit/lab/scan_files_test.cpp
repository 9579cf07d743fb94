// The plan and the log: what they refuse, and that a log truncated at any point can be resumed.
#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include "host-tools/error.h"
#include "host-tools/lab/scan_log.h"
#include "host-tools/lab/scan_plan.h"
#include "tests/support/temporary_folder.h"

namespace thimble::test {
namespace {

using host::Error;
using host::ExitCode;
using host::ProbedMove;
using host::ProbedStep;
using host::read_scan_plan_text;
using host::ScanLog;
using host::ScanPlan;

const std::string kPlan = R"({
  "thimble_scan": 1,
  "name": "pad",
  "origin_m": [-0.01, -0.01, -0.02],
  "u": [2, 0, 0],
  "v": [0, 1, 0],
  "columns": 3,
  "rows": 2,
  "cell_m": 0.01,
  "clearance_m": 0.003,
  "depth_m": 0.01,
  "force_limit_N": 1.5,
  "speed_m_s": 0.02
})";

std::string with(const std::string& from, const std::string& to) {
  std::string text = kPlan;
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

TEST(ScanPlanFile, IsRead) {
  const ScanPlan plan = read_scan_plan_text(kPlan, "plan.json");
  EXPECT_EQ(plan.points(), 6U);
  EXPECT_EQ(plan.approach, Eigen::Vector3d(0, 0, -1));
  EXPECT_EQ(plan.u, Eigen::Vector3d(1, 0, 0));
  EXPECT_TRUE(plan.measure_damping);
  ASSERT_EQ(plan.sites().size(), 2U);
  EXPECT_EQ(plan.sites()[1], Eigen::Vector2d(1.5, .5)) << "the middle of a cell";
  const ScanPlan given = read_scan_plan_text(
      with("\"rows\": 2", R"("rows": 2, "material": {"damping_N_s_m": 1, "static_friction": 0.4})"),
      "plan.json");
  EXPECT_FALSE(given.measure_damping);
  EXPECT_TRUE(given.sites().empty()) << "what the plan gives is not measured";
  EXPECT_EQ(plan.travel_speed_m_s, static_cast<double>(.05F));
  EXPECT_TRUE(plan.place_m(2, 1).isApprox(Eigen::Vector3d(.01, 0, -.02)));
  // There and back again: neighbours in time are neighbours in space.
  for (std::size_t point = 1; point < plan.points(); ++point) {
    const Eigen::Vector3d step = plan.place_m(plan.column_of(point), plan.row_of(point)) -
                                 plan.place_m(plan.column_of(point - 1), plan.row_of(point - 1));
    EXPECT_NEAR(step.norm(), .01, 1e-12) << point;
  }
}

TEST(ScanPlanFile, MistakesAreNamed) {
  struct Mistake {
    std::string text, pointer;
  };
  const Mistake kMistakes[] = {
      {with("\"columns\": 3", "\"columns\": 1"), "/columns"},
      {with("\"columns\": 3", "\"columns\": 2.5"), "/columns"},
      {with("\"columns\": 3", "\"columns\": 3000"), "/columns"},
      {with("\"rows\": 2", "\"rows\": 2000"), "/rows"},
      {with("\"rows\": 2", "\"rows\": \"2\""), "/rows"},
      {with("[0, 1, 0]", "[1, 1, 0]"), "/v"},
      {with("[2, 0, 0]", "[0, 0, 0]"), "/u"},
      {with("\"cell_m\": 0.01", "\"cell_m\": 0"), "/cell_m"},
      {with("\"force_limit_N\": 1.5", "\"force_limit_N\": 5"), "/force_limit_N"},
      {with("\"speed_m_s\": 0.02", "\"speed_m_s\": 0.2"), "/speed_m_s"},
      {with("\"speed_m_s\": 0.02", "\"speed_m_s\": 0.02, \"approach\": [0, 0, 1]"), "/approach"},
      {with("\"speed_m_s\": 0.02", "\"speed_m_s\": 0.02, \"arm\": 2"), "/arm"},
      {with("\"speed_m_s\": 0.02", "\"speed_m_s\": 0.02, \"conservative\": 1"), "/conservative"},
      {with("\"speed_m_s\": 0.02", "\"speed_m_s\": 0.02, \"material\": {\"damping_N_s_m\": -1}"),
       "/material/damping_N_s_m"},
      {with("\"thimble_scan\": 1", "\"thimble_scan\": 2"), "/thimble_scan"},
      {with("\"depth_m\"", "\"deep_m\""), "/deep_m"},
      {with("\"rows\": 2", "\"rows\": 2, \"friction_sites\": 0"), "/friction_sites"},
      {with("\"rows\": 2", "\"rows\": 2, \"stroke_m\": 0.1"), "/stroke_m"},
      {with("\"rows\": 2", R"("rows": 2, "friction": true, "material": {"static_friction": 0.4})"),
       "/friction"},
  };
  for (const Mistake& mistake : kMistakes) {
    try {
      (void)read_scan_plan_text(mistake.text, "plan.json");
      ADD_FAILURE() << mistake.pointer << " was taken";
    } catch (const Error& error) {
      EXPECT_EQ(error.code, ExitCode::kBadInput);
      EXPECT_NE(error.cause.find(mistake.pointer), std::string::npos) << error.cause;
      EXPECT_NE(error.cause.find("plan.json:"), std::string::npos) << error.cause;
    }
  }
}

class ScanLogFile : public ::testing::Test {
 protected:
  const TemporaryFolder folder_;
  const std::filesystem::path file_ = folder_.path() / "log.csv";
  std::string text() const {
    std::ifstream in(file_);
    std::ostringstream out;
    out << in.rdbuf();
    return out.str();
  }
  void write(const std::string& text) const { std::ofstream(file_) << text; }
};

// 3 x 2 points and one site.
ScanPlan small_plan(std::uint32_t crc = 0xABCD) {
  ScanPlan plan = read_scan_plan_text(with("\"rows\": 2", "\"rows\": 2, \"friction_sites\": 1"), "plan.json");
  plan.crc = crc;
  return plan;
}

ProbedStep probed(std::size_t number) {
  ProbedStep step{number, {}};
  const std::size_t moves = small_plan().is_site(number) ? host::kSiteMoves : 1;
  for (std::size_t k = 0; k < moves; ++k) {
    ProbedMove move;
    for (int i = 0; i < 3; ++i) move.samples.push_back({i < 2, {.001 * i, .5, -.02}, .25 * i});
    move.force_limit = (number + k) % 2 == 0;
    move.turn_m = {.1, .2, .3};
    move.peak_force_N = 1.5;
    step.moves.push_back(move);
  }
  return step;
}

// Every point, two of the presses along the normal, and the site.
constexpr std::array<std::size_t, 9> kSteps = {0, 1, 2, 3, 4, 5, 7, 10, 12};

TEST_F(ScanLogFile, GoesOnWhereverItBrokeOff) {
  const ScanPlan plan = small_plan();
  ASSERT_EQ(plan.steps(), 13U);
  const auto complete = [](ScanLog& log) {
    for (const std::size_t step : kSteps)
      if (log.find(step) == nullptr) log.append(probed(step));
  };
  {
    ScanLog log(file_, plan, false);
    complete(log);
  }
  const std::string whole = text();
  for (std::size_t bytes = 0; bytes <= whole.size(); bytes += bytes < 300 ? 1 : 7) {
    write(whole.substr(0, bytes));
    {
      ScanLog log(file_, plan, true);
      complete(log);
    }
    ASSERT_EQ(text(), whole) << "broken off after " << bytes << " bytes";
  }
  const ScanLog again(file_, plan, true);
  ASSERT_EQ(again.steps().size(), kSteps.size());
  const ProbedMove& first = again.steps()[1].moves[0];
  EXPECT_EQ(first.samples.size(), 3U);
  EXPECT_TRUE(first.samples[1].out);
  EXPECT_NEAR(first.samples[1].force_N, .25, 1e-9);
  EXPECT_FALSE(first.force_limit);
  EXPECT_TRUE(again.steps()[2].moves[0].force_limit);
  EXPECT_EQ(again.find(6), nullptr);
  ASSERT_NE(again.find(12), nullptr);
  EXPECT_EQ(again.find(12)->moves.size(), host::kSiteMoves);
  EXPECT_NE(whole.find("\n12,out,"), std::string::npos);
}

TEST_F(ScanLogFile, IsNeverOverwrittenAndBelongsToItsPlan) {
  { ScanLog(file_, small_plan(1), false).append(probed(0)); }
  const std::string whole = text();
  const auto refused = [&](std::uint32_t crc, bool resume) {
    try {
      const ScanLog log(file_, small_plan(crc), resume);
      return std::string();
    } catch (const Error& error) {
      return error.name;
    }
  };
  EXPECT_EQ(refused(1, false), "log-exists");
  EXPECT_EQ(refused(2, true), "wrong-log");
  EXPECT_EQ(text(), whole);
  for (const char* row :
       {"2,press,0,0,0,0\n", "1,press,0,0,nan,0\n", "1,out,0,0,0,0\n", "12,press,0,0,0,0\n"}) {
    write(whole + row);
    EXPECT_EQ(refused(1, true), "bad-log") << row;
  }
}

}  // namespace
}  // namespace thimble::test

// Simulated arms with faults: each is named by a step that can see it, and no motor ever gives the tip more than 1 N or 0.1 m/s before step 7. Good arms
// pass. THIMBLE_COMMISSION_ARMS=200 build/release/bin/commission_test is the whole; without it each kind of fault comes once, on arms of which most
// have one axis, because the time goes into the simulation of the arms. Of the whole, THIMBLE_COMMISSION_ONLY=32,45,74 are these alone, or
// falcon those of that arm; THIMBLE_COMMISSION_SEED=2 is another whole.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>
#include <string>
#include <vector>

#include "host-tools/commission/planted.h"
#include "host-tools/commission/sim_bench.h"
#include "host-tools/commission/steps.h"
#include "tests/support/figure.h"
#include "tests/support/random.h"

namespace thimble::host {
namespace {

using enum ArmFault;
using test::Random;

ArmFile arm_named(const std::string& name) {
  const std::string folder = name == "five-bar-odrive" ? "docs/examples/five-bar" : "arms";
  std::ifstream in(std::filesystem::path(THIMBLE_SOURCE_DIR) / folder / (name + ".arm.json"));
  return read_arm_file({std::istreambuf_iterator<char>(in), {}}, name);
}

const std::array kArms{"premium-1.5", "wooden", "paddle", "pantograph", "falcon", "touch", "five-bar-odrive"};

// Of the long form; 0: the short form.
std::size_t arms_to_try() {
  const char* given = std::getenv("THIMBLE_COMMISSION_ARMS");
  return given == nullptr ? 0 : static_cast<std::size_t>(std::strtoul(given, nullptr, 10));
}

// Whether the long form is asked for this one, by its number or the name of its arm.
bool is_asked_for(std::size_t number, const std::string& arm) {
  const char* given = std::getenv("THIMBLE_COMMISSION_ONLY");
  if (given == nullptr) return true;
  std::istringstream only(given);
  for (std::string one; std::getline(only, one, ',');)
    if (one == arm || one == std::to_string(number)) return true;
  return false;
}

std::uint64_t seed_of_arms() {
  const char* given = std::getenv("THIMBLE_COMMISSION_SEED");
  return given == nullptr ? 1 : std::strtoull(given, nullptr, 10);
}

std::string text(const SimFault& fault, const ArmFile& arm) {
  std::string all(text_of(fault.fault).name);
  all += " at " + arm.axes[fault.axis].name;
  if (fault.other != fault.axis) all += " and " + arm.axes[fault.other].name;
  return all + " x " + std::to_string(fault.factor);
}

// Whether the finding names the fault: itself, or as one that looks the same.
bool names(const ArmFinding& found, const SimFault& fault) {
  const auto is_axis = [&](int axis) {
    return axis == static_cast<int>(fault.axis) || axis == static_cast<int>(fault.other);
  };
  if (found.fault != kLineIgnored && !is_axis(found.axis) && !is_axis(found.other)) return false;
  return found.fault == fault.fault || std::ranges::find(found.twins, fault.fault) != found.twins.end();
}

struct Outcome {
  std::vector<std::string> wrong;  // findings that name nothing that is there, and faults that nobody named
  std::vector<std::pair<ArmFault, int>> named;  // with the step
  std::size_t unknowable = 0;
  std::vector<std::string> notes;     // of step 8
  double force_N = 0, speed_m_s = 0;  // before step 7
};

// What no step can see: torque by inertia where the file has no weights, and a weak motor by its torque alone where no voltage is measured and no
// weight turns the joint.
bool is_knowable(const SimFault& fault, const Expectation& arm, bool measures_voltage) {
  if (fault.fault == kWrongInertia) return arm.knows_inertia();
  if (fault.fault == kWeakMotor)
    return measures_voltage || arm.knows_inertia() || arm.gravity_turns(fault.axis);
  return true;
}

// Steps 0 to `last`; what is found is repaired, and the step repeated.
Outcome commission(const ArmFile& arm, const std::vector<SimFault>& faults, const SimBenchOptions& options,
                   int last) {
  SimBench bench(arm, faults, options);
  const Expectation expected(arm);
  Known known;
  StepContext context{bench, expected, known};
  Outcome outcome;
  for (const Step& step : steps()) {
    if (step.number > last) break;
    if (step.number == 7) {
      outcome.force_N = bench.most_tip_force_N();
      outcome.speed_m_s = bench.most_tip_speed_m_s();
    }
    for (int repeats = 0; repeats < 5; ++repeats) {
      const StepResult result = step.run(context);
      if (!bench.plant().closed())
        outcome.wrong.push_back("step " + std::to_string(step.number) + ": the links parted");
      if (step.number == 8) outcome.notes = result.notes;
      if (result.passed) break;
      bool repaired = false;
      for (const ArmFinding& found : result.findings) {
        const auto there =
            std::ranges::find_if(bench.faults(), [&](const SimFault& fault) { return names(found, fault); });
        if (there == bench.faults().end()) {
          if (!repaired) outcome.wrong.push_back("step " + std::to_string(step.number) + ": " + found.text);
          continue;
        }
        outcome.named.emplace_back(there->fault, step.number);
        bench.mend(static_cast<std::size_t>(there - bench.faults().begin()));
        repaired = true;
      }
      if (!repaired) break;
      if (repeats == 4) outcome.wrong.push_back("step " + std::to_string(step.number) + " does not end");
    }
    if (!outcome.wrong.empty()) break;
  }
  for (const SimFault& fault : bench.faults()) {
    if (!is_knowable(fault, expected, options.measures_voltage)) {
      ++outcome.unknowable;
      // That nobody knows its torque is said.
      const std::string said = quoted(expected, fault.axis) + ": gravity hardly turns it";
      if (fault.fault == kWrongInertia ||
          std::ranges::any_of(outcome.notes, [&](const std::string& note) { return note.starts_with(said); }))
        continue;
    }
    outcome.wrong.push_back("not named: " + text(fault, arm));
  }
  if (outcome.force_N == 0) outcome.force_N = bench.most_tip_force_N();  // it did not come to step 7
  if (outcome.speed_m_s == 0) outcome.speed_m_s = bench.most_tip_speed_m_s();
  return outcome;
}

constexpr std::array kFaults{kEncoderSign,   kMotorSign,   kEncodersSwapped, kMotorsSwapped,
                             kJointsSwapped, kWrongCounts, kWrongRatio,      kDeadChannel,
                             kDeadEncoder,   kSlip,        kIndexOff,        kOpenWinding,
                             kDeadPhase,     kWeakMotor,   kWrongInertia,    kNoise};

SimFault some_fault(Random& random, const ArmFile& arm) {
  const auto pick = [&](auto... values) {
    const std::array all{values...};
    return all.at(random.below(all.size()));
  };
  SimFault fault;
  fault.axis = random.below(arm.axes.size());
  fault.other = fault.axis;
  do {
    fault.fault = kFaults.at(random.below(kFaults.size()));
  } while (arm.axes.size() < 2 && (fault.fault == kEncodersSwapped || fault.fault == kMotorsSwapped ||
                                   fault.fault == kJointsSwapped));
  if (fault.fault == kEncodersSwapped || fault.fault == kMotorsSwapped || fault.fault == kJointsSwapped)
    fault.other = (fault.axis + 1 + random.below(arm.axes.size() - 1)) % arm.axes.size();
  // An axis without a motor has none of these.
  const auto planted = std::ranges::find(planted_faults(), fault.fault, &PlantedFault::fault);
  if (planted->of_motor && !(arm.axes[fault.axis].drive && arm.axes[fault.other].drive))
    fault = {kEncoderSign, fault.axis, fault.axis};
  if (fault.fault == kWrongCounts) fault.factor = pick(.25, .5, 2.0, 4.0);
  if (fault.fault == kWrongRatio) fault.factor = pick(.75, .8, .88, 1.12, 1.2, 1.3, 1.5);
  if (fault.fault == kSlip) fault.factor = random.uniform(1, 3);
  if (fault.fault == kIndexOff) fault.factor = pick(-1.0, 1.0);
  if (fault.fault == kWeakMotor) fault.factor = pick(.5, .577, .6);
  if (fault.fault == kWrongInertia) fault.factor = random.uniform(1.5, 2.5);
  return fault;
}

// The hands of the simulation bring a delta to where its weight does not turn its first axis, near to where its links part: they hold the others still
// there, and the axis stays when they let it go. A repair leaves the links as they are, there and where the arm lies, and a
// plant that is placed there at once has them in the same way.
TEST(Commission, HandsBringADeltaToWhereItRests) {
  constexpr double kBeside_rad = .004;  // of the other axes: nearer to where they part, and they swing more
  const ArmFile arm = arm_named("falcon");
  const Expectation expected(arm);
  SimBench bench(arm, {{kMotorSign, 0, 0}, {kMotorSign, 1, 1}}, {.seed = 110});
  Prompt prompt;
  prompt.kind = Prompt::Kind::kRest;
  ASSERT_EQ(bench.ask(prompt), Answer::kDone);
  bench.mend(1);
  EXPECT_TRUE(bench.plant().closed());
  prompt.kind = Prompt::Kind::kPlace;
  for (const std::size_t axis : {0U, 1U, 0U, 0U}) {
    prompt.axis = axis;
    for (std::size_t j = 0; j < 3; ++j)
      prompt.place.at(j) =
          expected.balanced(axis)[static_cast<Eigen::Index>(j)] + (j == axis ? 0 : kBeside_rad);
    ASSERT_EQ(bench.ask(prompt), Answer::kDone);
    for (std::size_t j = 0; j < 3; ++j)
      EXPECT_NEAR(bench.plant().joints_rad()[static_cast<Eigen::Index>(j)], prompt.place.at(j), .0075)
          << axis << ", " << j;
    EXPECT_LT(bench.plant().joint_speeds_rad_s().cwiseAbs().maxCoeff(), .1) << axis;
    EXPECT_TRUE(bench.plant().closed()) << axis;
    board::AnyPlant placed(bench.truth());
    placed.place(bench.plant().joints_rad());
    EXPECT_LT((placed.force_point_m() - bench.plant().force_point_m()).norm(), 1e-9) << axis;
    if (!bench.faults().empty()) bench.mend(0);
  }
}

TEST(Commission, GoodArmsPass) {
  const std::size_t whole = arms_to_try();
  // Short: wooden; the others go through all steps when the faults below are repaired.
  const std::size_t first = whole == 0 ? 1 : 0, count = whole == 0 ? 2 : whole / 4;
  double force_N = 0, speed_m_s = 0;
  std::size_t passed = 0, tried = 0;
  for (std::size_t i = first; i < count; ++i) {
    const ArmFile arm = arm_named(kArms.at(i % kArms.size()));
    if (whole > 0 && !is_asked_for(i, arm.name)) continue;
    ++tried;
    const Outcome outcome = commission(arm, {}, {.seed = i + 1, .measures_voltage = i % 3 != 0}, 8);
    for (const std::string& wrong : outcome.wrong) ADD_FAILURE() << arm.name << " " << i << ": " << wrong;
    passed += outcome.wrong.empty();
    force_N = std::max(force_N, outcome.force_N);
    speed_m_s = std::max(speed_m_s, outcome.speed_m_s);
  }
  test::figure("good arms that passed steps 0 to 8", static_cast<double>(passed),
               "of " + std::to_string(tried));
  test::figure("largest force of the motors at the tip, N", force_N, "1");
  test::figure("largest speed, m/s", speed_m_s, "0.1");
  EXPECT_LT(force_N, 1);
  EXPECT_LT(speed_m_s, .1);
}

// Two faults of one axis that no step before 8 can tell apart, or of which one hides the other's figures.
bool is_told_apart(const SimFault& one, const SimFault& other) {
  if (one.axis != other.axis && one.axis != other.other && one.other != other.axis) return true;
  const auto of = [](const SimFault& fault, std::initializer_list<ArmFault> kinds) {
    return std::ranges::find(kinds, fault.fault) != kinds.end();
  };
  const auto both = [&](std::initializer_list<ArmFault> kinds) { return of(one, kinds) && of(other, kinds); };
  return !both({kWrongCounts, kWrongRatio}) && !both({kWeakMotor, kWrongInertia}) &&
         one.fault != other.fault && !both({kEncodersSwapped, kJointsSwapped}) &&
         !both({kMotorsSwapped, kJointsSwapped}) && !both({kDeadEncoder, kDeadChannel});
}

struct FaultyArm {
  ArmFile arm;
  std::vector<SimFault> faults;
  bool measures_voltage = true;
  std::uint64_t seed = 0;  // of the arm; 0: by its place in the list
};

// One or two faults.
FaultyArm some_faulty_arm(Random& random) {
  FaultyArm one{arm_named(kArms.at(random.below(kArms.size()))), {}};
  one.faults.push_back(some_fault(random, one.arm));
  if (random.below(2) == 0) {
    SimFault second = some_fault(random, one.arm);
    while (!is_told_apart(one.faults[0], second)) second = some_fault(random, one.arm);
    one.faults.push_back(second);
  }
  one.measures_voltage = random.below(3) != 0;
  return one;
}

// Every kind of fault once. The five-bar has no gear: its motors show a dead phase only a long way from home. It lies flat: without voltage nobody
// sees the other one's torque.
std::vector<FaultyArm> short_form() {
  const ArmFile premium = arm_named("premium-1.5"), wooden = arm_named("wooden"),
                paddle = arm_named("paddle"), five_bar = arm_named("five-bar-odrive");
  return {{premium, {{kEncodersSwapped, 0, 1}, {kSlip, 2, 2, 2}}},
          {premium, {{kMotorsSwapped, 1, 2}, {kWrongInertia, 0, 0, 2}}},
          {wooden, {{kJointsSwapped, 0, 2}, {kDeadPhase, 1, 1}}},
          {paddle, {{kEncoderSign}, {kWrongCounts, 0, 0, 4}}},
          {paddle, {{kMotorSign}, {kIndexOff, 0, 0, -1}}, false},
          {paddle, {{kDeadChannel}, {kWeakMotor, 0, 0, .577}}},
          {paddle, {{kDeadEncoder}, {kWrongRatio, 0, 0, 1.2}}, false},
          {paddle, {{kOpenWinding}, {kNoise}}},
          {paddle, {{kWeakMotor, 0, 0, .5}}, false, 53},  // a weight tells it
          {five_bar, {{kWeakMotor, 1, 1, .5}, {kDeadPhase, 0, 0}}, false, 33}};
}

TEST(Commission, FaultyArmsAreNamed) {
  Random random(seed_of_arms());
  std::vector<FaultyArm> arms;
  const std::size_t whole = arms_to_try();
  for (std::size_t i = 0; i < whole; ++i) arms.push_back(some_faulty_arm(random));
  if (whole == 0) {
    arms = short_form();
    for (const ArmFault kind : kFaults)
      EXPECT_TRUE(std::ranges::any_of(arms,
                                      [kind](const FaultyArm& one) {
                                        return std::ranges::find(one.faults, kind, &SimFault::fault) !=
                                               one.faults.end();
                                      }))
          << text_of(kind).name << " does not come";
  }
  double force_N = 0, speed_m_s = 0;
  std::size_t named = 0, unknowable = 0, faults_in_all = 0, tried = 0, two = 0;
  for (std::size_t i = 0; i < arms.size(); ++i) {
    const auto& [arm, faults, measures_voltage, seed] = arms[i];
    if (whole > 0 && !is_asked_for(i, arm.name)) continue;
    ++tried;
    two += faults.size() == 2;
    const Outcome outcome =
        commission(arm, faults, {.seed = seed == 0 ? i + 1 : seed, .measures_voltage = measures_voltage}, 8);
    faults_in_all += faults.size();
    named += outcome.named.size();
    unknowable += outcome.unknowable;
    std::string all;
    for (const SimFault& fault : faults) all += text(fault, arm) + "; ";
    for (const std::string& wrong : outcome.wrong)
      ADD_FAILURE() << arm.name << " " << i << " with " << all << ": " << wrong;
    if (outcome.force_N > 1 || outcome.speed_m_s > .1)
      ADD_FAILURE() << arm.name << " " << i << " with " << all << ": " << outcome.force_N << " N, "
                    << outcome.speed_m_s << " m/s";
    force_N = std::max(force_N, outcome.force_N);
    speed_m_s = std::max(speed_m_s, outcome.speed_m_s);
  }
  test::figure("arms with one or two faults", static_cast<double>(tried),
               "of them with two: " + std::to_string(two));
  test::figure("faults named by a step", static_cast<double>(named), "of " + std::to_string(faults_in_all));
  test::figure("largest force of the motors at the tip, N", force_N, "1");
  test::figure("largest speed, m/s", speed_m_s, "0.1");
  test::figure("inertias and torques that no step can see", static_cast<double>(unknowable), "not named");
  EXPECT_EQ(named + unknowable, faults_in_all);
}

}  // namespace
}  // namespace thimble::host

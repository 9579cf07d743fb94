#include "host-tools/cli/commissioned_arm.h"

#include <fmt/format.h>

#include <algorithm>
#include <random>

#include "host-tools/cli/open_remote.h"
#include "host-tools/cli/talking_bench.h"
#include "host-tools/commission/link_bench.h"
#include "host-tools/commission/planted.h"

namespace thimble::host {
namespace {

std::vector<SimFault> faults_of(const CommissionChoice& choice, const ArmFile& arm) {
  std::vector<SimFault> faults;
  faults.reserve(choice.faults.size());
  for (const std::string& text : choice.faults) {
    const SimFault fault = planted_fault(text, arm);
    const bool twice = std::ranges::any_of(faults, [&](const SimFault& other) {
      return other.fault == fault.fault && other.axis == fault.axis;
    });
    if (twice)
      throw Error(ExitCode::kUsage, "bad-fault", fmt::format("--fault {}: it is planted already", text),
                  "give each fault of an axis once");
    faults.push_back(fault);
  }
  return faults;
}

[[noreturn]] void not_this_arm(const std::string& cause, const std::string& remedy) {
  throw Error(ExitCode::kRefused, "other-arm", cause, remedy);
}

class SimulatedArm final : public CommissionedArm {
 public:
  SimulatedArm(const Common& common, const CommissionChoice& choice, const ArmFile& arm,
               const std::string& state, SecondPlace* second)
      : choice_(choice),
        state_(state),
        sim_(arm, faults_of(choice, arm), options(choice)),
        bench_(sim_, choice.ask, common.json, second) {}

  [[nodiscard]] Bench& bench() override { return bench_; }
  void begin_step(int /*number*/) override { bench_.begin_step(); }
  [[nodiscard]] bool stopped() const override { return bench_.stopped(); }
  [[nodiscard]] bool is_asked() const override { return choice_.ask; }
  void repaired(const StepResult& result) override {
    for (const ArmFinding& found : result.findings)
      if (const std::optional<std::size_t> fault = fault_behind(sim_.faults(), found)) sim_.mend(*fault);
  }
  [[nodiscard]] std::optional<PerAxis<std::int64_t>> counts() override {
    PerAxis<std::int64_t> counts{};
    const PerAxis<AxisReading> readings = sim_.read();
    for (std::size_t j = 0; j < counts.size(); ++j) counts.at(j) = readings.at(j).counts;
    return counts;
  }
  [[nodiscard]] Json identity() override { return {{"seed", choice_.seed}, {"faults", choice_.faults}}; }
  // A fault that is gone was repaired. One that is new may be of a step that has passed, and would not be seen.
  void demand_same(const Json& saved) override {
    const Json seed = saved.value("seed", Json()), faults = saved.value("faults", Json::array());
    if (saved.contains("device"))
      not_this_arm(fmt::format("the commissioning in {} is of a real arm", state_),
                   "leave --simulate out, or give another file with --state");
    if (seed != Json(choice_.seed))
      not_this_arm(
          fmt::format("the commissioning in {} is of the simulated arm with --seed {}", state_, seed.dump()),
          "give that seed, or begin anew with --restart");
    for (const std::string& fault : choice_.faults) {
      if (choice_.step || std::ranges::find(faults, Json(fault)) != faults.end()) continue;
      not_this_arm(
          fmt::format("--fault {}: the arm of the commissioning in {} does not have it, and the step "
                      "that sees it may have passed",
                      fault, state_),
          "begin anew with --restart, or do one step again with --step");
    }
  }

 private:
  static SimBenchOptions options(const CommissionChoice& choice) {
    SimBenchOptions options;
    options.seed = choice.seed;
    options.accepts_corrections = choice.accept_corrections;
    // The counters of the simulated arm begin anew with each program.
    options.session = fmt::format("simulated {:08x}", std::random_device{}());
    return options;
  }

  const CommissionChoice& choice_;
  const std::string& state_;
  SimBench sim_;
  TalkingBench bench_;
};

class ConnectedArm final : public CommissionedArm {
 public:
  ConnectedArm(const Remote& remote, const CommissionChoice& choice, const ArmFile& arm,
               const std::string& state, SecondPlace* second)
      : state_(state),
        person_(second),
        link_([&remote] { return open_remote(remote); }, person_, static_cast<std::uint8_t>(choice.arm),
              arm) {}

  [[nodiscard]] Bench& bench() override { return link_; }
  void begin_step(int number) override { link_.begin_step(number); }
  [[nodiscard]] bool stopped() const override { return person_.stopped(); }
  [[nodiscard]] bool is_asked() const override { return true; }
  void repaired(const StepResult& /*result*/) override {}
  [[nodiscard]] std::optional<PerAxis<std::int64_t>> counts() override { return link_.newest_counts(); }
  [[nodiscard]] Json identity() override { return {{"device", link_.device_name()}}; }
  void demand_same(const Json& saved) override {
    const std::string device = saved.value("device", std::string());
    if (device.empty())
      not_this_arm(fmt::format("the commissioning in {} is of a simulated arm", state_),
                   "begin anew with --restart, or give another file with --state");
    if (device != link_.device_name())
      not_this_arm(fmt::format("the commissioning in {} is of the device {}, and this is {}", state_, device,
                               link_.device_name()),
                   "connect that device, or begin anew with --restart");
  }

 private:
  const std::string& state_;
  ConsolePerson person_;
  LinkBench link_;
};

}  // namespace

std::unique_ptr<CommissionedArm> commissioned_arm(const Common& common, const Remote& remote,
                                                  const CommissionChoice& choice, const ArmFile& arm,
                                                  const std::string& state, SecondPlace* second) {
  if (choice.simulate) return std::make_unique<SimulatedArm>(common, choice, arm, state, second);
  return std::make_unique<ConnectedArm>(remote, choice, arm, state, second);
}

}  // namespace thimble::host

// The steps of a commissioning. Each can be done alone, as long as those before it that it builds on were done; each judges by its own limits and
// names the fault that it sees. Steps 0 to 6 never ask for more than kTorqueShare, kTipForce_N and kTipSpeed_m_s (expectation.h).
#pragma once

#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "host-tools/commission/bench.h"
#include "host-tools/commission/expectation.h"
#include "host-tools/commission/faults.h"

namespace thimble::host {

// A number that a step measured. NaN: not known.
struct Measure {
  std::string name;  // "coulomb_N_m"
  int axis = -1;     // -1: of the whole arm
  double given = std::numeric_limits<double>::quiet_NaN();
  double value = std::numeric_limits<double>::quiet_NaN();
  double spread = 0;    // over the runs
  double residual = 0;  // what the model does not explain, of the whole
  double promise =
      0;  // the accuracy that the method has, relative; a value whose spread is above it is not written to the file
  // Of a wall: ticks a second, and B.
  double rate_Hz = std::numeric_limits<double>::quiet_NaN();
  double damping_N_s_m = std::numeric_limits<double>::quiet_NaN();
};

struct StepResult {
  bool passed = false;
  bool stopped = false;  // the builder gave up
  std::vector<ArmFinding> findings{};
  std::vector<Measure> measures{};
  std::vector<std::string> notes{};
};

// What later steps need of earlier ones.
struct Known {
  std::string session;                      // of the counters; another one: step 2 must be done again
  PerAxis<double> at_zero{};                // angle of the axis where its counter is 0
  PerAxis<double> torque_constant_N_m_A{};  // by back-EMF; 0: not measured
  PerAxis<bool> has_torque_scale{};         // by a weight
  PerAxis<std::optional<board::JointVector>>
      resting{};  // where an axis stays, of an arm of unknown weight; not saved
};

struct StepContext {
  Bench& bench;
  const Expectation& arm;
  Known& known;
};

struct Step {
  int number;
  std::string_view name;  // "motor-signs"
  std::string_view text;  // what it proves, for people
  bool needs_place;       // step 2 in this session
  StepResult (*run)(StepContext& context);
};
[[nodiscard]] std::span<const Step> steps() noexcept;  // 0 to 10

// Of the stiffest wall that step 10 found: what is written to the file.
inline constexpr double kWallMargin = .5;

StepResult prove_lines(StepContext& context);
StepResult prove_quiet(StepContext& context);
StepResult prove_encoders(StepContext& context);
StepResult prove_marks(StepContext& context);
StepResult prove_currents(StepContext& context);
StepResult prove_motors(StepContext& context);
StepResult prove_damping(StepContext& context);
StepResult prove_directions(StepContext& context);
StepResult prove_weight(StepContext& context);
StepResult identify(StepContext& context);
StepResult find_walls(StepContext& context);

// "'upper'"; "up and to the right"
[[nodiscard]] std::string quoted(const Expectation& arm, std::size_t axis);
// With a capital: "exchange the wires" as "Exchange the wires".
[[nodiscard]] std::string sentence(std::string_view text);
[[nodiscard]] std::string towards(const Eigen::Vector3d& direction);
// The sentence of a finding: joint, what, figures, remedy.
[[nodiscard]] ArmFinding finding(const Expectation& arm, ArmFault fault, std::size_t axis,
                                 const std::string& figures, double factor = 1);
// The same of the whole arm. subject: what it is about, "The e-stop".
[[nodiscard]] ArmFinding finding(ArmFault fault, std::string_view subject, const std::string& figures);
[[nodiscard]] Prompt prompt(Prompt::Kind kind, std::size_t axis, std::string text);
// All axes to `place`, with `axis` let go.
[[nodiscard]] Answer place(StepContext& context, std::size_t axis, const board::JointVector& at);
// All axes to `place`, and held there.
[[nodiscard]] Answer hold(StepContext& context, const board::JointVector& at);
[[nodiscard]] board::JointVector angles(const StepContext& context, const PerAxis<std::int64_t>& counts);

}  // namespace thimble::host

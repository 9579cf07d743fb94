#include "host-tools/commission/steps.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace thimble::host {
namespace {

constexpr std::array kSteps{
    Step{0, "lines", "e-stop, dead man and watchdog take the drives' enable away", false, prove_lines},
    Step{1, "quiet", "encoders are quiet at rest, with the drives off and on", false, prove_quiet},
    Step{2, "encoders",
         "each encoder is at its joint, counts the right way, and as many counts as the file says", false,
         prove_encoders},
    Step{3, "marks", "the home marks are where the file says, and are found again", true, prove_marks},
    Step{4, "currents", "windings, plugs and current loops", true, prove_currents},
    Step{5, "motors",
         "each motor is at its joint, turns it the right way, with the torque that the file says", true,
         prove_motors},
    Step{6, "damping", "a damper takes energy from a moving arm", true, prove_damping},
    Step{7, "directions", "the tip moves where it is pushed, and a spring opposes", true, prove_directions},
    Step{8, "weight", "gravity, and the scale of the torques", true, prove_weight},
    Step{9, "identify", "friction, inertia, stiffness, first resonance and delay", true, identify},
    Step{10, "walls", "the stiffest wall that the arm holds", true, find_walls},
};

}  // namespace

std::span<const Step> steps() noexcept { return kSteps; }

std::string quoted(const Expectation& arm, std::size_t axis) { return "'" + arm.axis(axis).name + "'"; }

std::string towards(const Eigen::Vector3d& direction) {
  struct Word {
    int axis;
    double sign;
    const char* text;
  };
  constexpr std::array kWords{
      Word{0, 1, "to the right"}, Word{0, -1, "to the left"}, Word{1, 1, "away from you"},
      Word{1, -1, "towards you"}, Word{2, 1, "up"},           Word{2, -1, "down"}};
  std::string text;
  for (const Word& word : kWords) {
    if (word.sign * direction[word.axis] < .35) continue;
    if (!text.empty()) text += " and ";
    text += word.text;
  }
  return text;
}

std::string sentence(std::string_view text) {
  std::string written(text);
  if (!written.empty() && written.front() >= 'a' && written.front() <= 'z')
    written.front() = static_cast<char>(written.front() - 'a' + 'A');
  return written;
}

ArmFinding finding(const Expectation& arm, ArmFault fault, std::size_t axis, const std::string& figures,
                   double factor) {
  ArmFinding found = finding(fault, quoted(arm, axis), figures);
  found.axis = static_cast<int>(axis);
  found.factor = factor;
  return found;
}

ArmFinding finding(ArmFault fault, std::string_view subject, const std::string& figures) {
  const FaultText& text = text_of(fault);
  ArmFinding found;
  found.fault = fault;
  found.text = fmt::format("{}: {} ({}). {}.", subject, text.what, figures, sentence(text.remedy));
  return found;
}

Prompt prompt(Prompt::Kind kind, std::size_t axis, std::string text) {
  Prompt made;
  made.kind = kind;
  made.axis = axis;
  made.text = std::move(text);
  return made;
}

namespace {

Answer bring_to(StepContext& context, std::size_t axis, const board::JointVector& at) {
  std::string text = "Bring the arm to";
  Prompt asked = prompt(Prompt::Kind::kPlace, axis, {});
  for (std::size_t j = 0; j < context.arm.axes(); ++j) {
    const double value = at[static_cast<Eigen::Index>(j)];
    asked.place.at(j) = value;
    text += context.arm.axis(j).is_prismatic
                ? fmt::format(" {} {:.0f} mm,", quoted(context.arm, j), 1e3 * value)
                : fmt::format(" {} {:.0f} degrees,", quoted(context.arm, j), value * 180 / std::numbers::pi);
  }
  asked.text = text + (axis < context.arm.axes() ? fmt::format(" hold the other joints still, and let {} go.",
                                                               quoted(context.arm, axis))
                                                 : std::string(" and hold it there."));
  return context.bench.ask(asked);
}

}  // namespace

Answer place(StepContext& context, std::size_t axis, const board::JointVector& at) {
  return bring_to(context, axis, at);
}

Answer hold(StepContext& context, const board::JointVector& at) {
  return bring_to(context, context.arm.axes(), at);
}

board::JointVector angles(const StepContext& context, const PerAxis<std::int64_t>& counts) {
  board::JointVector at(static_cast<Eigen::Index>(context.arm.axes()));
  for (std::size_t j = 0; j < context.arm.axes(); ++j)
    at[static_cast<Eigen::Index>(j)] =
        context.known.at_zero.at(j) + static_cast<double>(counts.at(j)) * context.arm.axis(j).per_count();
  return at;
}

}  // namespace thimble::host

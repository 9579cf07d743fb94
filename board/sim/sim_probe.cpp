#include "board/sim/sim_probe.h"

#include <cmath>
#include <string>
#include <utility>

#include "board/sim/verdict_text.h"
#include "firmware/sources/guarded_move_link.h"

namespace thimble::board {
namespace {

namespace link = firmware::link;
using firmware::Controller;

constexpr double kHoming_s = 60, kArming_s = 2;
constexpr double kLongestMove_s = 600;  // the longest way in and back at the lowest speed

SimBoardOptions alone(SimBoardOptions options) {
  options.hand = kNoHand;
  return options;
}

}  // namespace

SimProbe::SimProbe(SimBoardOptions options, std::span<const std::byte> image)
    : board_(alone(std::move(options))) {
  Controller& controller = board_.controller();
  if (controller.load_scene(image) != firmware::StoreStatus::kOk)
    fail("the scene was refused: " + text_of(controller.store().image_verdict()));
  tick();
  const auto until = [this](double most_s, auto&& condition) {
    for (long left = std::lround(most_s * board_.options().rate_Hz); left > 0 && !condition(); --left) tick();
    return condition();
  };
  if (controller.request(firmware::Command::kHome) != 0 ||
      !until(kHoming_s, [&] { return controller.mode() == firmware::Mode::kReady; }))
    fail("the controller did not home");
  if (controller.write_param(firmware::find_param("allow_moves")->id, 1) != firmware::ParamStatus::kOk ||
      controller.request(firmware::Command::kArm) != 0 ||
      !until(kArming_s, [&] { return controller.telemetry().ramp >= 1.0F; }))
    fail("the controller did not arm");
}

SimProbe::Result SimProbe::move(const link::MoveOrder& order) {
  Controller& controller = board_.controller();
  const firmware::MoveOrder wanted = firmware::from_link(order);
  if (!controller.move_in_range(wanted)) fail("the move's values are out of range");
  const firmware::Conditions against = controller.request_move(wanted);
  if (against != 0) {
    std::string names;
    for (const firmware::ConditionRow& row : firmware::kConditionTable)
      if ((against & row.bit) != 0) names += std::string(names.empty() ? "" : ",") + row.name;
    fail("the move was refused: " + names);
  }
  tick();
  for (long left = std::lround(kLongestMove_s * board_.options().rate_Hz);
       left > 0 && controller.move_results() == nullptr; --left)
    tick();
  const firmware::MoveResults* results = controller.move_results();
  if (results == nullptr) fail("the move did not end");
  if (controller.fault() != firmware::Fault::kNone) fail("the controller tripped");
  Result result{controller.move_state(), {}};
  for (const firmware::MoveSample& sample : results->going.samples())
    result.samples.push_back(firmware::to_link(link::MovePhase::kGoing, sample));
  for (const firmware::MoveSample& sample : results->coming_back.samples())
    result.samples.push_back(firmware::to_link(link::MovePhase::kComingBack, sample));
  return result;
}

void SimProbe::tick() {
  board_.controller().keep_alive();
  board_.tick();
}

void SimProbe::fail(const std::string& what) {
  const firmware::FaultRow* fault = firmware::find_fault(board_.controller().fault());
  throw ProbeError(fault == nullptr ? what : what + ": " + fault->cause);
}

}  // namespace thimble::board

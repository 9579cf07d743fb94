// The conditions of a tick, from its inputs and state.
#include "firmware/core/conditions.h"

#include "firmware/core/steps.h"

namespace thimble::firmware {

Conditions unmet_conditions(const Parts& parts, const Inputs& inputs) noexcept {
  const State& state = parts.state;
  if (parts.setup.arm_count == 0) return kBadConfig | kFaultLatched;
  unsigned unmet = 0;
  for (std::size_t i = 0; i < parts.setup.arm_count; ++i) {
    const ArmState& arm = state.arm[i];
    if (!arm.homed) unmet |= kNotHomed;
    if (arm.age_ticks > stale_ticks(parts)) unmet |= kEncoderStale;
    if (arm.homed && !arm.in_workspace) unmet |= kOutsideWorkspace;
    if (inputs.arm[i].drive_fault) unmet |= kDriveFault;
  }
  if (state.fault != Fault::kNone) unmet |= kFaultLatched;
  if (!inputs.dead_man) unmet |= kDeadManOpen;
  if (parts.sources.scene.sequence() == 0 && parts.sources.wanted(parts.params).needs().scene)
    unmet |= kNoScene;
  if (!state.link_seen) unmet |= kLinkDown;
  if (inputs.e_stop) unmet |= kEStopPressed;
  if (parts.setup.board_lacks) unmet |= kBoardLacks;
  if (parts.heat.not_kept.get()) unmet |= kStoreFails;
  // The first comparison spares other arms the reading of a parameter.
  if (parts.setup.uncommissioned_N > kUncommissioned_N &&
      too_strong(parts.setup, parts.params, parts.params.get(Param::max_force)))
    unmet |= kNotCommissioned;
  if (state.mode == Mode::kHoming || state.mode == Mode::kDamping) unmet |= kWrongMode;
  return unmet;
}

Conditions unmet_for_move(const Parts& parts, Conditions unmet) noexcept {
  constexpr CommandRow kRow = *find_command(Command::kMove);
  const State& state = parts.state;
  if (parts.setup.arm_count == 0) return unmet;
  unsigned against = unmet & kRow.refused_by;
  if (!contains(kRow.accepted_in, state.mode)) against |= kNotArmed;
  if (!parts.params.on(Param::allow_moves)) against |= kMovesNotAllowed;
  if (parts.params.on(Param::host_forces)) against |= kHostRenders;
  if (host_silence_s(parts) > link::kMoveHostTimeout_s) against |= kLinkDown;
  if (state.mode == Mode::kArmed && state.force_ramp < 1.0F && !state.guest) against |= kRampRuns;
  if (state.guest && (parts.sources.move.under_way() || parts.sources.axes.under_way()))
    against |= kMoveUnderWay;
  if (!state.guest && state.in_contact) against |= kInContact;
  return against;
}

}  // namespace thimble::firmware

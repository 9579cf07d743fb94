// What the board measures besides the counts, held against what the tick knows. A board that measures none of it loses these checks.
#include <algorithm>
#include <cmath>

#include "firmware/core/steps.h"

namespace thimble::firmware {
namespace {

// A current settles in a fraction of a millisecond; a tenth of the peak is more than an amplifier's offset and gain error.
constexpr float kCurrentOff = 0.1F, kCurrentTime_s = 1e-3F;
constexpr float kSupplyLow = 0.8F, kSupplyHigh = 1.2F, kSupplyTime_s = 5e-3F;  // of the arm's nominal supply
constexpr float kIndex_rad = 0.01F;  // an index is narrower; 2 mm at the tip

bool current_is_off(const ArmState& arm, const ArmEvidence& evidence,
                    const kinematics::ArmData& data) noexcept {
  for (std::size_t j = 0; j < arm.axes; ++j)
    if (std::abs(evidence.current_A[j] - arm.current_A[static_cast<int>(j)]) >
        kCurrentOff * data.axis[j].motor.peak_current_A)
      return true;
  return false;
}

}  // namespace

void check_evidence(Parts& parts, std::size_t index, const ArmInputs& input) noexcept {
  ArmState& arm = parts.state.arm[index];
  const kinematics::ArmData& data = parts.setup.arm[index].data();
  const ArmEvidence& evidence = input.evidence;
  const float period_s = parts.setup.period_s;
  if (input.drive_fault) trip(parts, Fault::drive_fault);
  if (evidence.line_loss) {
    if (arm.homed || parts.state.mode == Mode::kHoming) trip(parts, Fault::encoder_line);
    lose_home(arm);
  }
  // NaN, of a board that does not measure it, is never beyond a limit.
  const bool current_off = current_is_off(arm, evidence, data);
  if (arm.current_off.update(current_off, std::max(kCurrentTime_s, 3 * period_s), period_s))
    trip(parts, Fault::current_mismatch);
  const float supply = evidence.supply_V / data.supply_V;
  const bool supply_off = motors_on(parts.state.mode) && (supply < kSupplyLow || supply > kSupplyHigh);
  if (arm.supply_off.update(supply_off, kSupplyTime_s, period_s)) trip(parts, Fault::supply);
}

void check_index(Parts& parts, std::size_t index, const ArmInputs& input) noexcept {
  ArmState& arm = parts.state.arm[index];
  if (!arm.homed || !input.index || !parts.setup.has_index[index]) return;
  const Axes off = arm.joint_rad - parts.setup.arm[index].home();
  float most = 0;
  for (int j = 0; j < parts.setup.arm[index].axes(); ++j) most = std::max(most, std::abs(off[j]));
  if (most <= kIndex_rad) return;
  trip(parts, Fault::index_mismatch);
  lose_home(arm);
}

}  // namespace thimble::firmware

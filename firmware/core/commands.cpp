#include "firmware/core/commands.h"

#include <algorithm>
#include <cmath>

namespace thimble::firmware {
namespace {

constexpr float kWorkspaceMargin_rad = 0.05F;  // of a move's target
constexpr float kMostDriven_s = 60, kMostCoast_s = 5, kMostTone_Hz = 1000;

bool is_amount(float value) noexcept { return value >= 0 && std::isfinite(value); }
bool within(float value, float low, float high) noexcept { return value >= low && value <= high; }

}  // namespace

Conditions Commands::request(Command command) noexcept {
  if (command == Command::kStop) {
    stops_.add();
    return 0;
  }
  if (command == Command::kMove) return kWrongMode;  // without an order
  const CommandRow* row = find_command(command);
  if (row == nullptr) return 0;
  const Mode mode = status_.mode();
  const bool shows_life = alive_.get() != status_.alive();  // since that tick: the next one decides
  // Arming may do without a scene, where the host renders; a recording may not.
  const Conditions unmet = (command == Command::kArm ? status_.unmet() : status_.unmet_of_tick()) &
                           ~(shows_life ? kLinkDown : Conditions{0});
  switch (row->nothing_to_do) {
    case CommandRow::NothingToDo::kNever:
      break;
    case CommandRow::NothingToDo::kWhenArmed:
      if (mode == Mode::kArmed && !disarm_due()) return 0;
      break;
    case CommandRow::NothingToDo::kWithoutFault:
      if (status_.fault() == Fault::kNone) return 0;
      break;
  }
  const Conditions refused =
      (unmet & row->refused_by) | (contains(row->accepted_in, mode) ? Conditions{0} : Conditions{kWrongMode});
  if (refused != 0) return refused;
  if (command == Command::kDisarm) {
    disarms_.add();
  } else if (disarm_due() && yields_to_disarm(command)) {
    return kWrongMode;
  }
  channel_.post(command);  // a disarm, too: it replaces what was posted before it
  return 0;
}

bool Commands::move_in_range(const MoveOrder& order) const noexcept {
  if (order.arm >= setup_.arm_count || !std::isfinite(order.target_m.squaredNorm())) return false;
  const float max_N = std::min(params_.get(Param::max_force), setup_.arm[order.arm].data().max_force_N);
  return order.speed_m_s >= link::kMinMoveSpeed_m_s && order.speed_m_s <= link::kMaxMoveSpeed_m_s &&
         order.force_limit_N >= link::kMinMoveForce_N && order.force_limit_N <= link::kMaxMoveForce_N &&
         order.force_limit_N + GuardedMove::kForceMargin_N <= max_N;
}

Conditions Commands::request_move(const MoveOrder& order) noexcept {
  if (disarm_due()) return kWrongMode;
  if (pending()) return kMoveUnderWay;
  unsigned refused = status_.unmet_for_move();
  // The target, with room to spare; the tick stops the move where the straight line leaves the workspace.
  const kinematics::Arm<float>& arm = setup_.arm[order.arm];
  Axes joints = Axes::Zero();
  if (!arm.inverse(order.target_m, joints) || arm.limit(joints, kWorkspaceMargin_rad) != 0)
    refused |= kOutsideWorkspace;
  if (refused != 0) return static_cast<Conditions>(refused);
  if (!sources_.move.post(order)) return kMoveUnderWay;
  channel_.post(Command::kMove);
  return 0;
}

bool Commands::axes_in_range(const link::AxisOrder& order) const noexcept {
  if (order.arm >= setup_.arm_count || order.axis >= setup_.arm[order.arm].axes()) return false;
  bool good = within(order.driven_s, 0, kMostDriven_s) && within(order.move_s, 0, kMostDriven_s) &&
              within(order.coast_s, 0, kMostCoast_s) && within(order.frequency_Hz, 0, kMostTone_Hz) &&
              std::isfinite(order.offset_N_m) && std::isfinite(order.slope_N_m_s) &&
              std::isfinite(order.amplitude_N_m) && is_amount(order.most_energy_J);
  for (std::size_t j = 0; j < link::kMaxJoints; ++j) {
    good = good && std::isfinite(order.to_rad[j]);
    for (const float amount : {order.stiffness_N_m_rad[j], order.damping_N_m_s_rad[j],
                               order.most_torque_N_m[j], order.most_way_rad[j], order.most_speed_rad_s[j]})
      good = good && is_amount(amount);
  }
  return good;
}

Conditions Commands::request_axes(const link::AxisOrder& order) noexcept {
  if (disarm_due()) return kWrongMode;
  if (pending()) return kMoveUnderWay;
  if (const Conditions refused = status_.unmet_for_move(); refused != 0) return refused;
  if (!sources_.axes.post(order)) return kMoveUnderWay;
  channel_.post(Command::kMove);
  return 0;
}

bool Commands::place(const link::HomePlace& place) noexcept {
  place_.recall();
  if (place.arm >= setup_.arm_count) return false;
  *place_.blank() = place;
  place_.send();
  return true;
}

}  // namespace thimble::firmware

#include "firmware/core/commands.h"

#include <algorithm>
#include <cmath>

namespace thimble::firmware {
namespace {

constexpr float kWorkspaceMargin_rad = 0.05F;  // of a move's target

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

}  // namespace thimble::firmware

// Orders and samples of guarded moves as they travel over the link.
#pragma once

#include "firmware/link/messages.h"
#include "firmware/link/services.h"
#include "firmware/sources/guarded_move.h"

namespace thimble::firmware {

[[nodiscard]] inline MoveOrder from_link(const link::MoveOrder& order) noexcept {
  return {order.arm,
          order.come_back,
          {order.target_x_m, order.target_y_m, order.target_z_m},
          order.speed_m_s,
          order.force_limit_N};
}

[[nodiscard]] inline link::MoveSample to_link(link::MovePhase phase, const MoveSample& sample) noexcept {
  link::MoveSample entry;
  entry.phase = phase;
  entry.tip_x_m = sample.tip_m.x();
  entry.tip_y_m = sample.tip_m.y();
  entry.tip_z_m = sample.tip_m.z();
  entry.force_N = sample.force_N;
  return entry;
}

}  // namespace thimble::firmware

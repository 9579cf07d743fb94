#include "board/sim/drives/emulated_drive.h"

#include <algorithm>
#include <cmath>

namespace thimble::board::emulated {

EmulatedDrive::EmulatedDrive(double current_lag_s, double velocity_lag_s)
    : current_lag_s_(current_lag_s), velocity_lag_s_(velocity_lag_s) {}

void EmulatedDrive::hear(const CanFrame& frame, std::uint64_t now_us) {
  now_us_ = now_us;
  if (!inject.mute && now_us_ >= booted_us_) on_frame(frame);
}

void EmulatedDrive::power_cycle(std::uint64_t boot_us) {
  reboot();
  booted_us_ = now_us_ + boot_us;
}

void EmulatedDrive::advance(std::uint64_t now_us) {
  if (!started_) now_us_ = now_us;
  started_ = true;
  while (now_us_ + kStep_us <= now_us) {
    now_us_ += kStep_us;
    step();
  }
}

void EmulatedDrive::step() {
  constexpr double kStep_s = kStep_us * 1e-6;
  const double most = inject.most_torque_N_m;
  const double wanted = std::clamp(wanted_torque_N_m() * inject.current_factor, -most, most);
  // Without power nothing flows.
  current_N_m_ = powered() || wanted != 0
                     ? current_N_m_ + (wanted - current_N_m_) * (1 - std::exp(-kStep_s / current_lag_s_))
                     : 0;
  torque_N_m_ = current_N_m_ * inject.torque_factor;
  if (shaft.moves) {
    const double force = torque_N_m_ + shaft.hand_N_m - shaft.friction_N_m_s_rad * shaft.velocity_rad_s;
    shaft.velocity_rad_s += force / shaft.inertia_kg_m2 * kStep_s;
    shaft.position_rad += shaft.velocity_rad_s * kStep_s;
  }
  const double seen = inject.encoder_frozen ? 0 : shaft.velocity_rad_s;
  velocity_rad_s_ += (seen - velocity_rad_s_) * (1 - std::exp(-kStep_s / velocity_lag_s_));
  on_step();
}

double EmulatedDrive::read_encoder_rad() {
  if (!inject.encoder_frozen) frozen_rad_ = shaft.position_rad;
  double position = frozen_rad_ + inject.encoder_jump_rad;
  if (inject.encoder_noise_rad > 0)
    position +=
        std::uniform_real_distribution<double>(-inject.encoder_noise_rad, inject.encoder_noise_rad)(random_);
  return std::round(position / encoder_step_rad()) * encoder_step_rad();
}

void EmulatedDrive::send(const CanFrame& frame) {
  if (inject.mute || now_us_ < booted_us_) return;
  if (inject.drop_replies > 0) {
    --inject.drop_replies;
    return;
  }
  CanFrame out = frame;
  if (inject.answer_classic && out.fd) {
    out.fd = out.bit_rate_switch = false;
    out.size = std::min<std::uint8_t>(out.size, firmware::link::kClassicDataBytes);
  }
  if (inject.reply_id != 0) out.id = inject.reply_id;
  const Outgoing outgoing{now_us_ + kTurnaround_us + inject.more_delay_us, out};
  outgoing_.push_back(outgoing);
  if (inject.repeat_replies > 0) {
    --inject.repeat_replies;
    outgoing_.push_back(outgoing);
  }
}

}  // namespace thimble::board::emulated

#include "firmware/sources/host_forces.h"

#include <algorithm>

namespace thimble::firmware {
namespace {

constexpr link::Micros kLife_us = 20'000;
static_assert(HostForces::kLife_s == static_cast<float>(kLife_us) * 1e-6F);

constexpr float kStep_N = 1e-3F;  // of ForceOrder

std::int16_t to_mN(float force_N) noexcept { return link::wire::to_wire<std::int16_t>(force_N, kStep_N); }

}  // namespace

// A period that does not divide the life ends it early rather than late; one tick at least.
HostForces::HostForces(float period_s) noexcept
    : ForceSource({.name = "host", .host = true, .ends_recording = link::RecordingEnd::kHostForces}),
      life_ticks_(std::max<std::uint32_t>(1, static_cast<std::uint32_t>(kLife_s / period_s + 0.01F))) {}

bool HostForces::order(const link::ForceOrder& order, link::Micros now) noexcept {
  Arm& arm = arms_[order.arm];
  const auto ahead = static_cast<std::uint8_t>(order.sequence - arm.sequence);
  const bool after = ahead >= 1 && ahead < 128;
  if (arm.ordered && !after && now - arm.ordered_us <= kLife_us) return false;
  arm.ordered = true;
  arm.ordered_us = now;
  arm.sequence = order.sequence;
  arm.handed_over.write({to_mN(order.x_N), to_mN(order.y_N), to_mN(order.z_N), 0});
  return true;
}

bool HostForces::wanted(const Params& params) const noexcept { return params.on(Param::host_forces); }

void HostForces::start(const SourceTick&) noexcept {
  for (Arm& arm : arms_) {
    arm.handed_over.skip();
    arm.in_force = false;
  }
}

// Without an order that is in force the tip is damped.
void HostForces::forces(const SourceTick& tick, SourceForces& out) noexcept {
  const float damping_N_s_m = tick.params.get(Param::stop_damping);
  for (std::size_t i = 0; i < tick.arms.size(); ++i) {
    const ArmState& arm = tick.arms[i];
    const Vec3* ordered_N = take(i, tick.tick);
    out.arms[i].god_object_m = arm.posture.tip_m;
    out.arms[i].force_N = ordered_N != nullptr ? *ordered_N : Vec3(-damping_N_s_m * arm.tip_velocity_m_s);
    out.arms[i].contacts = 0;
  }
}

const Vec3* HostForces::take(std::size_t index, std::uint64_t tick) noexcept {
  Arm& arm = arms_[index];
  Force_mN force_mN;
  if (arm.handed_over.read(force_mN)) {
    arm.in_force = true;
    arm.taken_tick = tick;
    for (int k = 0; k < 3; ++k)
      arm.force_N[k] = static_cast<float>(force_mN[static_cast<std::size_t>(k)]) * kStep_N;
  }
  if (arm.in_force && tick - arm.taken_tick >= life_ticks_) {
    arm.in_force = false;
    expired_.add();
  }
  return arm.in_force ? &arm.force_N : nullptr;
}

}  // namespace thimble::firmware

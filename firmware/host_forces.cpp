#include "firmware/host_forces.h"

#include <algorithm>
#include <bit>

namespace thimble::firmware {
namespace {

constexpr link::Micros kLife_us = 20'000;
static_assert(HostForces::kLife_s == static_cast<float>(kLife_us) * 1e-6F);

constexpr float kStep_N = 1e-3F;  // of ForceOrder

std::uint32_t pack(float low_N, float high_N) noexcept {
  const auto half = [](float force_N) {
    return std::uint32_t{std::bit_cast<std::uint16_t>(link::wire::to_wire<std::int16_t>(force_N, kStep_N))};
  };
  return half(low_N) | half(high_N) << 16U;
}

float unpack(std::uint32_t half) noexcept {
  return static_cast<float>(std::bit_cast<std::int16_t>(static_cast<std::uint16_t>(half))) * kStep_N;
}

}  // namespace

// A period that does not divide the life ends it early rather than late; one tick at least.
HostForces::HostForces(float period_s) noexcept
    : life_ticks_(std::max<std::uint32_t>(1, static_cast<std::uint32_t>(kLife_s / period_s + 0.01F))) {}

bool HostForces::order(const link::ForceOrder& order, link::Micros now) noexcept {
  Arm& arm = arms_[order.arm];
  const auto ahead = static_cast<std::uint8_t>(order.sequence - arm.sequence);
  const bool after = ahead >= 1 && ahead < 128;
  if (arm.ordered && !after && now - arm.ordered_us <= kLife_us) return false;
  arm.ordered = true;
  arm.ordered_us = now;
  arm.sequence = order.sequence;
  const std::uint32_t version = arm.version.load(std::memory_order_relaxed);
  arm.version.store(version + 1, std::memory_order_relaxed);
  // Released: who reads one of these words anew reads the odd version, too, when it looks again.
  arm.words[0].store(pack(order.x_N, order.y_N), std::memory_order_release);
  arm.words[1].store(pack(order.z_N, 0.0F), std::memory_order_release);
  arm.version.store(version + 2, std::memory_order_release);
  return true;
}

void HostForces::forget() noexcept {
  for (Arm& arm : arms_) {
    arm.seen = arm.version.load(std::memory_order_acquire);
    arm.in_force = false;
  }
}

const Vec3* HostForces::take(std::size_t index, std::uint64_t tick) noexcept {
  Arm& arm = arms_[index];
  const std::uint32_t version = arm.version.load(std::memory_order_acquire);
  if (version != arm.seen && version % 2 == 0) {
    const std::uint32_t xy = arm.words[0].load(std::memory_order_acquire);
    const std::uint32_t z = arm.words[1].load(std::memory_order_acquire);
    if (arm.version.load(std::memory_order_relaxed) == version) {
      arm.seen = version;
      arm.in_force = true;
      arm.taken_tick = tick;
      arm.force_N = Vec3(unpack(xy), unpack(xy >> 16U), unpack(z));
    }
  }
  if (arm.in_force && tick - arm.taken_tick >= life_ticks_) {
    arm.in_force = false;
    expired_.store(expired_.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);  // one writer
  }
  return arm.in_force ? &arm.force_N : nullptr;
}

}  // namespace thimble::firmware

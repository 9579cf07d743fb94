// What the kinematics of an arm cost, on bare metal: an arm image in memory (QEMU's loader puts it there, behind its size) is moved along a path, as the
// tick moves it. tick_begin() and tick_end() enclose first nothing, then by turns position, Jacobian and weight, and the map of a force to torques;
// arm_cost.py counts the instructions between them. Exit code: 0; 40 after a crash; 42: no arm; 43: a posture without a tip.
#include <array>
#include <cstddef>
#include <cstring>

#include "board/cortex/runtime.h"
#include "firmware/arm/arm_image.h"
#include "kinematics/arm.h"
#include "kinematics/trig.h"
#include "tests/hardware/cortex/semihosting.h"

extern "C" {
[[gnu::noinline]] void tick_begin() { asm volatile(""); }
[[gnu::noinline]] void tick_end() { asm volatile(""); }
}

namespace thimble {
namespace {

using kinematics::PerAxis;

constexpr int kCrashed = 40, kNoArm = 42, kNoTip = 43;
constexpr int kTicks = 1000;
constexpr float kPart = 0.3F;           // of the way from home to the nearer limit
constexpr float kRadPerTick = 0.0063F;  // a swing takes 1000 ticks: a quarter of a second at 4 kHz

// Each axis swings about home, with another phase.
PerAxis<float> axes_at(const kinematics::ArmData& arm, int tick) {
  PerAxis<float> axes = arm.geometry.home;
  for (int j = 0; j < kinematics::axes_of(arm.geometry); ++j) {
    const kinematics::AxisData& axis = arm.axis[static_cast<std::size_t>(j)];
    const float below = axes[j] - axis.lower, above = axis.upper - axes[j];
    const float angle = kRadPerTick * static_cast<float>(tick % kTicks);
    const auto turn = kinematics::sin_cos(angle);
    axes[j] += kPart * (below < above ? below : above) * (j % 2 == 0 ? turn.sin : 1 - turn.cos);
  }
  return axes;
}

template <class Value>
void keep(const Value& value) {
  asm volatile("" : : "r"(&value) : "memory");
}

}  // namespace

void board::crash(std::uint32_t) noexcept { test::exit_with(kCrashed); }

extern "C" [[noreturn]] void run_board() {
  const auto* memory = reinterpret_cast<const std::byte*>(THIMBLE_RECORDING);
  std::uint32_t bytes = 0;
  std::memcpy(&bytes, memory, sizeof bytes);
  static kinematics::ArmData data;
  if (bytes > firmware::kMaxArmImageBytes ||
      firmware::read_arm_image({memory + 8, bytes}, data) != firmware::ArmStatus::kOk)
    test::exit_with(kNoArm);
  static const kinematics::Arm<float> arm(data);
  static kinematics::Posture<float> posture = arm.home_posture();
  PerAxis<float> torque = PerAxis<float>::Zero();
  tick_begin();
  tick_end();
  for (int tick = 0; tick < kTicks; ++tick) {
    const PerAxis<float> axes = axes_at(data, tick);
    keep(axes);
    tick_begin();
    arm.move_to(axes, posture);
    PerAxis<float> weight = arm.gravity_torques(posture);
    keep(weight);
    keep(posture);
    tick_end();
    if (!posture.tip_m.allFinite()) test::exit_with(kNoTip);
    const kinematics::Vector3<float> force_N(0.5F, -1.0F, 2.0F);
    keep(force_N);
    tick_begin();
    kinematics::torques(posture.jacobian, force_N, arm.axes(), torque);
    keep(torque);
    tick_end();
  }
  test::exit_with(0);
}

}  // namespace thimble

#include "board/cortex/fabric.h"

#include <atomic>

namespace thimble::board {
namespace {

// No overflow: the limits of firmware/ bound currents to some amperes.
std::int32_t to_microamperes(float current_A) noexcept {
  constexpr float kMost_uA = 1.0e9F;
  const float current_uA = current_A * 1.0e6F;
  if (!(current_uA >= -kMost_uA && current_uA <= kMost_uA)) return 0;
  return static_cast<std::int32_t>(current_uA);
}

}  // namespace

Fabric::Fabric(std::uintptr_t base, std::uint8_t arms) noexcept
    : registers_(reinterpret_cast<volatile FabricRegisters*>(base)), arms_(arms) {
  off();
}

bool Fabric::present() const noexcept {
  return registers_->id == kFabricId && registers_->version == kFabricVersion;
}

void Fabric::start_watchdog(std::uint32_t timeout_us) const noexcept {
  registers_->watchdog_us = timeout_us;
  off();
}

void Fabric::latch(firmware::Inputs& inputs) const noexcept {
  registers_->latch = 1;
  std::atomic_thread_fence(std::memory_order_seq_cst);
  const std::uint32_t lines = registers_->lines;
  inputs.e_stop = (lines & kLineEStopReleased) == 0;
  inputs.dead_man = (lines & kLineDeadManHeld) != 0;
  for (std::uint8_t i = 0; i < arms_; ++i) {
    const volatile FabricRegisters::Arm& arm = registers_->arm[i];
    firmware::ArmInputs& input = inputs.arm[i];
    for (std::size_t joint = 0; joint < kFabricJoints; ++joint) input.counts[joint] = arm.count[joint];
    input.sample_tick = inputs.tick;
    const std::uint32_t arm_lines = arm.lines;
    input.index = (arm_lines & kArmLineIndex) != 0;
    input.drive_fault = (arm_lines & kArmLineDrivesGood) == 0;
  }
}

void Fabric::commit(const firmware::Outputs& outputs) const noexcept {
  for (std::uint8_t i = 0; i < arms_; ++i) {
    volatile FabricRegisters::Arm& arm = registers_->arm[i];
    const firmware::ArmOutputs& output = outputs.arm[i];
    for (std::size_t joint = 0; joint < kFabricJoints; ++joint)
      arm.current_uA[joint] = to_microamperes(output.current_A[joint]);
    arm.enable = output.enable ? 1 : 0;
  }
  std::atomic_thread_fence(std::memory_order_seq_cst);
  registers_->commit = 1;
}

void Fabric::off() const noexcept {
  for (std::uint8_t i = 0; i < arms_; ++i) {
    volatile FabricRegisters::Arm& arm = registers_->arm[i];
    for (std::size_t joint = 0; joint < kFabricJoints; ++joint) arm.current_uA[joint] = 0;
    arm.enable = 0;
  }
  std::atomic_thread_fence(std::memory_order_seq_cst);
  registers_->commit = 1;
}

}  // namespace thimble::board

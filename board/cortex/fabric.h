// Encoders, motor currents and safety lines of the bare-metal boards: one register block in programmable
// logic, at an address that the board defines. docs/board-cortex.md has the table and the requirements for
// the logic.
//
//   every tick   fabric.latch(inputs)     counters and lines from one instant
//                ... Controller::tick ...
//                fabric.commit(outputs)   currents and enables, together
//
// In emulation the block is plain memory that contains kFabricId from the start; the simulated arm reads and
// writes it.
#pragma once

#include <cstdint>

#include "firmware/core/config.h"

namespace thimble::board {

// 32-bit registers, little-endian. R: the board reads; W: the board writes.
inline constexpr std::size_t kFabricJoints = 3;  // of an arm

struct FabricRegisters {
  std::uint32_t id;       // R  kFabricId: the logic is loaded
  std::uint32_t version;  // R  kFabricVersion
  std::uint32_t latch;    // W  any write latches the counters and lines below until the next write
  std::uint32_t lines;    // R  kLine bits
  std::uint32_t
      commit;  // W  any write applies the currents and enables below and restarts the watchdog of the logic
  // W  time without a commit after which the logic clears the enables, and kArmLineDrivesGood, until a commit
  // without an enable; 0: never
  std::uint32_t watchdog_us;
  std::uint32_t reserved[2];
  struct Arm {
    std::uint32_t count[kFabricJoints];      // R  encoder counters
    std::uint32_t lines;                     // R  kArmLine bits
    std::int32_t current_uA[kFabricJoints];  // W  motor currents, microamperes
    std::uint32_t enable;                    // W  1: the amplifiers may drive
  } arm[firmware::kMaxArms];
};
static_assert(sizeof(FabricRegisters) == 32 + 32 * firmware::kMaxArms);

inline constexpr std::uint32_t kFabricId = 0x424D4854;  // "THMB"
inline constexpr std::uint32_t kFabricVersion = 2;
inline constexpr std::uint32_t kLineEStopReleased = 1U << 0U;  // a broken wire reads as pressed
inline constexpr std::uint32_t kLineDeadManHeld = 1U << 1U;
inline constexpr std::uint32_t kArmLineIndex = 1U << 0U;
inline constexpr std::uint32_t kArmLineDrivesGood = 1U << 1U;

class Fabric {
 public:
  Fabric(std::uintptr_t base, std::uint8_t arms) noexcept;

  [[nodiscard]] bool present() const noexcept;
  // Last before the first tick: the watchdog has expired since the constructor if the start took longer, and its trip, which
  // reads as a drive fault, ends with the commit without enables that this does.
  void start_watchdog(std::uint32_t timeout_us) const noexcept;
  void latch(firmware::Inputs& inputs)
      const noexcept;  // fills all except time and tick; samples belong to inputs.tick
  void commit(const firmware::Outputs& outputs) const noexcept;
  void off() const noexcept;  // no current, no enable; last action of a crash handler

 private:
  volatile FabricRegisters* registers_;
  std::uint8_t arms_;
};

}  // namespace thimble::board

// The drives of one CAN bus: one tick is begin_cycle() with torques, the replies, and end_cycle() with what all drives said.
//
//   bus.begin_cycle(now_us, torque_N_m, damping_N_m_s_rad);   // drops what is left of the last tick, sends all commands at once
//   while (!bus.collect(now_us()) && in time) wait;           // or just the time of bus_time.h
//   for (const DriveState& drive : bus.end_cycle(now_us())) ...
//
// One thread. From begin_cycle() on nothing allocates, waits or throws. Frames leave in the order of the torques' shares of their peaks: the
// most loaded joint first, of equal ones the first of the list.
// There is no second way to ask a drive something: any frame feeds an ODrive's watchdog, so only what writes torques may send.
// A fault of one drive drops all: torque 0 and base damping for 300 ms, then off. Nothing is enabled again but by enable(). Where an arm has
// several buses, the owner calls disable() on the others.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "board/linux/drives/can_socket.h"
#include "board/linux/drives/drive_life.h"

namespace thimble::board::drives {

// Units: SI at the drive's shaft; NaN: never reported. Ages are of this host's receive stamp.
struct DriveState {
  double position_rad = 0;  // without wraps; valid if position_known
  float velocity_rad_s = 0;
  float torque_N_m = kNoValue;
  float torque_difference_N_m =
      0;  // of the last torque reported from the one asked for, damping and lag included
  float current_A = kNoValue;
  float supply_V = kNoValue;
  float drive_C = kNoValue;
  float motor_C = kNoValue;
  float age_us = kNoValue;  // of the position, at end_cycle()
  bool position_known = false;
  bool fresh = false;  // a position came for this tick's command
  State state = State::kUnknown;
  DriveFault fault = DriveFault::kNone;
  std::uint32_t drive_fault = 0;  // the drive's own code at the fault, or now
  Limiter limiter = Limiter::kNone;
  std::uint32_t late_replies = 0;  // that came after their tick, and were not taken for fresh
  std::uint32_t config_hash = 0;
  const char* wrong_item = nullptr;  // of its configuration
};

// A frame that no drive of the list sends: shown at discovery.
struct Stranger {
  std::uint32_t id = 0;
  std::uint8_t size = 0;
  bool extended = false;
  bool fd = false;
};

class DriveBus {
 public:
  static constexpr std::size_t kMostStrangers = 8;

  // `drives` have passed check_drives(). Allocates; the items that they point to must outlive it.
  DriveBus(Descriptor socket, std::span<const DriveConfig> drives, float period_s);

  // Values for each drive. Torque is limited to the drive's peak; damping below the base damping is raised to it. Both count in Running alone.
  void begin_cycle(std::uint64_t now_us, std::span<const float> torque_N_m,
                   std::span<const float> damping_N_m_s_rad) noexcept;
  // Reads what has come. True: every drive that answers each tick has.
  bool collect(std::uint64_t now_us) noexcept;
  [[nodiscard]] std::span<const DriveState> end_cycle(std::uint64_t now_us) noexcept;

  // Empty: accepted, and when all drives have been at rest for 20 ticks they run together. Else what stands against it.
  [[nodiscard]] std::string_view enable() noexcept;
  void disable() noexcept;
  // Off at once, from the next cycle on; `cut`: somebody else has switched them off, which is the fault switched_off of each that was on.
  void stop(bool cut = false) noexcept;
  void clear() noexcept;

  [[nodiscard]] std::span<const Stranger> strangers() const noexcept {
    return {strangers_.data(), stranger_count_};
  }
  [[nodiscard]] int descriptor() const { return socket_.get(); }  // to wait for, readable
  // What a raw socket of these drives has to receive, for open_can_bus(). Only after discovery: it hides strangers.
  [[nodiscard]] std::vector<can_filter> reply_filters() const;

 private:
  struct Slot {
    DriveConfig config;
    std::unique_ptr<Protocol> protocol;
    DriveLife life;
    Sample sample;
    News news;
    Command sent;
    std::uint64_t stamp_us = 0;
    std::uint32_t late = 0;
    std::uint32_t fault_code = 0;
  };
  enum class When : std::uint8_t { kLate, kInTime };

  void read(std::uint64_t now_us, When when) noexcept;
  void take(const CanSocket::Received& received, When when) noexcept;
  void add_frames(Slot& slot, float torque_N_m, float damping_N_m_s_rad) noexcept;
  void sort_by_load(std::span<const float> torque_N_m) noexcept;
  void note(const CanFrame& frame) noexcept;
  void fail_all(DriveFault fault) noexcept;
  void apply_bus_rules() noexcept;
  [[nodiscard]] DriveState state_of(const Slot& slot, std::uint64_t now_us) const noexcept;

  CanSocket socket_;
  std::vector<Slot> slots_;
  std::vector<DriveState> states_;
  Outbox outbox_;
  std::array<std::size_t, kMostDrives> order_{};  // in which the commands leave
  std::array<Stranger, kMostStrangers> strangers_{};
  std::size_t stranger_count_ = 0;
  std::uint64_t begun_us_ = 0;  // 0: never
};

}  // namespace thimble::board::drives

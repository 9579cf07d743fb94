// The drives on CAN of all arms of a board: their buses, and what the servo reads and writes of them in each tick.
//
//   DriveSet drives(arms, period_s, host);       // opens the buses and looks for the drives; up to kMostSearch_s
//   each tick   drives.read(in, samples, ...);   // ends the cycle of the tick before: positions, currents, temperatures, faults
//               drives.write(out, works, now);   // begins the next cycle: one command for each drive, all of a bus at once
//
// A command's reply comes within the tick that begins with the command, so a sample is as old as the rest of that tick. All drives are on
// together: they are enabled when the controller wants its motors on, give torque when every one of them runs, rising within kRamp_s, and are
// switched off together. A fault drops all; it stays until the controller's fault is cleared, and nothing is switched on by that.
// An ODrive has no position before its first closed loop: it is switched on without torque once, after the start or a cleared fault, as soon
// as no fault is latched and the e-stop is closed.
//
// From read() on nothing allocates, waits or throws. Units: A and counts of the arm's model, else SI.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "board/linux/board_config.h"
#include "board/linux/drive_stopper.h"
#include "board/linux/drives/bus_time.h"
#include "board/linux/drives/drive_bus.h"
#include "board/linux/drives/open_can_bus.h"
#include "board/linux/missing.h"
#include "firmware/core/config.h"

namespace thimble::board {

// What the drives need of the machine at start; tests have another.
struct DriveHost {
  // rate: of the controller behind the interface, left as it is where there is none.
  std::function<drives::OpenedBus(const std::string& interface, bool fd, drives::BusRate& rate, bool& real)>
      open;
  std::function<std::uint64_t()> now_us;
  std::function<void(std::uint64_t time_us)> sleep_until;

  [[nodiscard]] static DriveHost of_this_machine();
};

class DriveSet {
 public:
  static constexpr float kMostSearch_s = 6;
  static constexpr float kRamp_s = .1F;

  // Nothing to do without drives. Does not throw for missing ones. The arms' models must outlive it.
  DriveSet(std::span<const ArmWiring> arms, double rate_Hz, const DriveHost& host);

  [[nodiscard]] bool empty() const noexcept { return buses_.empty(); }
  [[nodiscard]] const std::vector<Missing>& missing() const noexcept { return missing_; }
  // For people: a line for each bus (its load) and for each drive (state, watchdog, configuration read back).
  [[nodiscard]] std::vector<std::string> report() const;

  // Sets counts (of joints without an encoder of their own), evidence and drive_fault of every arm with drives. sample_tick: is lowered to that of
  // the oldest drive's sample that is used. in.tick and in.e_stop are set.
  void read(firmware::Inputs& in, std::uint64_t now_ns, std::uint64_t period_ns) noexcept;
  // works: false: something else of the arms has failed, and the drives go off.
  void write(const firmware::Outputs& out, bool works, std::uint64_t now_ns) noexcept;
  // The share of the currents that the arms with drives get now, also by their DAC: 0 until every drive runs, then rising to 1.
  [[nodiscard]] float gain() const noexcept { return gain_; }
  [[nodiscard]] bool drives_arm(std::size_t arm) const noexcept { return driven_[arm]; }
  // The guardian has switched the drives off.
  void cut() noexcept;
  // Off without a fault, from the next cycle on.
  void stop() noexcept;
  // Off at once, out of turn: for when no tick runs, and for the guardian's process. Sends alone, changes nothing here.
  void send_off() noexcept { stopper_.stop(); }

  // What a drive has said since the last call, a sentence, for the log; any thread. Empty: nothing new.
  [[nodiscard]] std::string news();

 private:
  enum class Phase : std::uint8_t { kOff, kEnabling, kOn };
  struct Joint {
    std::size_t arm = 0, joint = 0;
    float direction = 1;
    float torque_per_A = 0;              // of the motor
    double counts_per_rad = 0;           // of the motor, with the sign of the axis's counts
    std::uint32_t mask = 0;              // of the counter's width
    bool encoder = false;                // its counts are the joint's
    std::string text;                    // "arm 0 joint 2 (moteus 1 on can0)"
    std::atomic<std::uint8_t> fault{0};  // drives::DriveFault
    std::uint8_t told = 0;
  };
  struct Bus {
    std::string interface;
    std::vector<drives::DriveConfig> configs;
    std::vector<std::vector<drives::ConfigItem>> items;
    std::vector<std::unique_ptr<Joint>> joints;  // in the order of configs
    std::unique_ptr<drives::DriveBus> bus;
    std::span<const drives::DriveState> states;
    std::array<float, drives::kMostDrives> torque_N_m{};
    std::string load;
  };

  void sort_into_buses();
  void open(Bus& bus, double rate_Hz, const DriveHost& host);
  void search(double rate_Hz, const DriveHost& host);
  void report_missing();
  void read_bus(Bus& bus, firmware::Inputs& in, std::uint64_t period_ns) noexcept;
  void take_evidence(const Joint& joint, float commanded_N_m, const drives::DriveState& state,
                     firmware::ArmEvidence& evidence) const noexcept;
  void follow(bool wanted, bool faulted_mode) noexcept;
  void enable() noexcept;
  void fail() noexcept;
  [[nodiscard]] bool wants_to_wake() const noexcept;
  template <class Test>
  [[nodiscard]] bool all(Test test) const noexcept;

  std::vector<ArmWiring> arms_;
  std::vector<Bus> buses_;
  std::vector<Missing> missing_;
  DriveStopper stopper_;
  float period_s_;
  std::array<bool, firmware::kMaxArms> driven_{};  // arms with a drive
  std::array<float, firmware::kMaxArms> supply_V_{};

  Phase phase_ = Phase::kOff;
  float gain_ = 0;
  float waited_s_ = 0;         // since the controller wanted its motors on
  bool faulted_ = false;       // a drive, or enabling them
  bool acknowledged_ = false;  // the controller has latched that
  bool was_faulted_mode_ = false;
  bool waking_ = false;
  bool may_wake_ = true;
  bool e_stop_ = true;
};

}  // namespace thimble::board

// A board with simulated hardware: plant, encoders, drives, a store in memory, and the controller.
// `thimble simulate` runs it as fast as possible; thimble-sim runs it in real time with the link:
//
//   SimBoard board({.variant = "premium-1.5"});
//   every period:  board.tick();                       // sample, controller.tick(), drives, plant
//   otherwise:     board.controller().on_frame(frame, now); ...
//
// One thread. Its clock counts ticks, so two runs with the same calls are bit-identical. The arm rests in a
// cradle at its home pose until it is homed; then the hand holds it. follow() moves the hand to the first
// point of a path, and along the path when the controller is armed and its force ramp has ended.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <random>
#include <span>
#include <string>
#include <vector>

#include "board/common/measured_currents.h"
#include "board/sim/broken_arm.h"
#include "board/sim/hand_path.h"
#include "board/sim/injection.h"
#include "board/sim/sim_arm.h"
#include "firmware/controller.h"

namespace thimble::board {

// The slots in memory. Pages that are never written occupy no memory.
class MemoryStorage final : public firmware::Storage {
 public:
  explicit MemoryStorage(std::size_t scene_slot_bytes);
  [[nodiscard]] std::span<const std::byte> slot(unsigned index) const noexcept override;
  [[nodiscard]] bool erase(unsigned index, std::size_t bytes) noexcept override;
  [[nodiscard]] bool write(unsigned index, std::size_t offset,
                           std::span<const std::byte> bytes) noexcept override;

 private:
  struct Free {
    void operator()(std::byte* memory) const noexcept;
  };
  std::array<std::size_t, kSlots> slot_bytes_{};
  std::array<std::unique_ptr<std::byte, Free>, kSlots> slots_;
};

struct SimBoardOptions {
  std::string variant = "premium-1.5";
  // Another arm in place of the variant's, as the controller knows it; and how it truly is, if that differs (not of a two-link arm).
  std::optional<kinematics::ArmData> arm{};
  std::optional<AnyPlantParameters> truth{};
  double rate_Hz = 4000.0;  // 100 to 20000
  std::uint8_t arm_count = 1;
  // Unset: a single arm has its home at the origin, two arms .1 m to the left and right of it.
  std::optional<std::array<kinematics::BasePose, control::kMaxArms>> base{};
  Hand hand{};
  std::shared_ptr<const Specimen> specimen{};  // object that arm 0 can touch; null: none
  std::uint64_t seed = 1;
  std::uint8_t node_id = 1;
  const char* reset_reason = "power_on";
  std::uint32_t utc_s = 0;               // firmware::Config::utc_s
  std::uint32_t bus_bits_per_s = 0;      // firmware::Config::bus_bits_per_s
  firmware::Storage* storage = nullptr;  // must outlive the board; null: internal storage in memory
  std::size_t slot_bytes =
      control::kMaxImageBytes + firmware::SceneStore::kHeaderBytes;  // of the internal storage
  Sensors sensors{};                                                 // of each arm
  double plant_step_s =
      kPlantStep_s;         // longer: hours of play are worth more than the last percent of the plant
  bool time_ticks = false;  // fill Inputs::last_tick_us from the machine's clock
  std::function<void(const firmware::Telemetry&)> each_tick{};  // called after each tick of the controller
};

class InjectRoutine;
class TearableStorage;

class SimBoard {
 public:
  // Throws std::invalid_argument for an unknown variant or an arm whose links do not meet, a rate out of range or a bad arm count.
  explicit SimBoard(const SimBoardOptions& options = {});
  SimBoard(const SimBoard&) = delete;
  SimBoard& operator=(const SimBoard&) = delete;
  ~SimBoard();

  void tick();                // one period
  void step(double seconds);  // runs the whole periods in this time; the remainder is kept for the next call

  // The hand follows a path, beginning at the start time of the path. loop: after the last point it returns
  // to the first. When the controller is not armed, the hand waits at the first point again.
  void follow(std::size_t arm, HandPath path, bool loop = false);
  // A further point of the path that the hand follows (HandPath::extend()).
  void extend(std::size_t arm, const PathPoint& point, double from_s) {
    arms_[arm].path->extend(point, from_s);
  }
  // Sets the target of the hand, which continues to move with this velocity; ends a path.
  void hold(std::size_t arm, const Vector3d& position_m, const Vector3d& velocity_m_s = Vector3d::Zero());
  [[nodiscard]] bool hand_waits(
      std::size_t arm) const noexcept;  // it waits at the first point of its path for the controller
  [[nodiscard]] bool hand_follows(std::size_t arm) const noexcept;

  // Breaks something now or at its time; a tick that has passed its end mends it.
  void inject(const PlannedFault& fault);
  // Whether a fault of this kind is broken now, and its value. For those that are not of the arm or the tick: of the link and the process.
  [[nodiscard]] std::optional<double> injected(Injection kind) const;

  // The controller begins again from its store, as after a crash of its process; the arms and the hands go on.
  void restart(const char* reason);

  // Whether the tip can be there, this far from every limit.
  [[nodiscard]] bool reaches(std::size_t arm, const Vector3d& position_m, double margin_rad = 0) const;
  // The position itself, or the point where the line from the arm's home to it leaves the workspace.
  [[nodiscard]] Vector3d within_reach(std::size_t arm, const Vector3d& position_m) const;

  void set_e_stop(bool pressed) noexcept { e_stop_ = pressed; }
  void set_dead_man(bool held) noexcept { dead_man_ = held; }

  [[nodiscard]] firmware::Controller& controller() noexcept { return *controller_; }
  [[nodiscard]] SimArm& arm(std::size_t arm) noexcept { return arms_[arm].plant; }
  [[nodiscard]] Plant& plant(std::size_t arm) { return arms_[arm].plant.two_link(); }
  [[nodiscard]] const Vector3d& sampled_tip_m(std::size_t arm) const noexcept {
    return arms_[arm].sampled_tip_m;
  }
  // The drives of the arm are on: enabled by the last tick, and written in time.
  [[nodiscard]] bool driven(std::size_t arm) const noexcept { return arms_[arm].driven; }
  [[nodiscard]] const SimBoardOptions& options() const noexcept { return options_; }
  [[nodiscard]] double time_s() const noexcept { return static_cast<double>(ticks_) / options_.rate_Hz; }

 private:
  enum class HandState : std::uint8_t { kCradle, kHold, kApproach, kWait, kFollow };
  struct Arm {
    SimArm plant;
    BrokenArm broken;
    bool driven = false;
    Vector3d sampled_tip_m;  // true position of the fingertip when the last tick sampled the encoders
    HandState state = HandState::kCradle;
    std::optional<HandPath> path;
    bool loop = false;
    double since_s = 0;  // start of the state
    double approach_s = 0;
    Vector3d from_m;  // start of the approach
    Vector3d at_m;    // target of the hand
    Vector3d velocity_m_s;
  };
  void move_hand(Arm& arm);
  void approach(Arm& arm);
  void inject_due();
  void set_fault(const PlannedFault& fault, bool broken);
  [[nodiscard]] bool tick_is_lost();
  [[nodiscard]] firmware::Outputs tick_controller();
  void run_plants(double seconds);

  struct Planned {
    PlannedFault fault;
    bool broken = false, over = false;
    double until_s = 0;
  };
  SimBoardOptions options_;
  bool no_hand_;  // the arm stays in place while its motors are off
  std::unique_ptr<MemoryStorage> own_storage_;
  std::vector<Arm> arms_;
  std::unique_ptr<TearableStorage> storage_;
  std::unique_ptr<InjectRoutine> inject_;
  MeasuredCurrents measured_;
  firmware::Config config_;
  std::unique_ptr<firmware::Controller> controller_;
  std::vector<Planned> faults_;
  std::optional<double> armed_at_s_, contact_at_s_;
  std::mt19937_64 random_;
  firmware::Inputs in_;
  firmware::Outputs out_;
  double written_at_s_ = 0;  // when the drives were last written
  std::uint64_t lost_in_a_row_ = 0;
  std::uint64_t ticks_ = 0;
  double owed_s_ = 0;
  float last_tick_us_ = 0;
  bool e_stop_ = false;
  bool dead_man_ = true;
};

}  // namespace thimble::board

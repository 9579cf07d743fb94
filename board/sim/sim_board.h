// A board whose hardware is simulated: plant, encoders, drives, store in memory, and the controller on top.
// `thimble simulate` runs it as fast as it goes; thimble-sim runs it in real time behind the link:
//
//   SimBoard board({.variant = "premium-1.5"});
//   every period:  board.tick();                       // sample, controller.tick(), drives, plant
//   otherwise:     board.controller().on_frame(frame, now); ...
//
// One thread. Its clock counts ticks, so two runs with the same calls are equal to the bit.
// The arm lies in a cradle at its home pose until it is homed; then the hand has it. follow() leads the hand
// to a path's first point and, once the controller is armed and its force ramp done, along the path.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "board/sim/hand_path.h"
#include "board/sim/plant.h"
#include "firmware/controller.h"

namespace thimble::board {

// The slots in memory. Pages that are never written cost nothing.
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
  std::array<std::size_t, kSlots> slot_bytes_;
  std::array<std::unique_ptr<std::byte, Free>, kSlots> slots_;
};

struct SimBoardOptions {
  std::string variant = "premium-1.5";
  double rate_Hz = 4000.0;  // 100 to 20000
  std::uint8_t arm_count = 1;
  // Unset: the home of a single arm is the origin, those of two arms lie .1 m left and right of it.
  std::optional<std::array<kinematics::BasePose, control::kMaxArms>> base{};
  Hand hand{};
  std::shared_ptr<const Specimen> specimen{};  // what arm 0 can touch; null: nothing
  std::uint64_t seed = 1;
  std::uint8_t node_id = 1;
  const char* reset_reason = "power_on";
  firmware::Storage* storage = nullptr;  // must outlive the board; null: its own, in memory
  std::size_t slot_bytes = control::kMaxImageBytes + firmware::SceneStore::kHeaderBytes;  // of its own
  bool time_ticks = false;  // fill Inputs::last_tick_us from the machine's clock (telemetry only)
};

class SimBoard {
 public:
  // Throws std::invalid_argument for an unknown variant, a rate out of range or a bad arm count.
  explicit SimBoard(const SimBoardOptions& options = {});

  void tick();                // one period
  void step(double seconds);  // as many whole periods as fit, the remainder kept for the next call

  // The hand follows a path, from the path's own start time on. loop: after the last point it is led back to
  // the first. Out of the armed state it waits at the first point again.
  void follow(std::size_t arm, HandPath path, bool loop = false);
  // The hand wants to be here, moving on at this velocity; ends a path.
  void hold(std::size_t arm, const Vector3d& position_m, const Vector3d& velocity_m_s = Vector3d::Zero());
  [[nodiscard]] bool hand_waits(
      std::size_t arm) const noexcept;  // at its path's first point, for the controller
  [[nodiscard]] bool hand_follows(std::size_t arm) const noexcept;

  // The position itself, or where the way from the arm's home to it leaves the workspace.
  [[nodiscard]] Vector3d within_reach(std::size_t arm, const Vector3d& position_m) const;

  void set_e_stop(bool pressed) noexcept { e_stop_ = pressed; }
  void set_dead_man(bool held) noexcept { dead_man_ = held; }

  [[nodiscard]] firmware::Controller& controller() noexcept { return *controller_; }
  [[nodiscard]] Plant& plant(std::size_t arm) noexcept { return arms_[arm].plant; }
  [[nodiscard]] const Vector3d& sampled_tip_m(std::size_t arm) const noexcept {
    return arms_[arm].sampled_tip_m;
  }
  [[nodiscard]] const SimBoardOptions& options() const noexcept { return options_; }
  [[nodiscard]] double time_s() const noexcept { return static_cast<double>(ticks_) / options_.rate_Hz; }

 private:
  enum class HandState : std::uint8_t { kCradle, kHold, kApproach, kWait, kFollow };
  struct Arm {
    Plant plant;
    Vector3d sampled_tip_m;  // the true fingertip when the last tick sampled the encoders
    HandState state = HandState::kCradle;
    std::optional<HandPath> path;
    bool loop = false;
    double since_s = 0;  // when the state began
    double approach_s = 0;
    Vector3d from_m;  // where the approach began
    Vector3d at_m;    // where the hand wants to be
    Vector3d velocity_m_s;
  };
  void move_hand(Arm& arm);
  void approach(Arm& arm);

  SimBoardOptions options_;
  bool nobody_;  // holds the arm: it lies where it stopped while its motors are off
  std::unique_ptr<MemoryStorage> own_storage_;
  std::vector<Arm> arms_;
  std::unique_ptr<firmware::Controller> controller_;
  std::uint64_t ticks_ = 0;
  double owed_s_ = 0;
  float last_tick_us_ = 0;
  bool e_stop_ = false;
  bool dead_man_ = true;
};

}  // namespace thimble::board

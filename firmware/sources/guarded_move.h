// A guarded move: the arm leads its tip along a straight line until it meets something or arrives, and measures on the way.
// `thimble scan` probes with it. The guest source GuardedMoveSource (guarded_move_source.h) calls tick() once a tick while the arm is
// armed and the move is active(). The core clamps and slews the force as any other, and stops the arm when it is blocked.
//
//   set point   from the tip (or where the last move holds it) towards the target, trapezoidal speed
//   force       K (set point - tip) + D (its velocity - the tip's), at most the order's limit + kForceMargin_N
//   going       until the contact force reaches the limit, or the target: then back to the start, or hold
//   blocked     the force reaches the limit sideways, on the way back or while holding, or the tip is faster than any move:
//               a person or an object obstructs the arm
//
// Contact force along the line: the commanded force minus the force that moves the arm itself, by its model: joint friction by its power,
// F v = sum of (coulomb |qd| + viscous qd^2), and inertia, q' (M + rotors) q' a. The tip position is that of the encoders plus the stretch
// of the cables (kinematics/compliance.h). Units: m, m/s, N, s; world frame. The only loop has at most kMaxSamples steps. Cannot fail:
// values that are not finite give a force that is not finite, and the core then raises a fault.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "firmware/core/config.h"
#include "firmware/core/force_limits.h"
#include "firmware/link/messages.h"
#include "firmware/link/services.h"
#include "kinematics/arm.h"
#include "kinematics/vector.h"

namespace thimble::firmware {

struct MoveOrder {
  std::uint8_t arm = 0;
  bool come_back = false;  // from the target too, not only from a contact
  Vec3 target_m = Vec3::Zero();
  float speed_m_s = 0;      // link::kMinMoveSpeed_m_s to kMaxMoveSpeed_m_s
  float force_limit_N = 0;  // link::kMinMoveForce_N to kMaxMoveForce_N
};

// Means over equal times. When the buffer is full, neighbours are joined and the time doubles.
struct MoveSample {
  Vec3 tip_m = Vec3::Zero();  // stretch taken off
  float force_N = 0;          // contact force along the line, model friction taken off
};

class SampleBuffer {
 public:
  static constexpr std::size_t kMaxSamples = link::kMaxMoveSamples / 2;

  // The samples stay where they are: an empty buffer to copy would take 1.5 kB of the tick's stack.
  void clear() noexcept {
    count_ = 0;
    sum_ = {};
    summed_ = 0;
    interval_ = 1;
  }
  void add(const MoveSample& sample) noexcept;
  [[nodiscard]] std::span<const MoveSample> samples() const noexcept {
    return std::span(samples_).first(count_);
  }

 private:
  std::array<MoveSample, kMaxSamples> samples_{};
  std::size_t count_ = 0;
  MoveSample sum_;
  std::uint32_t summed_ = 0;
  std::uint32_t interval_ = 1;  // ticks a sample
};

// What a move measured.
struct MoveResults {
  SampleBuffer going;
  SampleBuffer coming_back;
  float friction_N = 0;        // by the model, on the way out
  float peak_force_N = 0;      // of the contact, filtered
  Vec3 turn_m = Vec3::Zero();  // the tip where it turned or stopped
};

class GuardedMove {
 public:
  static constexpr float kStiffness_N_m = link::kMoveStiffness_N_m;
  static constexpr float kDamping_N_s_m = 5.0F;
  static constexpr float kAcceleration_m_s2 = link::kMoveAcceleration_m_s2;
  static constexpr float kForceMargin_N = 0.5F;  // of the clamp above the limit: friction and damping's noise
  static constexpr float kTopSpeed_m_s = 0.25F;  // of the tip; above it the move is blocked
  static constexpr float kFilter_s = 0.004F;     // of the force that is compared with the limit

  using State = link::MovePhase;
  using End = link::MoveEnd;

  [[nodiscard]] State state() const noexcept { return state_; }
  [[nodiscard]] End end() const noexcept { return end_; }
  [[nodiscard]] bool active() const noexcept { return state_ != State::kNone; }
  [[nodiscard]] bool under_way() const noexcept {
    return state_ == State::kGoing || state_ == State::kComingBack;
  }
  [[nodiscard]] float ordered_m_s() const noexcept { return order_.speed_m_s; }
  [[nodiscard]] std::uint8_t arm() const noexcept { return order_.arm; }
  [[nodiscard]] const Vec3& set_point_m() const noexcept { return set_point_m_; }

  // order: its ranges are checked. tip_m: by the encoders. results: written while under_way() only.
  void start(const MoveOrder& order, const Vec3& tip_m, MoveResults& results) noexcept;
  // The force to exert in this tick. last_force_N: what was exerted in the last one, after all limits.
  [[nodiscard]] LimitedForce tick(const kinematics::Arm<float>& arm, const Axes& joint_rad,
                                  const kinematics::Posture<float>& posture, const Vec3& tip_velocity_m_s,
                                  const Vec3& last_force_N, float period_s) noexcept;
  void stop() noexcept;  // the move ends

 private:
  void advance(float period_s, float lead_m) noexcept;
  void turn(End end, bool come_back) noexcept;
  void judge(const Vec3& tip_m, float speed_m_s, float friction_N) noexcept;

  MoveOrder order_;
  State state_ = State::kNone;
  End end_ = End::kNotYet;
  Vec3 start_m_ = Vec3::Zero();
  Vec3 direction_ = Vec3::Zero();
  float length_m_ = 0;
  float way_m_ = 0;      // of the set point from the start
  float speed_m_s_ = 0;  // of the set point; negative on the way back
  float waits_s_ = 0;    // how long the set point has waited for the tip
  float acceleration_m_s2_ = 0;
  Vec3 set_point_m_ = Vec3::Zero();
  Vec3 filtered_N_ = Vec3::Zero();
  MoveResults* results_ = nullptr;
};

}  // namespace thimble::firmware

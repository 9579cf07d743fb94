#include "firmware/sources/guarded_move.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "kinematics/compliance.h"
#include "kinematics/directions.h"

namespace thimble::firmware {
namespace {

constexpr float kShortest_m = 1e-4F;  // a line shorter than this has no direction: only hold
constexpr float kCreep_m_s = 1e-3F;   // lowest speed, or the last of sqrt(2 a s) would take for ever
constexpr float kArrived_m = 1e-6F;
// On a surface that leans by 45 degrees neither the force along the line nor that across it reaches the limit, though together they are the
// most that is commanded. The set point then waits for a tip that does not come: after this time the force counts as reached.
constexpr float kWaits_s = 0.2F;

float norm(const Vec3& v) noexcept { return std::sqrt(v.squaredNorm()); }

MoveSample mean(const MoveSample& a, const MoveSample& b) noexcept {
  return {0.5F * (a.tip_m + b.tip_m), 0.5F * (a.force_N + b.force_N)};
}

// Speeds of the axes for 1 m/s of the tip along the line. 0 in a singular posture: no estimate.
Axes speeds_along(const kinematics::Arm<float>& arm, const kinematics::Posture<float>& posture,
                  const Vec3& direction) noexcept {
  Axes per_m = Axes::Zero();
  if (arm.is_two_link()) {
    const kinematics::Matrix3<float> jacobian = posture.jacobian.leftCols<3>();
    per_m.head<3>() = jacobian.inverse() * direction;
  } else {
    per_m = kinematics::directions_of(arm.driven_jacobian(posture))
                .speeds_for(direction, kinematics::kLeastLever_m);
  }
  if (!std::isfinite(per_m.squaredNorm())) per_m.setZero();
  return per_m;
}

// Joint friction as a force along the line, by power over speed. per_m: joint angle per metre along the line.
float friction_along(const kinematics::Arm<float>& arm, const Axes& per_m, float speed_m_s) noexcept {
  float friction_N = 0;
  for (int j = 0; j < arm.axes(); ++j) {
    const kinematics::AxisData& axis = arm.data().axis[static_cast<std::size_t>(j)];
    friction_N += axis.coulomb_N_m * std::abs(per_m[j]) +
                  axis.viscous_N_m_s_rad * per_m[j] * per_m[j] * std::abs(speed_m_s);
  }
  return friction_N;
}

}  // namespace

void SampleBuffer::add(const MoveSample& sample) noexcept {
  // A running mean: sums of positions would lose what an encoder resolves.
  const float weight = 1.0F / static_cast<float>(++summed_);
  sum_.tip_m += (sample.tip_m - sum_.tip_m) * weight;
  sum_.force_N += (sample.force_N - sum_.force_N) * weight;
  if (summed_ < interval_) return;
  samples_[count_++] = sum_;
  sum_ = {};
  summed_ = 0;
  if (count_ < kMaxSamples) return;
  for (std::size_t i = 0; i < kMaxSamples / 2; ++i) samples_[i] = mean(samples_[2 * i], samples_[2 * i + 1]);
  count_ = kMaxSamples / 2;
  interval_ *= 2;
}

void GuardedMove::start(const MoveOrder& order, const Vec3& tip_m, MoveResults& results) noexcept {
  start_m_ = state_ == State::kHolding && order.arm == order_.arm ? set_point_m_ : tip_m;
  order_ = order;
  state_ = State::kGoing;
  end_ = End::kNotYet;
  const Vec3 way_m = order.target_m - start_m_;
  length_m_ = norm(way_m);
  direction_ = length_m_ > kShortest_m ? Vec3(way_m / length_m_) : Vec3::Zero();
  if (!(length_m_ > kShortest_m)) length_m_ = 0;
  way_m_ = speed_m_s_ = waits_s_ = 0;
  set_point_m_ = start_m_;
  filtered_N_.setZero();
  results_ = &results;
  results.friction_N = results.peak_force_N = 0;
  results.turn_m = tip_m;
  results.going.clear();
  results.coming_back.clear();
}

void GuardedMove::stop() noexcept {
  if (under_way()) end_ = End::kStopped;
  state_ = State::kNone;
}

// Moves the set point: it accelerates, holds its speed, or brakes towards the end of the line. It is never more than lead_m ahead of
// where the move began.
void GuardedMove::advance(float period_s, float lead_m) noexcept {
  acceleration_m_s2_ = 0;
  if (!under_way()) return;
  const float left_m = state_ == State::kGoing ? length_m_ - way_m_ : way_m_;
  const float faster_m_s = std::abs(speed_m_s_) + kAcceleration_m_s2 * period_s;
  const float braking_m_s = std::max(std::sqrt(2.0F * kAcceleration_m_s2 * left_m), kCreep_m_s);
  const float speed_m_s = std::min({faster_m_s, braking_m_s, order_.speed_m_s});
  const float step_m = std::min(speed_m_s * period_s, left_m);
  const float last_m_s = speed_m_s_;
  speed_m_s_ = state_ == State::kGoing ? speed_m_s : -speed_m_s;
  acceleration_m_s2_ = (speed_m_s_ - last_m_s) / period_s;
  way_m_ += state_ == State::kGoing ? step_m : -step_m;
  if (state_ != State::kGoing) return;
  const bool waits = way_m_ > lead_m;
  waits_s_ = waits ? waits_s_ + period_s : 0.0F;
  if (waits) way_m_ = std::max(lead_m, 0.0F);
}

void GuardedMove::turn(End end, bool come_back) noexcept {
  end_ = end;
  speed_m_s_ = 0;
  state_ = come_back ? State::kComingBack : State::kHolding;
}

// Decides from the force of the last ticks and the position of the set point how the move goes on.
void GuardedMove::judge(const Vec3& tip_m, float speed_m_s, float friction_N) noexcept {
  const float along_N = filtered_N_.dot(direction_);
  const float sideways_N = norm(filtered_N_ - along_N * direction_);
  bool blocked = sideways_N >= order_.force_limit_N || speed_m_s > kTopSpeed_m_s;
  switch (state_) {
    case State::kGoing: {
      const float contact_N = along_N - friction_N;
      results_->peak_force_N = std::max(results_->peak_force_N, contact_N);
      results_->turn_m = tip_m;
      if (contact_N >= order_.force_limit_N || waits_s_ > kWaits_s) {
        turn(End::kForceReached, true);
      } else if (way_m_ >= length_m_ - kArrived_m) {
        turn(End::kTargetReached, order_.come_back);
      }
      break;
    }
    case State::kComingBack:
      blocked = blocked || -along_N - friction_N >= order_.force_limit_N;
      if (way_m_ <= kArrived_m) {
        speed_m_s_ = 0;
        state_ = State::kHolding;
      }
      break;
    case State::kHolding:
      blocked = blocked || norm(filtered_N_) >= order_.force_limit_N;
      break;
    case State::kNone:
      break;
  }
  if (!blocked) return;
  end_ = End::kBlocked;
  state_ = State::kNone;
}

LimitedForce GuardedMove::tick(const kinematics::Arm<float>& arm, const Axes& joint_rad,
                               const kinematics::Posture<float>& posture, const Vec3& tip_velocity_m_s,
                               const Vec3& last_force_N, float period_s) noexcept {
  const float lead_m =
      (posture.tip_m - start_m_).dot(direction_) + (order_.force_limit_N + kForceMargin_N) / kStiffness_N_m;
  advance(period_s, lead_m);
  const Axes per_m = speeds_along(arm, posture, direction_);
  const float friction_N = friction_along(arm, per_m, speed_m_s_);
  const float inertia_N = arm.mass_along(joint_rad, posture, per_m) * acceleration_m_s2_;
  const float sign = speed_m_s_ > 0 ? 1.0F : speed_m_s_ < 0 ? -1.0F : 0.0F;
  const Vec3 contact_N = last_force_N - (sign * friction_N + inertia_N) * direction_;
  Axes torque_N_m = Axes::Zero();
  kinematics::torques(posture.jacobian, contact_N, arm.axes(), torque_N_m);
  torque_N_m += arm.gravity_torques(posture);
  const Vec3 tip_m =
      posture.tip_m + kinematics::tip_stretch(posture, arm.stiffness_N_m_rad(), torque_N_m, arm.axes());
  const MoveSample sample{tip_m, contact_N.dot(direction_)};
  if (state_ == State::kGoing) {
    results_->friction_N = friction_N;
    results_->going.add(sample);
  } else if (state_ == State::kComingBack) {
    results_->coming_back.add(sample);
  }
  filtered_N_ += (last_force_N - filtered_N_) * (period_s / (kFilter_s + period_s));
  judge(tip_m, norm(tip_velocity_m_s), friction_N);

  set_point_m_ = start_m_ + way_m_ * direction_;
  const Vec3 force_N = kStiffness_N_m * (set_point_m_ - posture.tip_m) +
                       kDamping_N_s_m * (speed_m_s_ * direction_ - tip_velocity_m_s);
  return clamp_force(force_N, order_.force_limit_N + kForceMargin_N);
}

}  // namespace thimble::firmware

#include "host-tools/viewer/simulated_hands.h"

#include <algorithm>
#include <cmath>

#include "firmware/link/messages.h"

namespace thimble::host {
namespace {

namespace link = firmware::link;

constexpr double kHandTime_s = 0.02;  // time constant of the hand; a page sends 60 positions a second
constexpr double kHandSpeed_m_s = 0.5;
constexpr double kMostStep_s = 0.02;

}  // namespace

SimulatedHands::SimulatedHands(board::SimBoard& board) : arms_(board.options().arm_count) {
  for (std::size_t arm = 0; arm < arms_; ++arm) {
    const board::Vector3d tip_m = board.arm(arm).tip_m();
    hands_[arm].at_m = hands_[arm].home_m = {tip_m.x(), tip_m.y(), tip_m.z()};
  }
}

void SimulatedHands::want(std::size_t arm, const Vector& position_m) {
  const MutexLock lock(mutex_);
  if (arm >= arms_ || led_home_) return;
  hands_[arm].wanted_m = position_m;
  hands_[arm].fresh = true;
}

void SimulatedHands::lead_home(bool yes) {
  const MutexLock lock(mutex_);
  led_home_ = yes;
  for (std::size_t arm = 0; yes && arm < arms_; ++arm) {
    hands_[arm].wanted_m = hands_[arm].home_m;
    hands_[arm].fresh = true;
  }
}

bool SimulatedHands::LedHome::there() const {
  constexpr double kNear_m = 1e-5;
  const MutexLock lock(hands_.mutex_);
  bool near = true;
  for (std::size_t arm = 0; arm < hands_.arms_; ++arm) {
    const Hand& hand = hands_.hands_[arm];
    for (std::size_t i = 0; i < 3; ++i) near = near && std::abs(hand.at_m[i] - hand.home_m[i]) < kNear_m;
  }
  return near;
}

std::array<double, 3> SimulatedHands::hand_m(std::size_t arm) const {
  const MutexLock lock(mutex_);
  return hands_.at(arm).at_m;
}

SimulatedHands::Stamp SimulatedHands::stamp(std::uint8_t sequence) const {
  const MutexLock lock(mutex_);
  return stamps_[sequence];
}

void SimulatedHands::move(const board::LiveLoop::Round& round) {
  const MutexLock lock(mutex_);
  for (const link::CanFrame& frame : round.sent) {
    link::Pose pose;
    if (link::from_frame(frame, round.board.options().node_id, pose))
      stamps_[pose.sequence] = {round.board.controller().telemetry().tick, round.since_us};
  }
  const double step_s =
      std::min(last_us_ == 0 ? 0.0 : static_cast<double>(round.since_us - last_us_) * 1e-6, kMostStep_s);
  last_us_ = round.since_us;
  for (std::size_t arm = 0; arm < arms_; ++arm) {
    Hand& hand = hands_[arm];
    if (!hand.wanted_m) continue;
    using board::Vector3d;
    if (hand.fresh) {
      const Vector& p = *hand.wanted_m;
      const Vector3d goal_m = round.board.within_reach(arm, Vector3d(p[0], p[1], p[2]));
      hand.goal_m = {goal_m.x(), goal_m.y(), goal_m.z()};
      hand.fresh = false;
    }
    const Vector3d at_m(hand.at_m[0], hand.at_m[1], hand.at_m[2]);
    const Vector3d goal_m(hand.goal_m[0], hand.goal_m[1], hand.goal_m[2]);
    Vector3d velocity_m_s = (goal_m - at_m) / kHandTime_s;
    const double speed_m_s = velocity_m_s.norm();
    if (speed_m_s > kHandSpeed_m_s) velocity_m_s *= kHandSpeed_m_s / speed_m_s;
    const Vector3d next_m = at_m + std::min(step_s, kHandTime_s) * velocity_m_s;
    round.board.hold(arm, next_m, velocity_m_s);
    hand.at_m = {next_m.x(), next_m.y(), next_m.z()};
  }
}

}  // namespace thimble::host

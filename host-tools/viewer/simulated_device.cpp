#include "host-tools/viewer/simulated_device.h"

#include <fcntl.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <system_error>

#include "firmware/link/messages.h"
#include "host-tools/client/slcan_transport.h"

namespace thimble::host {
namespace {

namespace link = firmware::link;

constexpr double kHandTime_s = 0.02;  // time constant of the hand; a page sends 60 positions a second
constexpr double kHandSpeed_m_s = 0.5;
constexpr double kMostStep_s = 0.02;

board::LiveOptions with_socket(board::LiveOptions options, Descriptor& host_end) {
  std::array<int, 2> ends{};
  if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0, ends.data()) != 0)
    throw std::system_error(errno, std::generic_category(), "socketpair");
  host_end = Descriptor(ends[0]);
  options.host_socket = ends[1];
  return options;
}

}  // namespace

SimulatedDevice::SimulatedDevice(const board::LiveOptions& options) : live_(with_socket(options, host_end_)) {
  uri_ = live_.uris().front();
  arms_ = live_.board().options().arm_count;
  for (std::size_t arm = 0; arm < arms_; ++arm) {
    const board::Vector3d tip_m = live_.board().arm(arm).tip_m();
    hands_[arm].at_m = hands_[arm].home_m = {tip_m.x(), tip_m.y(), tip_m.z()};
  }
  thread_ = std::thread([this] {
    live_.run(
        [this] {
          const std::scoped_lock lock(mutex_);
          return stopping_;
        },
        [this](const board::LiveLoop::Round& round) { each(round); });
  });
}

SimulatedDevice::~SimulatedDevice() {
  {
    const std::scoped_lock lock(mutex_);
    stopping_ = true;
  }
  thread_.join();
}

std::unique_ptr<Transport> SimulatedDevice::connect() const {
  return open_socket(Descriptor(fcntl(host_end_.get(), F_DUPFD_CLOEXEC, 0)), uri_);
}

void SimulatedDevice::want(std::size_t arm, const Vector& position_m) {
  const std::scoped_lock lock(mutex_);
  if (arm >= arms_ || led_home_) return;
  hands_[arm].wanted_m = position_m;
  hands_[arm].fresh = true;
}

void SimulatedDevice::lead_home(bool yes) {
  const std::scoped_lock lock(mutex_);
  led_home_ = yes;
  for (std::size_t arm = 0; yes && arm < arms_; ++arm) {
    hands_[arm].wanted_m = hands_[arm].home_m;
    hands_[arm].fresh = true;
  }
}

bool SimulatedDevice::LedHome::there() const {
  constexpr double kNear_m = 1e-5;
  const std::scoped_lock lock(device_.mutex_);
  bool near = true;
  for (std::size_t arm = 0; arm < device_.arms_; ++arm) {
    const Hand& hand = device_.hands_[arm];
    for (std::size_t i = 0; i < 3; ++i) near = near && std::abs(hand.at_m[i] - hand.home_m[i]) < kNear_m;
  }
  return near;
}

std::array<double, 3> SimulatedDevice::hand_m(std::size_t arm) const {
  const std::scoped_lock lock(mutex_);
  return hands_.at(arm).at_m;
}

SimulatedDevice::Stamp SimulatedDevice::stamp(std::uint8_t sequence) const {
  const std::scoped_lock lock(mutex_);
  return stamps_[sequence];
}

void SimulatedDevice::each(const board::LiveLoop::Round& round) {
  const std::scoped_lock lock(mutex_);
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

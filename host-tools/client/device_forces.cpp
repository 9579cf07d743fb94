// Device: forces from the program (docs/host-rendering.md).
#include <algorithm>
#include <cmath>
#include <utility>

#include "host-tools/client/device.h"

namespace thimble::host {

using link::CanFrame;
using link::Micros;

namespace {

constexpr Micros kRateKnown_us =
    5'000'000;  // the device measures its rate over half a second; a slow simulator takes longer

}  // namespace

void Device::take_over(double readings_per_s) {
  const firmware::ParamRow& decimation = *firmware::find_param("telemetry_decimation");
  double rate_Hz = 0;
  const Micros deadline_us = now_us() + kRateKnown_us;
  while (rate_Hz <= 0) {  // measured over half a second after its start
    rate_Hz = static_cast<double>(state().tick_rate_Hz);
    if (now_us() > deadline_us) {
      throw Error(ExitCode::kRefused, "not-in-time", "the device does not report its tick rate",
                  "check with `thimble info` that its loop runs");
    }
  }
  const double before = read_param(decimation);
  write_param(*firmware::find_param("host_forces"), 1);
  write_param(decimation,
              std::clamp(std::floor(rate_Hz / readings_per_s), 1.0, static_cast<double>(decimation.max)));
  if (!decimation_before_) decimation_before_ = before;
  try {
    arm();
  } catch (const Error& error) {
    if (error.code == ExitCode::kRefused) release_forces();  // on a lost link this would fail too
    throw;
  }
  for (Rendered& arm : rendered_) arm.newest.reset();
}

void Device::hand_back() {
  disarm();
  release_forces();
}

void Device::release_forces() {
  write_param(*firmware::find_param("host_forces"), 0);
  if (decimation_before_) write_param(*firmware::find_param("telemetry_decimation"), *decimation_before_);
  decimation_before_.reset();
}

void Device::order_force(const std::array<double, 3>& force_N, unsigned arm) {
  if (arm >= info_.arms || arm >= rendered_.size() ||
      !std::ranges::all_of(force_N, [](double f) { return std::isfinite(f); })) {
    throw Error(ExitCode::kUsage, "bad-force", "the force is not finite, or the device has no such arm",
                "check the force and the number of the arm in the program");
  }
  link::ForceOrder order;
  order.x_N = static_cast<float>(force_N[0]);
  order.y_N = static_cast<float>(force_N[1]);
  order.z_N = static_cast<float>(force_N[2]);
  order.arm = static_cast<std::uint8_t>(arm);
  order.sequence = ++rendered_[arm].sequence;
  services_.send(link::to_frame(order, services_.options().node));
}

// The pose comes before the force of the same tick.
void Device::take_reading(const CanFrame& frame) {
  link::Pose pose;
  link::Force force;
  link::Status status;
  link::Emergency emergency;
  if (link::from_frame(frame, services_.options().node, pose)) {
    if (pose.arm < rendered_.size()) rendered_[pose.arm].pose = pose;
  } else if (link::from_frame(frame, services_.options().node, force)) {
    if (force.arm >= rendered_.size()) return;
    const link::Pose& at = rendered_[force.arm].pose;
    if (at.sequence != force.sequence) return;  // the pose is of another tick
    TipReading reading;
    reading.position_m = {static_cast<double>(at.x_m), static_cast<double>(at.y_m),
                          static_cast<double>(at.z_m)};
    reading.force_N = {static_cast<double>(force.x_N), static_cast<double>(force.y_N),
                       static_cast<double>(force.z_N)};
    reading.limiters = force.limiters;
    constexpr unsigned kMask = (1U << link::kSequenceBits) - 1;
    Rendered& rendered = rendered_[force.arm];
    rendered.readings =
        static_cast<std::uint8_t>(rendered.readings + ((force.sequence - rendered.readings) & kMask));
    reading.sequence = rendered.readings;
    reading.heard_us = now_us();
    rendered_[force.arm].newest = reading;
  } else if (link::from_frame(frame, services_.options().node, emergency)) {
    if (emergency.fault != 0) services_.faulted("rendering", emergency.fault);
  } else if (link::from_frame(frame, services_.options().node, status) && decimation_before_ &&
             status.mode != link::Mode::kArmed) {
    if (status.fault != 0) services_.faulted("rendering", status.fault);
    throw Error(ExitCode::kRefused, "not-armed",
                std::string("the device is ") + name(status.mode) + ", not armed",
                "hold the dead-man switch, then take over again");
  }
}

std::optional<TipReading> Device::next_tip(Micros deadline_us, unsigned arm) {
  std::optional<TipReading>& newest = rendered_.at(arm).newest;
  while (true) {
    // Frames that have arrived already are read first, so that the newest reading is returned.
    const std::optional<CanFrame> frame = telemetry(newest ? 0 : deadline_us);
    if (!frame) return std::exchange(newest, std::nullopt);
    take_reading(*frame);
  }
}

}  // namespace thimble::host

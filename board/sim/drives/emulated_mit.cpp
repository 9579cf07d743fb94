#include "board/sim/drives/emulated_mit.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace thimble::board::emulated {
namespace {

constexpr double kPositionTop = 12.5, kKpTop = 500, kKdTop = 5;
constexpr double kMitCounts = 16384;
constexpr double kMitCurrentLag_s = 160e-6, kMitVelocityLag_s = .4e-3, kReportLag_s = 237e-6;
constexpr double kMiniCheetahTimeout_s = 1000 * 25e-6, kDamiaoTimeout_s = .015;
constexpr double kDamiaoStep_s = 50e-6;
constexpr std::uint32_t kLost = 0xD;

double decode(std::uint64_t bits, unsigned at, unsigned width, double lo, double hi) {
  const std::uint64_t top = (std::uint64_t{1} << width) - 1;
  return lo + static_cast<double>(bits >> at & top) * (hi - lo) / static_cast<double>(top);
}

// As the firmware: truncated, not limited; what is beyond the range overflows the field.
std::uint64_t encode(double value, unsigned width, double top_value) {
  const double top = std::exp2(width) - 1;
  const auto code = static_cast<std::int64_t>(std::floor((value + top_value) * top / (2 * top_value)));
  return static_cast<std::uint64_t>(code) & ((std::uint64_t{1} << width) - 1);
}

}  // namespace

EmulatedMit::EmulatedMit(Flavour flavour, std::uint16_t id, std::uint16_t reply_id, double velocity_rad_s,
                         double torque_N_m)
    : EmulatedDrive(kMitCurrentLag_s, kMitVelocityLag_s),
      flavour_(flavour),
      id_(id),
      reply_id_(reply_id),
      velocity_top_(velocity_rad_s),
      torque_top_(torque_N_m) {
  const auto bits = [](double value) { return std::bit_cast<std::uint32_t>(static_cast<float>(value)); };
  registers = {
      {7, reply_id},          {8, id}, {9, 0}, {10, 1}, {21, bits(kPositionTop)}, {22, bits(velocity_rad_s)},
      {23, bits(torque_N_m)}, {35, 4}};
  set_watchdog_s(flavour == Flavour::kDamiao ? kDamiaoTimeout_s : kMiniCheetahTimeout_s);
}

double EmulatedMit::encoder_step_rad() const { return kTurn_rad / kMitCounts; }

// The encoder of the output knows one turn; the count of turns is lost.
void EmulatedMit::reboot() {
  enabled_ = false;
  error_ = 0;
  orders_ = {};
  zero_rad_ = std::round(shaft.position_rad / kTurn_rad) * kTurn_rad;
}

void EmulatedMit::set_watchdog_s(double time_s) {
  registers[9] = static_cast<std::uint32_t>(std::lround(time_s / kDamiaoStep_s));
}

void EmulatedMit::fail(std::uint32_t code) {
  enabled_ = false;
  error_ = code;
}

double EmulatedMit::timeout_s() const { return registers.at(9) * kDamiaoStep_s; }

void EmulatedMit::on_step() {
  smoothed_N_m_ += (reported_torque_N_m() - smoothed_N_m_) * (1 - std::exp(-25e-6 / kReportLag_s));
  const double limit = timeout_s();
  if (!enabled_ || inject.watchdog_off || limit == 0 ||
      static_cast<double>(now_us() - heard_us_) * 1e-6 <= limit)
    return;
  if (flavour_ == Flavour::kDamiao) {
    fail(kLost);
  } else {
    timed_out_ = true;
    orders_ = {};  // still enabled, and without a word
  }
}

double EmulatedMit::wanted_torque_N_m() {
  if (!enabled_) return 0;
  const double torque = orders_.torque_N_m + orders_.kd * (orders_.velocity_rad_s - velocity_rad_s()) +
                        orders_.kp * (orders_.position_rad - (shaft.position_rad - zero_rad_));
  return std::clamp(torque, -torque_top_, torque_top_);
}

void EmulatedMit::on_frame(const CanFrame& frame) {
  if (frame.extended || frame.remote || frame.size != 8 || (frame.fd && !takes_fd)) return;
  if (flavour_ == Flavour::kDamiao && frame.id == 0x7FF) return answer_register(frame);
  if (frame.id != id_) return;
  std::uint64_t bits = 0;
  for (std::size_t i = 0; i < 8; ++i) bits = bits << 8U | frame.data[i];
  // Before the command is applied.
  if (bits >> 8U == 0xFFFFFFFFFFFFFF && frame.data[7] >= 0xFB) {
    const std::uint8_t last = frame.data[7];
    if (flavour_ == Flavour::kDamiao) take_magic(last);  // its answer shows the new state
    answer(frame.fd);
    if (flavour_ != Flavour::kDamiao) take_magic(last);
    heard_us_ = now_us();
    timed_out_ = false;
    return;
  }
  answer(frame.fd);
  heard_us_ = now_us();
  timed_out_ = false;
  orders_ = {decode(bits, 48, 16, -kPositionTop, kPositionTop),
             decode(bits, 36, 12, -velocity_top_, velocity_top_), decode(bits, 24, 12, 0, kKpTop),
             decode(bits, 12, 12, 0, kKdTop), decode(bits, 0, 12, -torque_top_, torque_top_)};
}

void EmulatedMit::take_magic(std::uint8_t last) {
  if (last == 0xFC && error_ == 0) {
    enabled_ = true;
    orders_ = {};
  } else if (last == 0xFD) {
    enabled_ = false;
  } else if (last == 0xFE) {
    zero_rad_ = shaft.position_rad;
    ++zeroed_;
  } else if (last == 0xFB) {
    error_ = 0;
  }
}

void EmulatedMit::answer(bool fd) {
  const std::uint64_t body = encode(read_encoder_rad() - zero_rad_, 16, kPositionTop) << 24U |
                             encode(velocity_rad_s(), 12, velocity_top_) << 12U |
                             encode(smoothed_N_m_, 12, torque_top_);
  CanFrame out;
  out.id = reply_id_;
  out.fd = out.bit_rate_switch = fd;
  for (std::size_t i = 0; i < 5; ++i) out.data[1 + i] = static_cast<std::uint8_t>(body >> (8 * (4 - i)));
  out.data[0] = static_cast<std::uint8_t>(id_);
  out.size = 8;
  switch (flavour_) {
    case Flavour::kMiniCheetah:
      out.size = old_reply ? 6 : 7;
      out.data[6] = old_reply ? 0 : 153;  // 24 V
      break;
    case Flavour::kCubeMars:
      out.data[6] = 30 + 40;
      out.data[7] = static_cast<std::uint8_t>(error_);
      break;
    case Flavour::kDamiao: {
      const std::uint32_t state = error_ != 0 ? error_ : enabled_ ? 1 : 0;
      out.data[0] = static_cast<std::uint8_t>(state << 4U | (id_ & 0xFU));
      out.data[6] = 41;
      out.data[7] = 38;
      break;
    }
  }
  send(out);
}

void EmulatedMit::answer_register(const CanFrame& frame) {
  if ((frame.data[0] | frame.data[1] << 8) != id_) return;
  const auto found = registers.find(frame.data[3]);
  if (found == registers.end() || (frame.data[2] != 0x33 && frame.data[2] != 0x55)) return;
  if (frame.data[2] == 0x55) {
    found->second = 0;
    for (std::size_t i = 0; i < 4; ++i)
      found->second |= static_cast<std::uint32_t>(frame.data[4 + i]) << (8 * i);
  }
  CanFrame out = frame;
  out.id = reply_id_;
  for (std::size_t i = 0; i < 4; ++i) out.data[4 + i] = static_cast<std::uint8_t>(found->second >> (8 * i));
  send(out);
}

}  // namespace thimble::board::emulated

#include "board/linux/drives/mit.h"

#include <algorithm>
#include <cmath>

#include "board/linux/drives/bytes.h"

namespace thimble::board::drives::mit {
namespace {

constexpr std::uint8_t kReadRegister = 0x33;
constexpr std::uint8_t kWriteRegister = 0x55;
constexpr float kSupplyStep_V = 40.0F / 255.0F;
constexpr float kCubeMarsOffset_C = 40;

float steps(float value, const Range& range) {
  return (std::clamp(value, range.lo, range.hi) - range.lo) * static_cast<float>(range.top()) /
         (range.hi - range.lo);
}

CanFrame frame_of(std::uint32_t id, bool fd) {
  CanFrame frame;
  frame.id = id;
  frame.size = 8;
  frame.fd = fd;
  frame.bit_rate_switch = fd;
  return frame;
}

CanFrame register_frame(std::uint16_t id, std::uint8_t order, std::uint8_t number, std::uint32_t value,
                        bool fd) {
  CanFrame frame = frame_of(kRegisterId, fd);
  put_u(frame, 0, id, 2);
  frame.data[2] = order;
  frame.data[3] = number;
  put_u(frame, 4, value, 4);
  return frame;
}

// The motor's id in byte 0 of a reply.
bool names_motor(Kind kind, std::uint16_t id, std::uint8_t byte) {
  return is_damiao(kind) ? (byte & 0xFU) == (id & 0xFU) : byte == (id & 0xFFU);
}

void take_damiao(const CanFrame& frame, Sample& sample) {
  const std::uint8_t error = frame.data[0] >> 4U;
  constexpr std::uint8_t kLost = 0xD;
  sample.drive_fault = error <= 1 ? 0 : error;
  sample.stage = error == 0       ? Stage::kOff
                 : error == 1     ? Stage::kOn
                 : error == kLost ? Stage::kTimedOut
                                  : Stage::kFaulted;
  sample.drive_C = frame.data[6];
  sample.motor_C = frame.data[7];
}

void take_cubemars(const CanFrame& frame, Sample& sample) {
  sample.motor_C = static_cast<float>(frame.data[6]) - kCubeMarsOffset_C;
  sample.drive_fault = frame.data[7];
  if (sample.drive_fault != 0) sample.stage = Stage::kFaulted;
}

}  // namespace

std::uint16_t nearest(float value, const Range& range) noexcept {
  return static_cast<std::uint16_t>(std::lround(steps(value, range)));
}

std::uint16_t truncated(float value, const Range& range) noexcept {
  return static_cast<std::uint16_t>(steps(value, range));
}

float value_of(std::uint16_t code, const Range& range) noexcept {
  return range.lo + static_cast<float>(code) * (range.hi - range.lo) / static_cast<float>(range.top());
}

CanFrame pack(std::uint16_t id, const Codes& codes, bool fd) noexcept {
  CanFrame frame = frame_of(id, fd);
  const unsigned kp = std::min<unsigned>(codes.kp, 0xFFE);
  const auto put = [&frame](std::size_t at, unsigned value) {
    frame.data[at] = static_cast<std::uint8_t>(value);
  };
  put(0, codes.position >> 8U);
  put(1, codes.position);
  put(2, codes.velocity >> 4U);
  put(3, (codes.velocity & 0xFU) << 4U | kp >> 8U);
  put(4, kp);
  put(5, codes.kd >> 4U);
  put(6, (codes.kd & 0xFU) << 4U | codes.torque >> 8U);
  put(7, codes.torque);
  return frame;
}

Codes codes_of(const CanFrame& frame) noexcept {
  const auto code = [](unsigned value) { return static_cast<std::uint16_t>(value); };
  const auto& d = frame.data;
  return {code(unsigned{d[0]} << 8U | d[1]), code(unsigned{d[2]} << 4U | unsigned{d[3]} >> 4U),
          code((d[3] & 0xFU) << 8U | d[4]), code(unsigned{d[5]} << 4U | unsigned{d[6]} >> 4U),
          code((d[6] & 0xFU) << 8U | d[7])};
}

Codes Dither::codes(const Command& command, const Ranges& ranges) noexcept {
  Codes codes;
  codes.position = nearest(0, ranges.position);
  codes.velocity = nearest(0, ranges.velocity);
  codes.kd = nearest(command.damping_N_m_s_rad, ranges.kd);
  const float bias_N_m = value_of(codes.kd, ranges.kd) * value_of(codes.velocity, ranges.velocity);
  const float wanted_N_m = command.torque_N_m - bias_N_m + owed_N_m_;
  codes.torque = nearest(wanted_N_m, ranges.torque);
  // At the end of the range the rest is lost, not owed.
  const float half_step = ranges.torque.step();
  owed_N_m_ = std::clamp(wanted_N_m - value_of(codes.torque, ranges.torque), -half_step, half_step);
  return codes;
}

CanFrame pack_magic(std::uint16_t id, Magic magic, bool fd) noexcept {
  CanFrame frame = frame_of(id, fd);
  std::fill_n(frame.data.begin(), 7, std::uint8_t{0xFF});
  frame.data[7] = static_cast<std::uint8_t>(magic);
  return frame;
}

CanFrame pack_read_register(std::uint16_t id, std::uint8_t number, bool fd) noexcept {
  return register_frame(id, kReadRegister, number, 0, fd);
}

CanFrame pack_write_register(std::uint16_t id, std::uint8_t number, std::uint32_t value, bool fd) noexcept {
  return register_frame(id, kWriteRegister, number, value, fd);
}

Unpacked unpack(Kind kind, std::uint16_t id, std::uint16_t master_id, const Ranges& ranges,
                std::uint8_t asked, const CanFrame& frame, Sample& sample) noexcept {
  Unpacked out;
  if (frame.extended || frame.remote || frame.id != master_id) return out;
  const bool old_reply = kind == Kind::kMiniCheetah && frame.size == 6;
  const std::size_t size = kind == Kind::kMiniCheetah ? 7 : 8;
  if (frame.size != size && !old_reply) {
    out.reply = Reply::kMalformed;
    return out;
  }
  if (is_damiao(kind) && asked != 0 && get_u(frame, 0, 2) == id && frame.data[3] == asked &&
      (frame.data[2] == kReadRegister || frame.data[2] == kWriteRegister)) {
    out = {Reply::kAnswer, asked, get_u(frame, 4, 4)};
    return out;
  }
  if (!names_motor(kind, id, frame.data[0])) return out;
  out.reply = Reply::kMotion;
  const auto& d = frame.data;
  const auto code = [](unsigned value) { return static_cast<std::uint16_t>(value); };
  sample.position_rad = value_of(code(unsigned{d[1]} << 8U | d[2]), ranges.position);
  sample.velocity_rad_s = value_of(code(unsigned{d[3]} << 4U | unsigned{d[4]} >> 4U), ranges.velocity);
  sample.torque_N_m = value_of(code((d[4] & 0xFU) << 8U | d[5]), ranges.torque);
  if (is_damiao(kind)) {
    take_damiao(frame, sample);
  } else if (kind == Kind::kCubeMars) {
    take_cubemars(frame, sample);
  } else if (!old_reply) {
    sample.supply_V = static_cast<float>(d[6]) * kSupplyStep_V;
  }
  return out;
}

}  // namespace thimble::board::drives::mit

#include "board/linux/drives/moteus.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "board/linux/drives/bytes.h"

namespace thimble::board::drives::moteus {
namespace {

enum Register : std::uint16_t {
  kMode = 0x000,
  kPosition = 0x001,
  kVelocity = 0x002,
  kTorque = 0x003,
  kQCurrent = 0x004,
  kDCurrent = 0x005,
  kMotorTemperature = 0x00A,
  kHomeState = 0x00C,
  kVoltage = 0x00D,
  kBoardTemperature = 0x00E,
  kFault = 0x00F,
  kCommandPosition = 0x020,
  kCommandTorque = 0x022,
  kCommandKpScale = 0x023,
  kCommandTimeout = 0x027,
  kMillisecondCounter = 0x070,
};

enum Subframe : std::uint8_t {
  kWriteInt8 = 0x00,
  kWriteInt16 = 0x04,
  kWriteFloat = 0x0C,
  kReadInt8 = 0x10,
  kReadInt16 = 0x14,
  kReadFloat = 0x1C,
  kReplyInt8 = 0x20,
  kReplyEnd = 0x30,
  kWriteError = 0x30,
  kReadError = 0x31,
  kClientToServer = 0x40,
  kServerToClient = 0x41,
  kClientPollServer = 0x42,
  kNoOperation = 0x50,
};

constexpr std::uint8_t kDiagnosticChannel = 1;
constexpr std::uint8_t kPositionMode = 10;
constexpr float kFullScale16 = 32767.0F;
constexpr std::uint32_t kNotAFault = 96;  // from here to kLastLimiter the fault register says who limits
constexpr std::uint32_t kLastLimiter = 103;

class Writer {
 public:
  explicit Writer(std::uint8_t id) {
    frame_.id = 0x8000U | id;
    frame_.extended = true;
    frame_.fd = true;
    frame_.bit_rate_switch = true;
  }
  void u8(unsigned value) { frame_.data[frame_.size++] = static_cast<std::uint8_t>(value); }
  void u16(unsigned value) {
    put_u(frame_, frame_.size, value, 2);
    frame_.size = static_cast<std::uint8_t>(frame_.size + 2);
  }
  void number(float value) {
    put_float(frame_, frame_.size, value);
    frame_.size = static_cast<std::uint8_t>(frame_.size + 4);
  }
  void characters(std::string_view text) {
    for (const char c : text) u8(static_cast<std::uint8_t>(c));
  }
  [[nodiscard]] CanFrame finish() {
    const std::uint8_t size = firmware::link::fd_size(frame_.size);
    while (frame_.size < size) u8(kNoOperation);
    return frame_;
  }

 private:
  CanFrame frame_;
};

void write_mode(Writer& out, std::uint8_t mode) {
  out.u8(kWriteInt8 | 1U);
  out.u8(kMode);
  out.u8(mode);
}

void write_query(Writer& out, Query query) {
  if (query == Query::kNone) return;
  if (query == Query::kMotion) {
    out.u8(kReadFloat | 2U);
    out.u8(kPosition);
    return;
  }
  out.u8(kReadFloat);
  out.u8(4);
  out.u8(kPosition);
  out.u8(kReadInt8 | 1U);
  out.u8(kMode);
  out.u8(kReadInt8 | 3U);
  out.u8(kVoltage);
  if (query == Query::kCounted) {
    out.u8(kReadInt16 | 1U);
    out.u8(kMillisecondCounter);
  }
}

// One value of a reply: float, or an integer of `bytes` with its type's unit.
struct Units {
  float of8, of16, of32;
};
constexpr Units kPlain = {1, 1, 1};

Units units_of(std::uint32_t reg) {
  switch (reg) {
    case kPosition:
      return {.01F, .0001F, .00001F};
    case kVelocity:
      return {.1F, .00025F, .00001F};
    case kTorque:
      return {.5F, .01F, .001F};
    case kQCurrent:
    case kDCurrent:
    case kMotorTemperature:
    case kBoardTemperature:
      return {1, .1F, .001F};
    case kVoltage:
      return {.5F, .1F, .001F};
    default:
      return kPlain;
  }
}

enum class Type : std::uint8_t { kInt8, kInt16, kInt32, kFloat };
constexpr std::size_t size_of(Type type) { return type == Type::kInt8 ? 1 : type == Type::kInt16 ? 2 : 4; }

float value_of(const CanFrame& frame, std::size_t at, Type type, std::uint32_t reg) {
  if (type == Type::kFloat) return get_float(frame, at);
  const std::size_t bytes = size_of(type);
  const std::uint32_t raw = get_u(frame, at, bytes);
  const std::uint32_t sign = 1U << (8U * bytes - 1U);
  if (raw == sign) return kNoValue;  // the most negative integer
  const auto value = static_cast<float>(std::bit_cast<std::int32_t>((raw ^ sign) - sign));
  const Units units = units_of(reg);
  return value * (type == Type::kInt8 ? units.of8 : type == Type::kInt16 ? units.of16 : units.of32);
}

Stage stage_of(float mode) {
  if (mode == 0) return Stage::kOff;
  if (mode == 1) return Stage::kFaulted;
  if (mode >= 2 && mode <= 4) return Stage::kStarting;
  if (mode == 11) return Stage::kTimedOut;
  if (mode >= 5 && mode <= 15) return Stage::kOn;
  return Stage::kUnknown;
}

Limiter limiter_of(std::uint32_t code) {
  switch (code) {
    case 98:
      return Limiter::kVoltage;
    case 99:
      return Limiter::kCurrent;
    case 102:
      return Limiter::kTorque;
    default:
      return Limiter::kOther;
  }
}

// A reply may carry any float there, NaN too: 0 for what is no such number.
template <class Integer>
Integer whole(float value, float most) {
  return value >= 0 && value <= most ? static_cast<Integer>(value) : Integer{0};
}

void take_fault(float value, Sample& sample) {
  constexpr std::uint32_t kNoCode = 0xFFFF;  // a number that is none is a fault too
  const auto whole_code = whole<std::uint32_t>(value, 0xFFFF);
  const std::uint32_t code = value == 0 || whole_code != 0 ? whole_code : kNoCode;
  const bool limits = code >= kNotAFault && code <= kLastLimiter;
  sample.limiter = limits ? limiter_of(code) : Limiter::kNone;
  sample.drive_fault = limits ? 0 : code;
}

void take(std::uint32_t reg, float value, Sample& sample) {
  switch (reg) {
    case kMode:
      sample.stage = stage_of(value);
      return;
    case kPosition:
      sample.position_rad = value * kTurn_rad;
      return;
    case kVelocity:
      sample.velocity_rad_s = value * kTurn_rad;
      return;
    case kTorque:
      sample.torque_N_m = value;
      return;
    case kQCurrent:
      sample.current_A = value;
      return;
    case kMotorTemperature:
      sample.motor_C = value;
      return;
    case kHomeState:
      sample.home_state = whole<std::uint8_t>(value, 0xFF);
      return;
    case kVoltage:
      sample.supply_V = value;
      return;
    case kBoardTemperature:
      sample.drive_C = value;
      return;
    case kFault:
      take_fault(value, sample);
      return;
    case kMillisecondCounter:
      sample.counter_ms = whole<std::uint16_t>(value, 0xFFFF);
      return;
    default:
      return;
  }
}

class Reader {
 public:
  explicit Reader(const CanFrame& frame) : frame_(frame) {}
  [[nodiscard]] bool more() const { return at_ < frame_.size; }
  [[nodiscard]] bool has(std::size_t bytes) const { return at_ + bytes <= frame_.size; }
  [[nodiscard]] std::uint32_t varuint() {
    std::uint32_t value = 0;
    for (unsigned shift = 0; shift < 28 && more(); shift += 7) {
      const std::uint8_t byte = frame_.data[at_++];
      value |= (byte & 0x7FU) << shift;
      if ((byte & 0x80U) == 0) return value;
    }
    good_ = false;
    return 0;
  }
  [[nodiscard]] std::size_t at() const { return at_; }
  void skip(std::size_t bytes) { at_ += bytes; }
  [[nodiscard]] bool good() const { return good_; }

 private:
  const CanFrame& frame_;
  std::size_t at_ = 0;
  bool good_ = true;
};

bool read_values(Reader& in, const CanFrame& frame, std::uint32_t subframe, Sample& sample, bool& motion) {
  const auto type = static_cast<Type>((subframe >> 2U) & 3U);
  std::uint32_t count = subframe & 3U;
  if (count == 0) count = in.varuint();
  const std::uint32_t first = in.varuint();
  if (!in.good() || count > frame.size || !in.has(count * size_of(type))) return false;
  for (std::uint32_t i = 0; i < count; ++i) {
    take(first + i, value_of(frame, in.at(), type, first + i), sample);
    motion = motion || first + i == kPosition;
    in.skip(size_of(type));
  }
  return true;
}

}  // namespace

CanFrame pack_motion(std::uint8_t id, const Motion& motion, Query query) noexcept {
  Writer out(id);
  write_mode(out, kPositionMode);
  out.u8(kWriteInt8 | 2U);
  out.u8(kCommandPosition);
  out.u8(0x80);  // NaN: no position
  out.u8(0);     // velocity
  out.u8(kWriteFloat | 1U);
  out.u8(kCommandTorque);
  out.number(motion.torque_N_m);
  out.u8(kWriteInt16 | 2U);
  out.u8(kCommandKpScale);
  out.u16(0);
  out.u16(static_cast<unsigned>(std::lround(std::clamp(motion.kd_scale, 0.0F, 1.0F) * kFullScale16)));
  if (motion.timeout_ms != 0) {
    out.u8(kWriteInt16 | 1U);
    out.u8(kCommandTimeout);
    out.u16(std::min<unsigned>(motion.timeout_ms, 0x7FFF));
  }
  write_query(out, query);
  return out.finish();
}

CanFrame pack_stop(std::uint8_t id, Query query) noexcept {
  Writer out(id);
  write_mode(out, 0);
  write_query(out, query);
  return out.finish();
}

CanFrame pack_query(std::uint8_t id, Query query) noexcept {
  Writer out(id);
  write_query(out, query);
  return out.finish();
}

CanFrame pack_home_query(std::uint8_t id) noexcept {
  Writer out(id);
  out.u8(kReadInt8 | 1U);
  out.u8(kHomeState);
  write_query(out, Query::kAll);
  return out.finish();
}

CanFrame pack_text(std::uint8_t id, std::string_view text) noexcept {
  Writer out(id);
  if (!text.empty()) {
    const std::string_view part = text.substr(0, kMostText);
    out.u8(kClientToServer);
    out.u8(kDiagnosticChannel);
    out.u8(static_cast<unsigned>(part.size()));
    out.characters(part);
  }
  out.u8(kClientPollServer);
  out.u8(kDiagnosticChannel);
  out.u8(48);
  return out.finish();
}

Unpacked unpack(std::uint8_t id, const CanFrame& frame, Sample& sample) noexcept {
  Unpacked out;
  if (frame.remote || (frame.id & 0xFFFFU) != reply_id(id)) return out;
  if (!frame.fd) {
    out.reply = Reply::kMalformed;
    return out;
  }
  Reader in(frame);
  bool motion = false;
  Sample read = sample;
  out.reply = Reply::kTelemetry;
  while (in.more()) {
    const std::uint32_t subframe = in.varuint();
    bool good = in.good();
    if (subframe == kNoOperation) continue;
    if (subframe >= kReplyInt8 && subframe < kReplyEnd) {
      good = good && read_values(in, frame, subframe, read, motion);
    } else if (subframe == kWriteError || subframe == kReadError) {
      out.rejected_register = static_cast<std::uint16_t>(in.varuint());
      out.error = static_cast<std::uint16_t>(in.varuint());
      good = good && in.good();
      out.reply = Reply::kRejected;
    } else if (subframe == kServerToClient) {
      const std::uint32_t channel = in.varuint();
      const std::uint32_t length = in.varuint();
      good = good && in.good() && channel == kDiagnosticChannel && in.has(length);
      if (good) out.text = {reinterpret_cast<const char*>(frame.data.data()) + in.at(), length};
      in.skip(length);
      out.reply = Reply::kAnswer;
    } else {
      good = false;
    }
    if (!good) {
      out.reply = Reply::kMalformed;
      return out;
    }
  }
  sample = read;
  if (motion && out.reply == Reply::kTelemetry) out.reply = Reply::kMotion;
  return out;
}

float kd_scale_of(float damping_N_m_s_rad, float kd) noexcept {
  return kd > 0 ? std::clamp(damping_N_m_s_rad * kTurn_rad / kd, 0.0F, 1.0F) : 0.0F;
}

}  // namespace thimble::board::drives::moteus

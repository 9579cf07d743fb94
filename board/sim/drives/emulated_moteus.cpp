#include "board/sim/drives/emulated_moteus.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <vector>

namespace thimble::board::emulated {
namespace {

constexpr double kMoteusCounts = 16384;
constexpr double kRotorTurns = 1;                // of the rotor in one of the output
constexpr double kBrake_N_m_s_rad = .01;         // phases shorted
constexpr double kMoteusVelocityLag_s = .00079;  // pll_filter_hz 1000
constexpr double kMoteusCurrentLag_s = 160e-6;

enum class Unit : std::uint8_t { kInteger, kPosition, kVelocity, kTorque, kCurrent, kVoltage, kScale, kTime };

Unit unit_of(std::uint32_t reg) {
  switch (reg) {
    case 0x001:
    case 0x020:
      return Unit::kPosition;
    case 0x002:
    case 0x021:
      return Unit::kVelocity;
    case 0x003:
    case 0x022:
    case 0x025:
      return Unit::kTorque;
    case 0x004:
    case 0x005:
    case 0x00A:
    case 0x00E:
      return Unit::kCurrent;
    case 0x00D:
      return Unit::kVoltage;
    case 0x023:
    case 0x024:
      return Unit::kScale;
    case 0x027:
      return Unit::kTime;
    default:
      return Unit::kInteger;
  }
}

// What one step of a type is. type: 0 int8, 1 int16, 2 int32, 3 float.
double step_of(std::uint32_t reg, unsigned type) {
  static constexpr double kSteps[8][3] = {{1, 1, 1},
                                          {.01, .0001, .00001},
                                          {.1, .00025, .00001},
                                          {.5, .01, .001},
                                          {1, .1, .001},
                                          {.5, .1, .001},
                                          {1.0 / 127, 1.0 / 32767, 1.0 / 2147483647},
                                          {.01, .001, 1e-6}};
  return type == 3 ? 1 : kSteps[static_cast<std::size_t>(unit_of(reg))][type];
}

std::size_t bytes_of(unsigned type) { return type == 0 ? 1 : type == 1 ? 2 : 4; }

double number_at(const std::uint8_t* at, unsigned type, double step) {
  if (type == 3) {
    float value = 0;
    std::memcpy(&value, at, 4);
    return static_cast<double>(value);
  }
  std::int64_t value = 0;
  for (std::size_t i = 0; i < bytes_of(type); ++i) value |= std::int64_t{at[i]} << (8 * i);
  const std::int64_t half = std::int64_t{1} << (8 * bytes_of(type) - 1);
  if (value >= half) value -= 2 * half;
  return value == -half ? std::numeric_limits<double>::quiet_NaN() : static_cast<double>(value) * step;
}

void append(std::vector<std::uint8_t>& out, unsigned type, double value, double step) {
  if (type == 3) {
    const auto number = static_cast<float>(value);
    std::array<std::uint8_t, 4> raw{};
    std::memcpy(raw.data(), &number, 4);
    out.insert(out.end(), raw.begin(), raw.end());
    return;
  }
  const double top = std::exp2(8.0 * static_cast<double>(bytes_of(type)) - 1) - 1;
  const std::int64_t code =
      std::isnan(value) ? -static_cast<std::int64_t>(top) - 1
                        : static_cast<std::int64_t>(std::llround(std::clamp(value / step, -top, top)));
  for (std::size_t i = 0; i < bytes_of(type); ++i) out.push_back(static_cast<std::uint8_t>(code >> (8 * i)));
}

}  // namespace

struct EmulatedMoteus::Reply {
  std::vector<std::uint8_t> bytes;
};

EmulatedMoteus::EmulatedMoteus(std::uint8_t id)
    : EmulatedDrive(kMoteusCurrentLag_s, kMoteusVelocityLag_s),
      config{{"servo.default_timeout_s", .1},    {"servo.timeout_mode", 12},
             {"servo.pid_position.kp", 4},       {"servo.pid_position.kd", .25},
             {"servo.pid_position.ki", 0},       {"servo.max_current_A", 20},
             {"servo.timeout_max_torque_Nm", 5}, {"motor_position.rotor_to_output_ratio", 1}},
      id_(id) {}

double EmulatedMoteus::encoder_step_rad() const { return kTurn_rad / kMoteusCounts; }
bool EmulatedMoteus::powered() const { return mode_ == 9 || mode_ == 10 || mode_ == 11; }

void EmulatedMoteus::reboot() {
  mode_ = 0;
  fault_ = 0;
  pending_ = active_ = {};
  booted_us_ = now_us();
  const double turn = kTurn_rad / kRotorTurns;
  zero_rad_ = std::round(shaft.position_rad / turn) * turn;
}

void EmulatedMoteus::set_watchdog_s(double time_s) { config["servo.default_timeout_s"] = time_s; }

void EmulatedMoteus::fail(std::uint32_t code) {
  mode_ = 1;
  fault_ = code;
}

void EmulatedMoteus::on_step() {
  if (mode_ != 10 || inject.watchdog_off) return;  // mode 9 has none
  const double own = config.at("servo.default_timeout_s");
  const double timeout_s = active_.timeout_s > 0 ? active_.timeout_s : own;
  if (static_cast<double>(now_us() - ordered_us_) * 1e-6 > timeout_s) mode_ = 11;
}

double EmulatedMoteus::damped(double kd) const { return -kd * velocity_rad_s() / kTurn_rad; }

double EmulatedMoteus::wanted_torque_N_m() {
  const double kd = config.at("servo.pid_position.kd") * active_.kd_scale;
  const double most = active_.most_torque_N_m;
  if (mode_ == 9) return active_.torque_N_m;
  if (mode_ == 10) {
    double torque = active_.torque_N_m + kd * active_.velocity + damped(kd);
    if (!std::isnan(active_.position))
      torque += config.at("servo.pid_position.kp") * active_.kp_scale *
                (active_.position - (shaft.position_rad - zero_rad_) / kTurn_rad);
    return std::clamp(torque, -most, most);
  }
  if (mode_ != 11) return 0;
  const double weak = config.at("servo.timeout_max_torque_Nm");
  switch (static_cast<int>(config.at("servo.timeout_mode"))) {
    case 12:
      return std::clamp(damped(kd), -weak, weak);
    case 15:
      return -kBrake_N_m_s_rad * shaft.velocity_rad_s;
    default:
      return 0;
  }
}

void EmulatedMoteus::on_frame(const CanFrame& frame) {
  // FD only; ids from 2048 on are of 29 bits.
  if (!frame.fd || (frame.id & 0x7FU) != id_ || (frame.id & 0x80U) != 0 ||
      ((frame.id & 0x8000U) != 0) != frame.extended)
    return;
  Reply reply;
  commanded_ = false;
  take_subframes(frame, reply);
  if (commanded_) apply(pending_);
  if ((frame.id & 0x8000U) == 0) return;
  CanFrame out;
  out.id = static_cast<std::uint32_t>(id_) << 8U | ((frame.id >> 8U) & 0x7FU);
  out.extended = out.id >= 2048;
  out.fd = out.bit_rate_switch = true;
  out.size = firmware::link::fd_size(std::min<std::size_t>(reply.bytes.size(), 64));
  out.data.fill(0x50);
  std::copy_n(reply.bytes.begin(), std::min<std::size_t>(reply.bytes.size(), 64), out.data.begin());
  send(out);
}

// Each step of the row; a read shows what was written before it in the same frame, but the torque of the last one.
void EmulatedMoteus::take_subframes(const CanFrame& frame, Reply& reply) {
  std::size_t at = 0;
  const auto more = [&] { return at < frame.size; };
  const auto varuint = [&] {
    std::uint32_t value = 0;
    for (unsigned shift = 0; more(); shift += 7) {
      const std::uint8_t byte = frame.data[at++];
      value |= (byte & 0x7FU) << shift;
      if ((byte & 0x80U) == 0) break;
    }
    return value;
  };
  while (more()) {
    const std::uint8_t subframe = frame.data[at++];
    if (subframe == 0x50) continue;
    if (subframe < 0x20) {
      const unsigned type = (subframe >> 2U) & 3U;
      std::uint32_t count = subframe & 3U;
      if (count == 0) count = varuint();
      const std::uint32_t first = varuint();
      const bool reads = subframe >= 0x10;
      if (reads) {
        reply.bytes.push_back(static_cast<std::uint8_t>(0x20U | type << 2U | (count < 4 ? count : 0)));
        if (count >= 4) reply.bytes.push_back(static_cast<std::uint8_t>(count));
        reply.bytes.push_back(static_cast<std::uint8_t>(first & 0x7FU));
        if (first > 0x7F) {
          reply.bytes.back() |= 0x80U;
          reply.bytes.push_back(static_cast<std::uint8_t>(first >> 7U));
        }
      }
      for (std::uint32_t i = 0; i < count; ++i) {
        const std::uint32_t reg = first + i;
        double value = 0;
        if (reads) {
          if (!read(reg, value)) value = kNaN;
          append(reply.bytes, type, value, step_of(reg, type));
          continue;
        }
        if (at + bytes_of(type) > frame.size) return;
        value = number_at(&frame.data[at], type, step_of(reg, type));
        at += bytes_of(type);
        if (!write(reg, value)) {
          const auto low = static_cast<std::uint8_t>(reg & 0x7FU);
          if (reg > 0x7F) {
            reply.bytes.insert(reply.bytes.end(), {0x30, static_cast<std::uint8_t>(low | 0x80U),
                                                   static_cast<std::uint8_t>(reg >> 7U), 1});
          } else {
            reply.bytes.insert(reply.bytes.end(), {0x30, low, 1});
          }
        }
      }
    } else if (subframe == 0x40) {
      (void)varuint();
      const std::uint32_t length = varuint();
      if (at + length > frame.size) return;
      answer_text({reinterpret_cast<const char*>(&frame.data[at]), length});
      at += length;
    } else if (subframe == 0x42) {
      const std::uint32_t channel = varuint();
      const std::size_t length = std::min<std::size_t>({varuint(), text_.size(), 20});
      reply.bytes.insert(reply.bytes.end(),
                         {0x41, static_cast<std::uint8_t>(channel), static_cast<std::uint8_t>(length)});
      reply.bytes.insert(reply.bytes.end(), text_.begin(),
                         text_.begin() + static_cast<std::ptrdiff_t>(length));
      text_.erase(0, length);
    } else {
      return;
    }
  }
}

bool EmulatedMoteus::write(std::uint32_t reg, double value) {
  commanded_ = true;
  if (reg == refuses_register) return false;
  switch (reg) {
    case 0x000:  // resets everything that is not written after it
      pending_ = {};
      pending_.mode = static_cast<int>(value);
      return true;
    case 0x020:
      pending_.position = value;
      return true;
    case 0x021:
      pending_.velocity = std::isnan(value) ? 0 : value;
      return true;
    case 0x022:
      pending_.torque_N_m = value;
      return true;
    case 0x023:
      pending_.kp_scale = value;
      return true;
    case 0x024:
      pending_.kd_scale = value;
      return true;
    case 0x025:
      pending_.most_torque_N_m = value;
      return true;
    case 0x027:
      pending_.timeout_s = value;
      return true;
    default:
      return false;
  }
}

bool EmulatedMoteus::read(std::uint32_t reg, double& value) {
  switch (reg) {
    case 0x000:
      value = mode_;
      return true;
    case 0x001:
      value = (read_encoder_rad() - zero_rad_) / kTurn_rad;
      return true;
    case 0x002:
      value = velocity_rad_s() / kTurn_rad;
      return true;
    case 0x003:
      value = reported_torque_N_m();
      return true;
    case 0x004:
      value = reported_torque_N_m() * 10;
      return true;
    case 0x00C:
      value = home_state;
      return true;
    case 0x00D:
      value = 24;
      return true;
    case 0x00E:
      value = 31;
      return true;
    case 0x00F:
      value = fault_ != 0 ? fault_ : limiter;
      return true;
    case 0x070: {
      if (!inject.clock_stands) stood_us_ = now_us();
      value = static_cast<double>(((stood_us_ - booted_us_) / 1000) & 0x7FFFU);
      return true;
    }
    default:
      return false;
  }
}

void EmulatedMoteus::apply(const Orders& orders) {
  if (orders.mode == 0) {  // clears a fault and a timeout
    mode_ = 0;
    fault_ = 0;
  } else if (mode_ != 1 && mode_ != 11) {
    mode_ = orders.mode;
  }
  active_ = orders;
  ordered_us_ = now_us();
}

void EmulatedMoteus::answer_text(const std::string& text) {
  heard_text_ += text;
  for (std::size_t end; (end = heard_text_.find('\n')) != std::string::npos; heard_text_.erase(0, end + 1)) {
    const std::string line = heard_text_.substr(0, end);
    const std::string get = "conf get ";
    const auto found = line.starts_with(get) ? config.find(line.substr(get.size())) : config.end();
    std::array<char, 32> number{};
    if (found != config.end()) std::snprintf(number.data(), number.size(), "%g\r\n", found->second);
    text_ += found != config.end() ? number.data() : "ERR unknown\r\n";
  }
}

}  // namespace thimble::board::emulated

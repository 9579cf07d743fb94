#include "board/sim/drives/drive_options.h"

#include <charconv>
#include <cmath>
#include <stdexcept>
#include <vector>

#include "board/sim/drives/emulated_mit.h"
#include "board/sim/drives/emulated_moteus.h"
#include "board/sim/drives/emulated_odrive.h"

namespace thimble::board::emulated {
namespace {

struct FaultName {
  const char* name;
  double value;  // without one in the text
  void (*happens)(EmulatedDrive&, double);
  double least = -1e9;  // of the value
};
constexpr FaultName kFaultNames[] = {
    {"drop", 1,
     [](EmulatedDrive& drive, double value) { drive.inject.drop_replies = static_cast<unsigned>(value); }, 0},
    {"repeat", 1,
     [](EmulatedDrive& drive, double value) { drive.inject.repeat_replies = static_cast<unsigned>(value); },
     0},
    {"mute", 1, [](EmulatedDrive& drive, double value) { drive.inject.mute = value != 0; }},
    {"delay_us", 1000,
     [](EmulatedDrive& drive, double value) {
       drive.inject.more_delay_us = static_cast<std::uint64_t>(value);
     },
     0},
    {"classic", 1, [](EmulatedDrive& drive, double value) { drive.inject.answer_classic = value != 0; }},
    {"reply_id", 0,
     [](EmulatedDrive& drive, double value) { drive.inject.reply_id = static_cast<std::uint32_t>(value); },
     0},
    {"watchdog_s", .015, [](EmulatedDrive& drive, double value) { drive.set_watchdog_s(value); }},
    {"watchdog_off", 1, [](EmulatedDrive& drive, double value) { drive.inject.watchdog_off = value != 0; }},
    {"frozen", 1, [](EmulatedDrive& drive, double value) { drive.inject.encoder_frozen = value != 0; }},
    {"jump_rad", kTurn_rad,
     [](EmulatedDrive& drive, double value) { drive.inject.encoder_jump_rad = value; }},
    {"noise_rad", .01, [](EmulatedDrive& drive, double value) { drive.inject.encoder_noise_rad = value; }},
    {"torque_factor", -1, [](EmulatedDrive& drive, double value) { drive.inject.torque_factor = value; }},
    {"current_factor", .5, [](EmulatedDrive& drive, double value) { drive.inject.current_factor = value; }},
    {"most_torque_N_m", .1, [](EmulatedDrive& drive, double value) { drive.inject.most_torque_N_m = value; }},
    {"clock_stands", 1, [](EmulatedDrive& drive, double value) { drive.inject.clock_stands = value != 0; }},
    {"reboot_us", 500'000,
     [](EmulatedDrive& drive, double value) { drive.power_cycle(static_cast<std::uint64_t>(value)); }, 0},
    {"fail", 1, [](EmulatedDrive& drive, double value) { drive.fail(static_cast<std::uint32_t>(value)); }, 0},
    {"hand_N_m", 0, [](EmulatedDrive& drive, double value) { drive.shaft.hand_N_m = value; }},
};

std::vector<std::string> parts_of(const std::string& text) {
  std::vector<std::string> parts(1);
  for (const char c : text) {
    if (c == ':') {
      parts.emplace_back();
    } else {
      parts.back() += c;
    }
  }
  return parts;
}

double number_of(const std::string& text, double lo, double hi) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !(value >= lo && value <= hi))
    throw std::invalid_argument("'" + text + "' is not a number that fits");
  return value;
}

template <typename Whole>
Whole whole_of(const std::string& text, double hi) {
  const double value = number_of(text, 0, hi);
  if (value != std::trunc(value)) throw std::invalid_argument("'" + text + "' is not a whole number");
  return static_cast<Whole>(value);
}

}  // namespace

NamedDrive parse_drive(const std::string& text) {
  const std::vector<std::string> parts = parts_of(text);
  if (parts.size() < 2 || parts.size() > 4)
    throw std::invalid_argument("'" + text + "' is not KIND:ID[:REPLY_ID[:TORQUE_N_M]]");
  const std::string& kind = parts[0];
  const bool odrive = kind == "odrive05" || kind == "odrive06";  // its identifiers have 6 bits for it
  const auto id = whole_of<std::uint8_t>(parts[1], odrive ? 63 : 127);
  const auto reply_id =
      parts.size() > 2 ? whole_of<std::uint16_t>(parts[2], 0x7FF) : static_cast<std::uint16_t>(id + 16);
  const double torque_N_m = parts.size() > 3 ? number_of(parts[3], .01, 1000) : 0;
  if (torque_N_m != 0 && (odrive || kind == "moteus"))
    throw std::invalid_argument("'" + text + "': the torque of a " + kind + " has no range");
  if (kind == "moteus") return {std::make_unique<EmulatedMoteus>(id), true};
  if (odrive) return {std::make_unique<EmulatedOdrive>(id, kind == "odrive06"), false};
  const auto mit = [&](EmulatedMit::Flavour flavour, double velocity_rad_s, double usual_N_m) {
    return std::make_unique<EmulatedMit>(flavour, id, reply_id, velocity_rad_s,
                                         torque_N_m != 0 ? torque_N_m : usual_N_m);
  };
  if (kind == "mini-cheetah") return {mit(EmulatedMit::Flavour::kMiniCheetah, 65, 40), false};
  if (kind == "cubemars") return {mit(EmulatedMit::Flavour::kCubeMars, 50, 15), false};  // AK60-6
  if (kind != "damiao" && kind != "damiao-fd")
    throw std::invalid_argument("no kind of drive: '" + kind + "'");
  auto damiao = mit(EmulatedMit::Flavour::kDamiao, 30, 10);  // DM4310
  damiao->takes_fd = kind == "damiao-fd";
  const bool fd = damiao->takes_fd;
  return {std::move(damiao), fd};
}

TimedFault parse_fault(const std::string& text) {
  const std::vector<std::string> parts = parts_of(text);
  if (parts.size() != 3) throw std::invalid_argument("'" + text + "' is not TIME_S:DRIVE:FAULT[=VALUE]");
  const std::size_t equals = parts[2].find('=');
  const std::string name = parts[2].substr(0, equals);
  for (const FaultName& one : kFaultNames) {
    if (name != one.name) continue;
    const double value =
        equals == std::string::npos ? one.value : number_of(parts[2].substr(equals + 1), one.least, 1e9);
    return {number_of(parts[0], 0, 1e6), whole_of<std::size_t>(parts[1], 31),
            [happens = one.happens, value](EmulatedDrive& drive) { happens(drive, value); }};
  }
  throw std::invalid_argument("no fault '" + name + "'; there are: " + fault_names());
}

std::string fault_names() {
  std::string out;
  for (const FaultName& one : kFaultNames) out += (out.empty() ? "" : ", ") + std::string(one.name);
  return out;
}

}  // namespace thimble::board::emulated

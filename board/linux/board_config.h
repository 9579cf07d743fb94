// The configuration of an embedded Linux board (wiring and run-time settings): one JSON file.
// docs/board-linux.md has every key.
#pragma once

#include <linux/counter.h>

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "board/common/ad5754.h"
#include "board/linux/counter_encoder.h"
#include "board/linux/drive_wiring.h"
#include "board/linux/gpio.h"
#include "firmware/core/config.h"
#include "kinematics/arm_data.h"
#include "kinematics/base_pose.h"

namespace thimble::board {

struct EncoderConfig {
  enum class Kind : std::uint8_t { kCounterPoll, kCounterEvents, kGpio };
  Kind kind = Kind::kCounterPoll;
  std::array<CounterPlace, kArmJoints> counter;      // without a name: the joint's drive has its encoder
  counter_event_type event = COUNTER_EVENT_CAPTURE;  // for kCounterEvents: the event that latches the counts
  std::array<std::array<std::string, 2>, kArmJoints>
      lines;  // for kGpio: A and B of each joint, empty as above
};

struct DacConfig {
  std::string device;
  std::uint32_t speed_Hz = 0;
  std::array<std::optional<Ad5754::Channel>, Ad5754::kOutputs>
      channels;  // of the first joints; none: it has a drive, or no motor
};

struct ArmWiring {
  std::string model;         // the built-in arm that it is while the store has none
  kinematics::ArmData arm;   // which it is
  std::string needs_stored;  // /stored_model, if the store does not have it: nothing of the arm is wired
  kinematics::BasePose base;
  std::optional<EncoderConfig> encoders;  // none: every joint has a drive with its encoder
  std::optional<DacConfig> dac;           // none: every motor has a drive
  std::optional<GpioLine> enable;         // of the amplifiers; none without a DAC
  DriveWirings drives;
  std::optional<GpioLine> drive_fault;
  std::optional<GpioLine> index;
};

// The joint's encoder is at a counter or at lines; otherwise its drive has it.
[[nodiscard]] bool has_own_encoder(const ArmWiring& arm, std::size_t joint) noexcept;

struct LinkConfig {
  enum class Kind : std::uint8_t { kCan, kTty };
  Kind kind = Kind::kCan;
  std::string device;  // "can0", "/dev/ttyGS0"
};

// The pulse train that an external retriggerable one-shot turns into the enable of the drives
// (docs/board-linux.md): a pulse with each tick that has a drive on.
struct HeartbeatConfig {
  GpioLine line;
  std::uint32_t timeout_us = 0;  // of the one-shot
};

struct BoardConfig {
  std::string serial_number;
  std::uint8_t node = 1;
  double rate_Hz = 0;
  std::uint32_t work_units = 0;  // of firmware::Config
  std::vector<LinkConfig> links;
  std::vector<ArmWiring> arms;
  // Switch contacts: active means closed, for either wiring; an open wire reads as open.
  GpioLine e_stop;
  std::optional<GpioLine> dead_man;
  double settle_s = 0.02;  // debounce time of both contacts
  std::filesystem::path store;
  int priority = 0;        // of SCHED_FIFO
  std::optional<int> cpu;  // processor reserved for the servo thread
  std::optional<HeartbeatConfig> heartbeat;
  std::optional<GpioLine> event;  // event_line.h
  std::optional<std::filesystem::path> watchdog;
  int watchdog_timeout_s = 0;
};

inline constexpr std::uint32_t kMostWorkUnits = 1'000'000;  // in /work_units

// what(): file, line, JSON pointer, value and what is allowed.
class ConfigError : public std::runtime_error {
 public:
  ConfigError(const std::string& cause, std::string what_to_do)
      : std::runtime_error(cause), remedy(std::move(what_to_do)) {}
  std::string remedy;  // what to do next
};

// The arms of the board's store, which come before the models that the configuration names.
using StoredArms = std::array<std::optional<kinematics::ArmData>, firmware::kMaxArms>;
using StoredArmsOf = std::function<StoredArms(const std::filesystem::path& store)>;

// Throws ConfigError, also for text that is not JSON. stored: empty, or called once with the value of /store.
[[nodiscard]] BoardConfig parse_board_config(const std::string& text, const std::string& file,
                                             const StoredArmsOf& stored = {});
// The same for a file; also throws ConfigError if the file cannot be read.
[[nodiscard]] BoardConfig read_board_config(const std::filesystem::path& file,
                                            const StoredArmsOf& stored = {});

}  // namespace thimble::board

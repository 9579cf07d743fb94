// Encoders on the kernel's counter subsystem, by two methods; docs/board-linux.md explains which one to use.
//   CounterPoll    reads sysfs: one pread() per joint and tick. Works with every counter driver.
//   CounterEvents  reads the character device: one read() per arm and tick. It needs a driver that latches all counts
//                  at an event at least once per tick (a timer's capture), with the time of the latch; the kernel delivers
//                  values only with events, never on demand.
// Places without a name are not read. Both configure the counts (quadrature x4, enabled) and refuse a ceiling that differs from the arm model's.
#pragma once

#include <linux/counter.h>

#include <array>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <system_error>

#include "board/linux/encoder_reader.h"
#include "board/linux/open_file.h"

namespace thimble::board {

// One count of one device. device: its kernel name ("counter0") or its driver's name for it (the file `name`
// in sysfs).
struct CounterPlace {
  std::string device;
  unsigned count = 0;
  unsigned bits = 32;  // of the joint's counter in the arm's model
};

// The folder of a device in sysfs. Throws std::system_error.
[[nodiscard]] std::filesystem::path find_counter(const std::string& device);

class CounterPoll final : public EncoderReader {
 public:
  // Throws std::system_error with the missing item, and for a wrong setting with a remedy.
  explicit CounterPoll(const std::array<CounterPlace, kArmJoints>& joints);
  [[nodiscard]] std::optional<EncoderSample> read(std::uint64_t now_ns) noexcept override;

 private:
  std::array<Descriptor, kArmJoints> files_;
};

class CounterEvents final : public EncoderReader {
 public:
  // All joints on one device. Throws as CounterPoll does.
  CounterEvents(const std::array<CounterPlace, kArmJoints>& joints, counter_event_type event);
  [[nodiscard]] std::optional<EncoderSample> read(std::uint64_t now_ns) noexcept override;

 private:
  static constexpr std::size_t kEvents = 64;  // size of the kernel's event queue

  std::array<int, kArmJoints> count_of_;  // -1: not read
  Descriptor device_;
  std::array<counter_event, kEvents> events_;
  // The events of one latch may arrive in two reads; they are collected until all counts with one time
  // are complete.
  EncoderSample gathered_;
  unsigned joints_gathered_ = 0;  // bits
  unsigned all_ = 0;              // of the joints that are read
};

}  // namespace thimble::board

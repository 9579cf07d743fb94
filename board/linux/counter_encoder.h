// Encoders on the kernel's counter subsystem, in two ways; board-linux.md says which board takes which.
//   CounterPoll    reads sysfs: one pread() a joint and tick. Works with every counter driver.
//   CounterEvents  reads the character device: one read() an arm and tick. It needs a driver that latches all three counts
//                  at an event that comes at least once a tick (a timer's capture), with the time of the latch; the kernel
//                  hands out values only with events, never on demand.
// Both set the counts up: quadrature x4, enabled, and refuse a ceiling that the arm model does not expect.
#pragma once

#include <linux/counter.h>

#include <array>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <system_error>

#include "board/linux/encoder_reader.h"
#include "board/linux/open_file.h"
#include "kinematics/arm_model.h"

namespace thimble::board {

// One count of one device. device: its kernel name ("counter0") or what its driver calls it (the file `name` in sysfs).
struct CounterPlace {
  std::string device;
  unsigned count = 0;
};

class CounterPoll final : public EncoderReader {
 public:
  // Throws std::system_error with what is missing and, where a setting is wrong, what to do.
  CounterPoll(const std::array<CounterPlace, 3>& joints, kinematics::CounterWidth width);
  [[nodiscard]] std::optional<EncoderSample> read(std::uint64_t now_ns) noexcept override;

 private:
  std::array<Descriptor, 3> files_;
};

class CounterEvents final : public EncoderReader {
 public:
  // All joints on one device. Throws as CounterPoll does.
  CounterEvents(const std::array<CounterPlace, 3>& joints, kinematics::CounterWidth width,
                counter_event_type event);
  [[nodiscard]] std::optional<EncoderSample> read(std::uint64_t now_ns) noexcept override;

 private:
  static constexpr std::size_t kEvents = 64;  // as many as the kernel keeps

  std::array<unsigned, 3> count_of_;
  Descriptor device_;
  std::array<counter_event, kEvents> events_;
  // A latch may arrive in two reads: gathered until all three counts of one time are there.
  EncoderSample gathered_;
  unsigned joints_gathered_ = 0;  // bits
};

}  // namespace thimble::board

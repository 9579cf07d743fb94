// The devices of an embedded Linux board, by its configuration: encoders, converters, drives on CAN, lines. A device that
// cannot be opened is listed in missing(), and the others work: without its lines the e-stop reads as
// pressed, without encoders there are no new samples, without a converter or an enable line the drive reports
// a fault.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "board/common/measured_currents.h"
#include "board/common/safety_switch.h"
#include "board/linux/arm_devices.h"
#include "board/linux/board_config.h"
#include "board/linux/event_line.h"
#include "board/linux/gpio.h"
#include "board/linux/missing.h"
#include "board/linux/servo_beat.h"
#include "board/linux/spi_dac.h"
#include "board/linux/tick_devices.h"

namespace thimble::board {

class Devices final : public TickDevices {
 public:
  // Sets all currents to zero and switches all drives off. Takes the debounce time of the contacts, and what the search for drives takes
  // (drive_set.h). Does not
  // throw for missing devices.
  // beat: must outlive the devices. Drives that the guardian has switched off read as a fault of every drive
  // until the servo has switched them off itself.
  Devices(const BoardConfig& config, ServoBeat& beat);
  [[nodiscard]] const std::vector<Missing>& missing() const noexcept { return missing_; }

  // The drives on CAN as they are found at start, for people; empty: there is none.
  [[nodiscard]] std::vector<std::string> report() const;
  // What a drive has said since the last call, for the log; empty: nothing. Any thread.
  [[nodiscard]] std::string news();
  [[nodiscard]] const firmware::BoardData& measured() const noexcept { return measured_; }

  void read(firmware::Inputs& in, std::uint64_t now_ns, std::uint64_t period_ns) noexcept override;
  void write(const firmware::Outputs& out) noexcept override;
  void make_safe() noexcept override;
  // The same for the guardian, which leaves the beat as it is.
  void switch_off() noexcept;

 private:
  struct Lines {  // of an arm: their indices among the inputs
    std::optional<std::size_t> drive_fault, index;
  };
  void open_heartbeat(const BoardConfig& config);
  void open_inputs(const BoardConfig& config);
  [[nodiscard]] ArmParts open_arm(const ArmWiring& wiring);
  [[nodiscard]] bool needs_heartbeat(const BoardConfig& config) const;
  void read_lines(firmware::Inputs& in) noexcept;

  ServoBeat& beat_;
  std::vector<Missing> missing_;
  std::unique_ptr<GpioInputs> inputs_;
  std::unique_ptr<GpioOutput> heartbeat_;
  EventLine event_;
  std::optional<std::size_t> dead_man_line_;
  SafetySwitch e_stop_;
  SafetySwitch dead_man_;
  std::vector<Lines> lines_;  // one for each arm
  std::unique_ptr<ArmDevices> arms_;
  MeasuredCurrents measured_;
  // One entry per input.
  bool lines_read_ = false;
  std::array<bool, GpioInputs::kMaxLines> levels_{};
  std::array<bool, GpioInputs::kMaxLines> rose_{};
  std::array<bool, GpioInputs::kMaxLines> fell_{};
};

}  // namespace thimble::board

// The encoders, converters, enable lines and drives of all arms, whichever an arm has, as the servo reads and writes them in each tick.
// devices.h adds the board's lines and opens them; tests give others.
//
// A joint has its count from the arm's encoders or from its drive, and its current by the arm's converter or its drive. An arm whose current
// cannot be set is switched off; an arm that cannot be enabled gets no current.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "board/linux/drive_set.h"
#include "board/linux/encoder_reader.h"
#include "board/linux/outputs.h"
#include "board/linux/servo_beat.h"

namespace thimble::board {

struct ArmParts {
  std::unique_ptr<EncoderReader> encoders;
  std::unique_ptr<CurrentOutput> dac;
  std::unique_ptr<SwitchOutput> enable;
  // What the arm should have; one that it should and does not have is a fault of the drive.
  bool needs_encoders = true;  // of its own
  bool needs_dac = true;       // with the enable line
};

class ArmDevices {
 public:
  // beat: must outlive it. drives: null without any.
  ArmDevices(std::vector<ArmParts> arms, std::unique_ptr<DriveSet> drives, ServoBeat& beat);

  // Counts, evidence and drive_fault of each arm; e_stop is set.
  void read(firmware::Inputs& in, std::uint64_t now_ns, std::uint64_t period_ns) noexcept;
  // works: false: the stop path of the board has failed.
  void write(const firmware::Outputs& out, bool works, std::uint64_t now_ns) noexcept;
  // Everything off: the lines, the converters, and frames to the drives. Also for the guardian's process.
  void switch_off() noexcept;
  // After switch_off() in the board's own process: no drive goes on by itself.
  void forget() noexcept;
  [[nodiscard]] DriveSet* drives() noexcept { return drives_.get(); }
  [[nodiscard]] const DriveSet* drives() const noexcept { return drives_.get(); }

 private:
  struct Arm {
    ArmParts parts;
    firmware::ArmInputs last;
    bool enabled = false;
    bool write_failed = false;
  };
  [[nodiscard]] bool write_arm(Arm& arm, const firmware::ArmOutputs& wanted, bool works) noexcept;

  ServoBeat& beat_;
  std::vector<Arm> arms_;
  std::unique_ptr<DriveSet> drives_;
};

}  // namespace thimble::board

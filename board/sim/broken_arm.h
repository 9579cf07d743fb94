// The hardware between one simulated arm and the controller, with what is broken in it: encoders, counters, index, converter, amplifiers,
// supply. Sound hardware passes everything on. SimBoard owns one an arm.
#pragma once

#include <array>
#include <bitset>
#include <cstdint>
#include <optional>

#include "board/sim/injection.h"
#include "board/sim/sim_arm.h"
#include "firmware/core/config.h"

namespace thimble::board {

// Which of the measurements of firmware::ArmEvidence the simulated board has.
struct Sensors {
  bool line_loss = false;
  bool current = false;
  bool supply = false;
  bool temperature = false;
  bool index = false;  // the arm has an index at its home position
};

class BrokenArm {
 public:
  // Breaks or mends; `plant` as it is now.
  void set(const PlannedFault& fault, bool broken, const SimArm& plant);

  // What the controller gets of the plant, except for the tick of the sample.
  void sense(const SimArm& plant, const Sensors& sensors, double time_s, firmware::ArmInputs& in);
  [[nodiscard]] bool stale() const noexcept { return stale_; }  // the counters are not read
  // What the drives do of the controller's command; whether they are on. A drive that is not enabled has no power, whatever else is
  // broken.
  bool drive(const firmware::ArmOutputs& out, SimArm& plant);

 private:
  struct Joint {
    std::optional<std::uint32_t> register_now;  // stuck there
    bool line = false;                          // and the receiver reports it
    std::optional<bool> dead_phase_b;           // a channel is dead: false A, true B
    std::uint32_t phase_base = 0;
    double slip_counts = 0, drift_counts_s = 0, drift_from_s = 0;
    bool reversed = false;
    double torque = 1;
    std::optional<double> stuck_A;
  };
  [[nodiscard]] std::uint32_t counts(const Joint& joint, std::uint32_t sound, double time_s) const;
  void set_joint(const PlannedFault& fault, bool broken, const SimArm& plant, std::size_t joint);

  std::array<Joint, firmware::kJoints> joints_;
  bool stale_ = false, index_missing_ = false, drive_fault_ = false, converter_stuck_ = false;
  double index_at_rad_ = 0;
  double supply_ = 1;
  SimArm::PerAxis commanded_A_ = SimArm::PerAxis::Zero();
};

}  // namespace thimble::board

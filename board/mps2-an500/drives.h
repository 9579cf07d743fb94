// The register block with the cut of the stop path: an interrupt that comes upon the tick switches the drives
// off. They stay off, and read as a fault, until the tick commits outputs without an enable.
#pragma once

#include <atomic>

#include "board/cortex/fabric.h"

namespace thimble::board {

class Drives {
 public:
  explicit Drives(const Fabric& logic) noexcept : logic_(logic) {}

  void latch(firmware::Inputs& inputs) const noexcept {
    logic_.latch(inputs);
    for (firmware::ArmInputs& arm : inputs.arm) arm.drive_fault = arm.drive_fault || cut_;
  }
  void commit(const firmware::Outputs& outputs) noexcept {
    bool any = false;
    for (const firmware::ArmOutputs& arm : outputs.arm) any = any || arm.enable;
    if (!any) cut_ = false;
    if (!cut_) logic_.commit(outputs);
    if (cut_) logic_.off();  // also if the interrupt came during the commit
  }
  void off() const noexcept { logic_.off(); }
  void cut() noexcept {
    cut_ = true;
    logic_.off();
  }

 private:
  const Fabric& logic_;
  std::atomic<bool> cut_{false};
};

}  // namespace thimble::board

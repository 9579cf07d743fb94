// The arm of linked_bench.h on drives on CAN, as thimble-board has them: the board's own drive set, and emulated drives at the other end of a socketpair,
// in simulated time. Their clocks drift, and the board's ticks begin late by chance.
#pragma once

#include <cstdint>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "board/linux/drive_set.h"
#include "board/sim/drives/emulated_bus.h"
#include "tests/closed_loop/commission/linked_bench.h"

namespace thimble::test {

class DrivenBench final : public LinkedBench {
 public:
  // board: the text of the board's configuration, which names a drive for each axis of the arm, on one bus.
  DrivenBench(const host::ArmFile& arm, std::vector<host::SimFault> faults,
              const host::SimBenchOptions& options, const std::string& board);

  [[nodiscard]] board::emulated::EmulatedDrive& drive(std::size_t axis) { return *drives_.at(axis); }

 private:
  void read_arm(firmware::Inputs& in) override;
  void drive_arm(const firmware::Outputs& out) override;
  void step_drives(std::uint64_t until_us);

  host::ArmFile arm_;
  std::mt19937_64 random_{1};
  std::uint64_t drives_us_ = 0;  // the drives' time, and the arm's
  board::ArmWiring wiring_;
  board::Descriptor end_;  // the board's
  std::unique_ptr<board::emulated::EmulatedBus> bus_;
  std::vector<board::emulated::EmulatedDrive*> drives_;
  host::PerAxis<double> last_rad_{};
  std::unique_ptr<board::DriveSet> set_;
};

}  // namespace thimble::test

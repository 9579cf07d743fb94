// The simulated arm behind a board's register block (board/cortex/fabric.h), where that block is plain memory which QEMU shares with this
// process. The arm moves on by one period each time the board has committed currents, and stands still otherwise: a machine that is
// busy slows it down, and does nothing else.
#pragma once

#include <atomic>
#include <filesystem>
#include <mutex>
#include <thread>

#include "board/cortex/fabric.h"
#include "board/sim/plant.h"

namespace thimble::tests {

class FabricPlant {
 public:
  // Maps the block, which begins `offset` bytes into the file, and says that it is there. Throws std::runtime_error.
  FabricPlant(const std::filesystem::path& memory, std::size_t offset, double rate_Hz);
  FabricPlant(const FabricPlant&) = delete;
  FabricPlant& operator=(const FabricPlant&) = delete;
  ~FabricPlant();

  // Until the first call the arm lies in its cradle. The hand goes there at 0.2 m/s: one that jumps is faster than max_tip_speed.
  void hold(const board::Vector3d& position_m);
  void set_lines(std::uint32_t lines) noexcept;  // board::kLine bits
  void set_drives_good(bool good) noexcept;
  [[nodiscard]] std::uint32_t lines() const noexcept;

  struct State {
    board::Vector3d tip_m;
    board::Vector3d hand_force_N;
    std::uint64_t steps = 0;
    bool enabled = false;
  };
  [[nodiscard]] State state() const;

 private:
  void run();
  void step();

  volatile board::FabricRegisters* registers_;
  void* map_;
  double period_s_;
  mutable std::mutex mutex_;
  board::Plant plant_;
  bool held_ = false;
  board::Vector3d wanted_m_, hand_m_;
  bool enabled_ = false;
  std::uint64_t steps_ = 0;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

}  // namespace thimble::tests

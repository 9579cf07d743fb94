#include "tests/hardware/cortex/fabric_plant.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <stdexcept>
#include <string>
#include <system_error>

namespace thimble::tests {
namespace {

constexpr std::size_t kMapBytes = 4096;
// Between two looks at the block. A tick of the emulated board takes longer.
constexpr std::chrono::microseconds kLook{20};
constexpr double kHand_m_s = 0.2;

void* map(const std::filesystem::path& memory, std::size_t offset) {
  const int fd = open(memory.c_str(), O_RDWR | O_CLOEXEC);
  if (fd < 0) throw std::system_error(errno, std::generic_category(), "cannot open " + memory.string());
  void* const map =
      mmap(nullptr, kMapBytes, PROT_READ | PROT_WRITE, MAP_SHARED, fd, static_cast<off_t>(offset));
  const int error = errno;
  close(fd);
  if (map == MAP_FAILED)
    throw std::system_error(error, std::generic_category(), "cannot map " + memory.string());
  return map;
}

}  // namespace

FabricPlant::FabricPlant(const std::filesystem::path& memory, std::size_t offset, double rate_Hz)
    : map_(map(memory, offset)),
      period_s_(1 / rate_Hz),
      plant_(board::PlantParameters::from(*board::find_plant_variant("premium-1.5")), board::Hand{}) {
  registers_ = static_cast<volatile board::FabricRegisters*>(map_);
  const std::array<std::uint32_t, 3> counts = plant_.encoder_counts();
  for (std::size_t joint = 0; joint < counts.size(); ++joint) registers_->arm[0].count[joint] = counts[joint];
  set_drives_good(true);
  set_lines(board::kLineEStopReleased | board::kLineDeadManHeld);
  registers_->version = board::kFabricVersion;
  registers_->id = board::kFabricId;
  thread_ = std::thread([this] { run(); });
}

FabricPlant::~FabricPlant() {
  stop_ = true;
  thread_.join();
  munmap(map_, kMapBytes);
}

void FabricPlant::hold(const board::Vector3d& position_m) {
  const std::lock_guard lock(mutex_);
  if (!held_) hand_m_ = plant_.tip_m();
  held_ = true;
  wanted_m_ = position_m;
}

void FabricPlant::set_lines(std::uint32_t lines) noexcept { registers_->lines = lines; }

void FabricPlant::set_drives_good(bool good) noexcept {
  registers_->arm[0].lines = good ? board::kArmLineDrivesGood : 0;
}

std::uint32_t FabricPlant::lines() const noexcept { return registers_->lines; }

FabricPlant::State FabricPlant::state() const {
  const std::lock_guard lock(mutex_);
  return {plant_.tip_m(), plant_.hand_force_N(), steps_, enabled_};
}

void FabricPlant::run() {
  while (!stop_) {
    if (registers_->commit != 0) {
      step();
    } else {
      std::this_thread::sleep_for(kLook);
    }
  }
}

void FabricPlant::step() {
  const std::lock_guard lock(mutex_);
  registers_->commit = 0;
  std::atomic_thread_fence(std::memory_order_seq_cst);
  const volatile board::FabricRegisters::Arm& arm = registers_->arm[0];
  enabled_ = arm.enable != 0;
  plant_.command_current(board::Vector3d(arm.current_uA[0], arm.current_uA[1], arm.current_uA[2]) * 1e-6,
                         enabled_);
  ++steps_;
  if (!held_) return;
  const board::Vector3d way_m = wanted_m_ - hand_m_;
  const double step_m = kHand_m_s * period_s_;
  hand_m_ += way_m * std::min(1.0, step_m / std::max(way_m.norm(), step_m));
  plant_.set_hand_target(hand_m_, board::Vector3d::Zero());
  plant_.step(period_s_);
  const std::array<std::uint32_t, 3> counts = plant_.encoder_counts();
  for (std::size_t joint = 0; joint < counts.size(); ++joint) registers_->arm[0].count[joint] = counts[joint];
}

}  // namespace thimble::tests

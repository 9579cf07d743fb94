#include "tests/closed_loop/commission/driven_bench.h"

#include <fcntl.h>

#include <cmath>
#include <numbers>
#include <utility>

#include "board/linux/board_config.h"
#include "host-tools/arms/arm_data.h"
#include "tests/unit/drives/rig.h"

namespace thimble::test {
namespace {

constexpr std::uint64_t kStep_us = 100;  // of drives and arm
constexpr unsigned kMostLate = 2;        // steps by which a tick begins late
constexpr double kDrift = 2e-4;          // of a drive's clock

board::BoardConfig config_of(const std::string& text, const host::ArmFile& arm) {
  return board::parse_board_config(text, "board.json", [&](const auto&) {
    board::StoredArms stored;
    stored[0] = host::arm_data(arm);
    return stored;
  });
}

}  // namespace

DrivenBench::DrivenBench(const host::ArmFile& arm, std::vector<host::SimFault> faults,
                         const host::SimBenchOptions& options, const std::string& board)
    : LinkedBench(arm, std::move(faults), options,
                  static_cast<std::uint64_t>(std::lround(1e6 / config_of(board, arm).rate_Hz))),
      arm_(arm),
      drives_us_(now_us()) {
  const board::BoardConfig config = config_of(board, arm);
  wiring_ = config.arms.at(0);
  auto [host_end, drives_end] = socket_pair();
  end_ = std::move(host_end);
  bus_ = std::make_unique<board::emulated::EmulatedBus>(std::move(drives_end));
  for (std::size_t j = 0; j < arm.axes.size(); ++j) {
    drives_.push_back(&bus_->add(emulated_of(wiring_.drives.at(j).value().config)));
    drives_.back()->shaft.moves = false;
    if (auto* odrive = dynamic_cast<board::emulated::EmulatedOdrive*>(drives_.back()))
      odrive->config.clock_drift = j % 2 == 0 ? kDrift : -kDrift;
  }
  step_drives(drives_us_ + kStep_us);
  for (board::emulated::EmulatedDrive* drive : drives_)
    drive->reboot();  // power comes on where the arm stands
  board::DriveHost host;
  host.open = [this](const std::string&, bool, board::drives::BusRate&, bool&) {
    return board::drives::OpenedBus{board::Descriptor(fcntl(end_.get(), F_DUPFD_CLOEXEC, 0)), {}};
  };
  host.now_us = [this] { return drives_us_; };
  host.sleep_until = [this](std::uint64_t time_us) { step_drives(time_us); };
  set_ = std::make_unique<board::DriveSet>(std::span(&wiring_, 1), config.rate_Hz, host);
  while (now_us() < drives_us_) wait_a_tick();
}

void DrivenBench::step_drives(std::uint64_t until_us) {
  for (; drives_us_ < until_us; drives_us_ += kStep_us) {
    host::PerAxis<double> current_A{};
    for (std::size_t j = 0; j < drives_.size(); ++j)
      current_A.at(j) = drives_[j]->torque_N_m() / arm_.axes[j].motor->torque_constant_N_m_A.value;
    move_arm(current_A, true, static_cast<double>(kStep_us) * 1e-6);  // a drive without power gives no torque
    const host::PerAxis<std::int64_t> now = counts();
    for (std::size_t j = 0; j < drives_.size(); ++j) {
      const double at_rad = 2 * std::numbers::pi * (static_cast<double>(now.at(j)) + .5) /
                            arm_.axes[j].encoder.counts_per_turn.value;
      drives_[j]->shaft.velocity_rad_s = (at_rad - last_rad_.at(j)) / (static_cast<double>(kStep_us) * 1e-6);
      drives_[j]->shaft.position_rad = last_rad_.at(j) = at_rad;
    }
    bus_->run(drives_us_ + kStep_us);
  }
}

void DrivenBench::read_arm(firmware::Inputs& in) { set_->read(in, now_us() * 1000, tick_us() * 1000); }

void DrivenBench::drive_arm(const firmware::Outputs& out) {
  set_->write(out, true, now_us() * 1000);
  bus_->run(drives_us_);
  step_drives(now_us() + tick_us() + random_() % (kMostLate + 1) * kStep_us);
}

}  // namespace thimble::test

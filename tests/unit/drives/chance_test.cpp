// Three drives of any kinds, faults and orders at random times, and a judge who looks at the emulated motors alone.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>

#include "tests/unit/drives/rig.h"

namespace thimble::test {
namespace {

constexpr std::size_t kDrives = 3;
constexpr float kPeak_N_m = .3F;

class Chance {
 public:
  explicit Chance(unsigned seed) : random_(seed), rig_(configs()) {}

  void play(unsigned ticks) {
    for (unsigned i = 0; i < ticks && !testing::Test::HasFailure(); ++i) {
      if (one_of(150)) happen(below(kDrives));
      if (one_of(50)) order();
      if (not_running_ % 900 == 899) heal();
      for (std::size_t drive = 0; drive < kDrives; ++drive) {
        rig_.torque_N_m[drive] = std::uniform_real_distribution<float>(-1, 1)(random_);
        rig_.damping_N_m_s_rad[drive] = std::uniform_real_distribution<float>(0, .02F)(random_);
      }
      rig_.tick();
      judge();
    }
  }
  [[nodiscard]] unsigned running() const { return running_; }  // ticks
  [[nodiscard]] unsigned faults() const { return faults_; }

 private:
  static std::vector<DriveConfig> of_kinds(std::mt19937& random) {
    std::vector<DriveConfig> configs;
    for (std::uint8_t id = 1; id <= kDrives; ++id) {
      configs.push_back(config_of(kKinds[random() % std::size(kKinds)], id));
      configs.back().peak_torque_N_m = kPeak_N_m;
    }
    return configs;
  }
  std::vector<DriveConfig> configs() { return of_kinds(random_); }
  unsigned below(unsigned many) { return static_cast<unsigned>(random_() % many); }
  bool one_of(unsigned many) { return below(many) == 0; }

  void happen(std::size_t i) {
    EmulatedDrive& drive = rig_.drive(i);
    switch (below(14)) {
      case 0:
        drive.inject.drop_replies = below(6);
        break;
      case 1:
        drive.inject.mute = true;
        break;
      case 2:
        drive.inject.more_delay_us = below(2000);
        break;
      case 3:
        drive.inject.repeat_replies = below(5);
        break;
      case 4:
        drive.inject.encoder_frozen = true;
        break;
      case 5:
        drive.inject.encoder_jump_rad = 1;
        break;
      case 6:
        drive.inject.current_factor = .5;
        break;
      case 7:
        drive.reboot();
        break;
      case 8:
        drive.power_cycle(below(100'000));
        break;
      case 9:
        drive.fail(8);
        break;
      case 10:
        rig_.pause(below(60));
        break;
      default:  // well again, so that there is something to break
        drive.inject = {};
        break;
    }
  }

  // What is broken for good would leave nothing to look at.
  void heal() {
    for (std::size_t i = 0; i < kDrives; ++i) {
      rig_.drive(i).inject = {};
      rig_.drive(i).shaft.velocity_rad_s = 0;
    }
    rig_.bus.clear();
    faulted_ = {};
  }

  void order() {
    switch (below(9)) {
      case 0:
        rig_.bus.disable();
        allowed_ = false;
        break;
      case 1:
      case 2:
        rig_.bus.clear();
        faulted_ = {};
        break;
      default:
        if (rig_.bus.enable().empty()) allowed_ = true;
        break;
    }
  }

  void judge() {
    bool runs = false;
    bool powered = false;
    for (std::size_t i = 0; i < kDrives; ++i) {
      const DriveState& state = rig_.states[i];
      const bool on = state.state == State::kRunning || state.state == State::kEnabled;
      runs = runs || state.state == State::kRunning;
      powered = powered || on || state.state == State::kBraking;
      ASSERT_TRUE(!on || allowed_) << "on without an order: " << rig_.text();
      ASSERT_TRUE(!faulted_[i] || state.fault != DriveFault::kNone) << "a fault has gone: " << rig_.text();
      if (state.fault != DriveFault::kNone) {
        faults_ += faulted_[i] ? 0U : 1U;
        faulted_[i] = true;
        allowed_ = false;
      }
    }
    running_ += runs ? 1U : 0U;
    not_running_ = runs ? 0 : not_running_ + 1;
    for (std::size_t i = 0; i < kDrives; ++i) {
      EmulatedDrive& drive = rig_.drive(i);
      const double torque = std::abs(drive.torque_N_m());
      const double speed = std::abs(drive.shaft.velocity_rad_s);
      // .02 N m s/rad at most, or the base damping; .01 N m are steps of the codes.
      ASSERT_LE(torque, static_cast<double>(kPeak_N_m) + .022 * speed + .01) << rig_.text();
      deaf_[i] = drive.inject.mute ? deaf_[i] + 1 : 0U;
      // A deaf drive goes on until its watchdog of at most 25 ms, and then brakes with what it had.
      // A moteus that does not answer is left to its watchdog of 15 ms and to the damping that it had; the others are told at once.
      const bool told = not_running_ > 20 && deaf_[i] == 0;
      const bool timed_out = deaf_[i] > 40 && not_running_ > 10;
      if (told) {
        const bool moteus = dynamic_cast<EmulatedMoteus*>(&drive) != nullptr;
        ASSERT_LE(torque, (moteus ? .022 : .006) * speed + .02) << i << ' ' << rig_.text();
      }
      if (timed_out) {
        ASSERT_LE(torque, .022 * speed + .02) << i << ' ' << rig_.text();
      }
      unpowered_[i] = powered || deaf_[i] > 0 ? 0 : unpowered_[i] + 1;
      if (unpowered_[i] > 700) {
        ASSERT_FALSE(drive.powered()) << i << ' ' << rig_.text();
      }
      // The hand stops it now and then, or it would turn ever faster.
      if (speed > 20) drive.shaft.velocity_rad_s = 0;
    }
  }

  std::mt19937 random_;
  DriveRig rig_;
  bool allowed_ = false;
  std::array<bool, kDrives> faulted_{};
  std::array<unsigned, kDrives> deaf_{}, unpowered_{};
  unsigned not_running_ = 0, running_ = 0, faults_ = 0;
};

TEST(DriveChance, NoTorqueWithoutAnOrderAndNoneAfterAFault) {
  unsigned ticks = 0, running = 0, faults = 0;
  for (unsigned seed = 1; seed <= 60; ++seed) {
    SCOPED_TRACE(seed);
    Chance chance(seed);
    chance.play(3000);
    ticks += 3000;
    running += chance.running();
    faults += chance.faults();
    if (HasFailure()) return;
  }
  std::printf("%u ticks, %u of them running, %u faults\n", ticks, running, faults);
  EXPECT_GT(running, 5000U);
  EXPECT_GT(faults, 300U);
}

}  // namespace
}  // namespace thimble::test

// An arm with faults and its builder, as sim_bench.h has them, but the motors obey a whole controller, which a LinkBench commands over the link: frames
// in memory. One thread: the board's time goes on while the host waits for a frame, and while the hands move.
#pragma once

#include <array>
#include <deque>
#include <functional>
#include <memory>
#include <vector>

#include "board/common/measured_currents.h"
#include "board/linux/drives/torque_witness.h"
#include "board/sim/sim_board.h"
#include "firmware/controller.h"
#include "host-tools/client/device.h"
#include "host-tools/commission/person.h"
#include "host-tools/commission/sim_bench.h"

namespace thimble::test {

class LinkedBench : public host::SimBench, public host::Person {
 public:
  // The host's clock is this one's until it is gone.
  LinkedBench(const host::ArmFile& arm, std::vector<host::SimFault> faults,
              const host::SimBenchOptions& options, std::uint64_t tick_us = 250);

  ~LinkedBench() override;
  [[nodiscard]] host::Device open();

  // --- the person
  [[nodiscard]] host::Answer ask(const host::Prompt& prompt) override;
  [[nodiscard]] host::Answer ask(const host::Prompt& prompt, const std::function<bool()>& round) override;

  [[nodiscard]] double time_s() const { return static_cast<double>(time_us_) * 1e-6; }
  [[nodiscard]] firmware::Controller& controller() { return *controller_; }
  // The board loses the tick in which so much time has passed from now on.
  void lose_a_tick_in(double seconds) { lost_tick_ = ticks_ + static_cast<std::uint64_t>(seconds / tick_s_); }
  // The encoders are known only after that, as those of drives that have to be on first.
  void know_encoders_in(double seconds) {
    known_tick_ = ticks_ + static_cast<std::uint64_t>(seconds / tick_s_);
  }

  // Of the currents that the controller asked for since the last prompt.
  [[nodiscard]] float most_A(std::size_t axis) const { return most_A_.at(axis); }

  [[nodiscard]] static firmware::link::Micros now_us() { return time_us_; }

 protected:
  // What the board reads of the arm: counts and evidence; in.tick and in.time_us are set.
  virtual void read_arm(firmware::Inputs& in);
  // What it writes to the motors. The arm moves on by a tick.
  virtual void drive_arm(const firmware::Outputs& out);
  void move_arm(const host::PerAxis<double>& current_A, bool enable, double seconds);
  [[nodiscard]] std::uint64_t tick_us() const { return tick_us_; }
  void wait_a_tick() { time_us_ += tick_us_, ++ticks_; }

 private:
  friend class MemoryTransport;

  [[nodiscard]] bool over() const override { return round_over_; }
  void step_plant(double seconds) override;
  void command(const host::PerAxis<double>&, bool) override {}  // the controller does
  void start();
  void tick();

  std::size_t given_axes_;
  bool measures_current_;
  board::MeasuredCurrents measured_;
  // As a board with drives on CAN tells a current: what it asked for, and what came more than in the last ticks (torque_witness.h).
  static constexpr float kPeak_A = 1, kLag_s = 2e-4F;
  std::vector<board::drives::TorqueWitness> witnesses_;
  std::array<float, kinematics::kMaxJoints> asked_A_{}, most_A_{};
  board::MemoryStorage storage_;
  firmware::Config config_;
  std::unique_ptr<firmware::Controller> controller_;
  std::deque<firmware::link::CanFrame> to_host_;
  std::function<bool()> round_;
  bool in_round_ = false, round_over_ = false, e_stop_ = false, dead_man_ = true;
  static inline std::uint64_t ticks_ = 0, time_us_ = 0;
  std::uint64_t tick_us_;
  double tick_s_;
  std::uint64_t lost_tick_ = 0, known_tick_ = 0;
  double owed_s_ = 0;
};

}  // namespace thimble::test

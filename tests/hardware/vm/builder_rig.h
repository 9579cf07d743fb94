// A simulated arm on emulated drives, and the builder who commissions it: in real time, on a CAN interface, beside a board that knows of neither.
//
// The arm and its faults are those of SimBench, whose true figures differ from the arm file by a few per cent. The drives' torques move it, and it
// moves their shafts. The builder reads what `thimble commission` prints, as a person does, does it with the hands, the e-stop and the dead-man
// switch, and answers. Of a wall he knows nothing: he pushes until he feels the force that he was told.
// Units: SI; times in microseconds of CLOCK_MONOTONIC. Throws std::runtime_error for a prompt that nobody would understand.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "board/sim/drives/emulated_bus.h"
#include "host-tools/commission/sim_bench.h"

namespace thimble::test {

struct Places {
  std::string e_stop, dead_man;  // of the lines' pulls: "pull-up" closes the contact
  std::string prompts, answers;  // FIFOs: the tool's stderr and stdin
};

class BuilderRig final : public host::SimBench {
 public:
  // drives: of the arm's axes in their order, one for each; on the bus. Both outlive it.
  BuilderRig(const host::ArmFile& arm, std::vector<host::SimFault> faults,
             const host::SimBenchOptions& options, board::emulated::EmulatedBus& bus,
             std::vector<board::emulated::EmulatedDrive*> drives, const Places& places);

  // Waits a tenth of a millisecond at most, moves the drives and the arm on to now, and does what has been asked for.
  void go_on();
  // The largest force and speed that the motors gave the tip so far, as a line of JSON.
  [[nodiscard]] std::string figures() const;

 private:
  using Prompt = host::Prompt;

  void step_plant(double seconds) override;
  void command(const host::PerAxis<double>& /*current_A*/, bool /*enable*/) override {}  // the drives do
  [[nodiscard]] bool over() const override {
    return !waits_ || doing_ != prompts_read_;
  }  // the tool has gone on
  void serve();
  void move_on(double seconds);
  void listen();
  void take_line(const std::string& line);
  void do_as_told(const std::string& text);
  [[nodiscard]] bool use_contacts(const std::string& text);
  [[nodiscard]] bool repair();
  void press(const Eigen::Vector3d& direction, double press_N);
  void pass(double seconds);
  [[nodiscard]] Prompt understood(const std::string& text) const;
  void answer(const char* text);

  board::emulated::EmulatedBus& bus_;
  std::vector<board::emulated::EmulatedDrive*> drives_;
  Places places_;
  host::ArmFile arm_;
  board::Descriptor prompts_, answers_;
  std::string partial_, told_;  // a line that has begun; the prompt that waits for an answer
  std::vector<std::string> found_;
  bool waits_ = false, at_work_ = false;
  unsigned prompts_read_ = 0, doing_ = 0;
  std::uint64_t plant_us_ = 0, until_us_ = 0;
  host::PerAxis<double> last_rad_{};
};

}  // namespace thimble::test

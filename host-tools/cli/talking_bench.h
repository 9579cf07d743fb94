// Between a commissioning and its simulated bench: prints what the builder is asked to do and, if a person plays the builder, waits for the answer.
#pragma once

#include <set>
#include <string>

#include "host-tools/cli/console_person.h"
#include "host-tools/commission/sim_bench.h"

namespace thimble::host {

class TalkingBench : public Bench {
 public:
  // asks: the prompts are answered on standard input, or at the second place, and the simulated hands then do it. silent: nothing is printed.
  TalkingBench(SimBench& bench, bool asks, bool silent, SecondPlace* second = nullptr)
      : bench_(bench), asks_(asks), silent_(silent), person_(second) {}

  [[nodiscard]] BenchFacts facts() override { return bench_.facts(); }
  void use(const ArmFile& arm) override { bench_.use(arm); }
  void locate(const PerAxis<double>& at_zero) override { bench_.locate(at_zero); }
  [[nodiscard]] PerAxis<AxisReading> read() override { return bench_.read(); }
  [[nodiscard]] Answer ask(const Prompt& prompt) override;
  [[nodiscard]] LineTrial try_line(Line line, const Prompt& prompt) override;
  [[nodiscard]] BenchRecording watch(const Prompt& prompt, bool powered) override;
  [[nodiscard]] BenchRecording wait(double seconds, bool powered) override;
  [[nodiscard]] BenchRecording run(const AxisProgram& program) override;
  [[nodiscard]] BenchRecording servo(const ServoProgram& program) override;
  [[nodiscard]] BenchRecording feel(const TipProgram& program, const Prompt& prompt) override;

  [[nodiscard]] bool stopped() const;
  // What was printed in the step before is printed again.
  void begin_step() { told_.clear(); }

 private:
  [[nodiscard]] Answer tell(const Prompt& prompt);  // and the answer, kDone where nobody is asked

  SimBench& bench_;
  bool asks_, silent_;
  ConsolePerson person_;
  std::set<std::string> told_;  // in this step
};

}  // namespace thimble::host

// A commissioning on its page (host-tools/viewer/commission_page.h): prompts are answered there, too, and the page gets the steps, and where the arm is.
#pragma once

#include <chrono>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "host-tools/cli/console_person.h"
#include "host-tools/cli/verbs.h"
#include "host-tools/commission/procedure.h"
#include "host-tools/viewer/commission_page.h"

namespace thimble::host {

class CommissionOnPage final : public SecondPlace {
 public:
  // Serves from now on. Errors: those of WebServer.
  CommissionOnPage(const CommissionChoice& choice, const ArmFile& arm);

  [[nodiscard]] const std::string& url() const { return page_.url(); }

  void ask(const Prompt& prompt, bool bench_waits) override;
  [[nodiscard]] std::optional<Answer> answer() override;
  void withdraw() override;
  [[nodiscard]] bool stopped() const override { return page_.stopped(); }

  // Newest counts of the axes, without a word with the device; nothing: none have come.
  using Counts = std::function<std::optional<PerAxis<std::int64_t>>()>;
  // read: lets newer ones come, with a word with the device. Called several times a second while the bench waits.
  void follow(Counts counts, std::function<void()> read) {
    counts_ = std::move(counts);
    read_ = std::move(read);
  }
  void use(const ArmFile& arm) { arm_ = arm; }
  void locate(const PerAxis<double>& at_zero) { at_zero_ = at_zero; }
  void look();  // where the arm is
  [[nodiscard]] const std::string& axis_name(std::size_t axis) const { return arm_.axes.at(axis).name; }

  // now: the step that is done; none: all of them are over.
  void show_steps(const std::map<int, StepResult>& results, std::optional<int> now);
  void say_doing(const std::string& what, std::optional<std::size_t> axis = {});
  void end(bool passed, const std::string& text);

 private:
  void read_if_due();

  CommissionPage page_;
  ArmFile arm_;
  Counts counts_;
  std::function<void()> read_;
  std::optional<std::chrono::steady_clock::time_point> read_due_;  // none: not now
  std::optional<PerAxis<double>> at_zero_;
  std::vector<double> shown_;
};

// Tells the page what goes by.
class WatchedBench final : public Bench {
 public:
  WatchedBench(Bench& bench, CommissionOnPage& page) : bench_(bench), page_(page) {}

  [[nodiscard]] BenchFacts facts() override { return bench_.facts(); }
  void use(const ArmFile& arm) override;
  void locate(const PerAxis<double>& at_zero) override;
  [[nodiscard]] PerAxis<AxisReading> read() override { return bench_.read(); }
  [[nodiscard]] Answer ask(const Prompt& prompt) override;
  [[nodiscard]] LineTrial try_line(Line line, const Prompt& prompt) override;
  [[nodiscard]] BenchRecording watch(const Prompt& prompt, bool powered) override;
  [[nodiscard]] BenchRecording wait(double seconds, bool powered) override;
  [[nodiscard]] BenchRecording run(const AxisProgram& program) override;
  [[nodiscard]] BenchRecording servo(const ServoProgram& program) override;
  [[nodiscard]] BenchRecording feel(const TipProgram& program, const Prompt& prompt) override;

 private:
  Bench& bench_;
  CommissionOnPage& page_;
};

}  // namespace thimble::host

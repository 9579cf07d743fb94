// The builder at the terminal: prompts are printed, and answered on standard input, or at a second place.
#pragma once

#include <optional>
#include <string>

#include "host-tools/commission/person.h"

namespace thimble::host {

// Ctrl-C, "q", the end of the input or the second place's stop.
struct BuilderStops {};

[[nodiscard]] bool may_be_declined(const Prompt& prompt);

// Where the prompts are answered, too: the first answer counts. Called in the commissioning's thread.
class SecondPlace {
 public:
  SecondPlace() = default;
  SecondPlace(const SecondPlace&) = delete;
  SecondPlace& operator=(const SecondPlace&) = delete;
  virtual ~SecondPlace() = default;

  // bench_waits: the bench does nothing meanwhile, and may be read.
  virtual void ask(const Prompt& prompt, bool bench_waits) = 0;
  // Every few milliseconds while the prompt stands. kDone or kNo.
  [[nodiscard]] virtual std::optional<Answer> answer() = 0;
  virtual void withdraw() = 0;
  [[nodiscard]] virtual bool stopped() const = 0;
};

// Every call throws BuilderStops once the program has been interrupted, or the second place has stopped it. Only the question about a correction does
// not: its answer is then no, and stopped() says so.
class ConsolePerson final : public Person {
 public:
  // second: null, or outlives this. With one the end of the input ends nothing.
  explicit ConsolePerson(SecondPlace* second = nullptr) : second_(second) {}

  [[nodiscard]] Answer ask(const Prompt& prompt) override;
  [[nodiscard]] Answer ask(const Prompt& prompt, const std::function<bool()>& round) override;
  void check() const override;
  [[nodiscard]] bool stopped() const;

 private:
  using Over = std::function<bool()>;
  // Neither: it is over, or to be stopped.
  struct Heard {
    std::optional<std::string> line;
    std::optional<Answer> elsewhere;
  };
  [[nodiscard]] Heard hear(const Over& over);
  [[nodiscard]] Answer read_answer(const Prompt& prompt, const Over& over);

  SecondPlace* second_;
  bool stopped_ = false, input_ended_ = false;
};

}  // namespace thimble::host

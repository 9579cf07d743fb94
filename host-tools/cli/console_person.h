// The builder at the terminal: prompts are printed, and answered on standard input.
#pragma once

#include "host-tools/commission/person.h"

namespace thimble::host {

// Ctrl-C, "q" or the end of the input.
struct BuilderStops {};

// Every call throws BuilderStops once the program has been interrupted. Only the question about a correction does not: its answer is then no,
// and stopped() says so.
class ConsolePerson final : public Person {
 public:
  [[nodiscard]] Answer ask(const Prompt& prompt) override;
  [[nodiscard]] Answer ask(const Prompt& prompt, const std::function<bool()>& round) override;
  void check() const override;
  [[nodiscard]] bool stopped() const;

 private:
  bool stopped_ = false;
};

}  // namespace thimble::host

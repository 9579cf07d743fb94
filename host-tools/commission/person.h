// The builder beside a real arm, as a bench over the link asks for what it cannot do itself.
#pragma once

#include <functional>

#include "host-tools/commission/bench.h"

namespace thimble::host {

class Person {
 public:
  Person() = default;
  Person(const Person&) = delete;
  Person& operator=(const Person&) = delete;
  virtual ~Person() = default;

  // Returns when it is done, or refused.
  [[nodiscard]] virtual Answer ask(const Prompt& prompt) = 0;
  // The same, and calls round() again and again meanwhile, with no more than 10 ms between two calls. round() takes what has come over the link and
  // does not wait for more. False: it is over, whatever the person does.
  [[nodiscard]] virtual Answer ask(const Prompt& prompt, const std::function<bool()>& round) = 0;
  // Throws what ends the commissioning, if the person wants that.
  virtual void check() const {}
};

}  // namespace thimble::host

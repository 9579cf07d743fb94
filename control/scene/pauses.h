// Pauses in long background work: a board whose tick is not an interrupt runs it there. Every loop whose
// length depends on the scene image calls step().
#pragma once

namespace thimble::control {

using Pause = void (*)() noexcept;  // null: no pauses needed

class Pauses {
 public:
  explicit Pauses(Pause pause) noexcept : pause_(pause) {}
  void step() noexcept {
    if (pause_ != nullptr && ++steps_ % kSteps == 0) pause_();
  }

 private:
  static constexpr unsigned kSteps = 64;  // about 10 us of checking on a board
  Pause pause_;
  unsigned steps_ = 0;
};

}  // namespace thimble::control

// Breaks in long work: a board whose tick is no interrupt runs it there. step() stands in every loop whose length a scene
// image chooses.
#pragma once

namespace thimble::control {

using Pause = void (*)() noexcept;  // null: no breaks needed

class Pauses {
 public:
  explicit Pauses(Pause pause) noexcept : pause_(pause) {}
  void step() noexcept {
    if (pause_ != nullptr && ++steps_ % kSteps == 0) pause_();
  }

 private:
  static constexpr unsigned kSteps = 64;  // some ten microseconds of checking on a board
  Pause pause_;
  unsigned steps_ = 0;
};

}  // namespace thimble::control

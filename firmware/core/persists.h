// A condition that has held without a break for some time: a measurement that is wrong for an instant is noise.
#pragma once

namespace thimble::firmware {

class Persists {
 public:
  // True: it has held for longer than time_s. Called once a tick.
  [[nodiscard]] bool update(bool holds, float time_s, float period_s) noexcept {
    held_s_ = holds ? held_s_ + period_s : 0.0F;
    return held_s_ > time_s;
  }

 private:
  float held_s_ = 0;
};

}  // namespace thimble::firmware

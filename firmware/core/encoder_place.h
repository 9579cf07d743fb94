// Where an encoder stands: one count, or two neighbouring ones, between which a joint at rest may tremble, and an encoder with one dead
// channel changes however far it is turned.
#pragma once

#include <algorithm>
#include <cstdint>

namespace thimble::firmware {

class EncoderPlace {
 public:
  void reset(std::int32_t counts) noexcept { lowest_ = highest_ = counts; }

  // Which way it has left the place, 1 or -1; then the new place begins. 0: it has not.
  [[nodiscard]] int left(std::int32_t counts) noexcept {
    const int way = counts - lowest_ > 1 ? 1 : highest_ - counts > 1 ? -1 : 0;
    lowest_ = way != 0 ? counts : std::min(lowest_, counts);
    highest_ = way != 0 ? counts : std::max(highest_, counts);
    return way;
  }

 private:
  std::int32_t lowest_ = 0, highest_ = 0;
};

// The least change of a joint's torque that moves its encoder by so many counts, whatever its friction did before, against a spring at
// the tip: the arm's cables, or a hand.
class SureChange {
 public:
  constexpr SureChange() = default;
  constexpr SureChange(float counts, float coulomb_N_m, float count_rad, float spring_N_m) noexcept
      : friction_N_m_(2.0F * coulomb_N_m), spring_N_(counts * count_rad * spring_N_m) {}

  // The square of the tip's lever at the joint.
  [[nodiscard]] constexpr float torque_N_m(float lever2_m2) const noexcept {
    return friction_N_m_ + spring_N_ * lever2_m2;
  }

 private:
  float friction_N_m_ = 0, spring_N_ = 0;
};

}  // namespace thimble::firmware

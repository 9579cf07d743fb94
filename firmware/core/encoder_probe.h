// Finds an encoder that died while the arm holds a force: its counts stand still, as with a hand that holds still, so the force would
// stay after the hand has let go. A joint is probed that has a share of the force and does not count for kStill_s, or while its torque
// changes by much (encoder_watch.h): the force is taken away smoothly until the joint counts, and comes back then. If no force is left
// and the joint has not counted, the encoder is dead, provided that the share was great enough to move a sound one. A smaller one may
// leave a sound joint where it is, by its friction: then the force stays away until the joint counts. The probe only takes force away,
// so it gives the hand no energy.
//
// One an arm. While armed, once a tick: watch() for every joint, then part(). Units: counts, N, s. Cannot fail.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "firmware/core/config.h"
#include "firmware/core/encoder_place.h"

namespace thimble::firmware {

class EncoderProbe {
 public:
  static constexpr float kStill_s = 0.2F;  // without a count; before, nothing is probed
  static constexpr float kShare_N = 0.3F;  // a joint with less of the force at the tip is not probed
  static constexpr float kCounts = 3.0F,
                         kFirmHand_N_m = 2000.0F;  // a share moves a sound joint by so much against this hand
  // A still hand answers within the first kGentle of the force, which is taken away in kGentle_s and given back as fast: a tenth is the
  // least change of a force that a hand notices (Weber fraction). The rest goes within kRest_s.
  static constexpr float kGentle = 0.1F, kGentle_s = 0.05F, kRest_s = 0.1F;
  // A hand that lifts off while the force is taken away may keep a joint where it is, by the joint's friction; not for this long.
  static constexpr float kEmpty_s = 0.1F;

  void reset() noexcept { *this = {}; }

  struct Sight {
    std::int32_t counts;
    bool holds;    // the joint has a share of the force of kShare_N or more
    bool sure;     // so great a share that a sound joint moves when it is taken away
    bool changed;  // its torque has changed by much since it last counted
    // Standing still alone is no reason: a receiver would report a cut cable, or the arm moves by itself.
    bool may_rest;
  };
  void watch(std::size_t joint, const Sight& sight, float period_s) noexcept {
    Joint& j = joints_[joint];
    if (j.place.counted(sight.counts)) {
      j.still_s = 0;
      j.sure = false;  // it has answered; what it does without a force tells nothing
    } else if (sight.holds && sight.changed) {
      j.still_s = 2 * kStill_s;
    } else {
      const bool suspect = sight.holds && !sight.may_rest;
      j.still_s = std::clamp(j.still_s + (suspect ? period_s : -period_s), 0.0F, 2 * kStill_s);
    }
    if (taken_ == 0.0F) j.sure = sight.sure;
  }

  // The part of the force that is left, 1 to 0.
  [[nodiscard]] float part(float period_s) noexcept {
    if (!any(&Joint::suspect)) {
      taken_ = std::max(taken_ - period_s * kGentle / kGentle_s, 0.0F);
    } else {
      const float rate = taken_ < kGentle ? kGentle / kGentle_s : (1.0F - kGentle) / kRest_s;
      taken_ = std::min(taken_ + period_s * rate, 1.0F);
    }
    empty_s_ = taken_ < 1.0F ? 0.0F : empty_s_ + period_s;
    return 1.0F - taken_;
  }

  [[nodiscard]] bool probes() const noexcept { return taken_ > 0.0F; }
  [[nodiscard]] bool dead() const noexcept { return empty_s_ > kEmpty_s && any(&Joint::surely); }

 private:
  struct Joint {
    EncoderPlace place;
    float still_s = 0;  // since it last counted, with a share of the force
    bool sure = false;  // when the probe began
    [[nodiscard]] bool suspect() const noexcept { return still_s > kStill_s; }
    [[nodiscard]] bool surely() const noexcept { return suspect() && sure; }
  };
  [[nodiscard]] bool any(bool (Joint::*is)() const noexcept) const noexcept {
    return std::any_of(joints_.begin(), joints_.end(), [&](const Joint& j) { return (j.*is)(); });
  }
  std::array<Joint, kJoints> joints_;
  float taken_ = 0;
  float empty_s_ = 0;  // since no force is left
};

}  // namespace thimble::firmware

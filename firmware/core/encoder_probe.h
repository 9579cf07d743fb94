// Finds an encoder that died while the arm holds a force: its counts stand still, as with a hand that holds still, so the force would
// stay after the hand has let go. A joint is probed that has a share of the force and does not count for kStill_s, or while its torque
// changes by much (encoder_watch.h): its torque, and no other joint's, is taken away smoothly until it counts, and comes back then. If no
// torque is left and the joint has not counted, the encoder is dead: only a share that moves a sound joint is probed. A probe only takes
// torque away, so it gives the hand no energy. The way in which a joint moves then tells a motor that is reversed.
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
  // A share of the force is probed if it moves a sound joint by so much against this hand, whatever its friction did before. A smaller one
  // proves nothing, and is no more than 0.6 N at the arms that are known (DeadEncoder.IsFoundWithinHalfASecond prints it).
  static constexpr float kCounts = 3.0F, kFirmHand_N_m = 2000.0F;
  // A still hand answers while the first kGentle of a joint's torque is taken away, in kGentle_s: about a tenth of the force, the least
  // change of it that a hand notices (Weber fraction). The rest goes within kRest_s. Both come back as fast.
  static constexpr float kGentle = 0.16F, kGentle_s = 0.08F, kRest_s = 0.04F;
  // A hand that lifts off while the torque is taken away may keep a joint where it is, by the joint's friction; not for this long.
  static constexpr float kEmpty_s = 0.04F;

  // A joint whose torque goes away moves against the torque. One that moves with it, so many times in a row, has a motor that pushes the
  // wrong way. A hand may move a sound one so at that moment, and one that lifts off does so in every probe; but then the joint gets on,
  // by the two counts that end a probe, and does not come back with its torque (DeadEncoder.ASoundEncoderIsNotTakenForADeadOne).
  static constexpr int kReversed = 4;
  static constexpr std::int32_t kComesBack = 2;  // counts within which it is in all of them

  void reset() noexcept { *this = {}; }

  struct Sight {
    std::int32_t counts;
    bool pushes_up;  // the joint's torque, its counts
    bool holds;    // the joint has so great a share of the force that a sound one moves when it is taken away
    bool changed;  // its torque has changed by much since it last counted
    // Standing still alone is no reason: a receiver would report a cut cable, or the arm moves by itself.
    bool may_rest;
  };
  void watch(std::size_t joint, const Sight& sight, float period_s) noexcept {
    Joint& j = joints_[joint];
    const float step = period_s * (j.taken < kGentle ? kGentle / kGentle_s : (1.0F - kGentle) / kRest_s);
    if (const int way = j.place.left(sight.counts); way != 0) {
      if (j.suspect() && j.taken > 0.0F) j.answered(sight.counts, way, sight.pushes_up);
      j.still_s = 0;
    } else if (j.suspect() || j.taken == 0.0F) {
      // Not while its torque comes back: what is left of it proves nothing.
      if (sight.holds && sight.changed) j.still_s = 2 * kStill_s;
      const bool suspect = sight.holds && !sight.may_rest;
      j.still_s = std::clamp(j.still_s + (suspect ? period_s : -period_s), 0.0F, 2 * kStill_s);
    }
    const bool probed_before = j.taken > 0.0F;
    j.taken = std::clamp(j.taken + (j.suspect() ? step : -step), 0.0F, 1.0F);
    probed_ += static_cast<int>(j.taken > 0.0F) - static_cast<int>(probed_before);
    // On a wall that swings or chatters the share comes and goes, and is less on average. A force that alternates has it for most of the time.
    if (j.taken < 1.0F) {
      j.empty_s = 0;
    } else {
      j.empty_s = sight.holds ? j.empty_s + period_s : std::max(0.0F, j.empty_s - 4.0F * period_s);
    }
  }

  // The part of the joint's torque that is left, 1 to 0.
  [[nodiscard]] float part(std::size_t joint) const noexcept { return 1.0F - joints_[joint].taken; }
  [[nodiscard]] bool probes() const noexcept { return probed_ != 0; }
  [[nodiscard]] bool dead() const noexcept {
    return std::ranges::any_of(joints_, [](const Joint& j) { return j.suspect() && j.empty_s > kEmpty_s; });
  }
  [[nodiscard]] bool reversed(std::size_t joint) const noexcept {
    return joints_[joint].with_torque >= kReversed;
  }

 private:
  struct Joint {
    EncoderPlace place;
    float still_s = 0;                // since it last counted, with a share of the force
    float taken = 0;                  // of its torque
    float empty_s = 0;                // while no torque is left: with such a share, less four times without
    int with_torque = 0;              // how many probes in a row ended so that it moved as its torque pushes
    std::int32_t with_torque_at = 0;  // its counts at the first of them
    [[nodiscard]] bool suspect() const noexcept { return still_s > kStill_s; }
    void answered(std::int32_t counts, int way, bool pushes_up) noexcept {
      if (with_torque == 0 || (counts - with_torque_at) * way > kComesBack) {
        with_torque = 0;
        with_torque_at = counts;
      }
      with_torque = (way > 0) == pushes_up ? with_torque + 1 : 0;
    }
  };
  std::array<Joint, kJoints> joints_;
  int probed_ = 0;  // joints of which something is taken: most ticks ask for it more than once
};

}  // namespace thimble::firmware

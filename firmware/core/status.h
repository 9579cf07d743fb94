// What the tick tells the background at the end of every tick: mode, fault, and what refuses a command.
#pragma once

#include <cstdint>

#include "firmware/core/conditions.h"
#include "firmware/core/faults.h"
#include "firmware/core/modes.h"
#include "firmware/core/state.h"
#include "firmware/exchange/word.h"
#include "firmware/params.h"
#include "firmware/sources/sources.h"

namespace thimble::firmware {

class Status {
 public:
  Status(const Params& params, const Sources& sources) noexcept : params_(params), sources_(sources) {}

  // --- tick
  void publish(const State& state, Conditions unmet, Conditions unmet_for_move) noexcept {
    faults_seen_.set(state.faults_seen);
    fault_tick_.set(state.fault_tick);
    fault_.set(state.fault);
    unmet_.set(unmet);
    unmet_for_move_.set(unmet_for_move);
    disarms_.set(state.disarms_seen);
    alive_.set(state.alive_seen);
    stopped_by_.set(state.stopped_by);
    mode_.set(state.mode);
  }

  // --- background
  [[nodiscard]] Mode mode() const noexcept { return mode_.get(); }
  [[nodiscard]] Fault fault() const noexcept { return fault_.get(); }
  [[nodiscard]] StoppedBy stopped_by() const noexcept { return stopped_by_.get(); }
  // The conditions that refuse arming, as of the last tick. Only the need for a scene follows the parameters at once, so that a host
  // may set host_forces and arm without waiting for a tick.
  [[nodiscard]] Conditions unmet() const noexcept {
    const Conditions unmet = unmet_.get();
    const bool scene = (unmet & kNoScene) == 0 || sources_.wanted(params_).needs().scene;
    return scene ? unmet : unmet & ~Conditions{kNoScene};
  }
  // How many disarms the tick has obeyed (Commands::disarms()).
  [[nodiscard]] std::uint32_t disarms() const noexcept { return disarms_.get(); }
  // How many signs of life it has seen (Commands::alive()); read before unmet(), which is of that tick then, or of a later one.
  [[nodiscard]] std::uint32_t alive() const noexcept { return alive_.get(); }
  [[nodiscard]] Conditions unmet_of_tick() const noexcept { return unmet_.get(); }
  [[nodiscard]] Conditions unmet_for_move() const noexcept { return unmet_for_move_.get(); }
  // Bit n: fault n occurred since the last clear. Low 32 bits of the tick in which the first one latched.
  [[nodiscard]] std::uint32_t faults_seen() const noexcept { return faults_seen_.get(); }
  [[nodiscard]] std::uint32_t fault_tick() const noexcept { return fault_tick_.get(); }

 private:
  const Params& params_;
  const Sources& sources_;
  // The mode is set last, and the fault after its figures. A reader of one of the two therefore sees figures of the same tick or a later
  // one.
  Signal<Mode> mode_{Mode::kDisarmed};
  Signal<Fault> fault_{Fault::kNone};
  Value<Conditions> unmet_{kNotHomed | kEncoderStale | kNoScene};
  Value<Conditions> unmet_for_move_{kNotArmed};
  Value<std::uint32_t> faults_seen_;
  Value<std::uint32_t> fault_tick_;
  Value<StoppedBy> stopped_by_{StoppedBy::kNothing};
  Signal<std::uint32_t> disarms_{0};
  Signal<std::uint32_t> alive_{0};
};

}  // namespace thimble::firmware

// Guarded moves (guarded_move.h) as a force source: a guest that leads one arm while the others feel the scene. Its orders come from
// the background, and the measurement goes back when a move has ended.
#pragma once

#include <cstdint>

#include "firmware/exchange/mailbox.h"
#include "firmware/exchange/word.h"
#include "firmware/link/messages.h"
#include "firmware/link/services.h"
#include "firmware/sources/force_source.h"
#include "firmware/sources/guarded_move.h"

namespace thimble::firmware {

class GuardedMoveSource final : public ForceSource {
 public:
  GuardedMoveSource() noexcept;

  // --- background
  // The order of Command::kMove, before that is posted. False: the last order is still waiting.
  [[nodiscard]] bool post(const MoveOrder& order) noexcept;
  [[nodiscard]] link::MovePhase phase() const noexcept { return phase_.get(); }
  [[nodiscard]] link::MoveEnd end() const noexcept { return end_.get(); }
  // Of the move that ran last. Null: one is under way, or ordered.
  [[nodiscard]] const MoveResults* results() const noexcept {
    return orders_.sent() ? nullptr : results_.letter();
  }

  // --- tick
  [[nodiscard]] bool wanted(const Params&) const noexcept override { return false; }  // a guest only
  void start(const SourceTick&) noexcept override {}
  void forces(const SourceTick& tick, SourceForces& out) noexcept override;

  [[nodiscard]] const MoveOrder* ordered() const noexcept { return orders_.letter(); }
  void begin(const SourceTick& tick) noexcept;  // the move that is ordered()
  void forget_order() noexcept { orders_.done(); }
  void stop() noexcept { move_.stop(); }
  void publish() noexcept;  // at the end of every tick

  [[nodiscard]] bool active() const noexcept { return move_.active(); }
  [[nodiscard]] float speed_m_s() const noexcept { return move_.ordered_m_s(); }  // of the move's order
  [[nodiscard]] bool under_way() const noexcept { return move_.under_way(); }

 private:
  GuardedMove move_;
  Mailbox<MoveOrder> orders_;
  Mailbox<MoveResults> results_;  // taken back when the next move is ordered
  // phase_ is set last: who reads it sees the end and the results that belong to it.
  Value<link::MoveEnd> end_{link::MoveEnd::kNotYet};
  Signal<link::MovePhase> phase_{link::MovePhase::kNone};
};

}  // namespace thimble::firmware

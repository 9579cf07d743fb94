// The table of force sources. When the arm is armed, the first row that is wanted() gives the forces of all arms; a guarded move and an
// order for the axes are guests on top of it.
#pragma once

#include <array>
#include <span>

#include "firmware/core/config.h"
#include "firmware/params.h"
#include "firmware/sources/axis_source.h"
#include "firmware/sources/guarded_move_source.h"
#include "firmware/sources/host_forces.h"
#include "firmware/sources/scene_source.h"

namespace thimble::firmware {

class Sources {
 public:
  // own: rows in front of table_ (Config::sources).
  Sources(float period_s, std::uint32_t work_units, std::span<ForceSource* const> own) noexcept
      : host(period_s), scene(work_units), own_(own) {}
  Sources(const Sources&) = delete;
  Sources& operator=(const Sources&) = delete;

  HostForces host;
  SceneSource scene;
  GuardedMoveSource move;
  AxisSource axes;

  // The source that arming with these parameters gives. Called from both contexts.
  [[nodiscard]] ForceSource& wanted(const Params& params) const noexcept {
    for (ForceSource* source : own_)
      if (source->wanted(params)) return *source;
    for (ForceSource* source : table_)
      if (source->wanted(params)) return *source;
    return *table_.back();
  }
  // A guest leads an arm, as of the last tick. Of the background.
  [[nodiscard]] bool guest_leads() const noexcept {
    return move.phase() != link::MovePhase::kNone || axes.state().phase != link::AxisPhase::kNone;
  }
  void start_all(const SourceTick& tick) noexcept {
    for (ForceSource* source : own_) source->start(tick);
    for (ForceSource* source : table_) source->start(tick);
  }

 private:
  std::span<ForceSource* const> own_;
  std::array<ForceSource*, 4> table_ = {&move, &axes, &host, &scene};
};

}  // namespace thimble::firmware

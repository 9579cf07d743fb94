// How the controller does, as real-time frames: Emergency at once when a fault latches or is cleared, Heartbeat and
// Status at fixed intervals. They go before all other frames.
//
// Who calls it: the controller, in the background context. Nothing here can fail.
#pragma once

#include <cstdint>

#include "firmware/core/core.h"
#include "firmware/core/faults.h"
#include "firmware/link/can_frame.h"
#include "firmware/link/messages.h"
#include "firmware/observe/telemetry_frames.h"
#include "firmware/params.h"
#include "firmware/store/scene_store.h"

namespace thimble::firmware {

class StatusFrames {
 public:
  static constexpr link::Micros kStatusPeriod_us = 100'000;
  static constexpr link::Micros kHeartbeatPeriod_us = 500'000;

  StatusFrames(const Core& core, const Params& params, const SceneStore& store, TelemetryFrames& telemetry,
               std::uint8_t node) noexcept
      : core_(core), params_(params), store_(store), telemetry_(telemetry), node_(node) {}

  [[nodiscard]] bool next_frame(link::CanFrame& frame, link::Micros now) noexcept;
  [[nodiscard]] link::StatusFlags flags() const noexcept;

 private:
  [[nodiscard]] link::CanFrame emergency_frame(Fault fault) const noexcept;
  [[nodiscard]] link::CanFrame heartbeat_frame(Fault fault) const noexcept;
  [[nodiscard]] link::CanFrame status_frame(Fault fault) noexcept;

  const Core& core_;
  const Params& params_;
  const SceneStore& store_;
  TelemetryFrames& telemetry_;
  std::uint8_t node_;
  Fault reported_ = Fault::kNone;
  link::Micros status_due_ = 0;
  link::Micros heartbeat_due_ = 0;
  bool put_off_due_ = false;
};

}  // namespace thimble::firmware

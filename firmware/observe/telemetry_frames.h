// The telemetry records of the tick as real-time frames. For each record a Pose and a Force of every arm, then a GodObject
// of every arm that touches something, then what the parameter telemetry_content adds of what the arms have. With the
// parameter telemetry_fd, one CAN FD frame (ArmRecord) of every arm instead. Only the newest record is sent; what was left
// of the record before it is dropped and counted.
//
// Who calls it: the controller, in the background context. Nothing here can fail.
#pragma once

#include <cstdint>

#include "control/scene/limits.h"
#include "firmware/core/core.h"
#include "firmware/link/can_frame.h"
#include "firmware/observe/telemetry.h"
#include "firmware/params.h"

namespace thimble::firmware {

class TelemetryFrames {
 public:
  TelemetryFrames(Core& core, const Params& params, std::uint8_t node) noexcept
      : core_(core), params_(params), node_(node) {}

  // Takes every record that the tick has put out. True: at least one.
  bool fetch() noexcept;
  [[nodiscard]] bool next_tip_frame(link::CanFrame& frame) noexcept;  // Pose and Force, or ArmRecord
  // Once the tip frames have left: GodObject, and what is opt-in.
  [[nodiscard]] bool next_detail_frame(link::CanFrame& frame) noexcept;

  [[nodiscard]] const Telemetry& record() const noexcept { return record_; }  // the newest
  [[nodiscard]] float rate_Hz() const noexcept { return rate_Hz_; }           // of the loop; 0: not known yet
  [[nodiscard]] std::uint32_t dropped() const noexcept { return dropped_; }   // frames, since start
  // Since the last call: the limiters that acted (Limiter bits), and the longest tick.
  [[nodiscard]] std::uint8_t take_limiters() noexcept;
  [[nodiscard]] float take_worst_tick_us() noexcept;

 private:
  [[nodiscard]] bool has_god_object(std::size_t arm) const noexcept;
  [[nodiscard]] bool has_orientation(std::size_t arm) const noexcept;
  [[nodiscard]] bool has_part(std::size_t arm, unsigned content) const noexcept;  // detail_part_
  [[nodiscard]] link::CanFrame orientation_frame(std::size_t arm) const noexcept;
  [[nodiscard]] link::CanFrame pose_frame(std::size_t arm) const noexcept;
  [[nodiscard]] link::CanFrame force_frame(std::size_t arm) const noexcept;
  [[nodiscard]] link::CanFrame god_object_frame(std::size_t arm) const noexcept;
  [[nodiscard]] link::CanFrame joints_frame(std::size_t arm, unsigned content) const noexcept;
  [[nodiscard]] link::CanFrame record_frame(std::size_t arm) const noexcept;
  template <class Message>
  void put_head(Message& message, std::size_t arm) const noexcept;

  Core& core_;
  const Params& params_;
  std::uint8_t node_;
  Telemetry record_;
  std::uint8_t sequence_ = 0;                    // counts records: pairs pose with force
  std::uint8_t tip_frames_left_ = 0;             // of record_
  std::uint8_t detail_arm_ = control::kMaxArms;  // of record_: the arm whose turn it is
  std::uint8_t detail_ = 0;                      // how many details of that arm have been looked at
  std::uint8_t detail_part_ = 0;                 // how many frames of this one have been sent
  bool fd_ = false;                              // record_ is sent as ArmRecords
  std::uint32_t content_ = 0;                    // of record_: TelemetryContent
  std::uint32_t dropped_ = 0;
  std::uint8_t limiters_ = 0;
  float worst_tick_us_ = 0;
  // The tick rate is measured over a window that began here.
  std::uint64_t window_tick_ = 0;
  std::uint64_t window_time_us_ = 0;
  float rate_Hz_ = 0;
};

}  // namespace thimble::firmware

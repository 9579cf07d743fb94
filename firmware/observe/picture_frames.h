// The picture of the scene as real-time frames: where its bodies are, how its control elements stand, its tissues, the
// planes that hold the god objects, and the solids that a tip is still inside of. A picture is the state of one tick. It is sent a few frames after each telemetry
// record, and the next picture is fetched when this one has left: a busy link shows fewer pictures, never half ones.
//
// Who calls it: the controller, in the background context. Nothing here can fail.
#pragma once

#include <cstddef>
#include <cstdint>

#include "control/bodies/bodies.h"
#include "control/fields/fields.h"
#include "control/scene/limits.h"
#include "firmware/core/core.h"
#include "firmware/link/can_frame.h"
#include "firmware/observe/telemetry.h"

namespace thimble::firmware {

class PictureFrames {
 public:
  // After each telemetry record. At 100 records a second 400 frames, a twentieth of a classic bus at 1 Mbit/s.
  static constexpr std::uint8_t kFramesARecord = 4;

  PictureFrames(Core& core, std::uint8_t node) noexcept : core_(core), node_(node) {}

  void on_record() noexcept { frames_left_ = kFramesARecord; }  // a telemetry record came
  [[nodiscard]] bool next_frame(link::CanFrame& frame) noexcept;

 private:
  [[nodiscard]] bool next_part(link::CanFrame& frame) noexcept;
  [[nodiscard]] bool next_of_arm(link::CanFrame& frame) noexcept;
  [[nodiscard]] link::CanFrame plane_frame(std::size_t arm, std::uint8_t index) const noexcept;
  [[nodiscard]] link::CanFrame body_frame(const control::BodyState& body, std::uint8_t part) const noexcept;
  [[nodiscard]] link::CanFrame tissue_frame(const control::TissueView& tissue) const noexcept;

  Core& core_;
  std::uint8_t node_;
  Picture picture_;
  std::uint8_t sequence_ = 0;             // counts pictures
  std::size_t at_ = 0;                    // bodies and tissues of the picture that have been sent whole
  std::uint8_t part_ = 0;                 // frames of the next one that have been sent
  std::uint8_t arm_ = control::kMaxArms;  // then the planes and the solids around the tip: whose turn it is
  std::uint8_t plane_at_ = 0;
  std::uint8_t frames_left_ = 0;  // until the next record
};

}  // namespace thimble::firmware

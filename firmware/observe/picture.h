// The picture of a scene in one tick: the poses of bodies, the deformation of tissues, the planes that hold the god objects, and the solids
// that a tip is still inside of. The tick takes a picture at a telemetry record if the background has fetched the one before (Mailbox). picture_frames.h sends it as frames.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "control/bodies/bodies.h"
#include "control/contact/god_object.h"
#include "control/fields/fields.h"
#include "control/scene/limits.h"
#include "firmware/exchange/mailbox.h"
#include "kinematics/vector.h"

namespace thimble::firmware {

struct Picture {
  std::array<control::BodyState, control::kMaxBodies> bodies;
  control::TissueViews tissues;
  std::array<std::array<Vec3, control::kMaxContacts>, control::kMaxArms>
      planes;  // their normals, world frame
  std::array<std::uint8_t, control::kMaxArms> plane_count{};
  std::array<std::uint64_t, control::kMaxArms> inside{};  // as ArmTelemetry::inside
  std::size_t body_count = 0;
  std::size_t tissue_count = 0;
};

class PictureExchange {
 public:
  // --- tick
  [[nodiscard]] Picture* blank() noexcept { return box_.blank(); }  // null: the last one was not fetched yet
  void send() noexcept { box_.send(); }

  // --- background
  // The newest picture since the last call; false: none was taken, or it would be empty.
  [[nodiscard]] bool next(Picture& picture) noexcept {
    const Picture* newest = box_.letter();
    if (newest == nullptr) return false;
    picture = *newest;
    box_.done();
    return true;
  }

 private:
  Mailbox<Picture> box_;
};

}  // namespace thimble::firmware

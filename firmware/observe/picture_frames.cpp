#include "firmware/observe/picture_frames.h"

#include <bit>

#include "firmware/link/messages.h"

namespace thimble::firmware {

bool PictureFrames::next_frame(link::CanFrame& frame) noexcept {
  if (frames_left_ == 0 || !next_part(frame)) return false;
  --frames_left_;
  return true;
}

// Each body: its position, its rotation and, when it is a control element, its coordinate. Then the tissues, then the planes and
// the solids around the tip of each arm.
bool PictureFrames::next_part(link::CanFrame& frame) noexcept {
  if (at_ == picture_.body_count + picture_.tissue_count) {
    if (next_of_arm(frame)) return true;
    if (!core_.observers().picture.next(picture_)) return false;
    ++sequence_;
    at_ = 0;
    part_ = 0;
    arm_ = 0;
    plane_at_ = 0;
    if (picture_.body_count + picture_.tissue_count == 0) return next_of_arm(frame);
  }
  if (at_ >= picture_.body_count) {
    frame = tissue_frame(picture_.tissues[at_++ - picture_.body_count]);
    return true;
  }
  const control::BodyState& body = picture_.bodies[at_];
  frame = body_frame(body, part_);
  const std::uint8_t parts = body.controlled ? 3 : 2;
  if (++part_ == parts) {
    part_ = 0;
    ++at_;
  }
  return true;
}

bool PictureFrames::next_of_arm(link::CanFrame& frame) noexcept {
  for (; arm_ < control::kMaxArms; ++arm_, plane_at_ = 0) {
    if (plane_at_ < picture_.plane_count[arm_]) {
      frame = plane_frame(arm_, plane_at_++);
      return true;
    }
    std::uint64_t& inside = picture_.inside[arm_];
    if (inside == 0) continue;
    link::Inside solid;
    solid.object = static_cast<std::uint8_t>(std::countr_zero(inside));
    solid.arm = arm_;
    solid.sequence = sequence_;
    inside &= inside - 1;
    frame = link::to_frame(solid, node_);
    return true;
  }
  return false;
}

link::CanFrame PictureFrames::plane_frame(std::size_t arm, std::uint8_t index) const noexcept {
  const Vec3& normal = picture_.planes[arm][index];
  link::ContactPlane plane;
  plane.arm = static_cast<std::uint8_t>(arm);
  plane.index = index;
  plane.count = picture_.plane_count[arm];
  plane.sequence = sequence_;
  plane.x = normal.x();
  plane.y = normal.y();
  plane.z = normal.z();
  return link::to_frame(plane, node_);
}

link::CanFrame PictureFrames::body_frame(const control::BodyState& body, std::uint8_t part) const noexcept {
  if (part == 0) {
    link::BodyPosition position;
    position.object = body.object;
    position.sequence = sequence_;
    position.x_m = body.position_m.x();
    position.y_m = body.position_m.y();
    position.z_m = body.position_m.z();
    return link::to_frame(position, node_);
  }
  if (part == 1) {
    const float side = body.rotation.w() < 0.0F ? -1.0F : 1.0F;  // both signs are the same rotation
    link::BodyRotation rotation;
    rotation.object = body.object;
    rotation.sequence = sequence_;
    rotation.x = side * body.rotation.x();
    rotation.y = side * body.rotation.y();
    rotation.z = side * body.rotation.z();
    return link::to_frame(rotation, node_);
  }
  link::ControlElementState control;
  control.object = body.object;
  control.sequence = sequence_;
  control.on = body.on;
  control.q = body.q;
  return link::to_frame(control, node_);
}

link::CanFrame PictureFrames::tissue_frame(const control::TissueView& tissue) const noexcept {
  const auto with = [&](auto message) {
    message.object = tissue.object;
    message.arm = tissue.arm;
    message.x_m = tissue.x_m;
    message.y_m = tissue.y_m;
    message.depth_m = tissue.depth_m;
    return message;
  };
  if (tissue.is_needle) {
    auto needle = with(link::NeedleState{});
    needle.inside = tissue.inside;
    needle.torn = tissue.torn;
    return link::to_frame(needle, node_);
  }
  auto dimple = with(link::TissueState{});
  dimple.pressed = tissue.inside;
  return link::to_frame(dimple, node_);
}

}  // namespace thimble::firmware

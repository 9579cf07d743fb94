#include "firmware/observe/picture_frames.h"

#include "firmware/link/messages.h"

namespace thimble::firmware {

bool PictureFrames::next_frame(link::CanFrame& frame) noexcept {
  if (frames_left_ == 0 || !next_part(frame)) return false;
  --frames_left_;
  return true;
}

// Each body: its position, its rotation and, when it is a control element, its coordinate. Then the tissues, then the planes.
bool PictureFrames::next_part(link::CanFrame& frame) noexcept {
  if (at_ == picture_.body_count + picture_.tissue_count) {
    if (next_plane(frame)) return true;
    if (!core_.observers().picture.next(picture_)) return false;
    ++sequence_;
    at_ = 0;
    part_ = 0;
    plane_arm_ = 0;
    plane_at_ = 0;
    if (picture_.body_count + picture_.tissue_count == 0) return next_plane(frame);
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

bool PictureFrames::next_plane(link::CanFrame& frame) noexcept {
  for (; plane_arm_ < control::kMaxArms; ++plane_arm_, plane_at_ = 0) {
    if (plane_at_ >= picture_.plane_count[plane_arm_]) continue;
    const Vec3& normal = picture_.planes[plane_arm_][plane_at_];
    link::ContactPlane plane;
    plane.arm = plane_arm_;
    plane.index = plane_at_;
    plane.count = picture_.plane_count[plane_arm_];
    plane.sequence = sequence_;
    plane.x = normal.x();
    plane.y = normal.y();
    plane.z = normal.z();
    ++plane_at_;
    frame = link::to_frame(plane, node_);
    return true;
  }
  return false;
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

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
    if (!servo_.next_scene_state(picture_)) return false;
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
    const unsigned count = picture_.plane_count[plane_arm_];
    if (plane_at_ >= count) continue;
    const Vec3& normal = picture_.planes[plane_arm_][plane_at_];
    const link::ContactPlane plane{
        static_cast<std::uint8_t>(plane_arm_ | static_cast<unsigned>(plane_at_) << 1U | count << 3U),
        sequence_, normal.x(), normal.y(), normal.z()};
    ++plane_at_;
    frame = link::to_frame(plane, node_);
    return true;
  }
  return false;
}

link::CanFrame PictureFrames::body_frame(const control::BodyState& body, std::uint8_t part) const noexcept {
  if (part == 0) {
    const link::BodyPosition position{body.object, sequence_, body.position_m.x(), body.position_m.y(),
                                      body.position_m.z()};
    return link::to_frame(position, node_);
  }
  if (part == 1) {
    const float side = body.rotation.w() < 0.0F ? -1.0F : 1.0F;  // both signs are the same rotation
    const link::BodyRotation rotation{body.object, sequence_, side * body.rotation.x(),
                                      side * body.rotation.y(), side * body.rotation.z()};
    return link::to_frame(rotation, node_);
  }
  const link::ControlState control{body.object, sequence_, static_cast<std::uint8_t>(body.on ? 1 : 0),
                                   body.q};
  return link::to_frame(control, node_);
}

link::CanFrame PictureFrames::tissue_frame(const control::TissueView& tissue) const noexcept {
  const unsigned arm_inside = tissue.arm | (tissue.inside ? 2U : 0U);
  if (tissue.is_needle) {
    const link::NeedleState needle{
        tissue.object, static_cast<std::uint8_t>(arm_inside | static_cast<unsigned>(tissue.torn) << 2U),
        tissue.x_m, tissue.y_m, tissue.depth_m};
    return link::to_frame(needle, node_);
  }
  const link::TissueState state{tissue.object, static_cast<std::uint8_t>(arm_inside), tissue.x_m, tissue.y_m,
                                tissue.depth_m};
  return link::to_frame(state, node_);
}

}  // namespace thimble::firmware

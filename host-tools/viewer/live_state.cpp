#include "host-tools/viewer/live_state.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "firmware/core/faults.h"
#include "host-tools/client/flag_names.h"

namespace thimble::host {
namespace {

// Planes that are not renewed belong to a past contact, and solids that are not have been left.
constexpr link::Micros kPlaneLife_us = 300'000;

// The precision of the link; more digits would double the message.
double rounded(double value, double per_unit) { return std::round(value * per_unit) / per_unit; }
constexpr double kPerMetre = 1e6, kPerNewton = 1e4, kPerOne = 1e5;

template <class Message>
Json vector_json(const Message& m, double per_unit) {
  return {rounded(static_cast<double>(m.x_m), per_unit), rounded(static_cast<double>(m.y_m), per_unit),
          rounded(static_cast<double>(m.z_m), per_unit)};
}

std::array<double, 3> tip_of(const link::Pose& p) {
  return {static_cast<double>(p.x_m), static_cast<double>(p.y_m), static_cast<double>(p.z_m)};
}
std::array<double, 3> force_of(const link::Force& f) {
  return {static_cast<double>(f.x_N), static_cast<double>(f.y_N), static_cast<double>(f.z_N)};
}

Json rotation_json(const link::BodyRotation& r) {
  const double x = static_cast<double>(r.x), y = static_cast<double>(r.y), z = static_cast<double>(r.z);
  const double w = std::sqrt(std::max(0.0, 1 - x * x - y * y - z * z));
  return {rounded(w, kPerOne), rounded(x, kPerOne), rounded(y, kPerOne), rounded(z, kPerOne)};
}

}  // namespace

bool LiveState::take(const link::CanFrame& frame, link::Micros now_us) {
  const bool was_due = !shown_;
  link::visit_messages([&](auto message) {
    using Message = decltype(message);
    if constexpr (Message::kIsFrame) {
      if (!link::from_frame(frame, node_, message)) return;
      if constexpr (std::is_same_v<Message, link::Pose>) {
        take_pose(message, now_us);
      } else if constexpr (std::is_same_v<Message, link::Force>) {
        take_force(message);
      } else if constexpr (std::is_same_v<Message, link::GodObject>) {
        take_god(message);
      } else if constexpr (std::is_same_v<Message, link::JointAngles>) {
        take_angles(message);
      } else if constexpr (std::is_same_v<Message, link::ContactPlane>) {
        take_plane(message, now_us);
      } else if constexpr (std::is_same_v<Message, link::Inside>) {
        if (message.arm < arms_) arm_.at(message.arm).inside_us[message.object] = now_us;
      } else if constexpr (std::is_same_v<Message, link::Status>) {
        status_ = message;
        if ((message.limiters & link::kLimitWork) == 0) put_off_.reset();
        if (message.mode == link::Mode::kArmed) stopped_by_ = link::StoppedBy::kNothing;
      } else if constexpr (std::is_same_v<Message, link::PutOff>) {
        put_off_ = message;
      } else if constexpr (std::is_same_v<Message, link::Emergency>) {
        if (message.fault != 0) emergency_ = message.fault;
      } else if constexpr (std::is_same_v<Message, link::BodyPosition>) {
        positions_[message.object] = message;
      } else if constexpr (std::is_same_v<Message, link::BodyRotation>) {
        const auto position = positions_.find(message.object);
        if (position != positions_.end() && position->second.sequence == message.sequence)
          bodies_[message.object] = {position->second, message};
      } else if constexpr (std::is_same_v<Message, link::ControlElementState>) {
        controls_[message.object] = message;
      } else if constexpr (std::is_same_v<Message, link::TissueState>) {
        tissues_[{message.object, message.arm}] = message;
      } else if constexpr (std::is_same_v<Message, link::NeedleState>) {
        needles_[{message.object, message.arm}] = message;
      }
    }
  });
  if (shown_) return false;
  // If the last frame of a record was lost, the record ends when the next one begins.
  link::Pose pose;
  const bool next_began = was_due && link::from_frame(frame, node_, pose) && pose.arm == 0;
  if (!complete() && !next_began) return false;
  shown_ = !next_began;
  return true;
}

void LiveState::take_pose(const link::Pose& pose, link::Micros now_us) {
  if (pose.arm >= arms_) return;
  Arm& arm = arm_.at(pose.arm);
  if (arm.pose && pose.sequence != arm.pose->sequence) {
    constexpr unsigned kCount = 1U << link::kSequenceBits;
    const unsigned records = (pose.sequence + kCount - arm.pose->sequence) % kCount;
    // So long after the last one the count has wrapped: nothing is known of the path between.
    const bool known = static_cast<double>(now_us - arm.pose_us) * 1e-6 < kCount * period_s_;
    const std::array<double, 3> from = tip_of(*arm.pose);
    const std::array<double, 3> to = tip_of(pose);
    for (std::size_t i = 0; i < to.size(); ++i) {
      constexpr double kNew = 0.5;  // a mean over some records: a step of the link's is 1 mm/s of one record
      const double speed = known ? (to[i] - from[i]) / (records * period_s_) : 0.0;
      arm.velocity_m_s[i] += kNew * (speed - arm.velocity_m_s[i]);
    }
    arm.moves = true;
  }
  if (!arm.pose || pose.sequence != arm.pose->sequence) {
    if (!arm.has_joints) arm.joints.reset();
    arm.has_joints = false;
    arm.angles.clear();
  }
  arm.pose = pose;
  arm.pose_us = now_us;
  sequence_ = pose.sequence;
  shown_ = false;
}

void LiveState::take_force(const link::Force& force) {
  if (force.arm >= arms_) return;
  Arm& arm = arm_.at(force.arm);
  const bool held_before = arm.force && arm.force->contacts != 0;
  arm.force = force;
  limiters_ = static_cast<std::uint8_t>(force.arm == 0 ? force.limiters : limiters_ | force.limiters);
  if (force.contacts == 0) arm.planes.clear();
  if (!arm.pose || arm.pose->sequence != force.sequence) {
    arm.worked.reset();
    return;
  }
  const std::pair now{tip_of(*arm.pose), force_of(force)};
  if (force.contacts != 0) {
    if (!held_before) {
      arm.energy_J = 0;
      arm.begun = true;
    }
    if (arm.worked && held_before) {
      for (std::size_t i = 0; i < 3; ++i) {
        arm.energy_J += 0.5 * (now.second[i] + arm.worked->second[i]) * (now.first[i] - arm.worked->first[i]);
      }
    }
  }
  arm.worked = now;
}

// A contact begins between two records: the hand has done the work that the spring holds by then.
void LiveState::take_god(const link::GodObject& god) {
  if (god.arm >= arms_) return;
  Arm& arm = arm_.at(god.arm);
  arm.god = god;
  if (!std::exchange(arm.begun, false) || !arm.worked || !arm.pose || arm.pose->sequence != god.sequence)
    return;
  const std::array<double, 3> at{static_cast<double>(god.x_m), static_cast<double>(god.y_m),
                                 static_cast<double>(god.z_m)};
  for (std::size_t i = 0; i < at.size(); ++i)
    arm.energy_J += 0.5 * arm.worked->second[i] * (arm.worked->first[i] - at[i]);
}

void LiveState::take_plane(const link::ContactPlane& plane, link::Micros now_us) {
  if (plane.arm >= arms_) return;
  Arm& arm = arm_.at(plane.arm);
  if (arm.planes_sequence != plane.sequence) arm.planes.clear();
  arm.planes_sequence = plane.sequence;
  arm.planes_us = now_us;
  constexpr std::size_t kMost = 3;
  const auto same = std::ranges::find(arm.planes, plane.index, &link::ContactPlane::index);
  if (same != arm.planes.end()) {
    *same = plane;
  } else if (arm.planes.size() < kMost) {
    arm.planes.push_back(plane);
  }
}

// They come in order; without the ones before, the rest is of no use.
void LiveState::take_angles(const link::JointAngles& angles) {
  if (angles.arm >= arms_ || angles.arm >= arm_.size()) return;
  Arm& arm = arm_.at(angles.arm);
  const std::size_t axes = axes_.at(angles.arm);
  if (!arm.pose || arm.pose->sequence != angles.sequence || arm.angles.size() >= axes) return;
  if (arm.angles.size() != angles.part * angles.angle_rad.size()) return;
  for (const float angle : angles.angle_rad) arm.angles.push_back(static_cast<double>(angle));
  if (arm.angles.size() < axes) return;
  arm.angles.resize(axes);
  arm.joints = Joints{arm.angles, tip_of(*arm.pose)};
  arm.has_joints = true;
}

bool LiveState::complete() const {
  for (std::size_t i = 0; i < arms_ && i < arm_.size(); ++i) {
    const Arm& arm = arm_.at(i);
    if (!arm.pose || !arm.force || arm.pose->sequence != sequence_ || arm.force->sequence != sequence_)
      return false;
    if (arm.force->contacts != 0 && (!arm.god || arm.god->sequence != sequence_)) return false;
    if (arm.joints && !arm.has_joints) return false;  // as in the record before
  }
  return true;
}

void LiveState::take_state(const link::DeviceState& state) {
  if (!status_) status_.emplace();
  status_->mode = state.mode;
  status_->fault = state.fault;
  status_->flags = state.flags;
  status_->tick_rate_Hz = state.tick_rate_Hz;
  stopped_by_ = state.mode == link::Mode::kArmed ? link::StoppedBy::kNothing : state.stopped_by;
}

void LiveState::forget_scene() {
  positions_.clear();
  bodies_.clear();
  controls_.clear();
  tissues_.clear();
  needles_.clear();
  for (Arm& arm : arm_) {
    arm.planes.clear();
    arm.inside_us.clear();
  }
}

std::optional<std::uint8_t> LiveState::take_emergency() { return std::exchange(emergency_, std::nullopt); }

Json LiveState::arm_json(const Arm& arm, link::Micros now_us) const {
  const unsigned contacts = arm.force ? arm.force->contacts : 0;
  const bool own = arm.god && (contacts != 0 || arm.god->sequence == arm.pose->sequence);
  Json json = {{"tip_m", vector_json(*arm.pose, kPerMetre)}};
  json["god_m"] = own ? vector_json(*arm.god, kPerMetre) : json["tip_m"];
  if (arm.force) {
    const std::array<double, 3> force = force_of(*arm.force);
    json["force_N"] = {rounded(force[0], kPerNewton), rounded(force[1], kPerNewton),
                       rounded(force[2], kPerNewton)};
    json["contacts"] = contacts;
    json["energy_J"] = rounded(arm.energy_J, kPerMetre);
  }
  if (arm.moves) {
    json["velocity_m_s"] = {rounded(arm.velocity_m_s[0], kPerOne), rounded(arm.velocity_m_s[1], kPerOne),
                            rounded(arm.velocity_m_s[2], kPerOne)};
  }
  json["planes"] = Json::array();
  if (now_us - arm.planes_us < kPlaneLife_us) {
    for (const link::ContactPlane& plane : arm.planes) {
      json["planes"].push_back(
          {{"normal",
            {rounded(static_cast<double>(plane.x), kPerOne), rounded(static_cast<double>(plane.y), kPerOne),
             rounded(static_cast<double>(plane.z), kPerOne)}}});
    }
  }
  json["inside"] = Json::array();
  for (const auto& [object, told_us] : arm.inside_us)
    if (now_us < told_us + kPlaneLife_us) json["inside"].push_back(object);
  return json;
}

Json LiveState::json(link::Micros now_us) const {
  Json json = Json::object();
  if (status_) {
    json["mode"] = link::name(status_->mode);
    if (stopped_by_ != link::StoppedBy::kNothing) {
      json["stopped_by"] = link::name(stopped_by_);
      json["stopped_by_text"] = description(stopped_by_);
    }
    json["fault"] = status_->fault;
    const firmware::FaultRow* row = firmware::find_fault(static_cast<firmware::Fault>(status_->fault));
    json["fault_name"] = row == nullptr ? "" : row->name;
    json["limiters"] = flag_names<link::Limiter>(status_->limiters | limiters_);
    if (put_off_) json["put_off"] = {{"object", put_off_->object}, {"ticks", put_off_->ticks}};
    json["tick_rate_Hz"] = status_->tick_rate_Hz;
    json["worst_tick_s"] = rounded(static_cast<double>(status_->worst_tick_s), 1e8);
  }
  json["arms"] = Json::array();
  for (std::size_t i = 0; i < arms_ && i < arm_.size(); ++i)
    json["arms"].push_back(arm_.at(i).pose ? arm_json(arm_.at(i), now_us) : Json());
  json["bodies"] = Json::array();
  for (const auto& [object, body] : bodies_) {
    json["bodies"].push_back({{"object", object},
                              {"position_m", vector_json(body.position, kPerMetre)},
                              {"rotation", rotation_json(body.rotation)}});
  }
  json["controls"] = Json::array();
  for (const auto& [object, control] : controls_) {
    json["controls"].push_back(
        {{"object", object}, {"q", rounded(static_cast<double>(control.q), kPerMetre)}, {"on", control.on}});
  }
  const auto at = [](const auto& m) {
    return Json{rounded(static_cast<double>(m.x_m), kPerMetre),
                rounded(static_cast<double>(m.y_m), kPerMetre)};
  };
  json["tissues"] = Json::array();
  for (const auto& [key, tissue] : tissues_) {
    json["tissues"].push_back({{"object", key.first},
                               {"arm", key.second},
                               {"pressed", tissue.pressed},
                               {"at_m", at(tissue)},
                               {"depth_m", rounded(static_cast<double>(tissue.depth_m), kPerMetre)}});
  }
  json["needles"] = Json::array();
  for (const auto& [key, needle] : needles_) {
    json["needles"].push_back({{"object", key.first},
                               {"arm", key.second},
                               {"inside", needle.inside},
                               {"at_m", at(needle)},
                               {"depth_m", rounded(static_cast<double>(needle.depth_m), kPerMetre)},
                               {"torn", needle.torn}});
  }
  return json;
}

}  // namespace thimble::host

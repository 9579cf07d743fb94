// The state of a device from its telemetry: merges all kinds of frames into the newest state. No I/O: frames and times in,
// JSON out. Used by the device's thread.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "firmware/link/messages.h"
#include "host-tools/client/stop.h"
#include "host-tools/viewer/protocol.h"

namespace thimble::host {

namespace link = firmware::link;

class LiveState {
 public:
  LiveState() = default;
  // axes: of each arm whose joint angles are of use; 0: of none.
  LiveState(std::uint8_t node, std::size_t arms, const std::array<std::size_t, 2>& axes = {})
      : node_(node), arms_(arms), axes_(axes) {}

  // True when the frame completes a record: tip, force and, where there are some, god object and joint angles of every arm. Frames may
  // be missing.
  bool take(const link::CanFrame& frame, link::Micros now_us);

  void take_state(
      const link::DeviceState& state);  // for before the first status frame, and for what no frame tells

  void forget_scene();  // forgets bodies and tissue of the previous scene
  void set_record_period(double seconds) { period_s_ = seconds; }  // between two records, for velocities

  [[nodiscard]] std::optional<std::uint8_t> take_emergency();  // the fault of an emergency frame that came
  [[nodiscard]] std::uint8_t sequence() const { return sequence_; }  // of the newest record
  // The last status said that the arm has stopped with a fault.
  [[nodiscard]] bool stopped() const { return status_ && has_stopped(*status_); }
  [[nodiscard]] link::Mode mode() const { return status_ ? status_->mode : link::Mode::kDisarmed; }

  // "mode" to "needles" of a state message. What has not come is left out; an arm of
  // which nothing has is null. energy_J: the work of the arm's force on the hand since the
  // contact began, from the telemetry's records; below zero, the hand has put it in.
  [[nodiscard]] Json json(link::Micros now_us) const;

  // Where an arm's axes were, and its tip, in one record: the newest one of which all angles came.
  struct Joints {
    std::vector<double> axes;
    std::array<double, 3> tip_m{};
  };
  [[nodiscard]] const std::optional<Joints>& joints(std::size_t arm) const { return arm_.at(arm).joints; }

 private:
  using Vector = std::array<double, 3>;
  struct Arm {
    std::optional<link::Pose> pose;
    link::Micros pose_us = 0;
    std::optional<link::Force> force;
    std::optional<link::GodObject> god;
    Vector velocity_m_s{};
    bool moves = false;  // two poses have come
    double energy_J = 0;
    bool begun = false;  // a contact, whose god object has not come
    std::vector<link::ContactPlane> planes;
    std::uint8_t planes_sequence = 0;
    link::Micros planes_us = 0;
    std::map<std::uint8_t, link::Micros> inside_us;   // by object: when it was told last
    std::optional<std::pair<Vector, Vector>> worked;  // tip and force of the record before
    std::vector<double> angles;                       // of the pose's record, as far as they have come
    std::optional<Joints> joints;                     // empty: the record before told no angles
    bool has_joints = false;                          // of the pose's record
  };
  struct Body {
    link::BodyPosition position;
    link::BodyRotation rotation;
  };

  void take_pose(const link::Pose& pose, link::Micros now_us);
  void take_force(const link::Force& force);
  void take_god(const link::GodObject& god);
  void take_plane(const link::ContactPlane& plane, link::Micros now_us);
  void take_angles(const link::JointAngles& angles);
  [[nodiscard]] bool complete() const;
  [[nodiscard]] Json arm_json(const Arm& arm, link::Micros now_us) const;

  std::uint8_t node_ = 1;
  std::size_t arms_ = 1;
  std::array<std::size_t, 2> axes_{};
  double period_s_ = 0.01;
  std::uint8_t sequence_ = 0;
  bool shown_ = true;  // the newest record has been reported
  std::array<Arm, 2> arm_;
  std::optional<link::Status> status_;
  link::StoppedBy stopped_by_ = link::StoppedBy::kNothing;  // while it is not armed
  std::optional<link::PutOff> put_off_;                     // since the last status without it
  std::optional<std::uint8_t> emergency_;
  std::uint8_t limiters_ = 0;                             // of the newest forces
  std::map<std::uint8_t, link::BodyPosition> positions_;  // whose rotation has not come
  std::map<std::uint8_t, Body> bodies_;                   // by object
  std::map<std::uint8_t, link::ControlElementState> controls_;
  std::map<std::pair<std::uint8_t, unsigned>, link::TissueState> tissues_;  // by object and arm
  std::map<std::pair<std::uint8_t, unsigned>, link::NeedleState> needles_;
};

}  // namespace thimble::host

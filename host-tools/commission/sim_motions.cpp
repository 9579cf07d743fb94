// The simulated board's closed loops: a servo of the axes, and forces at the tip.
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "host-tools/commission/expectation.h"
#include "host-tools/commission/sim_bench.h"
#include "host-tools/commission/wall_loop.h"
#include "kinematics/mechanism.h"

namespace thimble::host {
namespace {

using board::JointVector;

constexpr double kFilter_s = 2e-3;      // of the speed of an axis
constexpr double kSlowFilter_s = 1e-2;  // where a coarse count is not to look like a fast tip
constexpr double kHandled_s = 3, kHold_s = 1.5;

Eigen::Index row(std::size_t j) { return static_cast<Eigen::Index>(j); }

// Speed from counts: differences through a low pass, as short as the counts allow.
class Speeds {
 public:
  explicit Speeds(double tick_s, double filter_s = kFilter_s) : tick_s_(tick_s), filter_s_(filter_s) {}
  void add(const PerAxis<double>& angles, std::size_t axes) {
    for (std::size_t j = 0; j < axes; ++j) {
      if (begun_) {
        const double now = (angles.at(j) - last_.at(j)) / tick_s_;
        speed.at(j) += tick_s_ / (filter_s_ + tick_s_) * (now - speed.at(j));
      }
      last_.at(j) = angles.at(j);
    }
    begun_ = true;
  }
  PerAxis<double> speed{};

 private:
  double tick_s_, filter_s_;
  bool begun_ = false;
  PerAxis<double> last_{};
};

// ServoProgram's way: parts of the whole, of the time `at`.
struct Way {
  double part, speed;
};
Way way_at(double at) {
  constexpr double kTop = 1 / (1 - kServoRamp);
  if (at < kServoRamp) return {.5 * kTop / kServoRamp * at * at, kTop / kServoRamp * at};
  if (at > 1 - kServoRamp) {
    const double rest = 1 - at;
    return {1 - .5 * kTop / kServoRamp * rest * rest, kTop / kServoRamp * rest};
  }
  return {.5 * kTop * kServoRamp + kTop * (at - kServoRamp), kTop};
}

}  // namespace

BenchRecording SimBench::servo(const ServoProgram& program) {
  BenchRecording recording;
  plant_->set_max_step(motion_step_s_);
  const double tick_s = facts().tick_s;
  Speeds speeds(tick_s);
  const double all_s = program.move_s + program.stay_s;
  for (double t = 0; t < all_s; t += tick_s) {
    const Way along = way_at(program.move_s > 0 ? std::min(1.0, t / program.move_s) : 1.0);
    const PerAxis<double> angle = believed();
    speeds.add(angle, axes());
    PerAxis<double> asked{};
    for (std::size_t j = 0; j < axes(); ++j) {
      if (!given_.axes[j].drive) continue;
      const double way = program.to.at(j) - program.from.at(j);
      const double speed = program.move_s > 0 ? along.speed * way / program.move_s : 0;
      const double torque =
          program.stiffness_N_m_rad.at(j) * (program.from.at(j) + along.part * way - angle.at(j)) +
          program.damping_N_m_s_rad.at(j) * (speed - speeds.speed.at(j));
      const double most = program.most_torque_N_m.at(j);
      asked.at(j) = std::clamp(torque, -most, most) / given_.axes[j].per_ampere();
    }
    command(asked, true);
    advance(tick_s, false);
    record(recording, asked, t);
  }
  // It goes on holding until the next program.
  recording.driven_ticks = recording.ticks.size();
  return recording;
}

// Where the builder's hand is at the tip: about in a slow circle, or along the direction and back.
Eigen::Vector3d SimBench::hand_way(const Prompt& prompt, double time_s) const {
  constexpr double kWay_m = .02, kPeriod_s = 3;
  const double turn = 2 * 3.14159265358979 * time_s / kPeriod_s;
  if (prompt.kind == Prompt::Kind::kPush) return kWay_m * .5 * (1 - std::cos(turn)) * prompt.direction;
  return {kWay_m * std::sin(turn), kWay_m * .7 * std::sin(.8 * turn), kWay_m * .5 * std::sin(1.3 * turn)};
}

BenchRecording SimBench::feel(const TipProgram& program, const Prompt& prompt) {
  if (program.kind == TipProgram::Kind::kWall) return press_wall(program);
  BenchRecording recording;
  plant_->set_max_step(motion_step_s_);
  const double tick_s = facts().tick_s;
  const kinematics::Mechanism<double> mechanism(given_.geometry);
  kinematics::MechanismPose<double> pose = mechanism.home_pose();
  const auto axis_vector = [&](const PerAxis<double>& values) {
    JointVector v(row(axes()));
    for (std::size_t j = 0; j < axes(); ++j) v[row(j)] = values.at(j);
    return v;
  };
  Speeds speeds(tick_s), slow(tick_s, kSlowFilter_s);
  Eigen::Vector3d begin_m = Eigen::Vector3d::Zero();
  hold_tip();
  for (double t = 0; t < kHandled_s; t += tick_s) {
    move_tip(prompt, t, tick_s);
    const PerAxis<double> angle = believed();
    speeds.add(angle, axes());
    slow.add(angle, axes());
    PerAxis<double> asked{};
    if (mechanism.at(axis_vector(angle), pose)) {
      if (t == 0) begin_m = pose.force_point_m;
      const Eigen::Vector3d velocity = pose.force_jacobian * axis_vector(speeds.speed);
      Eigen::Vector3d force_N = -program.damping_N_s_m * velocity;
      if (program.kind == TipProgram::Kind::kSpring)
        force_N += program.stiffness_N_m * (begin_m - pose.force_point_m);
      if (force_N.norm() > program.most_force_N) force_N *= program.most_force_N / force_N.norm();
      const JointVector torque = mechanism.torques(pose, force_N);
      for (std::size_t j = 0; j < axes(); ++j)
        if (given_.axes[j].drive) asked.at(j) = torque[row(j)] / given_.axes[j].per_ampere();
      const Eigen::Vector3d slowly = pose.force_jacobian * axis_vector(slow.speed);
      if (program.most_speed_m_s > 0 && slowly.norm() > program.most_speed_m_s) {
        recording.ending = Ending::kSpeed;
        break;
      }
    }
    command(asked, true);
    advance(tick_s, false);
    record(recording, asked, t);
  }
  recording.driven_ticks = recording.ticks.size();
  command({}, false);
  let_tip_go();
  return recording;
}

void SimBench::hold_tip() {
  plant_->release_grip();
  plant_->set_hand({.05, 800, 8});
  hand_from_m_ = plant_->force_point_m();
}

void SimBench::move_tip(const Prompt& prompt, double time_s, double step_s) {
  const Eigen::Vector3d now = hand_way(prompt, time_s), next = hand_way(prompt, time_s + step_s);
  plant_->set_hand_target(hand_from_m_ + now, (next - now) / step_s);
}

void SimBench::let_tip_go() {
  plant_->set_hand(board::kNoHand);
  bring(plant_->joints_rad(), std::nullopt);
}

// A hand as in docs/stability.md meets the wall, presses it and holds.
void SimBench::approach_wall(double stiffness_N_m, double depth_m, const Eigen::Vector3d& normal,
                             double press_N) {
  constexpr double kApproach_m_s = .1;
  plant_->set_max_step(board::kPlantStep_s);
  plant_->release_grip();
  const board::Hand hand{};
  plant_->set_hand(hand);
  // At rest the wall, the arm's structure and the hand are three springs in a row.
  const double way_m =
      depth_m + press_N * (1 / stiffness_N_m + 1 / given_.tip_stiffness_N_m + 1 / hand.stiffness_N_m);
  press_way_m_ = -way_m * normal;
  press_travel_s_ = way_m / kApproach_m_s;
  hand_from_m_ = plant_->force_point_m();
}

// Whether it still goes on.
bool SimBench::press_on(double time_s) {
  const double part = std::min(1.0, time_s / press_travel_s_);
  plant_->set_hand_target(
      hand_from_m_ + part * press_way_m_,
      part < 1 ? Eigen::Vector3d(press_way_m_ / press_travel_s_) : Eigen::Vector3d::Zero());
  return time_s < press_travel_s_ + kHold_s;
}

BenchRecording SimBench::press_wall(const TipProgram& program) {
  BenchRecording recording;
  const double tick_s = facts().tick_s;
  const auto late = static_cast<std::size_t>(std::lround(options_.drive_delay_s / tick_s));
  const Expectation arm(given_);
  WallLoop loop(arm, program, tick_s);
  approach_wall(program.stiffness_N_m, program.wall_depth_m, program.wall_normal, press_N(program));
  for (double t = 0; press_on(t); t += tick_s) {
    const PerAxis<double> angle = believed();
    JointVector at(row(axes()));
    for (std::size_t j = 0; j < axes(); ++j) at[row(j)] = angle.at(j);
    const JointVector current = loop.currents(at, counts());
    PerAxis<double> asked{};
    for (std::size_t j = 0; j < axes(); ++j) asked.at(j) = current[row(j)];
    command(recording.ticks.size() < late ? PerAxis<double>{}
            : late == 0                   ? asked
                                          : recording.ticks[recording.ticks.size() - late].asked_A,
            true);
    advance(tick_s, false);
    record(recording, asked, t);
    if (loop.tip_speed_m_s() > program.most_speed_m_s) {
      recording.ending = Ending::kSpeed;
      break;
    }
  }
  recording.driven_ticks = recording.ticks.size();
  command({}, false);
  let_tip_go();
  return recording;
}

void SimBench::hands(const Prompt& prompt) {
  constexpr double kStep_s = 1e-3;
  // A list that grows is moved, which takes milliseconds while a board beside it waits for its encoders.
  constexpr std::size_t kMostTicks = 60'000;
  BenchRecording unseen;
  unseen.ticks.reserve(kMostTicks);
  plant_->set_max_step(hand_step_s_);
  switch (prompt.kind) {
    case Prompt::Kind::kTurn:
      turn(prompt, false, unseen);
      return;
    case Prompt::Kind::kPassHome:
      pass_home(prompt.times);
      return;
    case Prompt::Kind::kSwing:
      swing(prompt, false, unseen);
      return;
    case Prompt::Kind::kMoveAbout:
    case Prompt::Kind::kPush:
      hold_tip();
      for (double t = 0; t < kHandled_s; t += kStep_s) {
        move_tip(prompt, t, kStep_s);
        advance(kStep_s, false);
      }
      let_tip_go();
      return;
    case Prompt::Kind::kPressWall:
      // A person presses by feel; these hands know how far the wall and its softness are.
      approach_wall(prompt.wall_N_m, prompt.wall_m, -prompt.direction, prompt.press_N);
      for (double t = 0; press_on(t) && !over(); t += kStep_s) advance(kStep_s, false);
      if (!over()) let_tip_go();
      return;
    case Prompt::Kind::kOpenEStop:
    case Prompt::Kind::kReleaseDeadMan:
    case Prompt::Kind::kStopHost:
    case Prompt::Kind::kRest:
    case Prompt::Kind::kPlace:
    case Prompt::Kind::kHang:
    case Prompt::Kind::kLetGo:
    case Prompt::Kind::kRepair:
    case Prompt::Kind::kAcceptCorrection:
      return;
  }
}

}  // namespace thimble::host

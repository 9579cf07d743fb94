#include "tests/closed_loop/direct/linked_wall.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <deque>
#include <limits>
#include <stdexcept>

#include "board/sim/sim_board.h"
#include "firmware/link/iso_tp.h"
#include "firmware/link/messages.h"
#include "kinematics/dynamics.h"
#include "tests/support/scene.h"

namespace thimble::test {
namespace {

namespace link = firmware::link;
using link::CanFrame;

constexpr double kFloor_m = -.01;  // below the tip's home
constexpr double kTwoCounts_m = 59e-6;
constexpr std::uint8_t kNode = 1;

class DelayLine {
 public:
  explicit DelayLine(long ticks) : ticks_(ticks) {}
  void send(const CanFrame& frame, long tick) { frames_.push_back({frame, tick + ticks_}); }
  bool receive(CanFrame& frame, long tick) {
    if (frames_.empty() || frames_.front().due > tick) return false;
    frame = frames_.front().frame;
    frames_.pop_front();
    return true;
  }

 private:
  struct Waiting {
    CanFrame frame;
    long due;
  };
  long ticks_;
  std::deque<Waiting> frames_;
};

struct Swing {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  void add(double value) {
    low = std::min(low, value);
    high = std::max(high, value);
  }
};

void set(firmware::Controller& controller, const char* name, std::uint32_t bits) {
  if (controller.write_param(firmware::find_param(name)->id, bits) != firmware::ParamStatus::kOk)
    throw std::logic_error(name);
}

class Run {
 public:
  explicit Run(const LinkedWall& wall)
      : wall_(wall),
        board_({.variant = wall.arm,
                .rate_Hz = wall.rate_Hz,
                .hand = wall.hand,
                // No probes of the encoders: they would be taken for a limit cycle.
                .slot_bytes = 1U << 16U,
                .sensors = {.line_loss = true}}),
        to_host_(std::lround(wall.delay_s * wall.rate_Hz)),
        to_board_(std::lround(wall.delay_s * wall.rate_Hz)) {}

  LinkedWallResult operator()() {
    // At rest the wall, the arm's structure and the hand are three springs in a row.
    const kinematics::ArmData& model = board_.plant(0).parameters().model;
    const double target_m = kFloor_m - wall_.press_N / static_cast<double>(wall_.stiffness_N_m) -
                            wall_.press_N / static_cast<double>(model.tip_stiffness_N_m) -
                            wall_.press_N / wall_.hand.stiffness_N_m;
    const double travel_s = -target_m / wall_.approach_m_s;
    board_.follow(
        0, board::HandPath(
               {{0, {0, 0, 0}}, {travel_s, {0, 0, target_m}}, {travel_s + wall_.hold_s, {0, 0, target_m}}}));
    firmware::Controller& controller = board_.controller();
    set(controller, "telemetry_decimation", wall_.ticks_a_pose);
    if (wall_.on_host) {
      set(controller, "host_forces", 1);
    } else {
      SceneBuilder scene;
      scene.plane({0, 0, 1}, kFloor_m, {.stiffness_N_m = wall_.stiffness_N_m});
      if (controller.load_scene(scene.bytes()) != firmware::StoreStatus::kOk)
        throw std::logic_error("the wall was refused");
    }
    const long settled = std::lround((wall_.delay_s + .2) * wall_.rate_Hz);
    until([&] { return tick_ > settled; });
    if (controller.request(firmware::Command::kHome) != 0) throw std::runtime_error("homing was refused");
    until([&] { return controller.mode() == firmware::Mode::kReady && board_.hand_waits(0); });
    if (controller.request(firmware::Command::kArm) != 0) throw std::runtime_error("arming was refused");
    until([&] { return board_.hand_follows(0); });

    const auto begin = tick_;
    const auto at = [&](double share) {
      return begin + std::lround((travel_s + share * wall_.hold_s) * wall_.rate_Hz);
    };
    const long first = at(.3), half = at(.5), last = at(.8), end = at(1);
    Swing all, early, late;
    double sum_N = 0;
    std::uint32_t orders_at_half = 0;
    LinkedWallResult result;
    while (tick_ < end) {
      step();
      if (controller.fault() != firmware::Fault::kNone) {
        result.faulted = true;
        return result;
      }
      if (tick_ == half) orders_at_half = orders_;
      const double height_m = board_.sampled_tip_m(0).z();
      if (tick_ > first && tick_ <= half) early.add(height_m);
      if (tick_ > last) late.add(height_m);
      if (tick_ <= half) continue;
      all.add(height_m);
      sum_N += static_cast<double>(controller.telemetry().arm[0].force_N.z());
    }
    result.mean_force_N = sum_N / static_cast<double>(end - half);
    result.tip_swing_m = all.high - all.low;
    result.first_swing_m = early.high - early.low;
    result.last_swing_m = late.high - late.low;
    result.orders = orders_;
    result.orders_per_s = (orders_ - orders_at_half) / (wall_.hold_s / 2);
    result.expired = missed_;
    result.wall_ticks = controller.telemetry().contact_ticks;
    return result;
  }

 private:
  template <class Condition>
  void until(Condition&& condition) {
    constexpr double kLongest_s = 30;
    for (long left = std::lround(kLongest_s * wall_.rate_Hz); !condition(); --left) {
      if (left == 0 || board_.controller().fault() != firmware::Fault::kNone)
        throw std::runtime_error("the arm was not armed");
      step();
    }
  }

  void step() {
    firmware::Controller& controller = board_.controller();
    const auto now = static_cast<link::Micros>(std::llround(board_.time_s() * 1e6));
    CanFrame frame;
    while (to_board_.receive(frame, tick_)) controller.on_frame(frame, now);
    board_.tick();
    controller.poll(now);
    while (controller.next_frame(frame, now)) to_host_.send(frame, tick_);
    const bool damped = wall_.on_host && controller.mode() == firmware::Mode::kArmed && felt_once_ &&
                        controller.telemetry().arm[0].rendered_N.z() < 0;
    missed_ += damped ? 1 : 0;
    while (to_host_.receive(frame, tick_)) host(frame);
    if (tick_ % std::lround(.1 * wall_.rate_Hz) == 0) {  // a sign of life: tester-present, no answer wanted
      CanFrame alive;
      alive.id = link::request_id(kNode);
      alive.extended = true;
      alive.size = 8;
      alive.data[0] = 2;
      alive.data[1] = static_cast<std::uint8_t>(link::Service::kTesterPresent);
      alive.data[2] = link::kSuppressPositive;
      to_board_.send(alive, tick_ + 1);
    }
    ++tick_;
  }

  // The host's whole renderer.
  void host(const CanFrame& frame) {
    link::Pose pose;
    if (!wall_.on_host || !link::from_frame(frame, kNode, pose)) return;
    const double depth_m = kFloor_m - static_cast<double>(pose.z_m);
    link::ForceOrder order;
    order.z_N = depth_m > 0 ? static_cast<float>(depth_m) * wall_.stiffness_N_m : 0.0F;
    order.sequence = ++sequence_;
    to_board_.send(link::to_frame(order, kNode),
                   tick_ + 1);  // what leaves after a tick is there before the next
    ++orders_;
    felt_once_ = felt_once_ || order.z_N > 0;
  }

  const LinkedWall& wall_;
  board::SimBoard board_;
  DelayLine to_host_, to_board_;
  long tick_ = 0;
  std::uint8_t sequence_ = 0;
  std::uint32_t orders_ = 0, missed_ = 0;
  bool felt_once_ = false;
};

}  // namespace

LinkedWallResult press(const LinkedWall& wall) { return Run(wall)(); }

bool still(const LinkedWall& wall) {
  const LinkedWallResult result = press(wall);
  return !result.faulted && result.tip_swing_m <= kTwoCounts_m;
}

bool dies_down(const LinkedWall& wall) {
  const LinkedWallResult result = press(wall);
  // One that grew until the motors gave no more stays as it is, to a hundredth.
  constexpr double kSame = .98;
  return !result.faulted &&
         (result.last_swing_m <= kTwoCounts_m || result.last_swing_m < kSame * result.first_swing_m);
}

double moved_mass_kg(const std::string& arm, const board::Hand& hand) {
  const board::PlantParameters parameters = board::PlantParameters::from(*board::find_plant_variant(arm));
  const kinematics::TwoLinkArm<double> model(parameters.model, parameters.base);
  const kinematics::TwoLinkPosture<double> posture = model.at(model.home());
  Eigen::Matrix3d inertia = kinematics::mass_matrix(parameters.model.inertia, posture);
  for (int j = 0; j < 3; ++j)
    inertia(j, j) +=
        static_cast<double>(parameters.model.axis[static_cast<std::size_t>(j)].reflected_rotor_inertia());
  const Eigen::Matrix3d mobility = posture.jacobian * inertia.inverse() * posture.jacobian.transpose();
  return hand.mass_kg + 1 / mobility(2, 2);
}

}  // namespace thimble::test

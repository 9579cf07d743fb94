#include "tests/closed_loop/faults/fault_trial.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "board/sim/broken_link.h"
#include "firmware/link/host_address.h"
#include "firmware/link/services.h"
#include "tests/support/scene.h"

namespace thimble::test {
namespace {

using board::Injection;
using board::PlannedFault;
using board::SimBoard;
using board::Vector3d;
using firmware::Command;
using firmware::Mode;

constexpr double kWall_m = -.01;  // below home, along the normal
constexpr double kApproach_m_s = .1;
constexpr double kSettles_s = .35;  // after the approach
constexpr double kAtRest_m_s = .05;
constexpr double kLinkPeriod_s = 1e-3, kSignOfLife_s = .02;
constexpr double kNamed_s = .01;  // after which a fault has its name, though the drives' watchdog was faster
constexpr double kGone_s = .05;   // a killed process, until it starts again

double press_N(const Trial& trial, const kinematics::ArmData& model) {
  constexpr double kMaxForce_N = 8;  // default of the parameter
  return trial.force_N > 0 ? trial.force_N
                           : .8 * std::min(static_cast<double>(model.max_force_N), kMaxForce_N);
}

bool at_rest(const Sample& sample) { return !sample.driven && sample.velocity_m_s.norm() < kAtRest_m_s; }

// From the nearest point of a segment to a point.
Vector3d beyond(const Vector3d& p, const Vector3d& a, const Vector3d& b) {
  const Vector3d line = b - a;
  const double length2 = line.squaredNorm();
  const double along = length2 > 0 ? std::clamp((p - a).dot(line) / length2, 0.0, 1.0) : 0.0;
  return p - a - along * line;
}

class Run {
 public:
  explicit Run(const Trial& trial) : trial_(trial), board_(options(trial)) {
    SceneBuilder scene;
    const bool wall = trial.doing == Doing::kContact;
    scene.plane(wall ? trial.normal.normalized() : Vector3d(0, 0, 1), wall ? kWall_m : -1.0,
                {.stiffness_N_m = trial.stiffness_N_m,
                 .damping_N_s_m = 1,
                 .static_friction = trial.friction,
                 .dynamic_friction = trial.friction});
    require(board_.controller().load_scene(scene.bytes()) == firmware::StoreStatus::kOk, "load the scene");
    for (std::size_t arm = 0; arm < trial.arms; ++arm) home_m_.push_back(board_.plant(arm).tip_m());
    if (trial.doing == Doing::kMove) write(firmware::Param::allow_moves, 1);
    if (trial.supervised) {
      write(firmware::Param::link_timeout, std::bit_cast<std::uint32_t>(.1F));
      write(firmware::Param::host_supervision, 1);
    }
    for (const auto& [param, bits] : trial.params) write(param, bits);
    ticks(2);
    if (trial.doing == Doing::kHoming) board_.inject({.kind = Injection::kIndexMissing});
    if (trial.doing == Doing::kHoming) ticks(1);
    require(board_.controller().request(Command::kHome) == 0, "home");
    ticks(seconds(.05));
    if (trial.doing == Doing::kHoming) return;
    require(board_.controller().request(Command::kArm) == 0, "arm");
    ticks(seconds(.3));
    if (trial.doing == Doing::kMove) {
      firmware::MoveOrder order;
      order.target_m = {0, 0, -.03F};
      order.speed_m_s = .03F;
      order.force_limit_N = 2;
      require(board_.controller().request_move(order) == 0, "move");
      ticks(seconds(.3));
    } else {
      const double until_s = move_s() + kSettles_s + trial.phase_s;
      for (begin_s_ = board_.time_s(); board_.time_s() - begin_s_ < until_s;) tick();
    }
    require(board_.controller().mode() == Mode::kArmed,
            ("stay armed, fault " + std::to_string(static_cast<int>(board_.controller().fault()))).c_str());
  }

  // The faults, from now on. to_rest: little longer than until all have begun, the drives are off and the tip is slow.
  std::vector<Sample> watch(const std::vector<PlannedFault>& faults, bool to_rest) {
    double begun_s = board_.time_s();
    for (PlannedFault fault : faults) {
      fault.at_s += board_.time_s();
      begun_s = std::max(begun_s, fault.at_s);
      if (fault.kind == Injection::kProcessKilled) {
        begun_s = std::max(begun_s, fault.at_s + kGone_s);
        restarts_s_.push_back(fault.at_s + kGone_s);
        fault.kind = Injection::kTickHung;
        fault.for_s = kGone_s;
      }
      board_.inject(fault);
    }
    std::vector<Sample> samples;
    lifts_from_s_ = board_.time_s();
    bool rests = false;
    int after = 0;
    for (int i = 0; i < seconds(trial_.watch_s); ++i) {
      tick();
      samples.push_back({board_.plant(0).tip_m(), board_.plant(0).tip_velocity_m_s(),
                         board_.plant(0).hand_force_N(), board_.driven(0),
                         board_.controller().mode() == Mode::kArmed, board_.controller().fault(),
                         board_.controller().telemetry().arm[0].counts});
      rests = rests || at_rest(samples.back());
      if (to_rest && rests && board_.time_s() > begun_s && ++after > seconds(kNamed_s)) break;
    }
    return samples;
  }

  [[nodiscard]] std::uint32_t probes() { return board_.controller().telemetry().probes; }
  [[nodiscard]] std::array<double, 3> share_N() {
    const board::PlantParameters& parameters = board_.plant(0).parameters();
    const kinematics::TwoLinkPosture<double> posture =
        kinematics::TwoLinkArm<double>(parameters.model, parameters.base).at(board_.plant(0).joints_rad());
    const Vector3d force_N = board_.controller().telemetry().arm[0].force_N.cast<double>();
    std::array<double, 3> share_N{};
    for (int j = 0; j < 3; ++j)
      share_N[static_cast<std::size_t>(j)] = std::abs(posture.jacobian.col(j).normalized().dot(force_N));
    return share_N;
  }

 private:
  static board::SimBoardOptions options(const Trial& trial) {
    board::SimBoardOptions options{.variant = trial.variant, .rate_Hz = trial.rate_Hz};
    options.arm_count = trial.arms;
    options.hand = trial.doing == Doing::kMove ? board::kNoHand : trial.holds;
    options.sensors = trial.sensors;
    if (trial.doing == Doing::kHoming) options.sensors.index = true;
    options.slot_bytes = 1 << 16;
    return options;
  }
  static void require(bool done, const char* what) {
    if (!done) throw std::runtime_error(std::string("the arm did not ") + what);
  }
  void write(firmware::Param param, std::uint32_t bits) {
    require(board_.controller().write_param(firmware::row_of(param).id, bits) == firmware::ParamStatus::kOk,
            "take a parameter");
  }
  [[nodiscard]] int seconds(double s) const { return static_cast<int>(std::lround(s * trial_.rate_Hz)); }
  void ticks(int count) {
    for (int i = 0; i < count; ++i) tick();
  }

  // How far below home the hand wants to be when it presses.
  [[nodiscard]] double depth_m() {
    const kinematics::ArmData& model = board_.plant(0).parameters().model;
    return -kWall_m + press_N(trial_, model) *
                          (1 / static_cast<double>(trial_.stiffness_N_m) +
                           1 / static_cast<double>(model.tip_stiffness_N_m) + 1 / trial_.holds.stiffness_N_m);
  }
  [[nodiscard]] double move_s() { return trial_.doing == Doing::kContact ? depth_m() / kApproach_m_s : 0; }

  // The background: the host and its link, and what the controller writes to its store.
  void talk() {
    if (board_.time_s() < talks_s_) return;
    talks_s_ = board_.time_s() + kLinkPeriod_s;
    namespace link = firmware::link;
    firmware::Controller& controller = board_.controller();
    const auto now_us = static_cast<link::Micros>(std::llround(board_.time_s() * 1e6));
    if (board_.time_s() >= sign_of_life_s_) {
      sign_of_life_s_ = board_.time_s() + kSignOfLife_s;
      link::CanFrame sign;
      sign.id = link::request_id(1);
      sign.extended = true;
      sign.size = 3;
      sign.data = {2, static_cast<std::uint8_t>(link::Service::kTesterPresent), link::kSuppressPositive};
      from_host_.send(sign, now_us, board_);
    }
    const link::CanFrame nobodys = link::to_frame(link::HostClaim{}, 127, 0);
    for (flood_ += board_.injected(Injection::kLinkFlood).value_or(0) * kLinkPeriod_s; flood_ >= 1; --flood_)
      from_host_.send(nobodys, now_us, board_);
    while (const auto frame = from_host_.receive(now_us)) controller.on_frame(*frame, now_us);
    controller.poll(now_us);
    for (link::CanFrame out; controller.next_frame(out, now_us);) to_host_.send(out, now_us, board_);
    while (to_host_.receive(now_us)) continue;
  }
  void tick() {
    if (std::erase_if(restarts_s_, [this](double at_s) { return board_.time_s() >= at_s; }) != 0)
      board_.restart("crash");
    const auto gone = [this](double at_s) { return board_.time_s() >= at_s - kGone_s; };
    if (!std::ranges::any_of(restarts_s_, gone)) talk();
    if (trial_.doing != Doing::kMove && begin_s_ >= 0 && !board_.injected(Injection::kHandHolds)) {
      const double t = board_.time_s() - begin_s_;
      for (std::size_t arm = 0; arm < trial_.arms; ++arm) hold(arm, t);
    }
    board_.tick();
  }
  void hold(std::size_t arm, double t) {
    using std::numbers::pi;
    Vector3d at_m = home_m_[arm], speed_m_s = Vector3d::Zero();
    if (trial_.doing == Doing::kContact) {
      const double lifted_m = lifts_from_s_ ? trial_.lifts_m_s * (board_.time_s() - *lifts_from_s_) : 0;
      const double way_m = std::min(depth_m(), kApproach_m_s * t) - lifted_m;
      at_m -= way_m * trial_.normal.normalized();
    } else if (trial_.doing == Doing::kFree) {
      const Vector3d swing_m(.02, .015, .02), rate_rad_s(5, 7, 6);
      at_m += swing_m.cwiseProduct((rate_rad_s * t).array().sin().matrix());
      speed_m_s = swing_m.cwiseProduct(rate_rad_s).cwiseProduct((rate_rad_s * t).array().cos().matrix());
    }
    at_m += trial_.tremor_m *
            Vector3d(std::sin(2 * pi * 9 * t), std::sin(2 * pi * 11 * t + 1), std::sin(2 * pi * 9.7 * t + 2));
    board_.hold(arm, at_m, speed_m_s);
  }

  const Trial& trial_;
  SimBoard board_;
  std::vector<Vector3d> home_m_;
  board::BrokenLink from_host_, to_host_;
  double talks_s_ = 0, sign_of_life_s_ = 0, flood_ = 0;
  std::vector<double> restarts_s_;
  double begin_s_ = -1;
  std::optional<double> lifts_from_s_;
};

std::vector<Sample> watch(const Trial& trial, std::vector<PlannedFault> faults) {
  faults.insert(faults.end(), trial.hand.begin(), trial.hand.end());
  return Run(trial).watch(faults, false);
}

struct Watched {
  Verdict verdict;  // of this run alone
  std::vector<Sample> samples;
};

Watched watch_faulty(const Trial& trial) {
  Watched watched;
  Run run(trial);
  std::vector<PlannedFault> faults = trial.faults;
  faults.insert(faults.end(), trial.hand.begin(), trial.hand.end());
  Verdict& verdict = watched.verdict;
  verdict.share_N = run.share_N();
  const std::uint32_t probes_before = run.probes();
  watched.samples = run.watch(faults, true);
  verdict.probes = run.probes() - probes_before;
  for (std::size_t i = 0; i < watched.samples.size(); ++i) {
    const Sample& now = watched.samples[i];
    for (std::size_t j = 0; j < 3 && i > 0 && !verdict.found_s; ++j)
      if (now.counts[j] != watched.samples[i - 1].counts[j])
        verdict.last_count_s[j] = static_cast<double>(i + 1) / trial.rate_Hz;
    if (verdict.found_s || now.fault == firmware::Fault::kNone) continue;
    verdict.found_s = static_cast<double>(i + 1) / trial.rate_Hz;
    verdict.fault = now.fault;
  }
  return watched;
}

}  // namespace

Verdict look(const Trial& trial) { return watch_faulty(trial).verdict; }

std::vector<Sample> sound_run(const Trial& trial) {
  // No probes in the sound arm: its force would be less for a moment, which is not a fault of the other arm.
  Trial sound = trial;
  sound.sensors.line_loss = true;
  return watch(sound, {});
}

References references(const Trial& trial) {
  std::vector<PlannedFault> power_off;
  for (std::size_t arm = 0; arm < trial.arms; ++arm)
    power_off.push_back({.kind = Injection::kDriveFault, .arm = arm});
  return {sound_run(trial), watch(trial, power_off)};
}

Verdict judge(const Trial& trial, const References& references) {
  auto [verdict, faulty] = watch_faulty(trial);
  const auto& [sound, off] = references;
  double fastest_m_s = 0, own_m_s = 0;
  Vector3d impulse_N_s = Vector3d::Zero();
  for (std::size_t i = 0; i < faulty.size(); ++i) {
    const Sample& now = faulty[i];
    verdict.travel_m = std::max(verdict.travel_m, beyond(now.tip_m, off[i].tip_m, sound[i].tip_m).norm());
    const Vector3d gone_N = sound[i].on_hand_N - now.on_hand_N;
    if (const double force_N = sound[i].on_hand_N.norm(); force_N > 0) {
      verdict.sag = std::max(verdict.sag, gone_N.dot(sound[i].on_hand_N) / (force_N * force_N));
      verdict.change = std::max(verdict.change, gone_N.norm() / force_N);
    }
    impulse_N_s += beyond(now.on_hand_N, off[i].on_hand_N, sound[i].on_hand_N) / trial.rate_Hz;
    verdict.impulse_N_s = std::max(verdict.impulse_N_s, impulse_N_s.norm());
    fastest_m_s = std::max(fastest_m_s, now.velocity_m_s.norm());
    own_m_s = std::max({own_m_s, off[i].velocity_m_s.norm(), sound[i].velocity_m_s.norm()});
    if (now.driven) continue;
    if (!verdict.off_s) verdict.off_s = static_cast<double>(i + 1) / trial.rate_Hz;
    if (!at_rest(now)) continue;
    verdict.armed_again = std::any_of(faulty.begin() + static_cast<std::ptrdiff_t>(i), faulty.end(),
                                      [](const Sample& later) { return later.driven && later.armed; });
    break;
  }
  verdict.speed_m_s = std::max(0.0, fastest_m_s - own_m_s);
  return verdict;
}

}  // namespace thimble::test

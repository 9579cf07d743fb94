#include "board/sim/sim_board.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <new>
#include <stdexcept>

namespace thimble::board {
namespace {

constexpr double kMinRate_Hz = 100.0, kMaxRate_Hz = 20000.0;
constexpr double kApproachSpeed_m_s = .1;
constexpr double kShortestApproach_s = .3;
constexpr float kTwoArmsApart_m = .2F;

const PlantVariant& variant_of(const SimBoardOptions& options) {
  const PlantVariant* variant = find_plant_variant(options.variant);
  if (variant == nullptr) throw std::invalid_argument("there is no simulated arm named " + options.variant);
  if (!(options.rate_Hz >= kMinRate_Hz && options.rate_Hz <= kMaxRate_Hz)) {
    throw std::invalid_argument("the tick rate is not within 100 Hz to 20 kHz");
  }
  if (options.arm_count < 1 || options.arm_count > control::kMaxArms) {
    throw std::invalid_argument("the number of arms is not 1 or 2");
  }
  return *variant;
}

}  // namespace

void MemoryStorage::Free::operator()(std::byte* memory) const noexcept { std::free(memory); }

MemoryStorage::MemoryStorage(std::size_t scene_slot_bytes)
    : slot_bytes_{scene_slot_bytes, scene_slot_bytes, kParamSlotBytes, kParamSlotBytes} {
  for (unsigned i = 0; i < kSlots; ++i) {
    slots_[i].reset(
        static_cast<std::byte*>(std::calloc(slot_bytes_[i], 1)));  // pages are allocated when written
    if (!slots_[i]) throw std::bad_alloc();
  }
}

std::span<const std::byte> MemoryStorage::slot(unsigned index) const noexcept {
  return {slots_[index].get(), slot_bytes_[index]};
}

bool MemoryStorage::erase(unsigned index, std::size_t bytes) noexcept {
  if (bytes > slot_bytes_[index]) return false;
  std::memset(slots_[index].get(), 0xFF, bytes);
  return true;
}

bool MemoryStorage::write(unsigned index, std::size_t offset, std::span<const std::byte> bytes) noexcept {
  if (offset > slot_bytes_[index] || bytes.size() > slot_bytes_[index] - offset) return false;
  std::copy(bytes.begin(), bytes.end(), slots_[index].get() + offset);
  return true;
}

SimBoard::SimBoard(const SimBoardOptions& options)
    : options_(options), no_hand_(options.hand.mass_kg <= 0 && options.hand.stiffness_N_m <= 0) {
  const PlantVariant& variant = variant_of(options_);
  firmware::Config config;
  config.period_s = static_cast<float>(1.0 / options_.rate_Hz);
  config.arm_count = options_.arm_count;
  config.node_id = options_.node_id;
  config.board = "sim";
  config.reset_reason = options_.reset_reason;
  config.bus_bits_per_s = options_.bus_bits_per_s;
  if (options_.storage == nullptr) own_storage_ = std::make_unique<MemoryStorage>(options_.slot_bytes);
  for (std::size_t i = 0; i < options_.arm_count; ++i) {
    kinematics::BasePose base;
    if (options_.base) {
      base = (*options_.base)[i];
    } else if (options_.arm_count == 2) {
      base.home_m.x() = i == 0 ? -kTwoArmsApart_m / 2 : kTwoArmsApart_m / 2;
    }
    PlantParameters parameters = PlantParameters::from(variant);
    parameters.base = base;
    parameters.seed = options_.seed + i;
    Plant plant(parameters, options_.hand);
    if (i == 0) plant.set_specimen(options_.specimen);
    const Vector3d home = plant.tip_m();
    arms_.push_back({.plant = plant,
                     .sampled_tip_m = home,
                     .path = {},
                     .from_m = home,
                     .at_m = home,
                     .velocity_m_s = Vector3d::Zero()});
    config.arm[i].model = parameters.model->name.data();
    config.arm[i].base = base;
  }
  controller_ = std::make_unique<firmware::Controller>(
      config, options_.storage != nullptr ? *options_.storage : *own_storage_);
}

void SimBoard::tick() {
  firmware::Inputs in;
  in.tick = ticks_;
  in.time_us = static_cast<std::uint64_t>(std::llround(time_s() * 1e6));
  in.last_tick_us = last_tick_us_;
  in.e_stop = e_stop_;
  in.dead_man = dead_man_;
  for (std::size_t i = 0; i < arms_.size(); ++i) {
    move_hand(arms_[i]);
    arms_[i].sampled_tip_m = arms_[i].plant.tip_m();
    in.arm[i].counts = arms_[i].plant.encoder_counts();
    in.arm[i].sample_tick = ticks_;
  }

  const auto begin =
      options_.time_ticks ? std::chrono::steady_clock::now() : std::chrono::steady_clock::time_point{};
  const firmware::Outputs out = controller_->tick(in);
  if (options_.time_ticks) {
    last_tick_us_ =
        std::chrono::duration<float, std::micro>(std::chrono::steady_clock::now() - begin).count();
  }

  for (std::size_t i = 0; i < arms_.size(); ++i) {
    const firmware::ArmOutputs& drive = out.arm[i];
    arms_[i].plant.command_current(
        Eigen::Vector3f(drive.current_A[0], drive.current_A[1], drive.current_A[2]).cast<double>(),
        drive.enable);
    if (arms_[i].state == HandState::kCradle) continue;
    const bool driven = out.mode == firmware::Mode::kArmed || out.mode == firmware::Mode::kDamping;
    const Vector3d joints_rad = arms_[i].plant.joints_rad();
    arms_[i].plant.step(1.0 / options_.rate_Hz);
    if (no_hand_ && !driven) arms_[i].plant.place(joints_rad);
  }
  ++ticks_;
}

void SimBoard::step(double seconds) {
  for (owed_s_ += seconds; owed_s_ >= 1.0 / options_.rate_Hz; owed_s_ -= 1.0 / options_.rate_Hz) tick();
}

void SimBoard::follow(std::size_t arm, HandPath path, bool loop) {
  Arm& a = arms_[arm];
  a.path = std::move(path);
  a.loop = loop;
  if (a.state != HandState::kCradle) approach(a);
}

void SimBoard::hold(std::size_t arm, const Vector3d& position_m, const Vector3d& velocity_m_s) {
  Arm& a = arms_[arm];
  a.path.reset();
  a.at_m = position_m;
  a.velocity_m_s = velocity_m_s;
  if (a.state != HandState::kCradle) a.state = HandState::kHold;
  a.plant.set_hand_target(position_m, velocity_m_s);
}

Vector3d SimBoard::within_reach(std::size_t arm, const Vector3d& position_m) const {
  const PlantParameters& parameters = arms_[arm].plant.parameters();
  const kinematics::Arm<double> model(*parameters.model, parameters.base);
  constexpr double kMargin_rad = .03;  // distance to the joint limits
  const auto reached = [&](const Vector3d& p) {
    Vector3d joints;
    return model.inverse(p, joints) && kinematics::workspace_limit(*parameters.model, joints, kMargin_rad) ==
                                           kinematics::WorkspaceLimit::kNone;
  };
  if (reached(position_m)) return position_m;
  const Vector3d home = parameters.base.home_m.cast<double>();
  constexpr double kBeyond_m =
      2;  // beyond the reach of every arm; the bisection ends below a hundredth of a millimetre
  const Vector3d all = position_m - home;
  const Vector3d line = all * std::min(1.0, kBeyond_m / all.norm());
  double inside = 0, outside = 1;
  constexpr int kHalvings = 18;
  for (int i = 0; i < kHalvings; ++i) {
    const double middle = (inside + outside) / 2;
    (reached(home + middle * line) ? inside : outside) = middle;
  }
  return home + inside * line;
}

bool SimBoard::hand_waits(std::size_t arm) const noexcept { return arms_[arm].state == HandState::kWait; }

bool SimBoard::hand_follows(std::size_t arm) const noexcept { return arms_[arm].state == HandState::kFollow; }

void SimBoard::approach(Arm& arm) {
  arm.state = HandState::kApproach;
  arm.since_s = time_s();
  arm.from_m = arm.at_m;
  const double distance_m = (arm.path->at(arm.path->start_s()).position_m - arm.from_m).norm();
  arm.approach_s = std::max(kShortestApproach_s, distance_m / kApproachSpeed_m_s);
}

void SimBoard::move_hand(Arm& arm) {
  const firmware::Telemetry& telemetry = controller_->telemetry();
  const bool armed = telemetry.mode == firmware::Mode::kArmed;
  const bool rendered = armed && telemetry.ramp >= 1.0F;
  if (arm.state == HandState::kCradle) {
    if (telemetry.mode != firmware::Mode::kReady && !armed) return;
    arm.state = HandState::kHold;
    if (arm.path) approach(arm);
  }
  if (arm.state == HandState::kHold) return;

  if (arm.state == HandState::kFollow &&
      (!armed || (arm.loop && time_s() - arm.since_s > arm.path->end_s() - arm.path->start_s()))) {
    approach(arm);
  }
  const HandPath::Sample first = arm.path->at(arm.path->start_s());
  if (arm.state == HandState::kApproach && time_s() - arm.since_s >= arm.approach_s)
    arm.state = HandState::kWait;
  if (arm.state == HandState::kWait && rendered) {
    arm.state = HandState::kFollow;
    arm.since_s = time_s();
  }

  switch (arm.state) {
    case HandState::kCradle:
    case HandState::kHold:
      break;
    case HandState::kApproach: {  // minimum jerk: 10 u^3 - 15 u^4 + 6 u^5
      const double u = (time_s() - arm.since_s) / arm.approach_s;
      const Vector3d line = first.position_m - arm.from_m;
      arm.at_m = arm.from_m + u * u * u * (10 - 15 * u + 6 * u * u) * line;
      arm.velocity_m_s = 30 * u * u * (1 - u) * (1 - u) / arm.approach_s * line;
      break;
    }
    case HandState::kWait:
      arm.at_m = first.position_m;
      arm.velocity_m_s.setZero();
      break;
    case HandState::kFollow: {
      const HandPath::Sample sample = arm.path->at(arm.path->start_s() + (time_s() - arm.since_s));
      arm.at_m = sample.position_m;
      arm.velocity_m_s = sample.velocity_m_s;
      break;
    }
  }
  arm.plant.set_hand_target(arm.at_m, arm.velocity_m_s);
}

}  // namespace thimble::board

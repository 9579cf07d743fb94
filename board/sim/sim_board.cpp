#include "board/sim/sim_board.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <new>
#include <stdexcept>

#include "firmware/core/stop_timeout.h"
#include "kinematics/built_in_arms.h"
#include "kinematics/workspace.h"

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

// The plant of one arm: in closed form for a two-link arm of which nothing else is known.
SimArm sim_arm(const kinematics::ArmData& data, const SimBoardOptions& options,
               const kinematics::BasePose& base, std::uint64_t seed) {
  const auto begin = [&](auto parameters) {
    parameters.base = base;
    parameters.seed = seed;
    parameters.max_step_s = options.plant_step_s;
    return parameters;
  };
  if (!options.truth && kinematics::is_two_link(data.geometry) && data.has_inertia) {
    const bool friction = options.arm || variant_of(options).friction;
    return {data, Plant(begin(PlantParameters::from(data, friction)), options.hand)};
  }
  if (!kinematics::Mechanism<float>(data.geometry).closes_at_home())
    throw std::invalid_argument("the links of the arm do not meet at home");
  return {data,
          AnyPlant(begin(options.truth ? *options.truth : AnyPlantParameters::from(data)), options.hand)};
}

}  // namespace

void MemoryStorage::Free::operator()(std::byte* memory) const noexcept { std::free(memory); }

MemoryStorage::MemoryStorage(std::size_t scene_slot_bytes) {
  for (unsigned i = 0; i < kSlots; ++i) {
    slot_bytes_[i] = slot_bytes(i, scene_slot_bytes);
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

// The store as the controller sees it: a torn one takes no more bytes than are left, and loses the rest.
class TearableStorage final : public firmware::Storage {
 public:
  explicit TearableStorage(firmware::Storage& storage) : storage_(storage) {}
  void tear(std::optional<double> bytes_left) { left_ = bytes_left; }

  [[nodiscard]] std::span<const std::byte> slot(unsigned index) const noexcept override {
    return storage_.slot(index);
  }
  [[nodiscard]] bool erase(unsigned index, std::size_t bytes) noexcept override {
    return storage_.erase(index, take(bytes)) || left_.has_value();
  }
  [[nodiscard]] bool write(unsigned index, std::size_t offset,
                           std::span<const std::byte> bytes) noexcept override {
    return storage_.write(index, offset, bytes.first(take(bytes.size()))) || left_.has_value();
  }

 private:
  std::size_t take(std::size_t bytes) {
    if (!left_) return bytes;
    const auto taken = static_cast<std::size_t>(std::min(*left_, static_cast<double>(bytes)));
    *left_ -= static_cast<double>(taken);
    return taken;
  }
  firmware::Storage& storage_;
  std::optional<double> left_;
};

constexpr std::uint8_t kAllJoints = 255;

// Faults that a host injects.
class InjectRoutine final : public firmware::BoardRoutine {
 public:
  explicit InjectRoutine(SimBoard& board) : board_(board) {}

  [[nodiscard]] bool start(std::span<const std::uint8_t> arguments) noexcept override {
    firmware::link::InjectedFault order;
    if (!firmware::link::decode(arguments, order) || order.fault >= injections().size()) return false;
    if (order.arm >= board_.options().arm_count || !(order.for_s >= 0)) return false;
    PlannedFault fault{.kind = static_cast<Injection>(order.fault),
                       .arm = order.arm,
                       .value = static_cast<double>(order.value)};
    if (order.joint != kAllJoints) {
      if (order.joint >= board_.arm(order.arm).axes()) return false;
      fault.joint = order.joint;
    }
    fault.force_N = Eigen::Vector3f(order.force_x_N, order.force_y_N, order.force_z_N).cast<double>();
    if (order.for_s > 0) fault.for_s = static_cast<double>(order.for_s);
    board_.inject(fault);
    return true;
  }

 private:
  SimBoard& board_;
};

SimBoard::SimBoard(const SimBoardOptions& options)
    : options_(options), no_hand_(options.hand.mass_kg <= 0 && options.hand.stiffness_N_m <= 0) {
  const PlantVariant& variant = variant_of(options_);
  const kinematics::ArmData data = options_.arm ? *options_.arm : kinematics::built_in_arm(variant.arm);
  if (options_.arm) config_.arms_known = std::span(&*options_.arm, 1);
  config_.period_s = static_cast<float>(1.0 / options_.rate_Hz);
  config_.arm_count = options_.arm_count;
  config_.node_id = options_.node_id;
  config_.board = "sim";
  config_.reset_reason = options_.reset_reason;
  config_.utc_s = options_.utc_s;
  config_.bus_bits_per_s = options_.bus_bits_per_s;
  if (options_.storage == nullptr) own_storage_ = std::make_unique<MemoryStorage>(options_.slot_bytes);
  for (std::size_t i = 0; i < options_.arm_count; ++i) {
    kinematics::BasePose base;
    if (options_.base) {
      base = (*options_.base)[i];
    } else if (options_.arm_count == 2) {
      base.home_m.x() = i == 0 ? -kTwoArmsApart_m / 2 : kTwoArmsApart_m / 2;
    }
    SimArm plant = sim_arm(data, options_, base, options_.seed + i);
    if (i == 0) plant.set_specimen(options_.specimen);
    const Vector3d home = plant.tip_m();
    arms_.push_back({.plant = plant,
                     .broken = {},
                     .sampled_tip_m = home,
                     .path = {},
                     .from_m = home,
                     .at_m = home,
                     .velocity_m_s = Vector3d::Zero()});
    config_.arm[i].model = options_.arm ? options_.arm->name.data() : variant.arm.data();
    config_.arm[i].base = base;
    config_.arm[i].has_index = options_.sensors.index;
    config_.arm[i].has_line_loss = options_.sensors.line_loss;
  }
  inject_ = std::make_unique<InjectRoutine>(*this);
  config_.inject = inject_.get();
  config_.board_data = &measured_;
  storage_ =
      std::make_unique<TearableStorage>(options_.storage != nullptr ? *options_.storage : *own_storage_);
  controller_ = std::make_unique<firmware::Controller>(config_, *storage_);
}

void SimBoard::restart(const char* reason) {
  config_.reset_reason = reason;
  controller_.reset();
  controller_ = std::make_unique<firmware::Controller>(config_, *storage_);
}

firmware::Outputs SimBoard::tick_controller() {
  in_.tick = ticks_;
  in_.time_us = static_cast<std::uint64_t>(std::llround(time_s() * 1e6));
  in_.last_tick_us = last_tick_us_;
  in_.e_stop = e_stop_ || injected(Injection::kEStop);
  in_.dead_man = dead_man_ && !injected(Injection::kDeadMan);
  for (std::size_t i = 0; i < arms_.size(); ++i) {
    arms_[i].sampled_tip_m = arms_[i].plant.tip_m();
    arms_[i].broken.sense(arms_[i].plant, options_.sensors, time_s(), in_.arm[i]);
    if (!arms_[i].broken.stale()) in_.arm[i].sample_tick = ticks_;
  }
  measured_.take(in_);
  const auto begin =
      options_.time_ticks ? std::chrono::steady_clock::now() : std::chrono::steady_clock::time_point{};
  const firmware::Outputs out = controller_->tick(in_);
  if (options_.time_ticks) {
    last_tick_us_ =
        std::chrono::duration<float, std::micro>(std::chrono::steady_clock::now() - begin).count();
  }
  return out;
}

void SimBoard::run_plants(double seconds) {
  // The drives' own watchdog: they are off when no tick has written them for this long.
  std::uint32_t lost_ticks = 0;
  (void)controller_->read_param(firmware::row_of(firmware::Param::lost_ticks).id, lost_ticks);
  // A simulated board may be slower than a real one.
  const double longest_s = (lost_ticks + 1) / options_.rate_Hz;
  const auto stop_us =
      firmware::stop_timeout_us(static_cast<std::uint32_t>(1e9 / options_.rate_Hz), lost_ticks);
  constexpr double kRounding_s = 1e-9;
  const bool watched = time_s() - written_at_s_ < (stop_us ? *stop_us * 1e-6 : longest_s) - kRounding_s;
  for (std::size_t i = 0; i < arms_.size(); ++i) {
    Arm& arm = arms_[i];
    firmware::ArmOutputs drive = out_.arm[i];
    drive.enable = drive.enable && watched;
    arm.driven = arm.broken.drive(drive, arm.plant);
    if (arm.state == HandState::kCradle) continue;
    arm.plant.step(seconds, no_hand_ && !arm.driven);
  }
}

void SimBoard::tick() {
  inject_due();
  for (Arm& arm : arms_) move_hand(arm);
  const double period_s = 1.0 / options_.rate_Hz;
  double late_s = 0;
  if (!tick_is_lost()) {
    const firmware::Outputs out = tick_controller();
    late_s = std::clamp(injected(Injection::kTickLate).value_or(0), 0.0, period_s);
    if (const std::optional<double> jitter_s = injected(Injection::kTickJitter))
      late_s = std::uniform_real_distribution(0.0, std::clamp(*jitter_s, 0.0, period_s))(random_);
    if (late_s > 0) run_plants(late_s);
    out_ = out;
    written_at_s_ = time_s();
    if (options_.each_tick) options_.each_tick(controller_->telemetry());
  }
  if (late_s < period_s) run_plants(period_s - late_s);
  ++ticks_;
}

SimBoard::~SimBoard() = default;

void SimBoard::inject(const PlannedFault& fault) { faults_.push_back({fault}); }

std::optional<double> SimBoard::injected(Injection kind) const {
  for (const Planned& planned : faults_)
    if (planned.broken && planned.fault.kind == kind) return planned.fault.value;
  return std::nullopt;
}

// Begins and ends what is due. A fault at the time 0 from the start begins at once, also if it is injected later.
void SimBoard::inject_due() {
  const firmware::Telemetry& telemetry = controller_->telemetry();
  if (!armed_at_s_ && telemetry.mode == firmware::Mode::kArmed) armed_at_s_ = time_s();
  if (!contact_at_s_ && telemetry.contact_ticks != 0) contact_at_s_ = time_s();
  for (Planned& planned : faults_) {
    const InjectionTime from = planned.fault.from;
    const std::optional<double> zero_s = from == InjectionTime::kStart   ? 0.0
                                         : from == InjectionTime::kArmed ? armed_at_s_
                                                                         : contact_at_s_;
    if (!zero_s || time_s() < *zero_s + planned.fault.at_s) continue;
    if (!planned.broken) {
      planned.broken = true;
      planned.until_s = time_s() + planned.fault.for_s;
      set_fault(planned.fault, true);
    } else if (time_s() >= planned.until_s) {
      planned.broken = false;
      set_fault(planned.fault, false);
      planned.over = true;
    }
  }
  std::erase_if(faults_, [](const Planned& planned) { return planned.over; });
}

void SimBoard::set_fault(const PlannedFault& fault, bool broken) {
  using enum Injection;
  if (fault.arm >= arms_.size()) return;
  Arm& arm = arms_[fault.arm];
  if (fault.kind == kHandLetsGo) arm.plant.set_hand(broken ? kNoHand : options_.hand);
  if (fault.kind == kHandHolds && broken) hold(fault.arm, arm.at_m);
  if (fault.kind == kHandPushes) arm.plant.push(broken ? fault.force_N : Vector3d::Zero());
  if (fault.kind == kStorageTorn) storage_->tear(broken ? std::optional(fault.value) : std::nullopt);
  if (fault.kind == kProcessStopped && broken) (void)std::raise(SIGSTOP);
  if (fault.kind == kProcessKilled && broken) (void)std::raise(SIGKILL);
  arm.broken.set(fault, broken, arm.plant);
}

bool SimBoard::tick_is_lost() {
  const double row = injected(Injection::kTickLost).value_or(0);
  const bool lost = injected(Injection::kTickHung) || static_cast<double>(lost_in_a_row_) < row;
  lost_in_a_row_ = lost ? lost_in_a_row_ + 1 : 0;
  return lost;
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

bool SimBoard::reaches(std::size_t arm, const Vector3d& position_m, double margin_rad) const {
  const kinematics::ArmData& data = arms_[arm].plant.data();
  const kinematics::Arm<double> model(data, config_.arm[arm].base);
  kinematics::PerAxis<double> axes = kinematics::PerAxis<double>::Zero();
  return model.inverse(position_m, axes) && kinematics::workspace_limit(data, axes, margin_rad) == 0;
}

Vector3d SimBoard::within_reach(std::size_t arm, const Vector3d& position_m) const {
  constexpr double kMargin_rad = .03;  // distance to the joint limits
  const auto reached = [&](const Vector3d& p) { return reaches(arm, p, kMargin_rad); };
  if (reached(position_m)) return position_m;
  const Vector3d home = config_.arm[arm].base.home_m.cast<double>();
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

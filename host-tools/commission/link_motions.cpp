// The motions of a bench over the link.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "firmware/core/faults.h"
#include "host-tools/commission/link_bench.h"
#include "host-tools/commission/sweeps.h"

namespace thimble::host {
namespace {

using link::Micros;

constexpr double kHandled_s = 55;  // the most that a person may take: an order ends after 60 s
constexpr Micros kHeld_us = 1'300'000, kLeft_us = 200'000;
constexpr double kWatch_s = 1e-3;  // between two ticks of what a person does

// A current that is told while the order runs can be compared with what was asked for only when that is constant.
bool is_constant(const link::AxisOrder& order) {
  return order.offset_N_m != 0 && order.slope_N_m_s == 0 && order.amplitude_N_m == 0;
}

float f(double value) { return static_cast<float>(value); }

Ending ending_of(link::AxisEnd end) {
  switch (end) {
    case link::AxisEnd::kNotYet:
    case link::AxisEnd::kTime:
      return Ending::kTime;
    case link::AxisEnd::kWay:
      return Ending::kCounts;
    case link::AxisEnd::kSpeed:
      return Ending::kSpeed;
    case link::AxisEnd::kEnergy:
      return Ending::kEnergy;
    case link::AxisEnd::kStopped:
      return Ending::kLine;
  }
  return Ending::kLine;
}

}  // namespace

link::AxisOrder LinkBench::order(const EndsAt& ends) const {
  link::AxisOrder order;
  order.arm = arm_;
  order.most_energy_J = f(ends.energy_J);
  for (std::size_t j = 0; j < axes(); ++j) {
    const double per_count = std::abs(given_->axes[j].per_count());
    order.most_way_rad.at(j) = f(ends.counts.at(j) * per_count);
    order.most_speed_rad_s.at(j) = f(ends.counts_s.at(j) * per_count);
  }
  return order;
}

// Until the order has ended, or is holding, or the person is done.
LinkBench::Motion LinkBench::drive(const link::AxisOrder& order, const Prompt* prompt) {
  measured_.clear();
  device_->start_axes(order);
  const bool measures = measures_current_ && is_constant(order);
  if (measures) read_currents();  // a pulse may be over before there is time for another one
  link::AxisState state = device_->axis_state();
  const auto goes_on = [&] {
    return state.phase == link::AxisPhase::kDriving || state.phase == link::AxisPhase::kCoasting;
  };
  Micros asked_us = now_us();
  const auto round = [&] {
    pump(now_us());
    if (now_us() - asked_us < kRound_us) return goes_on();
    asked_us = now_us();
    state = device_->axis_state();
    return goes_on();
  };
  if (prompt != nullptr) {
    static_cast<void>(person_.ask(*prompt, round));
  } else {
    while (goes_on()) {
      if (measures) {
        for (const Micros until_us = now_us() + kRound_us; now_us() < until_us; pump(now_us()))
          read_currents();
      } else {
        pump(now_us() + kRound_us);
      }
      person_.check();
      state = device_->axis_state();
    }
  }
  const bool done = goes_on();  // by the person
  if (done) {
    device_->end_move();
    state = device_->axis_state();
  }
  holds_ = state.phase == link::AxisPhase::kHolding;
  if (state.end == link::AxisEnd::kStopped && !done) check_fault();
  Motion motion;
  motion.begin = stream_->whole(state.begin_tick);
  motion.driven = state.driven_ticks;
  motion.coasting =
      holds_ || done ? 0 : static_cast<std::size_t>(static_cast<double>(order.coast_s) / tick_s_);
  motion.end = done ? link::AxisEnd::kTime : state.end;
  return motion;
}

void LinkBench::read_currents() {
  if (const std::optional<link::MeasuredCurrents> now = device_->measured_currents())
    measured_.push_back(*now);
}

firmware::Axes LinkBench::angles(std::uint64_t tick) const {
  firmware::Axes angle = firmware::Axes::Zero();
  for (std::size_t j = 0; j < axes(); ++j) {
    const ArmAxis& axis = given_->axes[j];
    const auto counts = static_cast<double>(stream_->at(tick).at(j) + from_home_.at(j));
    angle[static_cast<Eigen::Index>(j)] = f(axis.home.value + counts * axis.per_count());
  }
  return angle;
}

// The torques are what the device's own law gives for the same counts.
BenchRecording LinkBench::cut(const link::AxisOrder& order, const Motion& motion) {
  const std::size_t all = motion.driven + motion.coasting;
  wait_for_tick(motion.begin + all);
  const auto feed = [&](std::uint64_t tick) -> const firmware::Axes& {
    law_tick_ = tick + 1;
    return law_.tick(angles(tick), static_cast<int>(axes()), f(tick_s_));
  };
  if (law_.active())  // it held the place before
    while (law_tick_ < motion.begin) static_cast<void>(feed(law_tick_));
  law_.start(order, angles(motion.begin));
  BenchRecording recording;
  recording.ending = ending_of(motion.end);
  recording.driven_ticks = motion.driven;
  recording.ticks.reserve(all);
  auto measured = measured_.begin();
  PerAxis<double> newest_A{};
  newest_A.fill(kNotMeasured);
  for (std::size_t k = 0; k < all; ++k) {
    for (; measured != measured_.end() && stream_->whole(measured->tick) <= motion.begin + k; ++measured)
      for (std::size_t j = 0; j < axes(); ++j)
        newest_A.at(j) = static_cast<double>(measured->current_A.at(arm_ * link::kMaxJoints + j));
    BenchTick tick;
    tick.time_s = static_cast<double>(k + 1) * tick_s_;
    const firmware::Axes& torque = feed(motion.begin + k);
    tick.counts = stream_->at(motion.begin + k + 1);
    for (std::size_t j = 0; j < axes(); ++j) {
      const double per_ampere = given_->axes[j].per_ampere();
      if (k < motion.driven && per_ampere != 0)
        tick.asked_A.at(j) = static_cast<double>(torque[static_cast<Eigen::Index>(j)]) / per_ampere;
    }
    tick.current_A = newest_A;
    tick.voltage_V.fill(kNotMeasured);
    recording.ticks.push_back(tick);
  }
  return recording;
}

BenchRecording LinkBench::cut(std::uint64_t from, std::uint64_t to, double between_s) {
  check_fault();  // it ends the recording
  if (to > from) wait_for_tick(to - 1);
  // A lost tick ends a recording. What a person did then is not all there, and would look like a dead encoder.
  if (stream_->broken() || device_->recording_state().phase != link::RecordingPhase::kRunning) {
    check_fault();
    counts_missing();
  }
  const auto step = static_cast<std::uint64_t>(std::max(1L, std::lround(between_s / tick_s_)));
  BenchRecording recording;
  for (std::uint64_t tick = from; tick < to; tick += step) {
    BenchTick now;
    now.time_s = static_cast<double>(tick - from) * tick_s_;
    now.counts = stream_->at(tick);
    now.current_A.fill(kNotMeasured);
    now.voltage_V.fill(kNotMeasured);
    recording.ticks.push_back(now);
  }
  recording.driven_ticks = recording.ticks.size();
  return recording;
}

JointVector LinkBench::believed() const {
  JointVector at(static_cast<Eigen::Index>(axes()));
  for (std::size_t j = 0; j < axes(); ++j)
    at[static_cast<Eigen::Index>(j)] =
        at_zero_.at(j) +
        static_cast<double>((stream_ ? stream_->newest() : counts_).at(j)) * given_->axes[j].per_count();
  return at;
}

void LinkBench::take_motors() {
  let_go();
  begin_recording();
  arm_motors();
}

bool LinkBench::still_armed(std::uint64_t since) const {
  return std::ranges::none_of(stream_->events(), [&](const CountStream::Event& event) {
    return event.tick >= since && event.mode != link::Mode::kArmed;
  });
}

// A turn is read from the middle on, where no stop is near.
bool LinkBench::bring_to_middle(std::size_t axis) {
  const Expectation arm(*given_);
  const JointVector home = arm.home();
  const Expectation::Span span = arm.span(axis, home);
  Prompt prompt;
  prompt.kind = Prompt::Kind::kPlace;
  prompt.axis = axis;
  for (std::size_t j = 0; j < axes(); ++j) prompt.place.at(j) = home[static_cast<Eigen::Index>(j)];
  prompt.place.at(axis) = .5 * (span.lower + span.upper);
  prompt.text = fmt::format("Bring '{}' to the middle of its range{}, and hold it there.",
                            given_->axes[axis].name, axes() > 1 ? ", the other joints to home" : "");
  return person_.ask(prompt) != Answer::kStop;
}

BenchRecording LinkBench::watch(const Prompt& prompt, bool powered) {
  let_go();
  if (!powered) forget_place();
  if (prompt.kind == Prompt::Kind::kTurn && !bring_to_middle(prompt.axis)) return {};
  begin_recording();
  if (powered) arm_motors();
  const std::uint64_t from = stream_->end();
  static_cast<void>(person_.ask(prompt, [&] {
    pump(now_us());
    return !powered || still_armed(from);
  }));
  if (powered && !still_armed(from)) check_fault();
  BenchRecording recording = cut(from, stream_->end(), kWatch_s);
  for (const std::uint64_t tick : stream_->home_marks(from)) recording.at_home.push_back(stream_->at(tick));
  let_go();
  return recording;
}

BenchRecording LinkBench::wait(double seconds, bool powered) {
  let_go();
  begin_recording();
  if (powered) arm_motors();
  const std::uint64_t from = stream_->end();
  const auto ticks = static_cast<std::uint64_t>(std::lround(seconds / tick_s_));
  const Micros until_us = now_us() + static_cast<Micros>((seconds + 2) * 1e6);
  while (stream_->end() < from + ticks && now_us() < until_us && !(powered && !still_armed(from))) {
    pump(now_us() + kRound_us);
    person_.check();
  }
  if (powered && !still_armed(from)) check_fault();
  BenchRecording recording = cut(from, from + ticks, kWatch_s);
  let_go();
  return recording;
}

// Before a motion the motors are armed for a moment, in which a loose axis may fall. Once the servo is proved, it brings back the axes
// that no hand holds. A held joint that is pushed and does not count looks like one with a dead encoder.
void LinkBench::bring_back() {
  if (!is_strong_ || !place_) {
    take_motors();
    return;
  }
  constexpr double kBring_s = .5;
  JointVector to(static_cast<Eigen::Index>(axes()));
  for (std::size_t j = 0; j < axes(); ++j) to[static_cast<Eigen::Index>(j)] = place_->at(j);
  begin_recording();
  ServoProgram bring = servo_to(Expectation(*given_), believed(), to);
  bring.move_s = bring.stay_s = kBring_s;
  for (std::size_t j = 0; j < axes(); ++j)
    if (held_.at(j)) bring.stiffness_N_m_rad.at(j) = bring.damping_N_m_s_rad.at(j) = 0;
  static_cast<void>(servo(bring));
}

BenchRecording LinkBench::run(const AxisProgram& program) {
  let_go();
  bring_back();
  link::AxisOrder motion = order(program.ends);
  const ArmAxis& axis = given_->axes[program.axis];
  motion.axis = static_cast<std::uint8_t>(program.axis);
  motion.driven_s = f(program.seconds);
  motion.coast_s = f(program.coast_s);
  motion.offset_N_m = f(program.constant_A * axis.per_ampere());
  motion.slope_N_m_s = f(program.slope_A_s * axis.per_ampere());
  motion.amplitude_N_m = f(program.tone_A * axis.per_ampere());
  motion.frequency_Hz = f(program.tone_Hz);
  motion.most_torque_N_m.at(program.axis) = f(axis.peak_torque());
  const Motion made = drive(motion);
  BenchRecording recording = cut(motion, made);
  let_go();
  return recording;
}

BenchRecording LinkBench::servo(const ServoProgram& program) {
  if (!holds_) take_motors();
  link::AxisOrder motion = order({});
  motion.hold = true;
  motion.move_s = f(program.move_s);
  motion.driven_s = f(program.move_s + program.stay_s);
  for (std::size_t j = 0; j < axes(); ++j) {
    motion.to_rad.at(j) = f(program.to.at(j));
    motion.stiffness_N_m_rad.at(j) = f(program.stiffness_N_m_rad.at(j));
    motion.damping_N_m_s_rad.at(j) = f(program.damping_N_m_s_rad.at(j));
    motion.most_torque_N_m.at(j) = f(program.most_torque_N_m.at(j));
  }
  const Motion made = drive(motion);
  if (!holds_) {
    check_fault();
    throw Error(ExitCode::kRefused, "let-go", "the device let the arm go in the middle of a motion",
                "hold the dead-man switch, and repeat the step");
  }
  return cut(motion, made);
}

BenchRecording LinkBench::feel(const TipProgram& program, const Prompt& prompt) {
  switch (program.kind) {
    case TipProgram::Kind::kDamping:
      return damp(program, prompt);
    case TipProgram::Kind::kSpring:
      return spring(program, prompt);
    case TipProgram::Kind::kWall:
      return press(program, prompt);
  }
  return {};
}

// Each axis is damped as the tip is along its own way.
BenchRecording LinkBench::damp(const TipProgram& program, const Prompt& prompt) {
  take_motors();
  const board::ByJoint jacobian = Expectation(*given_).jacobian(believed());
  link::AxisOrder motion = order({});
  motion.driven_s = f(kHandled_s);
  for (std::size_t j = 0; j < axes(); ++j) {
    const double lever_m = jacobian.col(static_cast<Eigen::Index>(j)).norm();
    if (!given_->axes[j].drive || lever_m == 0) continue;
    motion.damping_N_m_s_rad.at(j) = f(program.damping_N_s_m * lever_m * lever_m);
    motion.most_torque_N_m.at(j) = f(program.most_force_N * lever_m);
    motion.most_speed_rad_s.at(j) = f(program.most_speed_m_s / lever_m);
  }
  const Motion made = drive(motion, &prompt);
  BenchRecording recording = cut(motion, made);
  let_go();
  return recording;
}

// Of a spring as soft as this the host can give the force.
BenchRecording LinkBench::spring(const TipProgram& program, const Prompt& prompt) {
  constexpr double kReadings_Hz = 500;
  let_go();
  begin_recording();
  device_->keep_alive();
  device_->take_over(kReadings_Hz);
  armed_ = true;
  const std::uint64_t from = stream_->end();
  std::optional<std::array<double, 3>> begin_m;
  static_cast<void>(person_.ask(prompt, [&] {
    const std::optional<TipReading> tip = device_->next_tip(now_us(), arm_);
    if (!tip) return true;
    if (!begin_m) begin_m = tip->position_m;
    Eigen::Vector3d force_N =
        program.stiffness_N_m * (Eigen::Map<const Eigen::Vector3d>(begin_m->data()) -
                                 Eigen::Map<const Eigen::Vector3d>(tip->position_m.data()));
    if (force_N.norm() > program.most_force_N) force_N *= program.most_force_N / force_N.norm();
    device_->order_force({force_N.x(), force_N.y(), force_N.z()}, arm_);
    return true;
  }));
  const std::uint64_t to = stream_->end();
  device_->hand_back();
  armed_ = false;
  BenchRecording recording = cut(from, to, tick_s_);
  end_recording();
  return recording;
}

std::array<double, 3> LinkBench::tip_m() {
  pose_.reset();
  for (const Micros until_us = now_us() + 1'000'000; !pose_ && now_us() < until_us;)
    pump(now_us() + kRound_us);
  if (!pose_)
    throw Error(ExitCode::kLinkLost, "no-telemetry", "the device does not say where the tip is",
                "check that its loop runs (`thimble info`)");
  return {static_cast<double>(pose_->x_m), static_cast<double>(pose_->y_m), static_cast<double>(pose_->z_m)};
}

// A plane of the device's own renderer.
BenchRecording LinkBench::press(const TipProgram& program, const Prompt& prompt) {
  let_go();
  const std::array<double, 3> at_m = tip_m();
  const Eigen::Vector3d& n = program.wall_normal;
  upload_scene(fmt::format(
      R"({{"thimble_scene": 1, "name": "commissioning", "objects": [{{"name": "wall",)"
      R"( "shape": {{"plane": {{"normal": [{:.6f}, {:.6f}, {:.6f}], "offset_m": {:.6f}}}}},)"
      R"( "material": {{"stiffness_N_m": {:.3f}, "damping_N_s_m": {:.4f}, "static_friction": 0, "dynamic_friction": 0}}}}]}})",
      n.x(), n.y(), n.z(), n.dot(Eigen::Map<const Eigen::Vector3d>(at_m.data())) - program.wall_depth_m,
      program.stiffness_N_m, program.damping_N_s_m));
  set("gravity_compensation", 1);
  set("max_force", program.most_force_N);
  set("max_tip_speed", program.most_speed_m_s);
  take_motors();
  const std::uint64_t from = stream_->end();
  std::uint64_t to = from;
  // It is over when the wall has been pressed for as long as step 10 looks at: afterwards the hand lets go. A tip that swings leaves the wall again
  // and again.
  Micros pressed_us = 0, since_us = 0;
  static_cast<void>(person_.ask(prompt, [&] {
    pump(now_us());
    if (force_N_ > .5 * press_N(program)) {
      if (now_us() - pressed_us > kLeft_us) since_us = now_us();
      pressed_us = now_us();
    }
    to = stream_->end();
    const bool held = pressed_us != 0 && now_us() - pressed_us < kLeft_us && now_us() - since_us > kHeld_us;
    return still_armed(from) && !held;
  }));
  BenchRecording recording;
  if (device_->state().fault == static_cast<std::uint8_t>(firmware::Fault::tip_speed)) {
    recording.ending = Ending::kSpeed;  // the fault has ended the device's recording
    armed_ = false;
    device_->clear_faults();
  } else {
    recording = cut(from, to, tick_s_);
  }
  let_go();
  check_fault();
  set("gravity_compensation", 0);
  set("max_force", max_force_N_);
  set("max_tip_speed", before_.at("max_tip_speed"));
  upload_scene(kFreeSpace);
  return recording;
}

}  // namespace thimble::host

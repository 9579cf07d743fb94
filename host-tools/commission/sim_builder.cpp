// The simulated builder: what the hands do that a prompt asks for, and the motions of the board.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "host-tools/commission/expectation.h"
#include "host-tools/commission/sim_bench.h"

namespace thimble::host {
namespace {

using board::JointVector;

constexpr double kHandTick_s = 1e-3;
constexpr double kHandSpeed = 1.5;  // rad/s

Eigen::Index at(std::size_t j) { return static_cast<Eigen::Index>(j); }

}  // namespace

void SimBench::grip(const JointVector& target, std::optional<std::size_t> loose, double share) {
  JointVector k = grip_k_, d = grip_d_;
  if (loose) {
    k[at(*loose)] *= share;
    d[at(*loose)] *= std::sqrt(share);
  }
  plant_->set_grip(target, JointVector::Zero(target.size()), k, d);
}

void SimBench::bring(const JointVector& place, std::optional<std::size_t> loose) {
  plant_->set_max_step(hand_step_s_);
  const JointVector from = plant_->joints_rad();
  const double far = (place - from).cwiseAbs().maxCoeff();
  const double seconds = std::max(.3, far / 2);
  for (double t = 0; t < seconds; t += kHandTick_s) {
    grip(from + std::min(1.0, 1.25 * t / seconds) * (place - from), std::nullopt, 1);
    advance(kHandTick_s, false);
  }
  // Weight bends the grip: the hands correct it until the arm is still. Where the axes carry more than at home they swing slowly, with less damping, and
  // hands that correct as fast as at home would make that swing grow.
  constexpr int kLeast_ms = 60, kMost_ms = 1500;
  constexpr double kCorrected = .03, kOfDamping = .2, kStill_rad_s = 2e-3, kNear_rad = 5e-4;
  const board::JointMatrix M = plant_->mass_matrix();
  JointVector corrected = JointVector::Constant(place.size(), kCorrected), unit = corrected;
  for (std::size_t j = 0; j < axes(); ++j) {
    const double inertia = M(at(j), at(j)) + (truth_.axis[j].driven ? truth_.axis[j].rotor_kg_m2 : 0);
    corrected[at(j)] = std::min(kCorrected, kOfDamping * kHandTick_s * grip_d_[at(j)] / inertia);
    unit[at(j)] = per_radian(original_.axes[j]);
  }
  JointVector target = place;
  for (int k = 0; k < kMost_ms; ++k) {
    if (k > kLeast_ms && (place - plant_->joints_rad()).cwiseAbs().maxCoeff() < kNear_rad &&
        plant_->joint_speeds_rad_s().cwiseQuotient(unit).cwiseAbs().maxCoeff() < kStill_rad_s)
      break;
    target += corrected.cwiseProduct(place - plant_->joints_rad());
    grip(target, std::nullopt, 1);
    advance(kHandTick_s, false);
  }
  held_ = target;
  grip(target, loose, 0);
  for (int k = 0; loose && k < 100; ++k) advance(kHandTick_s, false);
}

// Lowers the arm until it lies still.
void SimBench::settle() {
  constexpr int kMost_ms = 40000, kStill_ms = 500;
  constexpr double kStill = 1e-5;
  const JointVector zero = JointVector::Zero(plant_->axes());
  plant_->set_grip(plant_->joints_rad(), zero, zero, .02 * grip_d_);
  int still = 0;
  for (int k = 0; k < kMost_ms && still < 2 * kStill_ms; ++k) {
    advance(kHandTick_s, false);
    still = plant_->joint_speeds_rad_s().cwiseAbs().maxCoeff() < kStill ? still + 1 : 0;
    if (still == kStill_ms) plant_->release_grip();
  }
}

Answer SimBench::ask(const Prompt& prompt) {
  if (prompt.kind != Prompt::Kind::kLetGo) command({}, false);
  switch (prompt.kind) {
    case Prompt::Kind::kPlace: {
      JointVector place(plant_->axes());
      for (std::size_t j = 0; j < axes(); ++j)
        place[at(j)] = prompt.place.at(j) +
                       (j == prompt.axis ? 0 : per_radian(original_.axes[j]) * uniform(-.005, .005));
      bring(place, prompt.axis < axes() ? std::optional(prompt.axis) : std::nullopt);
      break;
    }
    case Prompt::Kind::kRest:
      plant_->set_max_step(hand_step_s_);
      settle();
      break;
    case Prompt::Kind::kHang:
      plant_->release_grip();
      plant_->set_hand({prompt.mass_kg, 0, 0});
      plant_->push({0, 0, -prompt.mass_kg * static_cast<double>(kinematics::kGravity_m_s2)});
      break;
    case Prompt::Kind::kLetGo:
      plant_->release_grip();
      break;
    case Prompt::Kind::kAcceptCorrection:
      return options_.accepts_corrections ? Answer::kDone : Answer::kNo;
    case Prompt::Kind::kOpenEStop:
    case Prompt::Kind::kReleaseDeadMan:
    case Prompt::Kind::kStopHost:
    case Prompt::Kind::kTurn:
    case Prompt::Kind::kPassHome:
    case Prompt::Kind::kSwing:
    case Prompt::Kind::kMoveAbout:
    case Prompt::Kind::kPush:
    case Prompt::Kind::kPressWall:
    case Prompt::Kind::kRepair:
      break;
  }
  return Answer::kDone;
}

LineTrial SimBench::try_line(Line line, const Prompt& /*prompt*/) {
  if (lines_ignored_) return {false, 0};
  const BenchFacts known = facts();
  return {true, line == Line::kWatchdog ? known.watchdog_s * uniform(.8, .99) : known.tick_s * uniform(0, 1)};
}

BenchRecording SimBench::wait(double seconds, bool powered) {
  BenchRecording recording;
  command({}, powered);
  plant_->set_max_step(hand_step_s_);
  for (double t = 0; t < seconds; t += 5 * kHandTick_s) {
    advance(5 * kHandTick_s, false);
    record(recording, {}, t);
  }
  command({}, false);
  return recording;
}

BenchRecording SimBench::watch(const Prompt& prompt, bool powered) {
  BenchRecording recording;
  command({}, false);
  plant_->set_max_step(hand_step_s_);
  if (prompt.kind == Prompt::Kind::kTurn) turn(prompt, powered, recording);
  if (prompt.kind == Prompt::Kind::kSwing) swing(prompt, powered, recording);
  command({}, false);
  return recording;
}

// To a place of the axis with the hand that turns it, the others held.
void SimBench::go(std::size_t axis, double to, double speed, bool powered, BenchRecording& recording) {
  const double from = plant_->joints_rad()[at(axis)];
  const double seconds = std::abs(to - from) / speed + .25;
  JointVector target = held_;
  for (double t = 0; t < seconds; t += kHandTick_s) {
    const double part = std::min(1.0, t / (seconds - .25));
    target[at(axis)] = from + part * (to - from);
    grip(target, axis, kTurnShare);
    const JointVector before = plant_->rotors_rad();
    command({}, powered);
    advance(kHandTick_s, false);
    find_marks(recording, before);
    record(recording, {}, recording.ticks.empty() ? 0 : recording.ticks.back().time_s + kHandTick_s);
  }
}

void SimBench::turn(const Prompt& prompt, bool powered, BenchRecording& recording) {
  const std::size_t axis = prompt.axis;
  const Expectation told(original_);
  JointVector place = told.home();
  for (std::size_t j = 0; j < axes(); ++j)
    place[at(j)] += per_radian(original_.axes[j]) * uniform(-.005, .005);
  const Expectation::Span span = told.span(axis, place);
  place[at(axis)] = .5 * (span.lower + span.upper);
  bring(place, std::nullopt);
  // The hand knows the joint and where the tip goes, not the signs of the file.
  double sign = prompt.sign;
  if (prompt.direction.norm() > 0) {
    plant_->set_max_step(hand_step_s_);
    sign = board::AnyPlant(truth_).force_jacobian().col(at(axis)).dot(prompt.direction) > 0 ? 1 : -1;
  }
  // Nobody slams an axis into its stop: it yields by so many counts at most.
  constexpr double kYields = 100;
  const board::AxisTruth& own = truth_.axis[axis];
  const double inertia = plant_->mass_matrix()(at(axis), at(axis)) + (own.driven ? own.rotor_kg_m2 : 0);
  const double speed =
      std::min(kHandSpeed * std::min(1.0, (span.upper - span.lower) / 2),
               kYields * std::abs(own.rad_per_count) * std::sqrt(own.stop_stiffness_N_m_rad / inertia));
  for (int k = 0; k < 2 * prompt.times; ++k) {
    const bool up = (k % 2 == 0) == (sign > 0);
    const double beyond = kBeyond * per_radian(original_.axes[axis]) * uniform(.99, 1.01);
    go(axis, up ? span.upper + beyond : span.lower - beyond, speed, powered, recording);
  }
}

void SimBench::swing(const Prompt& prompt, bool powered, BenchRecording& recording) {
  const double middle = plant_->joints_rad()[at(prompt.axis)];
  const double unit = per_radian(original_.axes[prompt.axis]);
  for (const double by : {.15, -.15, .15, -.15})
    go(prompt.axis, middle + unit * by, unit * kHandSpeed, powered, recording);
}

// Each time from another side.
void SimBench::pass_home(int times) {
  constexpr double kAway = .1;
  const JointVector mark = home_mark();
  for (int k = 0; k < times; ++k) {
    JointVector away = mark;
    for (std::size_t j = 0; j < axes(); ++j)
      away[at(j)] +=
          ((static_cast<std::size_t>(k) + j) % 2 == 0 ? 1 : -1) * kAway * per_radian(original_.axes[j]);
    bring(away, std::nullopt);
    bring(mark, std::nullopt);
  }
}

// The mark of a joint is at home, or whole turns of its encoder beside.
JointVector SimBench::home_mark() const {
  JointVector mark(plant_->axes());
  for (std::size_t j = 0; j < axes(); ++j) {
    const ArmAxis& axis = original_.axes[j];
    const double turn = (axis.is_prismatic ? 1 : 2 * std::numbers::pi) / axis.encoder.turns_per_turn.value;
    mark[at(j)] = axis.home.value + mark_turns_.at(j) * turn;
  }
  return mark;
}

bool SimBench::at_home_mark() const {
  constexpr double kHalfWidth = .003;  // rad
  const JointVector off = plant_->rotors_rad() - home_mark();
  for (std::size_t j = 0; j < axes(); ++j)
    if (std::abs(off[at(j)]) > kHalfWidth * per_radian(original_.axes[j])) return false;
  return true;
}

void SimBench::find_marks(BenchRecording& recording, const JointVector& before) {
  if (!options_.has_mark) return;
  const JointVector marks = home_mark();
  for (std::size_t j = 0; j < axes(); ++j) {
    const std::size_t joint = encoder_of_.at(j);
    const double mark = marks[at(joint)];
    const double a = before[at(joint)] - mark, b = plant_->rotors_rad()[at(joint)] - mark;
    if (a * b > 0 || a == b || dead_encoder_.at(joint) || dead_channel_.at(joint)) continue;
    const double rad_per_count = truth_.axis[joint].rad_per_count;
    recording.marks.push_back(
        {j, static_cast<std::int64_t>(std::floor(mark / rad_per_count + slipped_.at(joint))),
         (b > a) == (rad_per_count > 0)});
  }
}

BenchRecording SimBench::run(const AxisProgram& program) {
  BenchRecording recording;
  plant_->set_max_step(motion_step_s_);
  const double tick_s = facts().tick_s;
  const PerAxis<std::int64_t> start = counts();
  const auto window = static_cast<std::size_t>(std::lround(.005 / tick_s));
  const double per_ampere = given_.axes[program.axis].per_ampere(),
               per_count = given_.axes[program.axis].per_count();
  double energy_J = 0;
  const auto limit = [&]() -> std::optional<Ending> {
    const BenchTick& now = recording.ticks.back();
    for (std::size_t j = 0; j < axes(); ++j) {
      const auto moved = static_cast<double>(std::abs(now.counts.at(j) - start.at(j)));
      if (program.ends.counts.at(j) > 0 && moved > program.ends.counts.at(j)) return Ending::kCounts;
      const std::size_t n = recording.ticks.size();
      const std::int64_t past = n > window ? recording.ticks[n - 1 - window].counts.at(j) : start.at(j);
      const double speed =
          static_cast<double>(std::abs(now.counts.at(j) - past)) / (static_cast<double>(window) * tick_s);
      if (program.ends.counts_s.at(j) > 0 && speed > program.ends.counts_s.at(j)) return Ending::kSpeed;
    }
    if (program.ends.energy_J > 0 && energy_J > program.ends.energy_J) return Ending::kEnergy;
    return std::nullopt;
  };
  std::int64_t last = start.at(program.axis);
  const auto late = static_cast<std::size_t>(std::lround(options_.drive_delay_s / tick_s));
  const auto coast = static_cast<std::size_t>(std::lround(program.coast_s / tick_s));
  bool over = false;
  for (std::size_t k = 0; k < program.ticks(tick_s) + coast; ++k) {
    PerAxis<double> asked{};
    if (!over && k == program.ticks(tick_s)) {
      over = true;
      recording.driven_ticks = recording.ticks.size();
    }
    if (!over) asked.at(program.axis) = program.current_A(static_cast<double>(k) * tick_s);
    PerAxis<double> arriving{};
    arriving.at(program.axis) = k < late || recording.ticks.size() < late ? 0
                                : late == 0                               ? asked.at(program.axis)
                                            : recording.ticks[k - late].asked_A.at(program.axis);
    command(arriving, true);
    advance(tick_s, true);
    record(recording, asked, static_cast<double>(k + 1) * tick_s);
    const std::int64_t now = recording.ticks.back().counts.at(program.axis);
    energy_J += asked.at(program.axis) * per_ampere * static_cast<double>(now - last) * per_count;
    last = now;
    if (over) {
      if (recording.ticks.size() >= recording.driven_ticks + coast) break;
      continue;
    }
    if (const std::optional<Ending> ending = limit()) {
      over = true;
      recording.ending = *ending;
      recording.driven_ticks = recording.ticks.size();
    }
  }
  command({}, false);
  return recording;
}

}  // namespace thimble::host

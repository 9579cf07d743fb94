#include "host-tools/commission/sim_bench.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "host-tools/arms/arm_data.h"
#include "host-tools/commission/expectation.h"
#include "host-tools/error.h"

namespace thimble::host {
namespace {

using board::JointVector;
using std::numbers::pi;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kPolePairs = 7;   // of the motors, where one has a dead phase
constexpr double kSafeStep = 1;    // by the fastest rate: Runge-Kutta 4 is stable to 2.7
constexpr double kSlipPart = .02;  // of a turn of the encoder, at each reversal

Eigen::Index index(std::size_t j) { return static_cast<Eigen::Index>(j); }

}  // namespace

SimBench::SimBench(const ArmFile& arm, std::vector<SimFault> faults, const SimBenchOptions& options)
    : original_(arm), given_(arm), faults_(std::move(faults)), options_(options), random_(options.seed) {
  clean_ = board::AnyPlantParameters::from(arm_data(arm), arm.body_inertia_kg_m2);
  clean_.least_spread = kLoopStop;
  add_light_links();
  add_least_friction();
  const double s = options.spread;
  const auto about = [&](double part) { return 1 + s * uniform(-part, part); };
  const double weight = about(.05);
  for (std::size_t i = 0; i < clean_.body_kg_m2.size(); ++i) {
    clean_.body_kg_m2.at(i) *= weight;
    clean_.geometry.body.at(i).mass_kg *= static_cast<float>(weight);
  }
  for (float* number :
       {&clean_.two_link_inertia.m11, &clean_.two_link_inertia.m11_cos_2q2,
        &clean_.two_link_inertia.m11_cos_2q3, &clean_.two_link_inertia.m22, &clean_.two_link_inertia.m33,
        &clean_.two_link_inertia.m23, &clean_.two_link_inertia.g2, &clean_.two_link_inertia.g3})
    *number *= static_cast<float>(weight);
  for (board::AxisTruth& axis : clean_.axis) {
    axis.coulomb_N_m *= about(.15);
    axis.viscous_N_m_s_rad *= about(.15);
    axis.stiffness_N_m_rad *= about(.1);
    axis.motor.torque_constant_N_m_A *= static_cast<float>(about(.03));
    axis.motor.resistance_ohm *= static_cast<float>(about(.05));
    const double way = axis.upper - axis.lower, off = .003 * s * way * uniform(-1, 1);
    axis.lower -= off;
    axis.upper -= off * uniform(-1, 1);
  }
  build();
  use(arm);
  // The counters of the file's axes are 0 at the beginning, as a bench widens them.
  bring(plant_->joints_rad(), std::nullopt);
}

// The links of an arm of several axes of which no weight is known: beside what is guessed to be at the tip, each has a tenth of what that adds to its axis.
// A link without inertia would be held by stops and hands alone, in steps of microseconds.
void SimBench::add_light_links() {
  constexpr double kPart = .1;
  if (clean_.tip_mass_kg == 0 || axes() < 2) return;
  const board::AnyPlant plant(clean_);
  const JointVector at_axis = plant.mass_matrix().diagonal();
  for (std::size_t j = 0; j < axes(); ++j)
    if (clean_.axis[j].driven) clean_.axis[j].link_kg_m2 += kPart * at_axis[index(j)];
}

// Where the file tells none, two fifths of what may be asked of the motor before step 7. No axis is without: one that went on for ever would not be at
// rest when a pulse begins.
void SimBench::add_least_friction() {
  constexpr double kPart = .4;
  const Expectation told(original_);
  for (std::size_t j = 0; j < axes(); ++j)
    if (told.driven(j) && clean_.axis[j].coulomb_N_m == 0)
      clean_.axis[j].coulomb_N_m = kPart * gentle_current_A(told, j) * std::abs(told.axis(j).per_ampere());
}

double SimBench::uniform(double low, double high) {
  random_ += 0x9E3779B97F4A7C15U;  // splitmix64
  std::uint64_t z = random_;
  z = (z ^ (z >> 30U)) * 0xBF58476D1CE4E5B9U;
  z = (z ^ (z >> 27U)) * 0x94D049BB133111EBU;
  z ^= z >> 31U;
  return low + (high - low) * static_cast<double>(z >> 11U) * 0x1p-53;
}

void SimBench::build() {
  truth_ = clean_;
  truth_.max_step_s = kSimMotionStep_s;
  encoder_port_.clear();
  drive_port_.clear();
  for (const ArmAxis& axis : original_.axes) {
    encoder_port_.push_back(axis.encoder.port);
    drive_port_.push_back(axis.drive ? axis.drive->port : -1);
  }
  slipping_ = noise_ = mark_turns_ = {};
  dead_channel_ = dead_encoder_ = dead_phase_ = open_ = {};
  lines_ignored_ = false;
  for (const SimFault& fault : faults_) add_fault(fault);
  const std::unique_ptr<board::AnyPlant> before = std::move(plant_);
  plant_ = std::make_unique<board::AnyPlant>(truth_);
  if (before != nullptr) plant_->place_as(*before);
  grip_k_ = grip_d_ = JointVector::Zero(plant_->axes());
  const board::JointMatrix M = plant_->mass_matrix();
  for (std::size_t j = 0; j < axes(); ++j) {
    const double inertia = M(index(j), index(j)) + (truth_.axis[j].driven ? truth_.axis[j].rotor_kg_m2 : 0);
    grip_k_[index(j)] = std::min(200 / std::pow(per_radian(original_.axes[j]), 2), 9e4 * inertia);
    grip_d_[index(j)] = 1.4 * std::sqrt(grip_k_[index(j)] * inertia);
    plant_->set_open(j, open_.at(j));
  }
  harden_stops();
  const double longest_s = kSafeStep / fastest_rate();
  hand_step_s_ = std::min(kSimHandStep_s, longest_s);
  motion_step_s_ = std::min(kSimMotionStep_s, longest_s);
  use(given_);
}

// A hand that pulls into a stop does it more or less hard, by kHandSpread: of a fine encoder that is to be less than two counts.
void SimBench::harden_stops() {
  constexpr double kCounts = 2, kHandSpread = .02;
  bool changed = false;
  for (std::size_t j = 0; j < axes(); ++j) {
    board::AxisTruth& axis = truth_.axis[j];
    const double pull =
        kTurnShare * grip_k_[index(j)] * kBeyond * per_radian(original_.axes[j]) * kHandSpread;
    const double least = pull / (kCounts * std::abs(axis.rad_per_count));
    if (axis.stop_stiffness_N_m_rad >= least) continue;
    axis.stop_damping_N_m_s_rad *= std::sqrt(least / axis.stop_stiffness_N_m_rad);
    axis.stop_stiffness_N_m_rad = least;
    changed = true;
  }
  if (!changed) return;
  const std::unique_ptr<board::AnyPlant> softer = std::move(plant_);
  plant_ = std::make_unique<board::AnyPlant>(truth_);
  plant_->place_as(*softer);
  for (std::size_t j = 0; j < axes(); ++j) plant_->set_open(j, open_.at(j));
}

// At home and at the corners of the limits.
std::vector<board::JointMatrix> SimBench::mass_at_corners(const board::AnyPlantParameters& of) const {
  board::AnyPlant plant(of);
  std::vector<board::JointMatrix> all{plant.mass_matrix()};
  JointVector at = plant.joints_rad();
  for (std::size_t corner = 0; corner < std::size_t{1} << axes(); ++corner) {
    for (std::size_t j = 0; j < axes(); ++j)
      at[index(j)] = ((corner >> j) & 1U) == 0 ? of.axis[j].lower : of.axis[j].upper;
    plant.place(at);
    all.push_back(plant.mass_matrix());
  }
  return all;
}

// 1/s: of the springs and dampers at the links, hands and stops included, and of the rotors on their transmissions; the largest at home and at
// the corners of the limits, because a mass matrix is nearest to singular in some of them.
double SimBench::fastest_rate() const {
  const Eigen::Index n = plant_->axes();
  Eigen::MatrixXd stiffness = Eigen::MatrixXd::Zero(n, n), damping = Eigen::MatrixXd::Zero(n, n);
  double fastest = 1;
  for (std::size_t j = 0; j < axes(); ++j) {
    const board::AxisTruth& axis = truth_.axis[j];
    stiffness(index(j), index(j)) = grip_k_[index(j)] + axis.stop_stiffness_N_m_rad + axis.stiffness_N_m_rad;
    damping(index(j), index(j)) = grip_d_[index(j)] + axis.stop_damping_N_m_s_rad + axis.damping_N_m_s_rad;
    if (axis.driven)
      fastest = std::max({fastest, std::sqrt(axis.stiffness_N_m_rad / axis.rotor_kg_m2),
                          (axis.damping_N_m_s_rad + axis.viscous_N_m_s_rad) / axis.rotor_kg_m2});
  }
  for (const board::JointMatrix& M : mass_at_corners(truth_)) {
    const auto largest = [&M](const Eigen::MatrixXd& of) {
      return Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd>(of, M, Eigen::EigenvaluesOnly)
          .eigenvalues()
          .maxCoeff();
    };
    fastest = std::max({fastest, std::sqrt(largest(stiffness)), largest(damping)});
  }
  return fastest;
}

// Of an axis with its links and its rotor. What is added is at the links; what is taken, there as far as the other links leave it wherever the arm
// may be, and at the rotor: a mass matrix with a negative direction has no motion, and one that is nearly so takes steps of microseconds.
void SimBench::change_inertia(const SimFault& fault) {
  constexpr double kMostOfLinks = .5, kMostOfRotor = .8;
  board::AxisTruth& axis = truth_.axis[fault.axis];
  const Eigen::Index row = index(fault.axis);
  const std::vector<board::JointMatrix> masses = mass_at_corners(clean_);
  double alone = masses.front()(row, row);  // with the other axes free
  for (const board::JointMatrix& M : masses) alone = std::min(alone, 1 / M.inverse()(row, row));
  const double wanted = (fault.factor - 1) * (masses.front()(row, row) + axis.rotor_kg_m2);
  const double at_links = std::max(wanted, -kMostOfLinks * std::max(0.0, alone));
  if (wanted - at_links < -kMostOfRotor * axis.rotor_kg_m2)
    throw Error(
        ExitCode::kUsage, "bad-fault",
        fmt::format(
            "--fault wrong-inertia: {} of the inertia of '{}' is less than what the other links leave",
            fault.factor, original_.axes[fault.axis].name),
        "give a factor nearer to 1");
  axis.link_kg_m2 += at_links;
  axis.rotor_kg_m2 += wanted - at_links;
}

void SimBench::add_fault(const SimFault& fault) {
  board::AxisTruth& axis = truth_.axis[fault.axis];
  switch (fault.fault) {
    case ArmFault::kLineIgnored:
      lines_ignored_ = true;
      break;
    case ArmFault::kNoise:
      noise_.at(fault.axis) = 4;
      break;
    case ArmFault::kEncoderSign:
      axis.rad_per_count = -axis.rad_per_count;
      break;
    case ArmFault::kMotorSign:
      axis.turns = -axis.turns;
      break;
    case ArmFault::kEncodersSwapped:
      std::swap(encoder_port_[fault.axis], encoder_port_[fault.other]);
      break;
    case ArmFault::kMotorsSwapped:
      std::swap(drive_port_[fault.axis], drive_port_[fault.other]);
      break;
    case ArmFault::kJointsSwapped:
      std::swap(encoder_port_[fault.axis], encoder_port_[fault.other]);
      std::swap(drive_port_[fault.axis], drive_port_[fault.other]);
      break;
    case ArmFault::kWrongCounts:
      axis.rad_per_count /= fault.factor;
      break;
    case ArmFault::kWrongRatio:
      axis.rad_per_count /= fault.factor;
      axis.turns *= fault.factor;
      axis.rotor_kg_m2 *= fault.factor * fault.factor;
      break;
    case ArmFault::kDeadChannel:
      dead_channel_.at(fault.axis) = true;
      break;
    case ArmFault::kDeadEncoder:
      dead_encoder_.at(fault.axis) = true;
      break;
    case ArmFault::kSlip:
      slipping_.at(fault.axis) = fault.factor;
      break;
    case ArmFault::kIndexOff:
      mark_turns_.at(fault.axis) = fault.factor;
      break;
    case ArmFault::kOpenWinding:
      open_.at(fault.axis) = true;
      break;
    case ArmFault::kDeadPhase:
      dead_phase_.at(fault.axis) = true;
      break;
    case ArmFault::kWeakMotor:
      axis.motor.torque_constant_N_m_A *= static_cast<float>(fault.factor);
      break;
    case ArmFault::kWrongInertia:
      change_inertia(fault);
      break;
    case ArmFault::kWrongResistance:
      axis.motor.resistance_ohm *= static_cast<float>(fault.factor);
      break;
    case ArmFault::kCurrentLoop:
    case ArmFault::kNoMotion:
    case ArmFault::kUneven:
    case ArmFault::kFeedsEnergy:
    case ArmFault::kWrongDirection:
    case ArmFault::kWrongWeight:
    case ArmFault::kStopElsewhere:
    case ArmFault::kNoRest:
      break;  // what faults look like, not faults
  }
}

void SimBench::mend(std::size_t fault) {
  faults_.erase(faults_.begin() + static_cast<std::ptrdiff_t>(fault));
  const JointVector held = held_;
  build();
  bring(held, std::nullopt);
}

BenchFacts SimBench::facts() {
  return {.tick_s = 1.0 / 4000,
          .watchdog_s = .02,
          .counts_illegal = true,
          .home_mark = options_.has_mark ? HomeMark::kEachAxis : HomeMark::kNone,
          .session = options_.session};
}

void SimBench::use(const ArmFile& arm) {
  given_ = arm;
  for (std::size_t j = 0; j < axes(); ++j) {
    for (std::size_t joint = 0; joint < axes(); ++joint) {
      if (encoder_port_[joint] == arm.axes[j].encoder.port) encoder_of_.at(j) = joint;
      if (arm.axes[j].drive && drive_port_[joint] == arm.axes[j].drive->port) motor_of_.at(j) = joint;
    }
  }
}

std::int64_t SimBench::counts_of(std::size_t encoder) const {
  const board::AxisTruth& axis = truth_.axis[encoder];
  const auto at = static_cast<std::int64_t>(
      std::floor(plant_->rotors_rad()[index(encoder)] / axis.rad_per_count + slipped_.at(encoder)));
  if (dead_encoder_.at(encoder)) return 0;
  return dead_channel_.at(encoder) ? (at & 2) / 2 : at;
}

PerAxis<std::int64_t> SimBench::counts() const {
  PerAxis<std::int64_t> counts{};
  for (std::size_t j = 0; j < axes(); ++j) counts.at(j) = counts_of(encoder_of_.at(j));
  return counts;
}

PerAxis<AxisReading> SimBench::read() {
  PerAxis<AxisReading> readings{};
  const PerAxis<std::int64_t> now = counts();
  for (std::size_t j = 0; j < axes(); ++j) {
    const std::size_t motor = motor_of_.at(j);
    const bool driven = given_.axes[j].drive.has_value();
    readings.at(j) = {
        .counts = now.at(j),
        .illegal = illegal_.at(encoder_of_.at(j)),
        .current_A = driven && options_.measures_current ? plant_->motors().at(motor).current_A : kNaN,
        .voltage_V = driven && options_.measures_voltage ? plant_->motor_voltage_V(motor) : kNaN,
        .temperature_C = driven ? plant_->motors().at(motor).winding_C : kNaN};
  }
  return readings;
}

PerAxis<double> SimBench::believed() const {
  PerAxis<double> angles{};
  const PerAxis<std::int64_t> now = counts();
  for (std::size_t j = 0; j < axes(); ++j)
    angles.at(j) = at_zero_.at(j) + static_cast<double>(now.at(j)) * given_.axes[j].per_count();
  return angles;
}

void SimBench::command(const PerAxis<double>& current_A, bool enable) {
  JointVector current = JointVector::Zero(plant_->axes());
  for (std::size_t j = 0; j < axes(); ++j)
    if (given_.axes[j].drive) current[index(motor_of_.at(j))] = current_A.at(j);
  powered_ = enable;
  plant_->command_current(current, enable);
}

// A dead phase: the torque is that of the component along the live windings, of the current's component there.
void SimBench::set_torques() {
  JointVector torque = JointVector::Ones(plant_->axes());
  for (std::size_t j = 0; j < axes(); ++j) {
    if (!dead_phase_.at(j)) continue;
    const double angle = kPolePairs * plant_->rotors_rad()[index(j)] * truth_.axis[j].turns;
    torque[index(j)] = std::cos(angle) * std::cos(angle);
  }
  plant_->set_drives(1, torque);
}

void SimBench::slip(std::size_t joint, double speed) {
  if (slipping_.at(joint) == 0) return;
  const double counts_per_turn =
      (original_.axes[joint].is_prismatic ? 1 : 2 * pi) /
      (std::abs(truth_.axis[joint].rad_per_count) * original_.axes[joint].encoder.turns_per_turn.value);
  if (std::abs(speed) > .1 * per_radian(original_.axes[joint])) {
    if (speed * last_speed_.at(joint) < 0)
      slipped_.at(joint) += slipping_.at(joint) * kSlipPart * counts_per_turn * uniform(.5, 1);
    last_speed_.at(joint) = speed;
  }
}

void SimBench::advance(double seconds, bool judge_speed) {
  set_torques();
  step_plant(seconds);
  for (std::size_t j = 0; j < axes(); ++j) slip(j, plant_->joint_speeds_rad_s()[index(j)]);
  judge(judge_speed);
}

void SimBench::judge(bool speed) {
  if (!powered_) return;
  const board::ByJoint J = plant_->force_jacobian();
  const JointVector& torque = plant_->motor_torques_N_m();
  // One motor pushes a finger that blocks its way with torque / lever; several with the force that their torques make.
  double force_N = 0;
  Eigen::Index pushing = 0;
  for (Eigen::Index j = 0; j < torque.size(); ++j) {
    if (std::abs(torque[j]) < 1e-9) continue;
    ++pushing;
    const double lever_m = J.col(j).norm();
    if (lever_m > .01) force_N = std::max(force_N, std::abs(torque[j]) / lever_m);
    const board::AxisTruth& axis = truth_.axis[static_cast<std::size_t>(j)];
    const ArmAxis& given = original_.axes[static_cast<std::size_t>(j)];
    if (given.drive)
      most_share_ =
          std::max(most_share_, std::abs(torque[j]) / (std::abs(axis.turns) *
                                                       static_cast<double>(axis.motor.torque_constant_N_m_A) *
                                                       given.motor->peak_current_A.value));
  }
  most_force_N_ = std::max(most_force_N_, force_N);
  if (speed) most_speed_m_s_ = std::max(most_speed_m_s_, (J * plant_->joint_speeds_rad_s()).norm());
}

void SimBench::record(BenchRecording& recording, const PerAxis<double>& asked_A, double time_s) {
  BenchTick tick;
  tick.time_s = time_s;
  tick.asked_A = asked_A;
  const PerAxis<AxisReading> now = read();
  for (std::size_t j = 0; j < axes(); ++j) {
    tick.counts.at(j) = now.at(j).counts;
    tick.current_A.at(j) = now.at(j).current_A + uniform(-.005, .005);
    tick.voltage_V.at(j) = now.at(j).voltage_V + uniform(-.02, .02);
    const double noise = noise_.at(encoder_of_.at(j));
    if (noise > 0 && uniform(0, 1) < .05) {
      tick.counts.at(j) += std::lround(uniform(-noise, noise));
      ++recording.illegal.at(j);
    }
  }
  recording.ticks.push_back(tick);
}

}  // namespace thimble::host

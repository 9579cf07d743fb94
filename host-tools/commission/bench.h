// What the commissioning of an arm asks of a device: lines, counters, reports of the drives, motions of one axis that end by themselves, and a
// builder who does what a text says. The simulated bench (sim_bench.h) implements it; a board does over the link.
//
// Axes are those of the arm file: the bench reads the encoder at the port that the file gives an axis and commands the drive at its port. Whether
// these are at that joint is what the commissioning finds out. Units: SI; counts as the encoder gives them, widened beyond its register.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

#include "host-tools/arms/arm_file.h"

namespace thimble::host {

template <typename T>
using PerAxis = std::array<T, kinematics::kMaxJoints>;

// What tells where home is: nothing, an index or switch of each axis, or one level that is true while all axes of the arm are at home.
enum class HomeMark : std::uint8_t { kNone, kEachAxis, kWholeArm };

struct BenchFacts {
  double tick_s = 1.0 / 4000;  // of the board's loop, and of what it records in a motion
  double watchdog_s = .02;     // within which the drives must be off when the host is silent
  bool counts_illegal = true;  // the counters tell transitions that no encoder makes
  HomeMark home_mark = HomeMark::kNone;
  std::string session;  // changes when the counters begin anew
};

enum class Line : std::uint8_t { kEStop, kDeadMan, kWatchdog };
struct LineTrial {
  bool fell = false;   // the enable, after the builder did what was asked
  double seconds = 0;  // from the line to the enable
};

inline constexpr double kNotMeasured = std::numeric_limits<double>::quiet_NaN();

// kNotMeasured: by the drive.
struct AxisReading {
  std::int64_t counts = 0;
  std::uint64_t illegal = 0;
  double current_A = 0, voltage_V = 0, temperature_C = 0;
};

struct BenchTick {
  double time_s = 0;
  PerAxis<std::int64_t> counts{};
  PerAxis<double> asked_A{}, current_A{}, voltage_V{};
};

// The home mark of an axis was passed.
struct Mark {
  std::size_t axis = 0;
  std::int64_t counts = 0;
  bool forward = false;  // counts rose
};

enum class Ending : std::uint8_t { kTime, kCounts, kSpeed, kEnergy, kLine };

struct BenchRecording {
  std::vector<BenchTick> ticks;
  std::vector<Mark> marks;                     // kEachAxis
  std::vector<PerAxis<std::int64_t>> at_home;  // kWholeArm: counts where the level rose
  PerAxis<std::uint64_t> illegal{};            // transitions in this time
  Ending ending = Ending::kTime;
  std::size_t driven_ticks = 0;  // of a program: before it ended
};

// Where a motion ends by itself, whichever axis reaches it. 0: no limit.
struct EndsAt {
  PerAxis<double> counts{};    // from the start
  PerAxis<double> counts_s{};  // over 5 ms
  double energy_J = 0;         // asked torque times way
};

// The current of one axis, then zero torque while it coasts, then off: a constant, a ramp and a tone (a cosine, whose mean motion does not drift).
struct AxisProgram {
  std::size_t axis = 0;
  double seconds = 0;
  double constant_A = 0, slope_A_s = 0, tone_A = 0, tone_Hz = 0;
  double coast_s = 0;
  EndsAt ends;
  [[nodiscard]] double current_A(double time_s) const {
    return constant_A + slope_A_s * time_s + tone_A * std::cos(2 * std::numbers::pi * tone_Hz * time_s);
  }
  [[nodiscard]] std::size_t ticks(double tick_s) const {
    return static_cast<std::size_t>(std::lround(seconds / tick_s));
  }
};

// The board holds the axes on a straight way between two places, each with a spring and a damper, and records. The speed rises over the first part of
// move_s, kServoRamp, is constant, and falls over the last part.
inline constexpr double kServoRamp = .25;
struct ServoProgram {
  PerAxis<double> from{}, to{};  // rad or m
  double move_s = 0, stay_s = 0;
  PerAxis<double> stiffness_N_m_rad{}, damping_N_m_s_rad{}, most_torque_N_m{};
};

// Forces at the tip while the builder moves it: -B v and a spring to where it was; or a wall wall_depth_m from there, which pushes along its normal
// and damps with B, with the arm's weight held by the motors.
struct TipProgram {
  enum class Kind : std::uint8_t { kDamping, kSpring, kWall };
  Kind kind = Kind::kDamping;
  double stiffness_N_m = 0, damping_N_s_m = 0, most_force_N = 0;
  double most_speed_m_s = 0;                               // it ends above that
  Eigen::Vector3d wall_normal = Eigen::Vector3d::UnitZ();  // of length 1, world frame
  double wall_depth_m = 0;
};

// What a hand presses a wall with, about: less where the wall gives less.
inline constexpr double kPress_N = 2;
[[nodiscard]] inline double press_N(const TipProgram& wall) {
  return wall.most_force_N < kPress_N / .8 ? .8 * wall.most_force_N : kPress_N;
}

// What the builder is asked to do. `text` is for people and says all; the rest is for pictures and for programs that play the builder.
struct Prompt {
  enum class Kind : std::uint8_t {
    kOpenEStop,
    kReleaseDeadMan,
    kStopHost,  // nothing to do: the tool goes silent
    kRest,      // lay the arm so that it rests, and take the hands off
    kTurn,      // an axis from stop to stop, `times` there and back, first along `direction` at the tip
    kPlace,  // bring all axes to `place`, then hold all but `axis` and let that one go; all, where it is no axis
    kPassHome,         // bring the arm to its home mark, at `place`, and away from it, `times`
    kSwing,            // turn the axis to and fro by hand, drives on and without torque
    kMoveAbout,        // hold the tip and move it slowly about
    kPush,             // push the tip slowly along `direction` by 20 mm, and back
    kHang,             // hang `mass_kg` at the tip, or take it off
    kLetGo,            // hands off: the board holds the arm
    kPressWall,        // push the tip along `direction` to the wall, press with press_N(), and hold
    kRepair,           // a fault was found; `finding` says which
    kAcceptCorrection  // whether the corrections of a finding are to be written into the new file
  };
  Kind kind = Kind::kRest;
  std::size_t axis = 0;
  Eigen::Vector3d direction = Eigen::Vector3d::Zero();  // world frame
  double sign = 1;  // of the motion of the axis that goes along `direction`, by the file
  int times = 1;
  PerAxis<double> place{};
  double mass_kg = 0;
  double
      wall_N_m = 0,
      wall_m = 0,
      press_N =
          0;  // its stiffness, how far it is and how hard to press it, for a program that plays the builder
  std::size_t finding = 0;  // index into StepResult::findings
  std::string text;
};
enum class Answer : std::uint8_t { kDone, kNo, kStop };

class Bench {
 public:
  Bench() = default;
  Bench(const Bench&) = delete;
  Bench& operator=(const Bench&) = delete;
  virtual ~Bench() = default;

  [[nodiscard]] virtual BenchFacts facts() = 0;
  // The board goes by this file from now on.
  virtual void use(const ArmFile& arm) = 0;
  // And by these angles (or m) of the axes where their counts are 0.
  virtual void locate(const PerAxis<double>& at_zero) = 0;
  [[nodiscard]] virtual PerAxis<AxisReading> read() = 0;
  [[nodiscard]] virtual Answer ask(const Prompt& prompt) = 0;
  [[nodiscard]] virtual LineTrial try_line(Line line, const Prompt& prompt) = 0;
  // Records, a thousand times a second, until the builder has done it.
  [[nodiscard]] virtual BenchRecording watch(const Prompt& prompt, bool powered) = 0;
  // The same for a time in which nobody does anything.
  [[nodiscard]] virtual BenchRecording wait(double seconds, bool powered) = 0;
  [[nodiscard]] virtual BenchRecording run(const AxisProgram& program) = 0;
  [[nodiscard]] virtual BenchRecording servo(const ServoProgram& program) = 0;
  [[nodiscard]] virtual BenchRecording feel(const TipProgram& program, const Prompt& prompt) = 0;
};

}  // namespace thimble::host

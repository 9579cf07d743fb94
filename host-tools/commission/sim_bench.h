// A bench with a simulated arm and a simulated builder, for `thimble commission --simulate` and for tests. What is true of the arm may differ from its
// file by faults and by a spread of its figures. The builder does what the prompts say. Every motion is watched: the largest force and speed that
// the motors gave the tip.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "board/sim/any_plant.h"
#include "host-tools/commission/bench.h"
#include "host-tools/commission/faults.h"

namespace thimble::host {

// Of the plant at most, in a motion of the motors and in one of the hands.
inline constexpr double kSimMotionStep_s = 1e-4, kSimHandStep_s = 5e-4;

// The hand pulls so far into a stop, rad, with so much of the grip's stiffness when it turns an axis.
inline constexpr double kBeyond = .15, kTurnShare = .03;

struct SimFault {
  ArmFault fault{};
  std::size_t axis = 0;
  std::size_t other = 0;  // of an exchange
  double factor = 1;      // true by given: counts, ratio, torque, inertia; turns of the index
};

struct SimBenchOptions {
  std::uint64_t seed = 1;
  double spread =
      1;  // of the true figures, 1: friction 15 %, inertia 5 %, torque constant 3 %, resistance 5 %, stiffness 10 %; 0: as the file
  bool measures_current = true, measures_voltage = true;
  bool has_mark = true;
  double drive_delay_s = 0;           // of a command, in whole ticks
  std::string session = "simulated";  // of the counters
  // What the builder says to a correction; without it: no, and what he repairs.
  bool accepts_corrections = false;
};

class SimBench : public Bench {
 public:
  SimBench(const ArmFile& arm, std::vector<SimFault> faults, const SimBenchOptions& options);

  [[nodiscard]] BenchFacts facts() override;
  void use(const ArmFile& arm) override;
  void locate(const PerAxis<double>& at_zero) override { at_zero_ = at_zero; }
  [[nodiscard]] PerAxis<AxisReading> read() override;
  [[nodiscard]] Answer ask(const Prompt& prompt) override;
  [[nodiscard]] LineTrial try_line(Line line, const Prompt& prompt) override;
  [[nodiscard]] BenchRecording watch(const Prompt& prompt, bool powered) override;
  [[nodiscard]] BenchRecording wait(double seconds, bool powered) override;
  [[nodiscard]] BenchRecording run(const AxisProgram& program) override;
  [[nodiscard]] BenchRecording servo(const ServoProgram& program) override;
  [[nodiscard]] BenchRecording feel(const TipProgram& program, const Prompt& prompt) override;

  // Repairs the fault; the hands take the arm to where they held it last.
  void mend(std::size_t fault);
  [[nodiscard]] const std::vector<SimFault>& faults() const { return faults_; }

  [[nodiscard]] const board::AnyPlant& plant() const { return *plant_; }
  [[nodiscard]] const board::AnyPlantParameters& truth() const { return truth_; }
  // The largest so far that the motors gave: while they had power, without the hand's own motion.
  [[nodiscard]] double most_tip_force_N() const { return most_force_N_; }
  [[nodiscard]] double most_tip_speed_m_s() const { return most_speed_m_s_; }
  [[nodiscard]] double most_torque_share() const { return most_share_; }

 protected:
  // A bench of a board that is simulated, too, has the board's own time and commands.
  virtual void step_plant(double seconds) { plant_->step(seconds); }
  virtual void command(const PerAxis<double>& current_A, bool enable);
  [[nodiscard]] PerAxis<std::int64_t> counts() const;  // of the axes of the file
  // What the hands do that a prompt asks for, from its beginning to its end.
  void hands(const Prompt& prompt);
  void let_tip_go();
  [[nodiscard]] board::AnyPlant& moved_plant() { return *plant_; }  // for hands of other kinds
  void take_fine_steps() { plant_->set_max_step(motion_step_s_); }  // as motors need
  // Where the marks of all axes are, and whether all axes are there, as one level of the arm would tell.
  [[nodiscard]] board::JointVector home_mark() const;
  [[nodiscard]] bool at_home_mark() const;
  [[nodiscard]] virtual bool over() const { return false; }  // the hands stop pressing
  void judge(bool speed);
  [[nodiscard]] bool ignores_lines() const { return lines_ignored_; }

 private:
  [[nodiscard]] std::size_t axes() const { return given_.axes.size(); }
  [[nodiscard]] double uniform(double low, double high);
  void add_light_links();
  void add_least_friction();
  void build();
  void harden_stops();
  [[nodiscard]] double fastest_rate() const;
  void add_fault(const SimFault& fault);
  void change_inertia(const SimFault& fault);
  [[nodiscard]] std::vector<board::JointMatrix> mass_at_corners(const board::AnyPlantParameters& of) const;
  [[nodiscard]] std::int64_t counts_of(std::size_t encoder) const;  // of the encoder at a joint
  void slip(std::size_t joint, double speed);
  void find_marks(BenchRecording& recording, const board::JointVector& before);
  void set_torques();
  void advance(double seconds, bool judge_speed);
  void record(BenchRecording& recording, const PerAxis<double>& asked_A, double time_s);
  [[nodiscard]] PerAxis<double> believed() const;  // angles by the file and the counts
  // The hands: all axes to a place, and hold them there, but for one.
  void bring(const board::JointVector& place, std::optional<std::size_t> loose);
  void settle();
  void grip(const board::JointVector& target, std::optional<std::size_t> loose, double share);
  void turn(const Prompt& prompt, bool powered, BenchRecording& recording);
  void go(std::size_t axis, double to, double speed, bool powered, BenchRecording& recording);
  void swing(const Prompt& prompt, bool powered, BenchRecording& recording);
  void pass_home(int times);
  [[nodiscard]] BenchRecording press_wall(const TipProgram& program);
  [[nodiscard]] Eigen::Vector3d hand_way(const Prompt& prompt, double time_s) const;
  void hold_tip();
  void move_tip(const Prompt& prompt, double time_s, double step_s);
  void approach_wall(double stiffness_N_m, double depth_m, const Eigen::Vector3d& normal, double press_N);
  [[nodiscard]] bool press_on(double time_s);

  ArmFile original_, given_;
  std::vector<SimFault> faults_;
  SimBenchOptions options_;
  std::uint64_t random_;
  board::AnyPlantParameters clean_, truth_;
  std::unique_ptr<board::AnyPlant> plant_;
  std::vector<int> encoder_port_,
      drive_port_;  // where the encoder and the motor of each joint are plugged in
  PerAxis<std::size_t> encoder_of_{}, motor_of_{};  // the joint behind each axis of the file
  PerAxis<double> slipped_{}, slipping_{}, last_speed_{}, mark_turns_{}, at_zero_{};
  PerAxis<bool> dead_channel_{}, dead_encoder_{}, dead_phase_{}, open_{};
  PerAxis<double> noise_{};
  PerAxis<std::uint64_t> illegal_{};
  double hand_step_s_ = kSimHandStep_s, motion_step_s_ = kSimMotionStep_s;
  bool lines_ignored_ = false, powered_ = false;
  board::JointVector grip_k_, grip_d_, held_;
  Eigen::Vector3d hand_from_m_ = Eigen::Vector3d::Zero(), press_way_m_ = Eigen::Vector3d::Zero();
  double press_travel_s_ = 0;
  double most_force_N_ = 0, most_speed_m_s_ = 0, most_share_ = 0;
};

}  // namespace thimble::host

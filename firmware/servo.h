// The servo: what happens in one tick, from encoder counts to motor currents, with the modes, faults and
// limits. Owned by Controller, which is what boards call; controller.h states the two contexts.
//
// encoders -> kinematics -> control::Renderer, or what the host orders -> ramp, clamp, slew -> Jacobian
// transpose + gravity -> currents, thermal
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <span>

#include "control/renderer.h"
#include "control/scene/limits.h"
#include "firmware/encoder_watch.h"
#include "firmware/faults.h"
#include "firmware/guarded_move.h"
#include "firmware/host_forces.h"
#include "firmware/params.h"
#include "firmware/telemetry.h"
#include "firmware/thermal.h"
#include "firmware/trace.h"
#include "kinematics/arm.h"
#include "kinematics/encoder.h"
#include "kinematics/vector.h"
#include "kinematics/velocity.h"

namespace thimble::firmware {

using control::kMaxArms;
inline constexpr std::size_t kJoints = 3;
inline constexpr std::size_t kFreezeTicks = 64;
inline constexpr std::array<float, 12> kLateBounds_us = {1,   2,   5,   10,   20,   50,
                                                         100, 200, 500, 1000, 2000, 5000};

struct ArmConfig {
  const char* model = "premium-1.5";  // an arm model of kinematics/, by name
  kinematics::BasePose base;          // default: the world's origin is at the tip's home position
  // True: homing ends at the tick in which ArmInputs::index is set. False: the user holds the arm in its home
  // pose and homing takes the next sample.
  bool has_index = false;
};

struct Config {
  float period_s = 1.0F / 4000.0F;  // 40 us to 20 ms
  std::uint8_t arm_count = 1;       // 1 to kMaxArms
  std::array<ArmConfig, kMaxArms> arm{};
  std::uint8_t node_id = 1;  // on the link, 1 to 127
  // Of an upload, taken at once: less where the store takes long, for the host waits for each block's answer.
  std::uint16_t block_bytes = link::kMaxBlockBytes;
  bool classic_can = false;            // the board's bus has no FD: hosts are told to ask in classic frames
  const char* serial_number = "none";  // text for the host
  const char* board = "none";          // the board that the image is for, by its folder in board/
  const char* reset_reason = "";  // why it started: "power_on", "watchdog", "host", "crash"; empty: not known
  // What the board lacks for safe motion, as far as it knew at start ("no_realtime_priority,no_watchdog"): arming is
  // refused with it. Empty: nothing.
  const char* lacks = "";
  // Called from long work of the background (checking an image) every 20 us or so: a board whose tick is no interrupt
  // runs it there. Null: not needed.
  control::Pause pause = nullptr;
};

struct ArmInputs {
  std::array<std::uint32_t, kJoints>
      counts{};                   // counter registers as they are (16 or 32 bits wide, as the model says)
  std::uint64_t sample_tick = 0;  // Inputs::tick in which they were latched
  bool index = false;             // the arm stands at its index
  bool drive_fault = false;
};

struct Inputs {
  // Periods since the loop started, lost ones included: it rises by 1 a tick, by more after an overrun.
  std::uint64_t tick = 0;
  std::uint64_t time_us = 0;  // the board's monotonic clock at the start of this tick
  float last_tick_us = 0;     // how long the tick before took, for telemetry
  float late_us = 0;          // how long after its time this tick began, for telemetry
  bool e_stop = false;        // true: pressed, or its wire open
  bool dead_man = false;      // true: held (a board without one says true)
  std::array<ArmInputs, kMaxArms> arm;
};

struct ArmOutputs {
  std::array<float, kJoints> current_A{};
  bool enable = false;  // of the motor drives
};

struct Outputs {
  Mode mode = Mode::kDisarmed;
  std::array<ArmOutputs, kMaxArms> arm;
};

enum class Command : std::uint8_t {
  kNone = 0,
  kHome = 1,
  kArm = 2,
  kDisarm = 3,   // always accepted
  kClear = 4,    // clears a latched fault whose cause is gone
  kStop = 5,     // trips host_stop; always accepted
  kMove = 6,     // comes with an order: request_move()
  kEndMove = 7,  // the arm that moves by itself is let go; accepted without one too
  kTrace = 8,    // the next tick is the first of a trace (firmware/trace.h); motors off
};

// What stands against a command, as bits. The numbers travel over the link: append only.
using Conditions = std::uint32_t;
enum Condition : Conditions {
  kNotHomed = 1U << 0U,
  kEncoderStale = 1U << 1U,
  kOutsideWorkspace = 1U << 2U,
  kFaultLatched = 1U << 3U,
  kDeadManOpen = 1U << 4U,
  kNoScene = 1U << 5U,
  kLinkDown = 1U << 6U,
  kEStopPressed = 1U << 7U,
  kDriveFault = 1U << 8U,
  kWrongMode = 1U << 9U,  // armed, homing or damping, and the command needs rest
  kBadConfig = 1U << 10U,
  // Against a guarded move only.
  kNotArmed = 1U << 11U,
  kMovesNotAllowed = 1U << 12U,
  kInContact = 1U << 13U,
  kMoveUnderWay = 1U << 14U,
  kRampRuns = 1U << 15U,
  // Against arming again: Config::lacks, which the refusal names.
  kBoardLacks = 1U << 16U,
  // Against a guarded move.
  kHostRenders = 1U << 17U,
};
struct ConditionRow {
  Condition bit;
  const char* name;
  const char* remedy;
};
inline constexpr std::array<ConditionRow, 18> kConditionTable = {{
    {kNotHomed, "not_homed", "home the arm"},
    {kEncoderStale, "encoder_stale", "check the encoder cable and that the loop runs"},
    {kOutsideWorkspace, "outside_workspace", "move the tip back, or home again"},
    {kFaultLatched, "fault_latched", "read the fault, remove its cause and clear it"},
    {kDeadManOpen, "dead_man_released", "hold the dead-man switch"},
    {kNoScene, "no_scene", "upload a scene"},
    {kLinkDown, "link_down", "send tester-present first and keep sending it"},
    {kEStopPressed, "e_stop_pressed", "release the e-stop"},
    {kDriveFault, "drive_fault", "check motor wiring and supply"},
    {kWrongMode, "wrong_mode", "wait until homing or damping has ended, or disarm"},
    {kBadConfig, "bad_config", "correct the board's configuration and restart"},
    {kNotArmed, "not_armed", "arm first"},
    {kMovesNotAllowed, "moves_not_allowed", "nobody's hand near the arm? then set allow_moves to 1"},
    {kInContact, "in_contact", "move the tip off the scene's surfaces"},
    {kMoveUnderWay, "move_under_way", "wait until the move has ended, or stop it"},
    {kRampRuns, "ramp_runs", "wait until the force has ramped up"},
    {kBoardLacks, "board_lacks", "give the board what the refusal names, and restart it"},
    {kHostRenders, "host_renders", "set host_forces to 0: a guarded move needs the scene"},
}};

class Servo {
 public:
  Servo(const Config& config, const Params& params) noexcept;
  Servo(const Servo&) = delete;
  Servo& operator=(const Servo&) = delete;

  static constexpr std::uint32_t kRecords = 8;  // telemetry records that wait for the background

  // --- servo context. Work: O(one renderer tick), no heap, lock, exception, I/O.
  [[nodiscard]] Outputs tick(const Inputs& inputs) noexcept;
  [[nodiscard]] const Telemetry& telemetry() const noexcept { return telemetry_; }
  [[nodiscard]] std::span<const control::BodyState> bodies() const noexcept { return renderer_.bodies(); }

  // --- background context
  // Posts a command for the next tick, or returns what stands against it (0: posted). A later command
  // replaces one that no tick has taken yet.
  [[nodiscard]] Conditions request(Command command) noexcept;
  [[nodiscard]] bool command_pending() const noexcept;
  // A guarded move: values within the limits; posted, or what stands against it (no command may be pending).
  [[nodiscard]] bool move_in_range(const MoveOrder& order) const noexcept;
  [[nodiscard]] Conditions request_move(const MoveOrder& order) noexcept;
  [[nodiscard]] Conditions unmet_for_move() const noexcept {
    return published_unmet_for_move_.load(std::memory_order_acquire);
  }
  [[nodiscard]] link::MovePhase move_phase() const noexcept {
    return published_move_phase_.load(std::memory_order_acquire);
  }
  [[nodiscard]] link::MoveEnd move_end() const noexcept {
    return published_move_end_.load(std::memory_order_acquire);
  }
  // Null while a move is under way or about to be.
  [[nodiscard]] const GuardedMove* move_results() const noexcept;
  [[nodiscard]] Trace& trace() noexcept { return trace_; }
  [[nodiscard]] const Trace& trace() const noexcept { return trace_; }
  // Before the first tick: the state that a trace began with, with the scene that was posted last. What is fed from then on gives
  // what it gave there.
  void resume(const link::TraceStart& start, const TraceArms& arms) noexcept;
  // Takes the command in the next tick, whatever stands against it: for a replay, which knows that it was obeyed.
  void replay(Command command) noexcept { post(command); }
  void keep_alive() noexcept;
  // A force that the host orders; its arm is one of the controller's. False: it was passed over.
  [[nodiscard]] bool order_force(const link::ForceOrder& order, link::Micros now) noexcept {
    return host_forces_.order(order, now);
  }
  [[nodiscard]] std::uint32_t orders_expired() const noexcept { return host_forces_.expired(); }
  [[nodiscard]] Mode mode() const noexcept { return published_mode_.load(std::memory_order_acquire); }
  [[nodiscard]] Fault fault() const noexcept { return published_fault_.load(std::memory_order_acquire); }
  // Of the last tick; but a host that sets host_forces and arms at once need not wait for one.
  [[nodiscard]] Conditions unmet() const noexcept {
    const Conditions unmet = published_unmet_.load(std::memory_order_acquire);
    return params_.on(Param::host_forces) ? unmet & ~Conditions{kNoScene} : unmet;
  }
  // Bit n: fault n occurred since the last clear. Low 32 bits of the tick in which the first one latched.
  [[nodiscard]] std::uint32_t faults_seen() const noexcept {
    return faults_seen_.load(std::memory_order_acquire);
  }
  [[nodiscard]] std::uint32_t fault_tick() const noexcept {
    return fault_tick_.load(std::memory_order_acquire);
  }
  // The next scene (its bytes must stay until a later scene is the running one). False: the last one is still
  // waiting. kGoOn: it is the last one in other materials.
  [[nodiscard]] bool post_scene(const control::SceneView& view, std::uint32_t sequence,
                                control::Binding binding = control::Binding::kStart) noexcept;
  [[nodiscard]] bool scene_pending() const noexcept;  // the tick has not taken the last one yet
  [[nodiscard]] bool next_record(Telemetry& record) noexcept;
  // The scene as it was at a record since the last call; false where nothing moves and nothing is touched, or no record came.
  [[nodiscard]] bool next_scene_state(SceneState& state) noexcept;
  // Ticks since start by how late they began: [i] counts those below kLateBounds_us[i] and not below the bound before
  // it, the last one the rest. In us: the worst.
  [[nodiscard]] std::uint32_t late_ticks(std::size_t index) const noexcept {
    return late_ticks_[index].load(std::memory_order_relaxed);
  }
  [[nodiscard]] float worst_late_us() const noexcept {
    return worst_late_us_.load(std::memory_order_relaxed);
  }
  // The ticks up to the trip, 0 the oldest, until the fault is cleared. False: there is no such tick.
  [[nodiscard]] bool freeze_tick(std::size_t index, Telemetry& tick) const noexcept;
  [[nodiscard]] std::size_t freeze_count() const noexcept;  // 0 without a fault

 private:
  struct ArmState {
    ArmState(const ArmConfig& config, float period_s) noexcept;

    kinematics::Arm<float> arm;
    kinematics::Posture<float> posture;
    std::array<kinematics::JointEncoder, kJoints> encoder;
    std::array<kinematics::VelocityEstimator, kJoints> speed;
    std::array<EncoderWatch, kJoints> watch;
    std::array<MotorHeat, kJoints> heat;
    bool has_index;
    bool seen = false;  // a first sample has come
    bool homed = false;
    bool in_workspace = false;
    std::uint64_t sample_tick = 0;
    std::uint64_t age_ticks = 0;  // of the newest sample
    Vec3 joint_rad = Vec3::Zero();
    Vec3 tip_velocity_m_s = Vec3::Zero();
    Vec3 force_N = Vec3::Zero();  // of the tick before, after clamp and slew
    Vec3 torque_N_m = Vec3::Zero();
    Vec3 current_A = Vec3::Zero();
    std::uint8_t limiters = 0;
  };

  [[nodiscard]] bool motors_on() const noexcept { return mode_ == Mode::kArmed || mode_ == Mode::kDamping; }
  [[nodiscard]] bool homed() const noexcept;
  [[nodiscard]] bool unattended() const noexcept;
  void trip(Fault reason) noexcept;
  void post(Command command) noexcept;
  void stop() noexcept;  // Armed -> Damping -> Ready
  void check_inputs(const Inputs& inputs) noexcept;
  void read_arm(ArmState& arm, const ArmInputs& input, std::uint64_t tick) noexcept;
  void home_arms(const Inputs& inputs) noexcept;
  [[nodiscard]] Conditions conditions(const Inputs& inputs) const noexcept;
  void obey(Command command, Conditions unmet) noexcept;
  void switch_scene() noexcept;
  void take_scene(std::uint32_t posted) noexcept;
  void start_trace(const Inputs& inputs) noexcept;
  void settle(const link::TraceStart& start, const TraceArms& arms) noexcept;
  void trace_tick(const Inputs& inputs, Command obeyed) noexcept;
  [[nodiscard]] Conditions move_conditions(Conditions unmet) const noexcept;
  void render() noexcept;
  void feel_orders() noexcept;
  void damp() noexcept;
  void drive(Outputs& outputs) noexcept;
  void show(const Inputs& inputs) noexcept;
  void show_scene() noexcept;

  const Params& params_;
  bool board_lacks_;
  float period_s_;
  std::uint8_t arm_count_;
  std::array<ArmState, kMaxArms> arms_;
  control::Renderer renderer_;
  std::array<control::Touch, kMaxArms> touches_{};

  Mode mode_ = Mode::kDisarmed;
  Fault fault_ = Fault::kNone;
  bool first_tick_ = true;
  bool dead_man_ = false;
  std::uint64_t tick_ = 0;
  std::uint64_t lost_ = 0;  // periods between the last tick and this one
  GuardedMove move_;
  HostForces host_forces_;
  // host_forces, as it was when this arming began.
  bool host_renders_ = false;
  float force_ramp_ = 0;    // of the rendered force
  float gravity_ramp_ = 0;  // of the weight that the motors carry
  float mode_time_s_ = 0;   // in kHoming and kDamping
  std::uint32_t link_age_ticks_ = 0;
  bool link_seen_ = false;
  std::uint32_t sequence_ = 0;  // of the scene; 0: none
  control::SceneView scene_;
  Telemetry telemetry_;
  Trace trace_;

  // Records on their way to the background: written by the tick at head, read by the background at tail.
  std::array<Telemetry, kRecords> records_;
  std::atomic<std::uint32_t> record_head_{0};
  std::atomic<std::uint32_t> record_tail_{0};
  std::uint32_t since_record_ = 0;
  // The tick writes it while it is empty, the background reads it while it is full.
  SceneState scene_state_;
  std::atomic<bool> scene_state_full_{false};
  std::array<std::uint8_t, kMaxArms> record_limiters_{};
  float record_tick_us_ = 0;

  // The last ticks; the tick writes while frozen_ is false, the background reads while it is true.
  std::array<Telemetry, kFreezeTicks> freeze_;
  std::uint32_t freeze_count_ = 0;
  std::atomic<bool> frozen_{false};

  // Background to tick: serial << 8 | command. The tick answers with the serial when it is done with it.
  std::atomic<std::uint32_t> command_{0};
  std::atomic<std::uint32_t> command_done_{0};
  MoveOrder posted_move_;                        // of kMove
  std::atomic<std::uint32_t> stop_requests_{0};  // apart from command_: nothing may replace a stop
  std::uint32_t stops_seen_ = 0;
  std::atomic<std::uint32_t> alive_{0};  // counts keep_alive()
  std::uint32_t alive_seen_ = 0;
  control::SceneView posted_scene_;
  std::uint32_t posted_sequence_ = 0;
  control::Binding posted_binding_ = control::Binding::kStart;
  std::atomic<std::uint32_t> scene_posted_{0};
  std::atomic<std::uint32_t> scene_taken_{0};

  // Tick to background.
  std::atomic<Mode> published_mode_{Mode::kDisarmed};
  std::atomic<Fault> published_fault_{Fault::kNone};
  std::atomic<Conditions> published_unmet_;
  std::atomic<Conditions> published_unmet_for_move_{kNotArmed};
  std::atomic<link::MovePhase> published_move_phase_{link::MovePhase::kNone};
  std::atomic<link::MoveEnd> published_move_end_{link::MoveEnd::kNotYet};
  std::array<std::atomic<std::uint32_t>, kLateBounds_us.size() + 1> late_ticks_{};
  std::atomic<float> worst_late_us_{0.0F};
  std::atomic<std::uint32_t> faults_seen_{0};
  std::atomic<std::uint32_t> fault_tick_{0};
};

}  // namespace thimble::firmware

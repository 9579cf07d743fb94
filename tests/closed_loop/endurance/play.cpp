#include "tests/closed_loop/endurance/play.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <filesystem>
#include <memory>
#include <optional>
#include <stdexcept>

#include "board/sim/hand_path_file.h"
#include "board/sim/sim_board.h"
#include "firmware/link/crc32.h"
#include "host-tools/compiler/compile.h"
#include "tests/support/random.h"
#include "tests/unit/firmware/tester.h"

namespace thimble::test {
namespace {

namespace fs = std::filesystem;
using board::Injection;
using board::SimBoard;
using board::Vector3d;
using firmware::Fault;
using firmware::Mode;

constexpr double kRate_Hz = 1000;
constexpr double kPlantStep_s = 125e-6;
constexpr double kBoard_s = 300;      // until the next restart
constexpr double kStretch_m = 0.012;  // a hand that feels 6 N gives way
constexpr double kOff_s = 0.25;       // after which the drives are off
constexpr double kRecovers_s = 900;   // longest; a hot motor takes minutes
constexpr std::uint16_t kArm = 0x0201, kDisarm = 0x0202, kHome = 0x0203, kActivate = 0x0204;

// What the board's tests call a bench, with the simulated arm behind it.
struct Rig {
  struct Clock {
    firmware::link::Micros time_us = 0;
  };
  SimBoard* board = nullptr;
  firmware::Controller* controller = nullptr;
  Clock inputs;
  std::vector<firmware::link::CanFrame> for_testers;
  bool alive = true;
  std::function<void()> before, after;  // a tick

  void tick() {
    before();
    board->tick();
    inputs.time_us = static_cast<firmware::link::Micros>(std::llround(board->time_s() * 1e6));
    controller->poll(inputs.time_us);
    after();
  }
};
using Host = TesterOf<Rig>;

// A hand that goes from one place to another near the home of its arm, with pauses, and gives way when it is held back.
class Wandering {
 public:
  void restart(const Vector3d& from_m) { at_m_ = from_m, left_ = 0, velocity_m_s_.setZero(); }
  void tick(SimBoard& board, std::size_t arm, const Vector3d& home_m, Random& random) {
    const Vector3d tip_m = board.plant(arm).tip_m();
    const bool held_back = (at_m_ - tip_m).norm() > kStretch_m;
    if (left_-- <= 0 || (held_back && !gives_way_)) {
      gives_way_ = held_back;
      const bool rests = !held_back && random.below(4) == 0;
      const Vector3d to_m = held_back ? Vector3d(tip_m + .1 * (at_m_ - tip_m))
                            : rests   ? at_m_
                                      : board.within_reach(arm, home_m + random.in_box({.06, .06, .05}));
      const double seconds = std::max(held_back ? .05 : random.uniform(.2, 2), (to_m - at_m_).norm() / .25);
      left_ = static_cast<int>(seconds * kRate_Hz);
      velocity_m_s_ = (to_m - at_m_) / seconds;
    }
    at_m_ += velocity_m_s_ / kRate_Hz;
    const Vector3d tremor_m = 20e-6 * Vector3d(std::sin(56 * board.time_s()), std::sin(63 * board.time_s()),
                                               std::sin(69 * board.time_s()));
    board.hold(arm, at_m_ + tremor_m, velocity_m_s_);
  }

 private:
  Vector3d at_m_ = Vector3d::Zero(), velocity_m_s_ = Vector3d::Zero();
  int left_ = 0;
  bool gives_way_ = false;
};

// One board from its start to the next restart.
class Session {
 public:
  Session(Random& random, std::span<const Demonstration> scenes, firmware::Storage& storage, Played& played)
      : random_(random), scenes_(scenes), played_(played), board_(options(random, storage)) {
    ++played_.boards;
    rig_.board = &board_;
    rig_.controller = &board_.controller();
    rig_.before = [this] { move_hands(); };
    rig_.after = [this] { look(); };
    for (std::size_t arm = 0; arm < board_.options().arm_count; ++arm) {
      home_m_.push_back(board_.plant(arm).tip_m());
      hands_.emplace_back().restart(home_m_.back());
    }
    rig_.tick();
    host_ = std::make_unique<Host>(rig_, random_.below(2) == 0, 1 + random_.below(1U << 20U));
    rig_.alive = true;
  }

  void run(double seconds) {
    const double until_s = board_.time_s() + std::min(seconds, kBoard_s);
    while (board_.time_s() < until_s && played_.complaints.empty()) {
      if (!recover()) return;
      ++played_.arms_armed;
      play(random_.uniform(1, 10));
      if (random_.below(3) != 0) {
        break_something();
        if (random_.below(4) == 0) break_something();
        while (board_.time_s() < broken_until_s_) play(.1);
      }
    }
  }
  [[nodiscard]] double time_s() const { return board_.time_s(); }

 private:
  static board::SimBoardOptions options(Random& random, firmware::Storage& storage) {
    constexpr std::array<const char*, 2> kVariants = {"premium-1.5", "wooden"};
    constexpr std::array<const char*, 3> kReasons = {"power_on", "host", "watchdog"};
    board::SimBoardOptions options{.variant = kVariants[random.below(2)], .rate_Hz = kRate_Hz};
    options.arm_count = random.below(4) == 0 ? 2 : 1;
    options.hand.stiffness_N_m = random.uniform(300, 600);
    options.hand.damping_N_s_m = random.uniform(5, 15);
    options.seed = random.bits();
    options.reset_reason = kReasons[random.below(3)];
    options.storage = &storage;
    options.sensors = {.line_loss = random.below(2) == 0,
                       .current = random.below(2) == 0,
                       .supply = random.below(2) == 0,
                       .temperature = random.below(2) == 0,
                       .index = random.below(2) == 0};
    options.plant_step_s = kPlantStep_s;
    return options;
  }
  [[nodiscard]] const firmware::Telemetry& shown() { return board_.controller().telemetry(); }
  void complain(const std::string& what) {
    played_.complaints.push_back(
        what + " (" + board_.options().variant + ", " + std::to_string(board_.options().arm_count) +
        " arms, " + scene_ + ", after " + std::to_string(played_.simulated_s) + " s; last: " + last_ + ")");
  }

  // --- the hands
  void move_hands() {
    for (std::size_t arm = 0; arm < hands_.size(); ++arm) {
      if (!wander_) {
        board_.hold(arm, home_m_[arm]);
        // Its index is where its cradle is.
        board::Plant& plant = board_.plant(arm);
        if (shown().mode == Mode::kHoming && (plant.tip_m() - home_m_[arm]).norm() < .005)
          plant.place(kinematics::TwoLinkArm<double>(plant.parameters().model).home());
        hands_[arm].restart(home_m_[arm]);
      } else if (!board_.hand_follows(arm)) {
        hands_[arm].tick(board_, arm, home_m_[arm], random_);
      }
    }
  }

  // --- after each tick
  void look() {
    const firmware::Telemetry& now = shown();
    ++played_.ticks;
    played_.simulated_s += 1 / kRate_Hz;
    if (now.mode == Mode::kArmed) played_.armed_s += 1 / kRate_Hz;
    for (std::size_t arm = 0; arm < now.arm_count; ++arm)
      if (!(now.arm[arm].force_N.norm() <= 20))
        complain("a force of " + std::to_string(now.arm[arm].force_N.norm()) + " N");
    if (now.fault != fault_) {
      fault_ = now.fault;
      if (fault_ != Fault::kNone) found();
    }
    const bool may_drive = now.mode == Mode::kArmed || now.mode == Mode::kDamping;
    not_driving_s_ = now.mode == Mode::kArmed ? 0 : not_driving_s_ + 1 / kRate_Hz;
    for (std::size_t arm = 0; arm < now.arm_count && !rigged(); ++arm)
      if (board_.driven(arm) && (!may_drive || not_driving_s_ > kOff_s + 2 / kRate_Hz))
        complain("a drive stays on");
    if (!rigged() && now.tick + 1 != static_cast<std::uint64_t>(std::llround(board_.time_s() * kRate_Hz)))
      complain("a tick did not come");
  }
  // Something of the hardware is broken now, or has been just before.
  [[nodiscard]] bool rigged() const { return board_.time_s() < broken_until_s_ + .3; }
  void found() {
    ++played_.named[static_cast<std::size_t>(fault_)];
    const char* name = firmware::find_fault(fault_)->name;
    const bool never = fault_ == Fault::tip_not_finite || fault_ == Fault::force_not_finite ||
                       fault_ == Fault::torque_not_finite || fault_ == Fault::bad_config;
    if (clean_ || never) complain(std::string("a fault that nothing explains: ") + name);
  }

  // --- arming
  void command(const Bytes& request) {
    ++played_.requests;
    asked_at_s_ = board_.time_s();
    const Bytes answer = host_->ask(request);
    if (answer.empty() && !rigged()) complain("no answer");
    const bool no = answer.empty() || (answer.size() == 3 && answer[0] == firmware::link::kNegative);
    refused_ = !no              ? firmware::link::Nrc::kOk
               : answer.empty() ? firmware::link::Nrc::kGeneralReject
                                : static_cast<firmware::link::Nrc>(answer[2]);
  }
  void routine(std::uint16_t id) {
    command({0x31, 0x01, static_cast<std::uint8_t>(id >> 8U), static_cast<std::uint8_t>(id)});
  }
  // Mended, cleared, at home, with a scene, and armed.
  bool recover() {
    clean_ = false;
    wander_ = false;
    const double until_s = board_.time_s() + kRecovers_s;
    while (board_.time_s() < until_s) {
      host_->run(static_cast<int>(.7 * kRate_Hz));
      if (board_.time_s() < broken_until_s_) continue;
      command({0x10, 0x03});
      command({0x14, 0xFF, 0xFF, 0xFF});
      if (scene_.empty()) swap();
      routine(kHome);
      host_->run(static_cast<int>(.2 * kRate_Hz));
      routine(kArm);
      if (refused_ == firmware::link::Nrc::kOk) break;
      why_ = host_->text(firmware::link::kDidRefusal);
    }
    if (shown().mode != Mode::kArmed) {
      complain("the arm cannot be armed again: " + why_ + ", mode " +
               std::to_string(static_cast<int>(shown().mode)) + ", fault " +
               std::to_string(static_cast<int>(shown().fault)) + ", answer " +
               std::to_string(static_cast<int>(refused_)) + ", at " + std::to_string(board_.time_s()) +
               " s, broken until " + std::to_string(broken_until_s_) + " s");
      return false;
    }
    clean_ = true;
    wander_ = true;
    if (random_.below(3) == 0) follow();
    return true;
  }
  void follow() {
    for (std::size_t arm = 0; arm < hands_.size(); ++arm) {
      std::vector<board::PathPoint> points = board::read_hand_path(demonstration_->stroke);
      std::erase_if(points,
                    [&](const board::PathPoint& point) { return point.arm != static_cast<int>(arm); });
      for (board::PathPoint& point : points) point.position_m = board_.within_reach(arm, point.position_m);
      if (!points.empty()) board_.follow(arm, board::HandPath(points), true);
    }
  }

  // --- play
  void play(double seconds) {
    const double until_s = board_.time_s() + seconds;
    while (board_.time_s() < until_s) {
      host_->run(static_cast<int>(.05 * kRate_Hz));
      if (board_.time_s() > asked_at_s_ + 1)
        command({0x3E, 0x00});  // a host that is silent for 5 s loses its place
      switch (random_.below(60)) {
        case 0:
          swap();
          break;
        case 1:
          write();
          break;
        case 2:
        case 3:
        case 4:
          ask();
          break;
        case 5:
          someone_else();
          break;
        case 6:
          if (random_.below(3) == 0) stop();
          break;
        default:
          break;
      }
    }
  }
  void swap() {
    demonstration_ = &scenes_[random_.below(scenes_.size())];
    scene_ = demonstration_->name;
    ++played_.swaps;
    host_->run(static_cast<int>(.1 * kRate_Hz));  // the tick has taken the last one
    if (rigged() || random_.below(4) != 0) {
      const firmware::StoreStatus status = board_.controller().load_scene(demonstration_->image);
      const bool may = torn_ || (rigged() && status == firmware::StoreStatus::kBusy);
      if (status != firmware::StoreStatus::kOk && !may)
        complain("a scene was refused: " + std::to_string(static_cast<int>(status)));
      return;
    }
    ++played_.uploads;
    command({0x10, 0x02});
    const Bytes end = download(*host_, std::span<const std::byte>(demonstration_->image),
                               firmware::link::crc32(demonstration_->image), 4093);
    if (end != Bytes{0x77} && !torn_)
      complain("an upload ended with " + std::to_string(end.size()) + " bytes");
    routine(kActivate);
    command({0x10, 0x03});
  }
  // A parameter that may be written at any time, within its range.
  void write() {
    constexpr std::array<firmware::Param, 3> kAny = {firmware::Param::max_force, firmware::Param::force_slew,
                                                     firmware::Param::telemetry_decimation};
    const firmware::ParamRow& row = firmware::kParamTable[static_cast<std::size_t>(kAny[random_.below(3)])];
    const double value = std::exp(random_.uniform(std::log(std::max(static_cast<double>(row.min), .5)),
                                                  std::log(static_cast<double>(row.max))));
    const std::uint32_t bits = row.type == firmware::ParamType::kFloat
                                   ? std::bit_cast<std::uint32_t>(static_cast<float>(value))
                                   : static_cast<std::uint32_t>(value);
    ++played_.writes;
    command({0x2E, static_cast<std::uint8_t>(row.id >> 8U), static_cast<std::uint8_t>(row.id),
             static_cast<std::uint8_t>(bits), static_cast<std::uint8_t>(bits >> 8U),
             static_cast<std::uint8_t>(bits >> 16U), static_cast<std::uint8_t>(bits >> 24U)});
  }
  void ask() {
    constexpr std::array<std::uint16_t, 8> kWhat = {0xF18C, 0xF195, 0xF1A0, 0xF1A1,
                                                    0xF1A9, 0xF1AC, 0xF1AD, 0x0100};
    ++played_.requests;
    (void)host_->read(kWhat[random_.below(kWhat.size())]);
  }
  // Another host: one that wants to command, one that asks and is gone, or one that sends what nobody understands.
  void someone_else() {
    const auto kind = random_.below(3);
    if (kind == 0) rival();
    if (kind == 1) {
      Host other(rig_, false);
      (void)other.text(firmware::link::kDidSceneName);
      rig_.alive = true;
    }
    for (int i = 0; kind == 2 && i < 50; ++i) {
      firmware::link::CanFrame junk;
      junk.id = static_cast<std::uint32_t>(random_.below(1U << 29U));
      junk.extended = true;
      junk.size = static_cast<std::uint8_t>(random_.below(9));
      for (std::size_t k = 0; k < junk.size; ++k) junk.data[k] = static_cast<std::uint8_t>(random_.bits());
      board_.controller().on_frame(junk, rig_.inputs.time_us);
    }
  }
  // It must not while this host has the arm armed.
  void rival() {
    Host other(rig_, false, (1U << 20U) + 1 + random_.below(1U << 20U));
    (void)other.ok({0x10, 0x03});
    firmware::link::DeviceState state;
    const std::array<Bytes, 3> commands = {Bytes{0x31, 0x01, 0x02, 0x01}, Bytes{0x31, 0x01, 0x02, 0x0C},
                                           Bytes{0x2E, 0x01, 0x01, 0, 0, 0, 0x45}};
    if (firmware::link::decode(other.read(firmware::link::DeviceState::kId), state) &&
        state.mode == Mode::kArmed && state.commander == host_->address()) {
      const Bytes answer = other.ask(commands[random_.below(commands.size())]);
      ++played_.rivals;
      if (!answer.empty() && answer[0] != firmware::link::kNegative && shown().mode == Mode::kArmed)
        complain("a second host commanded an armed arm");
    }
    other.leave();  // there are places for four
    rig_.alive = true;
  }
  void stop() {
    ++played_.stops;
    clean_ = false;
    last_ = "a stop";
    if (random_.below(2) == 0) {
      board_.controller().on_frame(firmware::link::to_frame(firmware::link::EmergencyStop{}, 1),
                                   rig_.inputs.time_us);
    } else {
      routine(kDisarm);
    }
    const std::uint64_t tick = shown().tick;
    host_->run(2);
    if (shown().tick == tick) host_->run(4);  // some ticks are lost, or it has hung
    const bool hung = shown().tick == tick;   // it obeys nothing, and its drives are off after 5 ms
    for (std::size_t arm = 0; arm < hands_.size(); ++arm)
      if (hung ? board_.driven(arm) : shown().mode == Mode::kArmed) complain("a stop was not obeyed");
    if (!recover()) return;
  }

  // --- the hardware
  void break_something() {
    using enum Injection;
    constexpr std::array kKinds = {
        kEncoderDead,  kEncoderCable, kEncoderPhaseA, kEncoderPhaseB, kEncoderSlip,    kEncoderDrift,
        kEncoderStuck, kSamplesStale, kMotorReversed, kMotorWeak,     kAmplifierStuck, kConverterStuck,
        kSupply,       kDriveFault,   kEStop,         kDeadMan,       kTickLost,       kTickLate,
        kTickJitter,   kTickHung,     kStorageTorn,   kHandLetsGo,    kHandHolds,      kHandPushes};
    const Injection kind = kKinds[random_.below(kKinds.size())];
    const auto row = std::ranges::find(board::injections(), kind, &board::InjectionRow::kind);
    board::PlannedFault fault{.kind = kind, .arm = random_.below(hands_.size())};
    if (row->of == board::InjectionOf::kJoint) fault.joint = random_.below(3);
    fault.at_s = board_.time_s() + random_.uniform(0, .3);
    fault.for_s = std::exp(random_.uniform(std::log(.02), std::log(1.5)));
    const double sign = random_.below(2) == 0 ? 1 : -1;
    if (kind == kEncoderSlip || kind == kEncoderDrift) fault.value = sign * std::exp(random_.uniform(0, 9));
    if (kind == kEncoderStuck) fault.value = random_.uniform(0, 65535);
    if (kind == kMotorWeak) fault.value = random_.uniform(0, .9);
    if (kind == kAmplifierStuck) fault.value = random_.uniform(-2, 2);
    if (kind == kSupply) fault.value = random_.uniform(0, 2);
    if (kind == kTickLost) fault.value = static_cast<double>(1 + random_.below(6));
    if (kind == kTickLate || kind == kTickJitter) fault.value = random_.uniform(0, 1 / kRate_Hz);
    if (kind == kStorageTorn) fault.value = random_.uniform(0, 200000);
    if (kind == kHandPushes) fault.force_N = random_.uniform(0, 6) * random_.direction();
    ++played_.injected;
    clean_ = false;
    torn_ = torn_ || kind == kStorageTorn;
    last_ = row->name;
    broken_until_s_ = std::max(broken_until_s_, fault.at_s + fault.for_s + 2 / kRate_Hz);
    board_.inject(fault);
  }

  Random& random_;
  std::span<const Demonstration> scenes_;
  Played& played_;
  SimBoard board_;
  Rig rig_;
  std::unique_ptr<Host> host_;
  std::vector<Vector3d> home_m_;
  std::vector<Wandering> hands_;
  const Demonstration* demonstration_ = nullptr;
  std::string scene_, last_ = "start", why_;
  firmware::link::Nrc refused_ = firmware::link::Nrc::kOk;
  Fault fault_ = Fault::kNone;
  double asked_at_s_ = 0, not_driving_s_ = 0, broken_until_s_ = 0;
  bool wander_ = false;
  bool clean_ = false;  // armed, after everything was mended: a fault has no reason
  bool torn_ = false;   // the store has lost bytes since the start
};

}  // namespace

std::vector<Demonstration> demonstrations() {
  std::vector<Demonstration> all;
  for (const fs::directory_entry& folder : fs::directory_iterator(fs::path(THIMBLE_SOURCE_DIR) / "scenes")) {
    const fs::path stroke = folder.path() / "stroke.csv";
    const std::string name = folder.path().filename().string();
    if (!fs::exists(stroke)) continue;
    all.push_back({name, host::compile_scene(folder.path() / (name + ".scene.json")).image, stroke.string()});
  }
  std::ranges::sort(all, {}, &Demonstration::name);
  return all;
}

Played play(std::uint64_t seed, double seconds) {
  static const std::vector<Demonstration> kScenes = demonstrations();
  Random random(seed);
  Played played;
  board::MemoryStorage storage(control::kMaxImageBytes + firmware::SceneStore::kHeaderBytes);
  while (played.simulated_s < seconds && played.complaints.empty()) {
    Session session(random, kScenes, storage, played);
    session.run(seconds - played.simulated_s);
  }
  return played;
}

}  // namespace thimble::test

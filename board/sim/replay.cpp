#include "board/sim/replay.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <stdexcept>

#include "board/sim/sim_board.h"
#include "board/sim/verdict_text.h"
#include "firmware/link/services.h"
#include "firmware/store/slot_header.h"
#include "kinematics/built_in_arms.h"

namespace thimble::board {
namespace {

namespace link = firmware::link;

firmware::Config config_of(const RecordedRun& run) {
  firmware::Config config;
  config.period_s = run.start.period_s;
  config.arm_count = run.start.arms;
  config.work_units = run.start.work_units;
  if (run.start.arms < 1 || run.start.arms > control::kMaxArms || run.arms.size() != run.start.arms ||
      run.models.size() != run.start.arms)
    throw std::invalid_argument("it has " + std::to_string(run.start.arms) + " arms, and the state of " +
                                std::to_string(run.arms.size()));
  for (std::size_t i = 0; i < run.arms.size(); ++i) {
    kinematics::ArmData known;
    if (!kinematics::built_in_arm(run.models[i], known))
      throw std::invalid_argument("its arm '" + run.models[i] + "' is not known here");
    const link::RecordingArm& from = run.arms[i];
    firmware::ArmConfig& to = config.arm[i];
    to.model = run.models[i].c_str();
    to.has_index = from.has_index;
    to.base.home_m = {from.home_m[0], from.home_m[1], from.home_m[2]};
    std::size_t at = 0;
    for (int row = 0; row < 3; ++row)
      for (int column = 0; column < 3; ++column) to.base.rotation(row, column) = from.rotation[at++];
  }
  return config;
}

}  // namespace

class Replay::Board {
 public:
  explicit Board(const RecordedRun& run)
      : storage_(run.image.size() + firmware::SceneStore::kHeaderBytes),
        controller_(config_of(run), storage_),
        arms_(run.start.arms),
        // As a float, 0.25 ms is 12 fs too long, which is visible after a minute.
        period_s_(1.0 / std::round(1.0 / static_cast<double>(run.start.period_s))) {
    if (controller_.fault() != firmware::Fault::kNone)
      throw std::invalid_argument("its loop's period of " + std::to_string(run.start.period_s) +
                                  " s is not possible");
    for (const auto& [id, bits] : run.params) {
      if (const firmware::ParamRow* row = firmware::find_param(id); row != nullptr && marks(*row)) continue;
      if (controller_.write_param(id, bits) != firmware::ParamStatus::kOk)
        throw std::invalid_argument("its parameter " + std::to_string(id) +
                                    " is not known here, or has a value that is not allowed");
    }
    const firmware::StoreStatus status = controller_.load_scene(run.image);
    if (status != firmware::StoreStatus::kOk)
      throw std::invalid_argument("its scene was refused: " + text_of(controller_.store().image_verdict()));
    firmware::RecordingStart start{run.start, {}};
    for (std::size_t i = 0; i < run.arms.size(); ++i) {
      start.arms[i] = run.arms[i];
      std::copy_n(run.arms[i].raw.begin(), inputs_.arm[i].counts.size(), inputs_.arm[i].counts.begin());
    }
    controller_.resume(start, run.trial);
    inputs_.tick = first_ = run.start.tick;
  }

  void tick(const Replay::Tick& tick, link::RecordingCheck& check) {
    ++inputs_.tick;
    inputs_.dead_man = tick.levels.dead_man;
    inputs_.e_stop = tick.levels.e_stop;
    for (std::size_t i = 0; i < arms_; ++i) {
      firmware::ArmInputs& arm = inputs_.arm[i];
      arm.sample_tick = inputs_.tick;
      arm.index = tick.levels.index[i];
      arm.drive_fault = tick.levels.drive_fault[i];
      for (std::size_t j = 0; j < link::kClassicCounts; ++j) {
        const auto low =
            static_cast<std::uint16_t>(tick.counts[link::kClassicCounts * i + j] - arm.counts[j]);
        arm.counts[j] +=
            static_cast<std::uint32_t>(static_cast<std::int32_t>(static_cast<std::int16_t>(low)));
      }
    }
    controller_.keep_alive();
    const auto command = static_cast<firmware::Command>(tick.command);
    if (command == firmware::Command::kStop) {
      static_cast<void>(controller_.request(command));
    } else if (command != firmware::Command::kNone) {
      controller_.replay(command);
    }
    if (tick.trial)
      static_cast<void>(controller_.write_param(row_of(firmware::Param::trial).id, *tick.trial));
    static_cast<void>(controller_.tick(inputs_));
    std::array<float, 3 * control::kMaxArms> forces_N{};
    for (std::size_t i = 0; i < arms_; ++i)
      std::memcpy(&forces_N[3 * i], controller_.telemetry().arm[i].force_N.data(), 3 * sizeof(float));
    check.crc = firmware::crc32(std::as_bytes(std::span(forces_N).first(3 * arms_)), check.crc);
    check.tick = static_cast<std::uint16_t>(inputs_.tick);
    check.mode = controller_.telemetry().mode;
    check.levels = tick.levels;
    scene_ = scene_row_(controller_.renderer());
  }

  [[nodiscard]] const firmware::Controller& controller() const noexcept { return controller_; }

  [[nodiscard]] LogRow row(std::size_t arm) const noexcept {
    const firmware::ArmTelemetry& shown = controller_.telemetry().arm[arm];
    LogRow row;
    row.time_s = static_cast<double>(inputs_.tick - first_) * period_s_;
    row.arm = static_cast<int>(arm);
    row.tip_m = shown.tip_m.cast<double>();
    row.proxy_m = shown.god_object_m.cast<double>();
    row.force_N = shown.force_N.cast<double>();
    row.contacts = shown.contacts;
    row.scene = scene_;
    return row;
  }

 private:
  MemoryStorage storage_;
  firmware::Controller controller_;
  std::size_t arms_;
  double period_s_;
  std::uint64_t first_ = 0;
  firmware::Inputs inputs_;
  SceneRowOf scene_row_;
  SceneRow scene_;
};

Replay::Replay(const RecordedRun& run) : board_(std::make_unique<Board>(run)) {}
Replay::~Replay() = default;

void Replay::tick(const Tick& tick) { board_->tick(tick, check_); }
std::uint8_t Replay::fault() const noexcept {
  return static_cast<std::uint8_t>(board_->controller().fault());
}
LogRow Replay::row(std::size_t arm) const noexcept { return board_->row(arm); }

}  // namespace thimble::board

#include "board/sim/simulation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <sstream>
#include <stdexcept>

#include "board/sim/sim_board.h"
#include "board/sim/verdict_text.h"
#include "control/renderer.h"

namespace thimble::board {
namespace {

using control::kMaxArms;

constexpr double kLongestWait_s = 60.0;  // for each of homing, approach and ramp

SimulationResult failure(SimulationStatus status, std::string detail) {
  SimulationResult result;
  result.status = status;
  result.detail = std::move(detail);
  return result;
}

// One path per arm, all with the same start time. Throws std::invalid_argument.
std::vector<HandPath> split(const std::vector<PathPoint>& path) {
  std::array<std::vector<PathPoint>, kMaxArms> points;
  double start_s = std::numeric_limits<double>::infinity();
  for (const PathPoint& point : path) {
    if (point.arm < 0 || point.arm >= static_cast<int>(kMaxArms)) {
      throw std::invalid_argument("the path names an arm other than 0 and 1");
    }
    points[static_cast<std::size_t>(point.arm)].push_back(point);
    start_s = std::min(start_s, point.time_s);
  }
  if (points[0].empty()) throw std::invalid_argument("the path has no point for arm 0");
  std::vector<HandPath> paths;
  for (std::vector<PathPoint>& p : points) {
    if (p.empty()) continue;
    if (p.front().time_s > start_s) {
      PathPoint wait = p.front();
      wait.time_s = start_s;
      p.insert(p.begin(), wait);
    }
    paths.emplace_back(std::move(p));
  }
  return paths;
}

// Which solids the tips are inside of, from tick to tick.
class InsideLog {
 public:
  InsideLog(const control::SceneView& scene, std::vector<BeganInside>& log) : scene_(scene), log_(log) {}

  void take(double time_s, std::size_t arm, std::uint64_t inside) {
    std::uint64_t& before = inside_[arm];
    if (inside == before) return;
    const int number = static_cast<int>(arm);
    for (std::size_t object = 0; object < control::kMaxObjects; ++object) {
      const std::uint64_t bit = std::uint64_t{1} << object;
      const std::string name = (bit & (inside | before)) == 0 ? "" : name_of(object);
      if ((bit & before & ~inside) != 0) {
        for (BeganInside& entry : log_)
          if (entry.arm == number && entry.object == name && !entry.until_s) entry.until_s = time_s;
      } else if ((bit & inside & ~before) != 0) {
        log_.push_back({number, name, time_s, {}});
      }
    }
    before = inside;
  }

 private:
  [[nodiscard]] std::string name_of(std::size_t object) const {
    return scene_.scene()->objects()->Get(static_cast<flatbuffers::uoffset_t>(object))->name()->str();
  }

  const control::SceneView& scene_;
  std::vector<BeganInside>& log_;
  std::array<std::uint64_t, kMaxArms> inside_{};
};

class Simulation {
 public:
  Simulation(std::span<const std::byte> image, std::span<const PathPoint> points, std::vector<HandPath> paths,
             const SimulationOptions& options, const std::function<void(const LogRow&)>& row)
      : image_(image),
        points_(points),
        paths_(std::move(paths)),
        options_(options),
        row_(row),
        start_s_(paths_[0].start_s()) {
    double end_s = start_s_;
    for (const HandPath& path : paths_) end_s = std::max(end_s, path.end_s());
    // Includes the last time if it is on a tick; a thousandth of a period allows for rounding.
    ticks_ = static_cast<std::uint64_t>(std::floor((end_s - start_s_) * options_.rate_Hz + 1e-3)) + 1;
  }

  SimulationResult run() {
    std::vector<std::uint64_t> aligned((image_.size() + 7) / 8);
    if (!image_.empty()) std::memcpy(aligned.data(), image_.data(), image_.size());
    control::SceneView scene;
    const control::ImageVerdict verdict =
        control::SceneView::check(std::as_bytes(std::span(aligned)).first(image_.size()), scene);
    if (verdict != control::ImageStatus::kOk) return refused(verdict);
    return options_.ideal ? ideal(scene) : through_the_arm(scene);
  }

 private:
  SimulationResult ideal(const control::SceneView& scene) {
    const auto renderer = std::make_unique<control::Renderer>();
    renderer->bind(scene);
    renderer->set_trial(options_.trial);
    std::vector<control::Tip> tips(paths_.size());
    std::vector<control::Touch> touches(paths_.size());
    SimulationResult result;
    InsideLog inside(scene, result.inside);
    for (; result.ticks < ticks_; ++result.ticks) {
      const double time_s = time_of(result.ticks);
      for (std::size_t i = 0; i < paths_.size(); ++i) {
        const HandPath::Sample sample = paths_[i].at(time_s);
        const double step_m = (sample.position_m - tips[i].position_m.cast<double>()).norm();
        if (result.ticks > 0 && step_m * options_.rate_Hz > kJump_m_s) renderer->reset(i);
        tips[i] = {sample.position_m.cast<float>(), sample.velocity_m_s.cast<float>()};
      }
      renderer->tick(tips, static_cast<float>(1.0 / options_.rate_Hz), touches);
      const SceneRow scene_row = scene_row_(*renderer);
      for (std::size_t i = 0; i < paths_.size(); ++i) {
        inside.take(time_s, i, renderer->inside(i));
        row_({time_s, static_cast<int>(i), tips[i].position_m.cast<double>(),
              touches[i].god_object_m.cast<double>(), touches[i].force_N.cast<double>(), touches[i].contacts,
              scene_row});
      }
    }
    result.bounds = renderer->counters();
    return result;
  }

  SimulationResult through_the_arm(const control::SceneView& scene) {
    SimBoardOptions board_options{.rate_Hz = options_.rate_Hz};
    board_options.arm = options_.arm_data;
    if (!board_options.arm) board_options.variant = options_.arm;
    board_options.arm_count = static_cast<std::uint8_t>(paths_.size());
    board_options.hand = options_.hand;
    board_options.seed = options_.seed;
    board_options.sensors = options_.sensors;
    board_options.slot_bytes = image_.size() + firmware::SceneStore::kHeaderBytes;
    SimBoard board(board_options);
    firmware::Controller& controller = board.controller();
    for (const PathPoint& point : points_) {
      if (!board.reaches(static_cast<std::size_t>(point.arm), point.position_m))
        return failure(SimulationStatus::kOutOfReach, out_of_reach(point));
    }
    for (std::size_t i = 0; i < paths_.size(); ++i) board.follow(i, paths_[i]);

    if (controller.load_scene(image_) != firmware::StoreStatus::kOk)
      return refused(controller.store().image_verdict());
    const auto until = [&](auto&& condition) {
      for (long left = std::lround(kLongestWait_s * options_.rate_Hz); left > 0; --left) {
        if (condition()) return true;
        controller.keep_alive();
        board.tick();
        if (controller.fault() != firmware::Fault::kNone) return false;
      }
      return false;
    };
    const auto all_hands = [&](bool (SimBoard::*is)(std::size_t) const noexcept) {
      for (std::size_t i = 0; i < paths_.size(); ++i) {
        if (!(board.*is)(i)) return false;
      }
      return true;
    };
    static_cast<void>(controller.write_param(firmware::row_of(firmware::Param::trial).id, options_.trial));
    controller.keep_alive();
    board.tick();
    if (controller.request(firmware::Command::kHome) != 0 || !until([&] {
          return controller.mode() == firmware::Mode::kReady && all_hands(&SimBoard::hand_waits);
        })) {
      return not_armed(controller, "home");
    }
    if (controller.request(firmware::Command::kArm) != 0 || !until([&] {
          return controller.mode() == firmware::Mode::kArmed && controller.telemetry().ramp >= 1.0F;
        })) {
      return not_armed(controller, "arm");
    }

    SimulationResult result;
    InsideLog inside(scene, result.inside);
    for (; result.ticks < ticks_; ++result.ticks) {
      controller.keep_alive();
      board.tick();
      const firmware::Telemetry& telemetry = controller.telemetry();
      const SceneRow scene_row = scene_row_(controller.renderer());
      for (std::size_t i = 0; i < paths_.size(); ++i) {
        const firmware::ArmTelemetry& arm = telemetry.arm[i];
        inside.take(time_of(result.ticks), i, arm.inside);
        row_({time_of(result.ticks), static_cast<int>(i), board.sampled_tip_m(i),
              arm.god_object_m.cast<double>(), arm.force_N.cast<double>(), arm.contacts, scene_row});
      }
      if (controller.fault() != firmware::Fault::kNone) {
        ++result.ticks;
        result.status = SimulationStatus::kFaulted;
        result.detail = firmware::find_fault(controller.fault())->cause;
        break;
      }
    }
    result.bounds = controller.telemetry().bounds;
    return result;
  }

  [[nodiscard]] double time_of(std::uint64_t tick) const noexcept {
    return start_s_ + static_cast<double>(tick) / options_.rate_Hz;
  }

  static std::string out_of_reach(const PathPoint& point) {
    std::ostringstream text;
    text << "the path's point at " << point.time_s << " s, (" << point.position_m.x() << ", "
         << point.position_m.y() << ", " << point.position_m.z() << ") m, is outside the workspace of arm "
         << point.arm;
    return text.str();
  }

  static SimulationResult refused(const control::ImageVerdict& verdict) {
    return failure(SimulationStatus::kImageRefused, "the scene image was refused: " + text_of(verdict));
  }

  static SimulationResult not_armed(const firmware::Controller& controller, const char* what) {
    std::string detail = std::string("the controller did not ") + what;
    if (const firmware::FaultRow* fault = firmware::find_fault(controller.fault()); fault != nullptr) {
      return failure(SimulationStatus::kFaulted, detail + ": " + fault->cause);
    }
    for (const firmware::ConditionRow& row : firmware::kConditionTable) {
      if ((controller.unmet() & row.bit) != 0) detail += std::string(", ") + row.name;
    }
    return failure(SimulationStatus::kNotArmed, detail);
  }

  std::span<const std::byte> image_;
  std::span<const PathPoint> points_;
  std::vector<HandPath> paths_;
  const SimulationOptions& options_;
  const std::function<void(const LogRow&)>& row_;
  SceneRowOf scene_row_;
  double start_s_;
  std::uint64_t ticks_;
};

}  // namespace

SimulationResult simulate(std::span<const std::byte> image, const std::vector<PathPoint>& path,
                          const SimulationOptions& options, const std::function<void(const LogRow&)>& row) {
  if (!(options.rate_Hz >= 100 && options.rate_Hz <= 20000)) {
    return failure(SimulationStatus::kBadRate, "the rate is not within 100 Hz to 20 kHz");
  }
  if (!options.arm_data && find_plant_variant(options.arm) == nullptr) {
    return failure(SimulationStatus::kUnknownArm, "there is no simulated arm named " + options.arm);
  }
  std::vector<HandPath> paths;
  try {
    paths = split(path);
  } catch (const std::invalid_argument& error) {
    return failure(SimulationStatus::kBadPath, error.what());
  }
  Simulation simulation(image, path, std::move(paths), options, row);
  return simulation.run();
}

}  // namespace thimble::board

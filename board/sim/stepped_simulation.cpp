#include "board/sim/stepped_simulation.h"

#include <array>
#include <cmath>
#include <cstring>
#include <deque>
#include <optional>
#include <utility>

#include "board/sim/sim_board.h"
#include "board/sim/verdict_text.h"
#include "control/renderer.h"
#include "control/scene/same_shapes.h"

namespace thimble::board {
namespace {

using control::kMaxArms;

constexpr double kLongestWait_s = 60.0;  // for each of homing, approach and ramp

SimulationResult failed_run(SimulationStatus status, std::string detail) {
  SimulationResult result;
  result.status = status;
  result.detail = std::move(detail);
  return result;
}

SimulationResult refused(const control::ImageVerdict& verdict) {
  return failed_run(SimulationStatus::kImageRefused, "the scene image was refused: " + text_of(verdict));
}

// A copy of an image where its numbers can be read in place.
class AlignedImage {
 public:
  explicit AlignedImage(std::span<const std::byte> image)
      : aligned_((image.size() + 7) / 8), size_(image.size()) {
    if (!image.empty()) std::memcpy(aligned_.data(), image.data(), image.size());
  }
  [[nodiscard]] std::span<const std::byte> bytes() const {
    return std::as_bytes(std::span(aligned_)).first(size_);
  }
  control::ImageVerdict check() { return control::SceneView::check(bytes(), view_); }
  [[nodiscard]] const control::SceneView& view() const { return view_; }

 private:
  std::vector<std::uint64_t> aligned_;
  std::size_t size_;
  control::SceneView view_;
};

// Which solids the tips are inside of, from tick to tick.
class InsideLog {
 public:
  void take(const control::SceneView& scene, double time_s, std::size_t arm, std::uint64_t inside,
            std::vector<BeganInside>& log) {
    std::uint64_t& before = inside_[arm];
    if (inside == before) return;
    const int number = static_cast<int>(arm);
    for (std::size_t object = 0; object < control::kMaxObjects; ++object) {
      const std::uint64_t bit = std::uint64_t{1} << object;
      const std::string name = (bit & (inside | before)) == 0 ? "" : name_of(scene, object);
      if ((bit & before & ~inside) != 0) {
        for (BeganInside& entry : log)
          if (entry.arm == number && entry.object == name && !entry.until_s) entry.until_s = time_s;
      } else if ((bit & inside & ~before) != 0) {
        log.push_back({number, name, time_s, {}});
      }
    }
    before = inside;
  }

 private:
  [[nodiscard]] static std::string name_of(const control::SceneView& scene, std::size_t object) {
    const auto& objects = *scene.scene()->objects();
    return object < objects.size() ? objects.Get(static_cast<flatbuffers::uoffset_t>(object))->name()->str()
                                   : "";
  }

  std::array<std::uint64_t, kMaxArms> inside_{};
};

}  // namespace

class SteppedSimulation::Run {
 public:
  Run() = default;
  Run(const Run&) = delete;
  Run& operator=(const Run&) = delete;
  virtual ~Run() = default;

  virtual SimulationResult begin() = 0;
  virtual void tick(const RowFunction& row) = 0;
  virtual void extend(std::size_t arm, const PathPoint& point) = 0;
  virtual SimulationResult load(std::span<const std::byte> image) = 0;
  virtual std::uint64_t mark(firmware::link::MarkKind kind, std::uint16_t value) = 0;
  [[nodiscard]] virtual bool reaches(std::size_t arm, const Eigen::Vector3d& position_m) const = 0;
  [[nodiscard]] virtual double time_of(std::uint64_t tick) const noexcept = 0;
  [[nodiscard]] virtual const SimulationResult& result() const noexcept = 0;
};

namespace {

// What both kinds of runs do alike.
class SceneRun : public SteppedSimulation::Run {
 public:
  SceneRun(std::span<const std::byte> image, const SimulationOptions& options, double start_s)
      : image_(image), rate_Hz_(options.rate_Hz), start_s_(start_s) {}

  SimulationResult begin() final {
    const control::ImageVerdict verdict = image_.check();
    return verdict == control::ImageStatus::kOk ? start() : refused(verdict);
  }
  SimulationResult load(std::span<const std::byte> image) final {
    AlignedImage next(image);
    const control::ImageVerdict verdict = next.check();
    if (verdict != control::ImageStatus::kOk) return refused(verdict);
    SimulationResult result = change_to(next);
    if (result.status == SimulationStatus::kOk) image_ = std::move(next);
    return result;
  }
  std::uint64_t mark(firmware::link::MarkKind kind, std::uint16_t value) final {
    marks_.emplace_back(kind, value);
    return result_.ticks + marks_.size() - 1;
  }
  [[nodiscard]] double time_of(std::uint64_t tick) const noexcept final {
    return start_s_ + static_cast<double>(tick) / rate_Hz_;
  }
  [[nodiscard]] const SimulationResult& result() const noexcept final { return result_; }

 protected:
  virtual SimulationResult start() = 0;
  virtual SimulationResult change_to(const AlignedImage& next) = 0;
  // Of the tick that comes.
  [[nodiscard]] std::optional<std::pair<firmware::link::MarkKind, std::uint16_t>> next_mark() {
    if (marks_.empty()) return std::nullopt;
    const auto mark = marks_.front();
    marks_.pop_front();
    return mark;
  }

  AlignedImage image_;
  double rate_Hz_;
  double start_s_;
  SimulationResult result_;
  InsideLog inside_;
  SceneRowOf scene_row_;

 private:
  std::deque<std::pair<firmware::link::MarkKind, std::uint16_t>> marks_;  // that wait for their ticks
};

// The tip follows the path exactly.
class IdealRun final : public SceneRun {
 public:
  IdealRun(std::span<const std::byte> image, const SimulationOptions& options, std::vector<HandPath> paths)
      : SceneRun(image, options, paths[0].start_s()),
        renderer_(std::make_unique<control::Renderer>()),
        paths_(std::move(paths)),
        tips_(paths_.size()),
        touches_(paths_.size()) {}

  void tick(const SteppedSimulation::RowFunction& row) override {
    const double time_s = time_of(result_.ticks);
    for (std::size_t i = 0; i < paths_.size(); ++i) {
      const HandPath::Sample sample = paths_[i].at(time_s);
      const double step_m = (sample.position_m - tips_[i].position_m.cast<double>()).norm();
      if (result_.ticks > 0 && step_m * rate_Hz_ > kJump_m_s) renderer_->reset(i);
      tips_[i] = {sample.position_m.cast<float>(), sample.velocity_m_s.cast<float>()};
    }
    (void)take_mark();
    renderer_->tick(tips_, static_cast<float>(1.0 / rate_Hz_), touches_);
    const SceneRow scene_row = scene_row_(*renderer_);
    for (std::size_t i = 0; i < paths_.size(); ++i) {
      inside_.take(image_.view(), time_s, i, renderer_->inside(i), result_.inside);
      row({time_s, static_cast<int>(i), tips_[i].position_m.cast<double>(),
           touches_[i].god_object_m.cast<double>(), touches_[i].force_N.cast<double>(), touches_[i].contacts,
           scene_row});
    }
    ++result_.ticks;
    result_.bounds = renderer_->counters();
  }
  void extend(std::size_t arm, const PathPoint& point) override {
    paths_[arm].extend(point, time_of(result_.ticks));
  }
  [[nodiscard]] bool reaches(std::size_t, const Eigen::Vector3d&) const override { return true; }

 private:
  bool take_mark() {
    const auto mark = next_mark();
    if (mark && mark->first == firmware::link::MarkKind::kTrial)
      renderer_->set_trial(static_cast<std::uint8_t>(mark->second));
    return mark.has_value();
  }

  SimulationResult start() override {
    renderer_->bind(image_.view());
    while (take_mark()) {
    }
    return {};
  }
  SimulationResult change_to(const AlignedImage& next) override {
    renderer_->bind(next.view(),
                    control::binding_of(image_.bytes(), image_.view(), next.bytes(), next.view()));
    return {};
  }

  std::unique_ptr<control::Renderer> renderer_;
  std::vector<HandPath> paths_;
  std::vector<control::Tip> tips_;
  std::vector<control::Touch> touches_;
};

SimBoardOptions board_options_of(const SimulationOptions& options, std::size_t arms) {
  SimBoardOptions board_options{.rate_Hz = options.rate_Hz};
  board_options.arm = options.arm_data;
  if (!board_options.arm) board_options.variant = options.arm;
  board_options.arm_count = static_cast<std::uint8_t>(arms);
  board_options.hand = options.hand;
  board_options.seed = options.seed;
  board_options.sensors = options.sensors;
  return board_options;
}

// The controller drives the simulated arm, which the hand holds.
class ArmRun final : public SceneRun {
 public:
  ArmRun(std::span<const std::byte> image, const SimulationOptions& options, std::vector<HandPath> paths)
      : SceneRun(image, options, paths[0].start_s()),
        arms_(paths.size()),
        board_(board_options_of(options, paths.size())) {
    for (std::size_t i = 0; i < arms_; ++i) board_.follow(i, std::move(paths[i]));
  }

  void tick(const SteppedSimulation::RowFunction& row) override {
    firmware::Controller& controller = board_.controller();
    if (waiting_ && give(*waiting_) != firmware::StoreStatus::kBusy) waiting_.reset();
    tick_board();
    const firmware::Telemetry& telemetry = controller.telemetry();
    const SceneRow scene_row = scene_row_(controller.renderer());
    const double time_s = time_of(result_.ticks);
    for (std::size_t i = 0; i < arms_; ++i) {
      const firmware::ArmTelemetry& arm = telemetry.arm[i];
      inside_.take(image_.view(), time_s, i, arm.inside, result_.inside);
      row({time_s, static_cast<int>(i), board_.sampled_tip_m(i), arm.god_object_m.cast<double>(),
           arm.force_N.cast<double>(), arm.contacts, scene_row});
    }
    ++result_.ticks;
    result_.bounds = telemetry.bounds;
    if (controller.fault() != firmware::Fault::kNone) {
      result_.status = SimulationStatus::kFaulted;
      result_.detail = firmware::find_fault(controller.fault())->cause;
    }
  }
  void extend(std::size_t arm, const PathPoint& point) override {
    board_.extend(arm, point, time_of(result_.ticks));
  }
  [[nodiscard]] bool reaches(std::size_t arm, const Eigen::Vector3d& position_m) const override {
    return board_.reaches(arm, position_m);
  }

 private:
  void tick_board() {
    firmware::Controller& controller = board_.controller();
    controller.keep_alive();
    if (const auto mark = next_mark()) {
      const bool trial = mark->first == firmware::link::MarkKind::kTrial;
      const firmware::ParamRow& row = row_of(trial ? firmware::Param::trial : firmware::Param::event);
      static_cast<void>(controller.write_param(row.id, mark->second));
    }
    board_.tick();
  }

  // Ticks until the condition holds. False: it never did, or there was a fault.
  template <class Condition>
  bool until(Condition condition) {
    firmware::Controller& controller = board_.controller();
    for (long left = std::lround(kLongestWait_s * rate_Hz_); left > 0; --left) {
      if (condition()) return true;
      tick_board();
      if (controller.fault() != firmware::Fault::kNone) return false;
    }
    return false;
  }

  SimulationResult start() override {
    firmware::Controller& controller = board_.controller();
    if (controller.load_scene(image_.bytes()) != firmware::StoreStatus::kOk)
      return refused(controller.store().image_verdict());
    const auto all_hands_wait = [&] {
      for (std::size_t i = 0; i < arms_; ++i) {
        if (!board_.hand_waits(i)) return false;
      }
      return true;
    };
    tick_board();
    if (controller.request(firmware::Command::kHome) != 0 ||
        !until([&] { return controller.mode() == firmware::Mode::kReady && all_hands_wait(); }))
      return not_armed("home");
    if (controller.request(firmware::Command::kArm) != 0 || !until([&] {
          return controller.mode() == firmware::Mode::kArmed && controller.telemetry().ramp >= 1.0F;
        }))
      return not_armed("arm");
    return {};
  }

  SimulationResult change_to(const AlignedImage& next) override {
    waiting_.reset();
    const firmware::StoreStatus status = give(next);
    if (status == firmware::StoreStatus::kBusy) waiting_.emplace(next.bytes());
    if (status == firmware::StoreStatus::kOk || waiting_) return {};
    return refused(board_.controller().store().image_verdict());
  }
  firmware::StoreStatus give(const AlignedImage& image) {
    return board_.controller().load_scene(image.bytes());
  }

  SimulationResult not_armed(const char* what) {
    const firmware::Controller& controller = board_.controller();
    std::string detail = std::string("the controller did not ") + what;
    if (const firmware::FaultRow* fault = firmware::find_fault(controller.fault()); fault != nullptr)
      return failed_run(SimulationStatus::kFaulted, detail + ": " + fault->cause);
    for (const firmware::ConditionRow& row : firmware::kConditionTable) {
      if ((controller.unmet() & row.bit) != 0) detail += std::string(", ") + row.name;
    }
    return failed_run(SimulationStatus::kNotArmed, detail);
  }

  std::size_t arms_;
  SimBoard board_;
  std::optional<AlignedImage> waiting_;  // until the controller has taken the last one
};

std::unique_ptr<SteppedSimulation::Run> open_run(std::span<const std::byte> image,
                                                 const SimulationOptions& options,
                                                 std::vector<HandPath> paths) {
  std::unique_ptr<SteppedSimulation::Run> run;
  if (options.ideal)
    run = std::make_unique<IdealRun>(image, options, std::move(paths));
  else
    run = std::make_unique<ArmRun>(image, options, std::move(paths));
  if (options.trial != 0) (void)run->mark(firmware::link::MarkKind::kTrial, options.trial);
  return run;
}

}  // namespace

SteppedSimulation::SteppedSimulation(std::span<const std::byte> image, const SimulationOptions& options,
                                     std::vector<HandPath> paths)
    : run_(open_run(image, options, std::move(paths))) {}
SteppedSimulation::~SteppedSimulation() = default;

SimulationResult SteppedSimulation::begin() { return run_->begin(); }
void SteppedSimulation::tick(const RowFunction& row) { run_->tick(row); }
void SteppedSimulation::extend(std::size_t arm, const PathPoint& point) { run_->extend(arm, point); }
SimulationResult SteppedSimulation::load(std::span<const std::byte> image) { return run_->load(image); }
std::uint64_t SteppedSimulation::mark(firmware::link::MarkKind kind, std::uint16_t value) {
  return run_->mark(kind, value);
}
bool SteppedSimulation::reaches(std::size_t arm, const Eigen::Vector3d& position_m) const {
  return run_->reaches(arm, position_m);
}
double SteppedSimulation::time_of(std::uint64_t tick) const noexcept { return run_->time_of(tick); }
const SimulationResult& SteppedSimulation::result() const noexcept { return run_->result(); }

}  // namespace thimble::board

#include "board/sim/scene_cost.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <memory>
#include <vector>

#include "control/contact/world.h"

namespace thimble::board {
namespace {

using control::kMaxArms;
using control::kMaxObjects;

// Bounds: walks of kWalkTicks ticks, until kMostTicks or kMostUnits are spent.
constexpr std::size_t kWalkTicks = 1000, kLeastWalks = 8, kMostTicks = 64'000;
constexpr std::uint64_t kMostUnits = 10'000'000;
constexpr float kReach_m = 0.15F;     // of an arm, from its home
constexpr float kSmall_m = 0.03F;     // about a volume, which has no box
constexpr float kBeside_m = 5.0e-3F;  // where a walk begins: outside of the box
constexpr float kGoal_s = 0.05F;      // until the hand turns to another place

// How a hand moves: it comes with kApproach_m a tick until it touches, then stays within depth_m of the god object, which slides over the
// surface behind it.
constexpr float kApproach_m = 4.0e-4F;
struct Manner {
  float speed_m_s;
  float depth_m;
  bool dart;  // through everything: for the worst, and no contact that one would miss
};
constexpr std::array<Manner, 4> kManners = {
    {{0.15F, 2.0e-3F, false}, {0.15F, 4.0e-3F, false}, {0.05F, 1.0e-3F, false}, {1.5F, 0.02F, true}}};
constexpr std::uint64_t kLeastBusy = 100;  // ticks of a walk that say something

struct Box {
  Vec3 lo_m;
  Vec3 hi_m;
};

// Vigna's splitmix64.
class Dice {
 public:
  [[nodiscard]] float between(float low, float high) noexcept {
    state_ += 0x9E3779B97F4A7C15ULL;
    std::uint64_t z = state_;
    z = (z ^ (z >> 30U)) * 0xBF58476D1CE4E5B9ULL;
    z = (z ^ (z >> 27U)) * 0x94D049BB133111EBULL;
    return low + (high - low) * (static_cast<float>((z ^ (z >> 31U)) >> 40U) * 0x1p-24F);
  }
  [[nodiscard]] Vec3 in(const Box& box) noexcept {
    Vec3 p;
    for (int axis = 0; axis < 3; ++axis) p[axis] = between(box.lo_m[axis], box.hi_m[axis]);
    return p;
  }

 private:
  std::uint64_t state_ = 1;
};

// Of the objects within reach, where the scene begins.
std::vector<Box> boxes_of(const control::SceneView& scene) {
  const auto world = std::make_unique<control::World>();
  world->bind(scene);
  std::vector<Box> boxes;
  const auto add = [&boxes](const Vec3& lo_m, const Vec3& hi_m) {
    const Vec3 reach = Vec3::Constant(kReach_m);
    const Box box{lo_m.cwiseMax(-reach), hi_m.cwiseMin(reach)};
    if ((box.lo_m.array() <= box.hi_m.array()).all()) boxes.push_back(box);
  };
  for (std::size_t i = 0; i < world->count; ++i) {
    const control::PlacedObject& object = world->objects[i];
    if (!object.half_space) {
      add(object.lo_m, object.hi_m);
      continue;
    }
    // About the place of the plane that is nearest to the home.
    const Vec3 middle = object.offset_m * object.normal;
    const Vec3 extent = 2.0F * kSmall_m * (Vec3::Ones() - object.normal.cwiseAbs());
    add(middle - extent, middle + extent);
  }
  for (const scene::Object* object : *scene.scene()->objects()) {
    if (!control::is_volume(object->shape_type())) continue;
    const scene::Vec3& at = object->pose()->position_m();
    const Vec3 middle(at.x(), at.y(), at.z());
    add(middle - Vec3::Constant(kSmall_m), middle + Vec3::Constant(kSmall_m));
  }
  return boxes;
}

class Walker {
 public:
  Walker(const control::SceneView& scene, const BoardCost& board, double rate_Hz, std::uint32_t work_units,
         std::size_t arms)
      : board_(board), period_s_(static_cast<float>(1.0 / rate_Hz)), arms_(std::min(arms, kMaxArms)) {
    renderer_->bind(scene);
    renderer_->bound_work(work_units);
    cost_.work_units = work_units;
    cost_.period = board.clock_Hz / rate_Hz;
  }

  SceneCost go(std::vector<Box> boxes) {
    if (boxes.empty()) boxes.push_back({Vec3::Constant(-kSmall_m), Vec3::Constant(kSmall_m)});
    const std::size_t walks = std::max(boxes.size(), kLeastWalks);
    const auto is_bounded = [this] { return ticks_ < kMostTicks && units_ < kMostUnits; };
    for (std::size_t n = 0; n < walks && is_bounded(); ++n)
      walk(boxes[n % boxes.size()], kManners[(n + n / boxes.size()) % kManners.size()], n % 2 == 0);
    const Sum& typical = touching_.ticks != 0 ? touching_ : all_;
    const auto ticks = static_cast<double>(std::max<std::uint64_t>(typical.ticks, 1));
    cost_.typical = {static_cast<std::uint32_t>(std::lround(static_cast<double>(typical.units) / ticks)),
                     typical.instructions / ticks};
    cost_.worst.instructions = board_.core.empty() ? 0.0 : BoardCost::worst(most_instructions_);
    cost_.put_off = static_cast<double>(put_off_) / static_cast<double>(std::max<std::uint64_t>(ticks_, 1));
    return cost_;
  }

 private:
  struct Sum {
    std::uint64_t ticks = 0;
    std::uint64_t units = 0;
    double instructions = 0;
  };

  // From the home, which may be within the object, or from beside it.
  void walk(const Box& box, const Manner& manner, bool from_home) {
    std::array<control::Tip, kMaxArms> tips;
    std::array<control::Touch, kMaxArms> touches;
    std::array<Vec3, kMaxArms> goals;
    for (std::size_t arm = 0; arm < arms_; ++arm) {
      renderer_->reset(arm);
      goals[arm] = dice_.in(box);
      Vec3& tip_m = tips[arm].position_m;
      if (from_home) continue;
      tip_m = goals[arm];
      tip_m.z() = box.hi_m.z() + kBeside_m;
    }
    std::array<std::uint32_t, kMaxObjects> put_off_at{};
    std::uint64_t busy = 0, put_off = 0;
    float step_m = kApproach_m;
    const auto turn = std::max(1UL, static_cast<std::size_t>(std::lround(kGoal_s / period_s_)));
    for (std::size_t i = 0; i < kWalkTicks; ++i) {
      for (std::size_t arm = 0; arm < arms_; ++arm) {
        if ((i + 1) % turn == 0) goals[arm] = dice_.in(box);
        move(tips[arm], goals[arm], touches[arm], manner.depth_m, step_m, i == 0);
      }
      renderer_->tick(std::span(tips).first(arms_), period_s_, std::span(touches).first(arms_));
      const bool touched = count(std::span(touches).first(arms_));
      if (touched) step_m = manner.speed_m_s * period_s_;
      if (!renderer_->is_put_off()) {
        busy += touched ? 1U : 0U;
        continue;
      }
      ++busy;
      ++put_off;
      ++put_off_;
      if (const std::uint8_t object = renderer_->counters().put_off_object; object < kMaxObjects)
        ++put_off_at[object];
    }
    if (manner.dart || busy < kLeastBusy || 2 * put_off <= busy || cost_.slow_object) return;
    cost_.slow_object = static_cast<std::size_t>(std::ranges::max_element(put_off_at) - put_off_at.begin());
  }

  void move(control::Tip& tip, const Vec3& goal_m, const control::Touch& touch, float depth_m, float step_m,
            bool first) const {
    const Vec3 before_m = tip.position_m;
    const Vec3 way_m = goal_m - before_m;
    const float length_m = way_m.norm();
    if (length_m > 0.0F) tip.position_m += std::min(1.0F, step_m / length_m) * way_m;
    if (!first) {
      const Vec3 in_m = tip.position_m - touch.god_object_m;
      const float deep_m = in_m.norm();
      if (touch.contacts != 0 && deep_m > depth_m)
        tip.position_m = touch.god_object_m + (depth_m / deep_m) * in_m;
    }
    tip.velocity_m_s = (tip.position_m - before_m) / period_s_;
  }

  // Of the last tick. Whether something was touched in it.
  bool count(std::span<const control::Touch> touches) {
    std::size_t touching = 0, contacts = 0;
    for (const control::Touch& touch : touches) {
      touching += touch.contacts != 0 ? 1U : 0U;
      contacts += touch.contacts;
    }
    const std::uint32_t units = renderer_->tick_work();
    const double instructions =
        board_.core.empty()
            ? 0.0
            : board_.of(terms_of(renderer_->load(), period_s_, touches.size(), touching, contacts));
    for (Sum* sum : {&all_, touching != 0 ? &touching_ : nullptr}) {
      if (sum == nullptr) continue;
      ++sum->ticks;
      sum->units += units;
      sum->instructions += instructions;
    }
    cost_.worst.units = std::max(cost_.worst.units, units);
    most_instructions_ = std::max(most_instructions_, instructions);
    ++ticks_;
    units_ += units;
    return touching != 0;
  }

  const BoardCost& board_;
  float period_s_;
  std::size_t arms_;
  std::unique_ptr<control::Renderer> renderer_ = std::make_unique<control::Renderer>();
  Dice dice_;
  SceneCost cost_;
  Sum all_, touching_;
  double most_instructions_ = 0;
  std::uint64_t ticks_ = 0, units_ = 0, put_off_ = 0;
};

// A scene image that is aligned and checked.
class CheckedScene {
 public:
  explicit CheckedScene(std::span<const std::byte> image) : aligned_((image.size() + 7) / 8) {
    if (!image.empty()) std::memcpy(aligned_.data(), image.data(), image.size());
    valid_ = control::SceneView::check(std::as_bytes(std::span(aligned_)).first(image.size()), view_) ==
             control::ImageStatus::kOk;
  }
  [[nodiscard]] bool has_objects() const { return valid_ && view_.scene()->objects()->size() != 0; }
  [[nodiscard]] SceneCost cost(const BoardCost& board, double rate_Hz, std::uint32_t work_units,
                               std::size_t arms) const {
    return Walker(view_, board, rate_Hz, work_units, arms).go(boxes_of(view_));
  }

 private:
  std::vector<std::uint64_t> aligned_;
  control::SceneView view_;
  bool valid_ = false;
};

}  // namespace

std::optional<SceneCost> scene_cost(std::span<const std::byte> image, const BoardCost& board, double rate_Hz,
                                    std::uint32_t work_units, std::size_t arms) {
  const CheckedScene scene(image);
  if (!scene.has_objects()) return std::nullopt;
  return scene.cost(board, rate_Hz, work_units, arms);
}

std::optional<double> highest_fitting_rate_Hz(std::span<const std::byte> image, const BoardCost& board,
                                              double below_Hz, std::size_t arms) {
  const CheckedScene scene(image);
  if (!scene.has_objects()) return std::nullopt;
  // Bisection: what fits at a rate fits at lower ones.
  int fits = 0;
  for (int not_fits = static_cast<int>(std::ceil(below_Hz / kRateStep_Hz)); not_fits - fits > 1;) {
    const int middle = fits + (not_fits - fits) / 2;
    const double rate_Hz = kRateStep_Hz * middle;
    (scene.cost(board, rate_Hz, board.work_units(rate_Hz, arms), arms).fits() ? fits : not_fits) = middle;
  }
  return fits == 0 ? std::nullopt : std::optional(kRateStep_Hz * fits);
}

}  // namespace thimble::board

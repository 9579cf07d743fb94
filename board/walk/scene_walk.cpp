#include "board/walk/scene_walk.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

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

class Hand {
 public:
  Hand(control::Renderer& renderer, float period_s, std::size_t arms)
      : renderer_(renderer), period_s_(period_s), arms_(arms) {}

  void go(std::vector<Box> boxes, const SceneWalk::Visitor& visitor) {
    if (boxes.empty()) boxes.push_back({Vec3::Constant(-kSmall_m), Vec3::Constant(kSmall_m)});
    const std::size_t walks = std::max(boxes.size(), kLeastWalks);
    const auto is_bounded = [this] { return ticks_ < kMostTicks && units_ < kMostUnits; };
    for (std::size_t n = 0; n < walks && is_bounded(); ++n) {
      const Manner& manner = kManners[(n + n / boxes.size()) % kManners.size()];
      walk(boxes[n % boxes.size()], manner, n % 2 == 0, visitor.tick);
      visitor.end_of_walk(manner.dart);
    }
  }

 private:
  // From the home, which may be within the object, or from beside it.
  void walk(const Box& box, const Manner& manner, bool from_home, const auto& tick) {
    std::array<control::Tip, kMaxArms> tips;
    std::array<control::Touch, kMaxArms> touches;
    std::array<Vec3, kMaxArms> goals;
    for (std::size_t arm = 0; arm < arms_; ++arm) {
      renderer_.reset(arm);
      goals[arm] = dice_.in(box);
      Vec3& tip_m = tips[arm].position_m;
      if (from_home) continue;
      tip_m = goals[arm];
      tip_m.z() = box.hi_m.z() + kBeside_m;
    }
    float step_m = kApproach_m;
    const auto turn = std::max(std::size_t{1}, static_cast<std::size_t>(std::lround(kGoal_s / period_s_)));
    for (std::size_t i = 0; i < kWalkTicks; ++i) {
      for (std::size_t arm = 0; arm < arms_; ++arm) {
        if ((i + 1) % turn == 0) goals[arm] = dice_.in(box);
        move(tips[arm], goals[arm], touches[arm], manner.depth_m, step_m, i == 0);
      }
      tick(std::span<const control::Tip>(tips).first(arms_), std::span(touches).first(arms_));
      ++ticks_;
      units_ += renderer_.tick_work();
      const auto touched = [](const control::Touch& touch) { return touch.contacts != 0; };
      if (std::ranges::any_of(std::span(touches).first(arms_), touched))
        step_m = manner.speed_m_s * period_s_;
    }
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

  control::Renderer& renderer_;
  float period_s_;
  std::size_t arms_;
  Dice dice_;
  std::uint64_t ticks_ = 0, units_ = 0;
};

}  // namespace

CheckedScene::CheckedScene(std::span<const std::byte> image) : aligned_((image.size() + 7) / 8) {
  if (!image.empty()) std::memcpy(aligned_.data(), image.data(), image.size());
  walkable_ = control::SceneView::check(std::as_bytes(std::span(aligned_)).first(image.size()), view_) ==
                  control::ImageStatus::kOk &&
              view_.scene()->objects()->size() != 0;
}

SceneWalk::SceneWalk(const control::SceneView& scene, float period_s, std::uint32_t work_units,
                     std::size_t arms)
    : scene_(scene), period_s_(period_s), work_units_(work_units), arms_(std::min(arms, kMaxArms)) {}

void SceneWalk::go(const Visitor& visitor) {
  renderer_->bind(scene_);
  renderer_->bound_work(work_units_);
  Hand(*renderer_, period_s_, arms_).go(boxes_of(scene_), visitor);
}

}  // namespace thimble::board

// A hand that walks over each solid of a scene and darts through it, to find out what the scene costs: the same steps on every machine.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "control/renderer.h"
#include "control/scene/scene_view.h"

namespace thimble::board {

// A scene image that is aligned and checked.
class CheckedScene {
 public:
  explicit CheckedScene(std::span<const std::byte> image);  // any alignment
  // Null where the image is not valid, and of a scene without objects.
  [[nodiscard]] const control::SceneView* view() const noexcept { return walkable_ ? &view_ : nullptr; }

 private:
  std::vector<std::uint64_t> aligned_;
  control::SceneView view_;
  bool walkable_ = false;
};

class SceneWalk {
 public:
  // scene: not null, CheckedScene::view(). work_units: Config::work_units.
  SceneWalk(const control::SceneView& scene, float period_s, std::uint32_t work_units, std::size_t arms);

  struct Visitor {
    // Calls renderer().tick() with these, once.
    std::function<void(std::span<const control::Tip> tips, std::span<control::Touch> touches)> tick;
    std::function<void(bool dart)> end_of_walk = [](bool) {};
  };
  // At most 64 000 ticks and 10 million units of work. The next one takes the same steps from the scene's beginning.
  void go(const Visitor& visitor);

  [[nodiscard]] control::Renderer& renderer() noexcept { return *renderer_; }
  [[nodiscard]] std::size_t arms() const noexcept { return arms_; }

 private:
  const control::SceneView& scene_;
  float period_s_;
  std::uint32_t work_units_;
  std::size_t arms_;
  std::unique_ptr<control::Renderer> renderer_ = std::make_unique<control::Renderer>();
};

}  // namespace thimble::board

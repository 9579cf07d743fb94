// What a scene does beside the fingertips in one tick, for a log: moving objects, tissues, and how often bounds were reached.
#pragma once

#include <span>

#include "control/renderer.h"

namespace thimble::board {

// Refers to the state of a renderer: valid until its next tick.
struct SceneRow {
  std::span<const control::BodyState> bodies;    // with their poses after the tick
  std::span<const control::TissueView> tissues;  // one for each volume and arm
  control::RenderCounters bounds;                // since the scene began
};

class SceneRowOf {
 public:
  [[nodiscard]] SceneRow operator()(const control::Renderer& renderer) noexcept {
    return {renderer.bodies(), std::span(tissues_).first(renderer.tissue_views(tissues_)),
            renderer.counters()};
  }

 private:
  control::TissueViews tissues_;
};

}  // namespace thimble::board

// Random motion of a fingertip in a scene that may be hostile.
#pragma once

#include <Eigen/Core>
#include <span>

#include "control/renderer.h"
#include "control/scene/scene_view.h"
#include "tests/support/random.h"

namespace thimble::test {

// Ticks at 4 kHz within 60 mm of the origin. False when a force or a place was not finite, or there were more contacts than can be.
inline bool stays_finite(const control::SceneView& view, Random& random, int ticks) {
  static control::Renderer renderer;
  renderer.bind(view);
  Eigen::Vector3d p(0.0, 0.0, 0.05);
  for (int tick = 0; tick < ticks; ++tick) {
    const Eigen::Vector3d before = p;
    p += (random.below(4) == 0 ? 5e-3 : 2e-4) * (0.06 * random.direction() - p).normalized();
    control::Tip tip;
    tip.position_m = p.cast<float>();
    tip.velocity_m_s = ((p - before) * 4000.0).cast<float>();
    control::Touch touch;
    renderer.tick(std::span(&tip, 1), 2.5e-4F, std::span(&touch, 1));
    if (!touch.force_N.allFinite() || !touch.god_object_m.allFinite() || touch.contacts > 3) return false;
  }
  return true;
}

}  // namespace thimble::test

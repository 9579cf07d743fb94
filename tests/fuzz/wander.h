// Random motion of a fingertip in a scene that may be hostile.
#pragma once

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <string>

#include "control/renderer.h"
#include "control/scene/scene_view.h"
#include "tests/fuzz/image.h"
#include "tests/support/figure.h"
#include "tests/support/random.h"

namespace thimble::test {

// 1000 ticks at 4 kHz within 60 mm of the origin. False when a force or a place was not finite, or there were
// more contacts than can be.
inline bool stays_finite(const control::SceneView& view, Random& random) {
  static control::Renderer renderer;
  renderer.bind(view);
  Eigen::Vector3d p(0.0, 0.0, 0.05);
  for (int tick = 0; tick < 1000; ++tick) {
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

// Spoils the image `mutants` times over: what is accepted is finite, wherever the tip goes.
inline void mutants_are_refused_or_lived_with(const std::string& what, const Bytes& image, int mutants,
                                              std::uint64_t seed) {
  Random random(seed);
  int accepted = 0;
  int not_finite = 0;
  for (int mutant = 0; mutant < mutants; ++mutant) {
    Bytes bytes = image;
    spoil(bytes, random);
    control::SceneView view;
    if (control::SceneView::check(bytes, view) != control::ImageStatus::kOk) continue;
    ++accepted;
    if (!stays_finite(view, random)) ++not_finite;
  }
  figure(what + ": mutants accepted, of " + std::to_string(mutants), accepted, "reported");
  figure(what + ": accepted mutants with a force that is not finite", not_finite, "0");
  EXPECT_GT(accepted, mutants / 20);
  EXPECT_EQ(not_finite, 0);
}

}  // namespace thimble::test

// Mutants of a scene image, and random motion in those that are accepted.
#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <string>

#include "control/scene/scene_view.h"
#include "tests/fuzz/finite.h"
#include "tests/fuzz/image.h"
#include "tests/support/figure.h"
#include "tests/support/random.h"

namespace thimble::test {

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
    if (!stays_finite(view, random, 1000)) ++not_finite;  // of 1000 ticks
  }
  figure(what + ": mutants accepted, of " + std::to_string(mutants), accepted, "reported");
  figure(what + ": accepted mutants with a force that is not finite", not_finite, "0");
  EXPECT_GT(accepted, mutants / 20);
  EXPECT_EQ(not_finite, 0);
}

}  // namespace thimble::test

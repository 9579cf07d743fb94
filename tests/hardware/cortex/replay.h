// Feeds a recorded run to a controller, as a board would: the same source on a PC and on bare metal. No heap.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "firmware/controller.h"
#include "tests/hardware/cortex/recording.h"

// Around Controller::tick: where the counting of instructions begins and ends.
extern "C" void tick_begin();
extern "C" void tick_end();
// Around those, not counted: where a board's image forbids and permits what a tick must not use.
extern "C" void before_tick();
extern "C" void after_tick();

namespace thimble::test {

enum class ReplayEnd : std::uint8_t { kDone = 0, kRefused = 1, kNotHomed = 2, kNotArmed = 3, kFaulted = 4 };

// The force of every arm, tick by tick: arms x 3 floats.
using ForceSink = void (*)(std::span<const float> force_N);

// `controller` is fresh and was made with config_of(recording).
[[nodiscard]] ReplayEnd replay(const Recording& recording, firmware::Controller& controller,
                               ForceSink sink) noexcept;
[[nodiscard]] firmware::Config config_of(const Recording& recording) noexcept;

}  // namespace thimble::test

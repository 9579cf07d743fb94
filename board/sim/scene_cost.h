// What a scene takes of a board's ticks, before it is on the board: a hand walks over each solid and darts through it, in the renderer that the
// boards run, with the work that the board gives to a tick. The same on every machine; no clock is read.
//
// An estimate (board/sim/tick_cost.h), of what this hand happens to meet: a scene that is accepted is safe whatever it says (docs/time.md).
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "board/sim/tick_cost.h"

namespace thimble::board {

struct SceneCost {
  struct Ticks {
    std::uint32_t units = 0;
    double instructions = 0;  // 0 where the board has no core of its own
  };
  Ticks typical;      // the mean of the ticks in which something is touched, or of all
  Ticks worst;        // units: the most of a tick; instructions: BoardCost::worst()
  double period = 0;  // instructions of a period; 0: not known
  std::uint32_t work_units = 0;
  double put_off = 0;  // the part of the ticks that put something off
  // What is put off in most of the ticks of some walk that touch or put off: its index in the scene.
  std::optional<std::size_t> slow_object;

  // Nothing is put off most of the time, and the worst tick ends within its period.
  [[nodiscard]] bool fits() const noexcept {
    return !slow_object && (period == 0 || worst.instructions <= period);
  }
};

// rate_Hz: above 0. work_units: Config::work_units. image: a scene image, any alignment. None where it is not valid, and of a scene without
// objects.
[[nodiscard]] std::optional<SceneCost> scene_cost(std::span<const std::byte> image, const BoardCost& board,
                                                  double rate_Hz, std::uint32_t work_units,
                                                  std::size_t arms = 1);

// The highest rate below `below_Hz` at which it fits, in steps of kRateStep_Hz. None: there is none.
inline constexpr double kRateStep_Hz = 250.0;
[[nodiscard]] std::optional<double> highest_fitting_rate_Hz(std::span<const std::byte> image,
                                                            const BoardCost& board, double below_Hz,
                                                            std::size_t arms = 1);

}  // namespace thimble::board

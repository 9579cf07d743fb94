// What a unit of rendering's work (control/work.h) takes on this computer. It only proposes a value for /work_units of the board's
// configuration (docs/board-linux.md): what a tick may do must not depend on a clock.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>

namespace thimble::board {

struct WorkMeasure {
  double unit_ns = 0;            // the most, in the ticks that spend at least half of most_units
  double worst_tick_ns = 0;      // of rendering
  std::uint32_t most_units = 0;  // of a tick
};

// Walks over the scene a few times; of each tick the shortest time counts, so that what interrupts the program does not. work_units: of a
// tick. now_ns: a monotonic clock. None where the image is not valid, and of a scene without objects.
[[nodiscard]] std::optional<WorkMeasure> measure_work(std::span<const std::byte> image, double rate_Hz,
                                                      std::uint32_t work_units, std::size_t arms,
                                                      const std::function<std::uint64_t()>& now_ns);

// Fewer units say nothing of a unit: most of such a tick is something else.
inline constexpr std::uint32_t kTellingUnits = 50;

// What takes a quarter of a period, as on the bare-metal boards (board/common/work_units.h), and no less than each arm needs.
[[nodiscard]] std::uint32_t proposed_work_units(double unit_ns, double rate_Hz, std::size_t arms) noexcept;

}  // namespace thimble::board

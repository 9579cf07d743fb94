#include "board/linux/measure_work.h"

#include <algorithm>
#include <limits>
#include <vector>

#include "board/linux/board_config.h"
#include "board/walk/scene_walk.h"
#include "firmware/core/config.h"

namespace thimble::board {
namespace {

constexpr int kPasses = 5;

struct Tick {
  std::uint64_t ns = std::numeric_limits<std::uint64_t>::max();
  std::uint32_t units = 0;
};

}  // namespace

std::optional<WorkMeasure> measure_work(std::span<const std::byte> image, double rate_Hz,
                                        std::uint32_t work_units, std::size_t arms,
                                        const std::function<std::uint64_t()>& now_ns) {
  const CheckedScene scene(image);
  if (scene.view() == nullptr) return std::nullopt;
  const auto period_s = static_cast<float>(1.0 / rate_Hz);
  SceneWalk walk(*scene.view(), period_s, work_units, arms);
  std::vector<Tick> ticks;
  for (int pass = 0; pass < kPasses; ++pass) {
    std::size_t i = 0;
    walk.go({.tick = [&](std::span<const control::Tip> tips, std::span<control::Touch> touches) {
      const std::uint64_t begin_ns = now_ns();
      walk.renderer().tick(tips, period_s, touches);
      const std::uint64_t end_ns = now_ns();
      if (pass == 0) ticks.emplace_back();
      Tick& tick = ticks[i++];
      tick.ns = std::min(tick.ns, end_ns - begin_ns);
      tick.units = walk.renderer().tick_work();
    }});
  }
  WorkMeasure measure;
  for (const Tick& tick : ticks) {
    measure.most_units = std::max(measure.most_units, tick.units);
    measure.worst_tick_ns = std::max(measure.worst_tick_ns, static_cast<double>(tick.ns));
  }
  for (const Tick& tick : ticks) {
    if (tick.units == 0 || 2 * tick.units < measure.most_units) continue;
    measure.unit_ns = std::max(measure.unit_ns, static_cast<double>(tick.ns) / tick.units);
  }
  return measure;
}

std::uint32_t proposed_work_units(double unit_ns, double rate_Hz, std::size_t arms) noexcept {
  const double units = 0.25e9 / rate_Hz / std::max(unit_ns, 1.0);
  return std::max(static_cast<std::uint32_t>(std::min(units, static_cast<double>(kMostWorkUnits))),
                  firmware::kLeastWork * static_cast<std::uint32_t>(arms));
}

}  // namespace thimble::board

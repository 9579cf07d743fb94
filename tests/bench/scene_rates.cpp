#include "tests/bench/scene_rates.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "board/sim/scene_cost.h"
#include "tests/bench/scene_path.h"

namespace thimble::test {
namespace {

// Cycles an instruction, caches and memory included: assumptions, to be measured on a board. A quarter of the instructions of control/ are
// floating-point arithmetic, one in 80 a division or a root (docs/bench.md has the command).
//
// Cortex-M7: it does 5.01 CoreMark/MHz and a Cortex-M4 3.40, which issues one instruction a cycle and takes 1.2 cycles for one. So 0.8 cycles,
// and 0.15 for divisions and roots of 14 cycles; with the tick's code and data in TCM or in warm caches. A third more for those that are not.
constexpr double kCyclesM7 = 1.25;
// Cortex-R5F: 1.67 DMIPS/MHz beside 2.14 of the Cortex-M7. The tick is in TCM, the scene is not.
constexpr double kCyclesR5F = 1.6;
// Cortex-A8: 2.0 DMIPS/MHz, but its VFP is not pipelined: 10 cycles for an addition or a multiplication. A quarter of 10, three quarters of 0.8,
// and 0.4 for divisions, roots and misses of the cache.
constexpr double kCyclesA8 = 3.5;

struct CoreOfATable {
  std::string_view name, title;
  std::string_view board;  // whose instructions are counted
  double clock_Hz, cycles;
};
constexpr std::array<CoreOfATable, 4> kCores = {{
    {"m7-480", "M7, 480 MHz", "mps2-an500", 480e6, kCyclesM7},
    {"m7-600", "M7, 600 MHz", "mps2-an500", 600e6, kCyclesM7},
    {"r5f-500", "R5F, 500 MHz", "zynqmp", 500e6, kCyclesR5F},
    {"a8-1000", "A8, 1 GHz", "zynqmp", 1e9, kCyclesA8},
}};
constexpr std::array<double, 9> kRates_Hz = {20e3, 16e3, 12e3, 10e3, 8e3, 6e3, 4e3, 2e3, 1e3};
constexpr double kShown_Hz = 4000;  // of the columns of instructions

// The costs of one scene, each found once.
class Costs {
 public:
  explicit Costs(const ScenePath& scene) : scene_(scene) {}

  const board::SceneCost& at(std::string_view board, double rate_Hz) {
    const auto [place, is_new] = found_.try_emplace({board, rate_Hz});
    if (is_new) {
      const board::BoardCost& cost = *board::find_board_cost(board);
      place->second = board::scene_cost(scene_.image.bytes(), cost, rate_Hz,
                                        cost.work_units(rate_Hz, scene_.arms), scene_.arms)
                          .value();
    }
    return place->second;
  }

 private:
  const ScenePath& scene_;
  std::map<std::pair<std::string_view, double>, board::SceneCost> found_;
};

// The highest rate that fits, in kHz, with a star where the next one would put off too much, and a dash where none fits.
std::string highest(Costs& costs, const CoreOfATable& core) {
  bool lags = false;
  for (const double rate_Hz : kRates_Hz) {
    const board::SceneCost& cost = costs.at(core.board, rate_Hz);
    const bool in_time = core.cycles * cost.worst.instructions * rate_Hz <= core.clock_Hz;
    if (in_time && !cost.slow_object) return fmt::format("{:.0f}{}", 1e-3 * rate_Hz, lags ? " *" : "");
    lags = in_time;
  }
  return "-";
}

// Two digits: a table that a small change of the code does not change.
std::string two_digits(double number) {
  const double unit = std::pow(10.0, std::floor(std::log10(number)) - 1);
  return fmt::format("{:.0f}", std::round(number / unit) * unit);
}

}  // namespace

std::string scene_rates(std::string_view core) {
  std::vector<CoreOfATable> cores;
  std::vector<std::string_view> boards;
  for (const CoreOfATable& one : kCores) {
    if (core != "all" && core != one.name) continue;
    cores.push_back(one);
    if (std::ranges::find(boards, one.board) == boards.end()) boards.push_back(one.board);
  }
  if (cores.empty()) return {};
  std::string table = "| scene | arms |", line = "|---|---|";
  for (const std::string_view board : boards) {
    table += fmt::format(" {0}: mean | {0}: worst |", board::find_board_cost(board)->core);
    line += "---|---|";
  }
  for (const CoreOfATable& one : cores) {
    table += fmt::format(" {}: kHz |", one.title);
    line += "---|";
  }
  table += fmt::format("\n{}", line);
  for (const auto& [name, file] : demonstrations()) {
    const ScenePath scene = scene_path(file);
    Costs costs(scene);
    table += fmt::format("\n| {} | {} |", name, scene.arms);
    for (const std::string_view board : boards) {
      const board::SceneCost& cost = costs.at(board, kShown_Hz);
      table += fmt::format(" {} | {} |", two_digits(cost.typical.instructions),
                           two_digits(cost.worst.instructions));
    }
    for (const CoreOfATable& one : cores) table += fmt::format(" {} |", highest(costs, one));
  }
  return table;
}

std::string core_names() {
  std::string names;
  for (const CoreOfATable& core : kCores) names += fmt::format("{}{}", names.empty() ? "" : ", ", core.name);
  return names;
}

}  // namespace thimble::test

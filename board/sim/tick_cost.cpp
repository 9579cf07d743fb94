#include "board/sim/tick_cost.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "board/common/work_units.h"
#include "firmware/core/config.h"
#include "kinematics/velocity.h"

namespace thimble::board {
namespace {

// From tests/hardware/cortex/fit_cost.
constexpr std::array<BoardCost, 4> kBoards = {{
    {"mps2-an500", "Cortex-M7", 480.0e6, {4949, 3797, -3024, 3279, 1650, 104, 96, 882, 69, 61, 46}},
    {"zynqmp", "Cortex-R5F", 500.0e6, {5305, 4080, -2510, 2801, 1534, 111, 114, 720, 70, 39, 48}},
    {"linux", "", 0.0, {}},
    {"sim", "", 0.0, {}},
}};
constexpr double kWorstFactor = 1.5;
constexpr double kRecord = 6700.0;  // of a tick that publishes a record of telemetry

}  // namespace

TickTerms terms_of(const control::Renderer::Load& load, float period_s, std::size_t arms,
                   std::size_t touching, std::size_t contacts) noexcept {
  using kinematics::VelocityEstimator;
  const auto arm_count = static_cast<double>(arms);
  const auto readings = static_cast<double>(std::min(std::round(VelocityEstimator::kMaxWindow_s / period_s),
                                                     static_cast<float>(VelocityEstimator::kMaxWindow)));
  return {{1.0, arm_count - 1.0, static_cast<double>(touching), static_cast<double>(contacts),
           load.shaded ? static_cast<double>(touching) : 0.0, static_cast<double>(load.finger_units),
           static_cast<double>(load.body_units), static_cast<double>(load.awake),
           arm_count * static_cast<double>(load.solids), arm_count * static_cast<double>(load.volumes),
           arm_count * readings}};
}

double BoardCost::of(const TickTerms& terms) const noexcept {
  return std::inner_product(terms.of.begin(), terms.of.end(), instructions.begin(), 0.0);
}

double BoardCost::worst(double most) noexcept { return kRecord + kWorstFactor * most; }

std::uint32_t BoardCost::work_units(double rate_Hz, std::size_t arms) const noexcept {
  return core.empty()
             ? firmware::Config{}.work_units
             : board::work_units(static_cast<float>(1.0 / rate_Hz), static_cast<std::uint32_t>(arms));
}

std::span<const BoardCost> board_costs() noexcept { return kBoards; }

const BoardCost* find_board_cost(std::string_view name) noexcept {
  const auto found = std::ranges::find(kBoards, name, &BoardCost::name);
  return found == kBoards.end() ? nullptr : &*found;
}

}  // namespace thimble::board

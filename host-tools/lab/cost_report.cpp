#include "host-tools/lab/cost_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <vector>

#include "control/scene/scene_view.h"
#include "thimble_scene_schema/scene_generated.h"

namespace thimble::host {
namespace {

// "21 000" with two digits.
std::string rounded(double number, int digits = 2) {
  const double unit =
      std::max(1.0, std::pow(10.0, std::floor(std::log10(std::max(number, 1.0))) + 1 - digits));
  std::string text = fmt::format("{:.0f}", std::round(number / unit) * unit);
  for (std::size_t at = text.size(); at > 3;) text.insert(at -= 3, 1, ' ');
  return text;
}

std::string percent(double part) {
  if (part == 0) return "no tick puts anything off";
  if (part < 0.001) return "fewer than 0.1 % of ticks put something off";
  return fmt::format("{:.{}f} % of ticks put something off", 100 * part, part < 0.1 ? 1 : 0);
}

// Of a valid image.
std::string object_name(std::span<const std::byte> image, std::size_t index) {
  std::vector<std::uint64_t> aligned((image.size() + 7) / 8);
  std::memcpy(aligned.data(), image.data(), image.size());
  control::SceneView view;
  const auto verdict = control::SceneView::check(std::as_bytes(std::span(aligned)).first(image.size()), view);
  if (verdict != control::ImageStatus::kOk || index >= view.scene()->objects()->size()) return "the scene";
  return view.scene()->objects()->Get(static_cast<flatbuffers::uoffset_t>(index))->name()->str();
}

std::string warning_of(std::span<const std::byte> image, const board::SceneCost& cost,
                       const std::string& where, double fits_Hz) {
  const std::string remedy =
      fits_Hz > 0 ? fmt::format("lower the rate to {:.0f} Hz, or simplify it", fits_Hz) : "simplify it";
  if (cost.slow_object)
    return fmt::format(
        "{}: most ticks of a contact put something off {}, so forces or moving objects lag; {}",
        object_name(image, *cost.slow_object), where, remedy);
  return fmt::format("the worst tick takes up to {} instructions, longer than a period {}; {}",
                     rounded(cost.worst.instructions), where, remedy);
}

}  // namespace

CostReport cost_report(std::span<const std::byte> image, const board::BoardCost& board, double rate_Hz,
                       std::uint32_t work_units, std::size_t arms) {
  const std::uint32_t units = work_units == 0 ? board.work_units(rate_Hz, arms) : work_units;
  const std::optional<board::SceneCost> found = board::scene_cost(image, board, rate_Hz, units, arms);
  if (!found) return {};
  const board::SceneCost& cost = *found;
  CostReport report{
      .board = std::string(board.name), .rate_Hz = rate_Hz, .cost = cost, .text = {}, .warning = {}};
  const std::string where = fmt::format("at {:.0f} Hz on {}", rate_Hz, board.name);
  if (board.core.empty())
    report.text =
        fmt::format("cost {}: typical {}, worst {} of {} units; {}", where, rounded(cost.typical.units),
                    rounded(cost.worst.units), units, percent(cost.put_off));
  else
    report.text = fmt::format("cost {}: typical {}, worst {} of {} instructions; {}", where,
                              rounded(cost.typical.instructions), rounded(cost.worst.instructions),
                              rounded(cost.period, 3), percent(cost.put_off));
  if (cost.fits()) return report;
  // Where the units do not depend on the rate, no rate helps.
  if (!board.core.empty())
    report.fits_Hz = board::highest_fitting_rate_Hz(image, board, rate_Hz, arms).value_or(0);
  report.warning = warning_of(image, cost, where, report.fits_Hz);
  return report;
}

std::string board_names() {
  std::string names;
  for (const board::BoardCost& board : board::board_costs())
    names += (names.empty() ? "" : ", ") + std::string(board.name);
  return names;
}

}  // namespace thimble::host

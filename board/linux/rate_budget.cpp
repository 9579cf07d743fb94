#include "board/linux/rate_budget.h"

#include <algorithm>
#include <array>
#include <cstdio>

#include "board/linux/drives/bus_time.h"

namespace thimble::board {
namespace {

constexpr double kFrameBits = 24;        // of an AD5754
constexpr double kRenderingShare = .25;  // that --measure proposes work_units for

struct Load {
  std::string interface;
  double time_us = 0;
};

// At the usual bit rates; the search for drives takes those of the interface.
Load most_loaded_bus(const BoardConfig& config) {
  std::vector<Load> loads;
  for (const ArmWiring& arm : config.arms)
    for (const auto& drive : arm.drives) {
      if (!drive) continue;
      auto at = std::ranges::find(loads, drive->interface, &Load::interface);
      if (at == loads.end()) at = loads.insert(loads.end(), {drive->interface, 0});
      at->time_us += static_cast<double>(exchange_time_us(exchange_of(drive->config)));
    }
  const auto most = std::ranges::max_element(loads, {}, &Load::time_us);
  return most == loads.end() ? Load{} : *most;
}

std::string row(double time_us, double period_us, const char* what) {
  std::array<char, 160> text{};
  std::snprintf(text.data(), text.size(), "  %6.0f us %3.0f %%  %s", time_us, 100 * time_us / period_us,
                what);
  return text.data();
}

}  // namespace

RateBudget rate_budget(const BoardConfig& config, double read_us, std::optional<double> unit_ns) {
  RateBudget budget;
  budget.period_us = 1e6 / config.rate_Hz;
  budget.read_us = read_us;
  budget.measured = unit_ns.has_value();
  budget.rendering_us = unit_ns ? config.work_units * *unit_ns * 1e-3 : kRenderingShare * budget.period_us;
  for (const ArmWiring& arm : config.arms)
    if (arm.dac) {
      const auto outputs =
          std::ranges::count_if(arm.dac->channels, [](const auto& one) { return one.has_value(); });
      budget.spi_us += static_cast<double>(outputs + 1) * kFrameBits / arm.dac->speed_Hz * 1e6;
    }
  const Load bus = most_loaded_bus(config);
  budget.bus = bus.interface;
  budget.bus_us = bus.time_us;
  return budget;
}

std::vector<std::string> RateBudget::lines() const {
  std::array<char, 160> head{};
  std::snprintf(head.data(), head.size(), "a tick of %.0f us takes at most:", period_us);
  std::vector<std::string> all = {head.data(), row(read_us, period_us, "encoders and lines, measured now"),
                                  row(rendering_us, period_us,
                                      measured ? "rendering, work_units with the unit measured now"
                                               : "rendering, if work_units is what --measure proposes")};
  if (spi_us > 0) all.push_back(row(spi_us, period_us, "converters, on the wire of SPI"));
  if (bus_us > 0) all.push_back(row(bus_us, period_us, ("commands and replies on " + bus).c_str()));
  all.push_back(
      row(sum_us(), period_us,
          sum_us() <= period_us ? "in all" : "in all, which does not fit: lower the rate or work_units"));
  return all;
}

}  // namespace thimble::board

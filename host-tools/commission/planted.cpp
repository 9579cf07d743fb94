#include "host-tools/commission/planted.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

#include "host-tools/error.h"

namespace thimble::host {
namespace {

using enum ArmFault;

constexpr std::array kPlanted{PlantedFault{kLineIgnored},
                              PlantedFault{kNoise},
                              PlantedFault{kEncoderSign},
                              PlantedFault{kMotorSign, true},
                              PlantedFault{kEncodersSwapped, false, true},
                              PlantedFault{kMotorsSwapped, true, true},
                              PlantedFault{kJointsSwapped, true, true},
                              PlantedFault{kWrongCounts, false, false, 4, .05, 20},
                              PlantedFault{kWrongRatio, true, false, 1.2, .2, 5},
                              PlantedFault{kDeadChannel},
                              PlantedFault{kDeadEncoder},
                              PlantedFault{kSlip, false, false, 2, .1, 10},
                              PlantedFault{kIndexOff, false, false, 1, -3, 3},
                              PlantedFault{kOpenWinding, true},
                              PlantedFault{kDeadPhase, true},
                              PlantedFault{kWeakMotor, true, false, .577, .1, 3},
                              PlantedFault{kWrongInertia, true, false, 2, .3, 5},
                              PlantedFault{kWrongResistance, true, false, 2, .1, 10}};

[[noreturn]] void refuse(const char* name, const std::string& cause, const std::string& remedy) {
  throw Error(ExitCode::kUsage, name, "--fault " + cause, remedy);
}

const PlantedFault& planted_named(const std::string& name) {
  for (const PlantedFault& planted : kPlanted)
    if (text_of(planted.fault).name == name) return planted;
  std::string all;
  for (const PlantedFault& planted : kPlanted) {
    if (!all.empty()) all += ", ";
    all += text_of(planted.fault).name;
  }
  refuse("unknown-fault", fmt::format("{}: this is no fault that can be planted", name),
         "give one of " + all);
}

std::optional<std::size_t> axis_named(const ArmFile& arm, const std::string& name) {
  const auto found = std::ranges::find(arm.axes, name, &ArmAxis::name);
  if (found == arm.axes.end()) return std::nullopt;
  return static_cast<std::size_t>(found - arm.axes.begin());
}

std::size_t demand_axis(const ArmFile& arm, const std::string& name, const PlantedFault& planted,
                        const std::string& text) {
  const std::optional<std::size_t> axis = axis_named(arm, name);
  if (!axis) {
    std::string all;
    for (const ArmAxis& one : arm.axes) {
      if (!all.empty()) all += ", ";
      all += one.name;
    }
    refuse("unknown-axis", fmt::format("{}: the arm has no axis '{}'", text, name), "give one of " + all);
  }
  if (planted.of_motor && !arm.axes[*axis].drive)
    refuse("bad-fault", fmt::format("{}: axis '{}' has no motor", text, name), "give an axis that is driven");
  return *axis;
}

double factor_of(const std::string& word, const PlantedFault& planted, const std::string& text) {
  double factor = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), factor);
  const bool is_number = error == std::errc() && end == word.data() + word.size() && std::isfinite(factor);
  const bool whole = planted.fault != kIndexOff || (factor == std::round(factor) && factor != 0);
  const bool changes = factor != 1 || planted.fault == kIndexOff || planted.fault == kSlip;
  if (planted.factor == 0 || !is_number || !whole || !changes || factor < planted.least ||
      factor > planted.most)
    refuse("bad-fault", fmt::format("{}: '{}' is no factor of this fault", text, word),
           planted.factor == 0 ? "leave it away: the fault takes none"
           : planted.fault == kIndexOff
               ? "give whole turns of the encoder, -3 to 3 and not 0"
               : fmt::format("give a number from {} to {}, not 1", planted.least, planted.most));
  return factor;
}

}  // namespace

std::span<const PlantedFault> planted_faults() noexcept { return kPlanted; }

SimFault planted_fault(const std::string& text, const ArmFile& arm) {
  const std::size_t at = text.find('@');
  const PlantedFault planted = planted_named(text.substr(0, at));
  SimFault fault;
  fault.fault = planted.fault;
  if (planted.factor != 0) fault.factor = planted.factor;
  if (planted.fault == kLineIgnored) {
    if (at != std::string::npos)
      refuse("bad-fault", text + ": the lines are those of the whole arm", "give it without an axis");
    return fault;
  }
  if (at == std::string::npos)
    refuse("bad-fault", text + ": an axis is missing",
           fmt::format("give it as {}@{}", text, planted.exchanges ? "AXIS,AXIS" : "AXIS"));
  std::string axes = text.substr(at + 1);
  const std::size_t colon = axes.rfind(':');
  if (colon != std::string::npos && !axis_named(arm, axes)) {
    fault.factor = factor_of(axes.substr(colon + 1), planted, text);
    axes.resize(colon);
  }
  const std::size_t comma = planted.exchanges ? axes.find(',') : std::string::npos;
  if (planted.exchanges && comma == std::string::npos)
    refuse("bad-fault", text + ": it exchanges two axes", "give both, with a comma between them");
  fault.axis = demand_axis(arm, axes.substr(0, comma), planted, text);
  fault.other = planted.exchanges ? demand_axis(arm, axes.substr(comma + 1), planted, text) : fault.axis;
  if (planted.exchanges && fault.other == fault.axis)
    refuse("bad-fault", text + ": an axis is exchanged with itself", "give two axes");
  return fault;
}

std::optional<std::size_t> fault_behind(std::span<const SimFault> faults, const ArmFinding& found) {
  const auto is_at = [&](int axis, const SimFault& fault) {
    return axis == static_cast<int>(fault.axis) || axis == static_cast<int>(fault.other);
  };
  for (std::size_t i = 0; i < faults.size(); ++i) {
    const SimFault& fault = faults[i];
    if (found.fault != kLineIgnored && !is_at(found.axis, fault) && !is_at(found.other, fault)) continue;
    if (found.fault == fault.fault || std::ranges::find(found.twins, fault.fault) != found.twins.end())
      return i;
  }
  return std::nullopt;
}

}  // namespace thimble::host

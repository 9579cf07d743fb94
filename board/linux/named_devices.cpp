#include "board/linux/named_devices.h"

#include <algorithm>
#include <string>
#include <system_error>
#include <vector>

#include "board/linux/counter_encoder.h"
#include "board/linux/gpio.h"

namespace thimble::board {
namespace {

namespace fs = std::filesystem;

std::vector<std::string> named_lines(const BoardConfig& config) {
  std::vector<std::string> names = {config.e_stop.name};
  const auto add = [&names](const std::optional<GpioLine>& line) {
    if (line) names.push_back(line->name);
  };
  add(config.dead_man);
  add(config.event);
  if (config.heartbeat) add(config.heartbeat->line);
  for (const ArmWiring& arm : config.arms) {
    add(arm.enable);
    add(arm.drive_fault);
    add(arm.index);
    if (!arm.encoders) continue;
    for (const auto& joint : arm.encoders->lines) names.insert(names.end(), joint.begin(), joint.end());
  }
  return names;
}

std::vector<fs::path> named_files(const BoardConfig& config) {
  std::vector<fs::path> files;
  if (config.watchdog) files.push_back(*config.watchdog);
  for (const LinkConfig& link : config.links)
    if (link.kind == LinkConfig::Kind::kTty) files.emplace_back(link.device);
  for (const ArmWiring& arm : config.arms) {
    if (arm.dac) files.emplace_back(arm.dac->device);
    if (!arm.encoders) continue;
    for (const CounterPlace& joint : arm.encoders->counter) {
      if (joint.device.empty()) continue;  // at GPIO lines, or in its drive
      try {
        files.push_back("/dev" / find_counter(joint.device).filename());
      } catch (const std::system_error&) {  // its driver is not loaded
      }
    }
  }
  return files;
}

}  // namespace

bool names_device(const BoardConfig& config, const fs::path& device) {
  if (device.filename().string().starts_with("gpiochip"))
    return std::ranges::any_of(named_lines(config), [&](const std::string& line) {
      return !line.empty() && gpio_chip_has_line(device, line);
    });
  const fs::path node = fs::weakly_canonical(device);  // a configuration may name a link to it
  return std::ranges::any_of(named_files(config),
                             [&](const fs::path& file) { return fs::weakly_canonical(file) == node; });
}

}  // namespace thimble::board

#include "board/linux/check_board.h"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <iostream>
#include <span>
#include <sstream>
#include <stdexcept>
#include <system_error>

#include "board/common/stop_path.h"
#include "board/files/text_file.h"
#include "board/linux/clock.h"
#include "board/linux/devices.h"
#include "board/linux/measure_work.h"
#include "board/linux/rate_budget.h"
#include "board/linux/realtime.h"
#include "board/posix/can_port.h"
#include "board/posix/tty_port.h"
#include "firmware/core/stop_timeout.h"

namespace thimble::board {
namespace {

// The median of what reading encoders and lines takes; a system call that is late once does not count.
double reading_us(Devices& devices, double rate_Hz) {
  constexpr std::size_t kTimes = 101;
  std::vector<double> times_us;
  times_us.reserve(kTimes);
  firmware::Inputs in;
  const auto period_ns = static_cast<std::uint64_t>(1e9 / rate_Hz);
  for (std::size_t i = 0; i < kTimes; ++i) {
    in.tick = i;
    const std::uint64_t begin_ns = monotonic_ns();
    devices.read(in, begin_ns, period_ns);
    times_us.push_back(static_cast<double>(monotonic_ns() - begin_ns) * 1e-3);
  }
  std::nth_element(times_us.begin(), times_us.begin() + kTimes / 2, times_us.end());
  return times_us[kTimes / 2];
}

// Of the scenes that are given with --check, the longest unit.
std::optional<double> longest_unit_ns(const BoardConfig& config, const std::vector<std::string>& files) {
  std::optional<double> unit_ns;
  for (const std::string& file : files) {
    const std::string image = read_text(file);
    const auto found = measure_work(std::as_bytes(std::span(image)), config.rate_Hz, config.work_units,
                                    config.arms.size(), monotonic_ns);
    if (found && found->most_units >= kTellingUnits) unit_ns = std::max(unit_ns.value_or(0), found->unit_ns);
  }
  return unit_ns;
}

// What is not missing: the drives, what a tick takes, and what the kernel has.
void tell(const BoardConfig& config, Devices& devices, const std::vector<std::string>& scenes) {
  for (const std::string& line : devices.report()) std::cout << line << '\n';
  const std::optional<double> unit_ns = longest_unit_ns(config, scenes);
  for (const std::string& line : rate_budget(config, reading_us(devices, config.rate_Hz), unit_ns).lines())
    std::cout << line << '\n';
  const KernelLatency latency;
  for (const std::string& line : latency.report()) std::cout << line << '\n';
}

}  // namespace

Missing no_watchdog(const BoardConfig& config, int error) {
  if (!config.watchdog)
    return {"no_watchdog", "no watchdog is configured",
            "add \"watchdog\": { \"device\": \"/dev/watchdog\", \"timeout_s\": 2 } to the configuration",
            error};
  const char* remedy = error == EBUSY ? "end the program that feeds it (systemd: RuntimeWatchdogSec=off)"
                                      : "load its driver, or install the udev rule and run as its group";
  return {"no_watchdog", config.watchdog->string() + ": " + std::strerror(error), remedy, error};
}

std::optional<Missing> too_late(const BoardConfig& config, SlotFiles& store) {
  const std::uint32_t lost_ticks = saved_lost_ticks(store);
  const auto wanted_us =
      firmware::stop_timeout_us(static_cast<std::uint32_t>(1e9 / config.rate_Hz), lost_ticks);
  if (wanted_us && (!config.heartbeat || *wanted_us <= config.heartbeat->timeout_us)) return std::nullopt;
  std::ostringstream what;
  what << "lost_ticks " << lost_ticks << " at " << config.rate_Hz << " Hz asks the stop path for "
       << 1e3 * (lost_ticks + 1) / config.rate_Hz << " ms, ";
  if (wanted_us) {
    what << "the heartbeat's one-shot ends after " << config.heartbeat->timeout_us * 1e-3 << " ms";
    return Missing{"heartbeat_too_short", what.str(),
                   "lower lost_ticks (thimble param set, param save) and restart, or fit a longer one-shot",
                   EINVAL};
  }
  what << "allowed are " << firmware::kLongestStop_us / 1000 << " ms";
  return Missing{firmware::kLacksShortStop, what.str(),
                 "lower lost_ticks (thimble param set, param save) and restart", EINVAL};
}

std::unique_ptr<Port> open_port(const LinkConfig& link, std::uint8_t node) {
  switch (link.kind) {
    case LinkConfig::Kind::kCan:
      return std::make_unique<CanPort>(link.device, node);
    case LinkConfig::Kind::kTty:
      return std::make_unique<TtyPort>(link.device);
  }
  return nullptr;
}

int check_board(const BoardConfig& config, const std::vector<std::string>& scenes) {
  const ServoBeat::Shared beat = ServoBeat::make();
  Devices devices(config, *beat);
  std::vector<Missing> missing = devices.missing();
  if (const std::optional<Missing> memory = lock_memory()) missing.push_back(*memory);
  add(missing, try_realtime(config.priority + 1, config.cpu));  // the guardian's, above the servo's
  try {
    SlotFiles store(config.store, kSceneSlotBytes, SlotFiles::Access::kLook);
    if (const std::optional<Missing> late = too_late(config, store)) missing.push_back(*late);
  } catch (const std::system_error& error) {
    const int code = error.code().value();
    missing.push_back({"no_store", error.what(), remedy_for_store(config.store, code), code});
  }
  for (const LinkConfig& link : config.links) {
    try {
      (void)open_port(link, config.node);
    } catch (const std::system_error& error) {
      missing.push_back(
          {"no_link", error.what(), "or correct /links in the configuration", error.code().value()});
    } catch (const std::runtime_error& error) {
      missing.push_back({"no_link", error.what(), "or correct /links in the configuration", ENODEV});
    }
  }
  // The watchdog is not opened, because that would start it.
  if (!config.watchdog) {
    missing.push_back(no_watchdog(config, ENOENT));
  } else if (access(config.watchdog->c_str(), W_OK) != 0) {
    missing.push_back(no_watchdog(config, errno));
  }
  tell(config, devices, scenes);
  for (const Missing& one : missing) std::cout << "missing: " << describe(one) << '\n';
  if (missing.empty()) {
    std::cout << "nothing is missing\n";
    return 0;
  }
  const bool forbidden =
      std::any_of(missing.begin(), missing.end(), [](const Missing& one) { return one.forbidden(); });
  return forbidden ? kCheckForbidden : kCheckMissing;
}

}  // namespace thimble::board

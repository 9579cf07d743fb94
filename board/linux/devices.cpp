#include "board/linux/devices.h"

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <string>
#include <system_error>
#include <thread>

#include "board/linux/clock.h"
#include "board/linux/gpio_encoder.h"

namespace thimble::board {
namespace {

constexpr std::size_t kEStopLine = 0;  // index among the inputs

std::uint32_t settle_ticks(const BoardConfig& config) {
  return static_cast<std::uint32_t>(std::ceil(config.settle_s * config.rate_Hz));
}

std::string remedy_for(int error) {
  switch (error) {
    case EACCES:
    case EPERM:
      return "install the udev rule and run as its group, or as root";
    case EBUSY:
      return "end the program that uses it (gpioinfo shows the lines' holders)";
    case ENOENT:
    case ENODEV:
    case ENXIO:
      return "load its driver, or correct the configuration";
    default:
      return "see the kernel's log (dmesg)";
  }
}

std::unique_ptr<EncoderReader> open_encoders(const ArmWiring& wiring) {
  const EncoderConfig& encoders = *wiring.encoders;
  switch (encoders.kind) {
    case EncoderConfig::Kind::kCounterPoll:
      return std::make_unique<CounterPoll>(encoders.counter);
    case EncoderConfig::Kind::kCounterEvents:
      return std::make_unique<CounterEvents>(encoders.counter, encoders.event);
    case EncoderConfig::Kind::kGpio:
      return std::make_unique<GpioEncoder>(encoders.lines);
  }
  return nullptr;
}

// Runs `open`; an exception becomes an entry of `missing`.
template <typename Open>
void attempt(std::vector<Missing>& missing, const char* name, Open open) {
  try {
    open();
  } catch (const GpioError& error) {
    missing.push_back({name, error.what(), remedy_for(error.code.value()), error.code.value()});
  } catch (const std::system_error& error) {
    const int code = error.code().value();
    missing.push_back({name, error.what(), remedy_for(code), code});
  }
}

}  // namespace

Devices::Devices(const BoardConfig& config, ServoBeat& beat)
    : beat_(beat),
      e_stop_(settle_ticks(config)),
      dead_man_(settle_ticks(config)),
      lines_(config.arms.size()) {
  // The outputs first: from then on they are in the safe state, even if other devices are missing.
  std::vector<ArmParts> parts;
  parts.reserve(config.arms.size());
  bool driven = false;
  for (const ArmWiring& arm : config.arms) {
    parts.push_back(open_arm(arm));
    driven = driven || std::ranges::any_of(arm.drives, [](const auto& drive) { return drive.has_value(); });
  }
  std::unique_ptr<DriveSet> drives;
  if (driven) {
    drives = std::make_unique<DriveSet>(config.arms, config.rate_Hz, DriveHost::of_this_machine());
    missing_.insert(missing_.end(), drives->missing().begin(), drives->missing().end());
  }
  arms_ = std::make_unique<ArmDevices>(std::move(parts), std::move(drives), beat);
  open_heartbeat(config);
  if (config.event)
    attempt(missing_, "no_event_line", [&] { event_.open(std::make_unique<GpioOutput>(*config.event)); });
  attempt(missing_, "no_inputs", [&] { open_inputs(config); });
  // Wait until the contacts are debounced; otherwise every start would begin with an e-stop.
  const std::chrono::duration<double> period(1.0 / config.rate_Hz);
  for (std::uint32_t tick = 0; tick <= settle_ticks(config) && inputs_; ++tick) {
    firmware::Inputs in;
    read_lines(in);
    std::this_thread::sleep_for(period);
  }
}

ArmParts Devices::open_arm(const ArmWiring& wiring) {
  ArmParts arm;
  if (!wiring.needs_stored.empty()) {
    missing_.push_back({"no_stored_model", "the store does not have the arm \"" + wiring.needs_stored + "\"",
                        "upload it: thimble model upload", ENOENT});
    arm.needs_dac = false;  // there is nothing to switch, and no sample is ever new
    return arm;
  }
  arm.needs_encoders = wiring.encoders.has_value();
  arm.needs_dac = wiring.dac.has_value();
  if (wiring.enable)
    attempt(missing_, "no_enable_line", [&] { arm.enable = std::make_unique<GpioOutput>(*wiring.enable); });
  if (wiring.dac)
    attempt(missing_, "no_dac", [&] {
      arm.dac = std::make_unique<SpiDac>(wiring.dac->device, wiring.dac->speed_Hz, wiring.dac->channels);
    });
  if (wiring.encoders) attempt(missing_, "no_encoders", [&] { arm.encoders = open_encoders(wiring); });
  return arm;
}

// The watchdogs of drives on CAN are a stop path of their own.
bool Devices::needs_heartbeat(const BoardConfig& config) const {
  return std::ranges::any_of(config.arms, [](const ArmWiring& arm) { return arm.dac.has_value(); });
}

void Devices::open_heartbeat(const BoardConfig& config) {
  if (!config.heartbeat && !needs_heartbeat(config)) return;
  if (!config.heartbeat) {
    missing_.push_back({"no_heartbeat", "no heartbeat is configured",
                        "fit the one-shot of docs/board-linux.md and add \"heartbeat\" to the configuration",
                        ENOENT});
    return;
  }
  attempt(missing_, "no_heartbeat",
          [&] { heartbeat_ = std::make_unique<GpioOutput>(config.heartbeat->line); });
}

void Devices::open_inputs(const BoardConfig& config) {
  std::vector<GpioLine> lines = {config.e_stop};
  const auto add = [&lines](const GpioLine& line) {  // two arms may share a line
    const auto there = std::ranges::find(lines, line);
    const auto place = static_cast<std::size_t>(there - lines.begin());
    if (there == lines.end()) lines.push_back(line);
    return place;
  };
  if (config.dead_man) dead_man_line_ = add(*config.dead_man);
  for (std::size_t i = 0; i < lines_.size(); ++i) {
    if (config.arms[i].drive_fault) lines_[i].drive_fault = add(*config.arms[i].drive_fault);
    if (config.arms[i].index) lines_[i].index = add(*config.arms[i].index);
  }
  inputs_ = std::make_unique<GpioInputs>(lines);
}

void Devices::read(firmware::Inputs& in, std::uint64_t now_ns, std::uint64_t period_ns) noexcept {
  read_lines(in);
  arms_->read(in, now_ns, period_ns);
  for (std::size_t i = 0; i < lines_.size(); ++i)
    if (lines_[i].drive_fault && (!lines_read_ || levels_[*lines_[i].drive_fault]))
      in.arm[i].drive_fault = true;
  measured_.take(in);
}

// Without its lines the e-stop of the board reads as pressed.
void Devices::read_lines(firmware::Inputs& in) noexcept {
  rose_.fill(false);
  fell_.fill(false);
  const auto seen = inputs_ ? inputs_->edges() : std::nullopt;
  const bool read = seen && inputs_->levels(levels_);
  if (!read) levels_.fill(false);
  if (read)
    for (const GpioEdge& edge : seen->edges) (edge.active ? rose_ : fell_)[edge.line] = true;
  in.e_stop = !e_stop_.update(read && levels_[kEStopLine], fell_[kEStopLine]);
  in.dead_man = dead_man_line_ ? dead_man_.update(levels_[*dead_man_line_], fell_[*dead_man_line_]) : read;
  lines_read_ = read;
  for (std::size_t i = 0; i < lines_.size(); ++i)
    in.arm[i].index = lines_[i].index && (levels_[*lines_[i].index] || rose_[*lines_[i].index]);
}

// The heartbeat's pulse begins before the transfers to converters and drives and ends after them: every tick gives the edge that triggers the
// one-shot, and a call that hangs gives no further one. The event line changes when the currents of its tick have left.
void Devices::write(const firmware::Outputs& out) noexcept {
  const bool any = std::ranges::any_of(out.arm, [](const firmware::ArmOutputs& arm) { return arm.enable; });
  const std::uint64_t now_ns = monotonic_ns();
  if (any) beat_.driving(now_ns);
  const bool pulse = any && heartbeat_ && !beat_.cut();
  const bool pulsed = !pulse || heartbeat_->set(true);
  arms_->write(out, pulsed, now_ns);
  if (pulse) (void)heartbeat_->set(false);
  event_.write(out.event);
  if (!any) {
    beat_.off();
  } else if (beat_.cut()) {  // by the guardian, during this call
    arms_->switch_off();
  }
}

void Devices::make_safe() noexcept {
  switch_off();
  arms_->forget();
  beat_.off();
}

void Devices::switch_off() noexcept {
  arms_->switch_off();
  event_.off();
}

std::vector<std::string> Devices::report() const {
  return arms_->drives() == nullptr ? std::vector<std::string>{} : arms_->drives()->report();
}

std::string Devices::news() { return arms_->drives() == nullptr ? std::string() : arms_->drives()->news(); }

}  // namespace thimble::board

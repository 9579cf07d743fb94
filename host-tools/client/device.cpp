#include "host-tools/client/device.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <sstream>
#include <utility>

#include "host-tools/client/requests.h"

namespace thimble::host {
namespace {

using link::Micros;
using link::Mode;
using link::Nrc;
using link::Routine;
using link::Service;
using link::Session;

constexpr Micros kModePoll_us = 20'000;

// The mode that the device says next, by itself: DeviceState is longer than a frame.
std::optional<Mode> mode_of_status(ServiceClient& services, Micros deadline_us) {
  while (const std::optional<link::CanFrame> frame = services.telemetry(deadline_us)) {
    link::Status status;
    if (link::from_frame(*frame, services.options().node, status)) return status.mode;
  }
  return std::nullopt;
}

bool at_rest(Mode mode) { return mode != Mode::kArmed && mode != Mode::kDamping; }

[[noreturn]] void not_disarmed(std::optional<Mode> mode) {
  throw Error(ExitCode::kRefused, "not-in-time",
              mode ? std::string("the device is still ") + name(*mode)
                   : "the device was told to disarm, and does not say its mode",
              "press the e-stop, then see `thimble info`");
}

// Other programs may use the address of who has no place, too, and each hears the answers to all: no answer proves anything, and one that
// was spoiled may have been another's. So the order is repeated until the device's status confirms it, as a stop is.
Mode disarm_without_place(ServiceClient& services, Micros deadline_us) {
  constexpr Micros kRepeat_us = 100'000;
  while (services.telemetry(now_us())) {
  }  // what came before the order confirms nothing
  std::optional<Mode> mode;
  while (now_us() < deadline_us) {
    services.say(routine_request(Routine::kDisarm));
    const Micros repeat_us = now_us() + kRepeat_us;
    while (const std::optional<Mode> said = mode_of_status(services, repeat_us)) {
      mode = said;
      if (at_rest(*mode)) return *mode;
    }
  }
  not_disarmed(mode);
}

Mode disarm_by(ServiceClient& services, Micros wait_us) {
  const Micros deadline_us = now_us() + std::max(wait_us, services.patience_us());
  const auto placeless = [&] { return services.address() == link::kTesterAddress; };
  try {
    if (!placeless()) services.demand_without_place(routine_request(Routine::kDisarm), "disarming");
  } catch (const Error&) {
    if (!placeless()) throw;  // else the place was lost meanwhile
  }
  if (placeless()) return disarm_without_place(services, deadline_us);
  while (true) {
    const Mode mode = services.state().mode;
    if (at_rest(mode)) return mode;
    if (now_us() > deadline_us) not_disarmed(mode);
  }
}

}  // namespace

Device::Device(std::unique_ptr<Transport> transport, const DeviceOptions& options)
    : services_(std::move(transport), options) {
  info_ = services_.record<link::LinkInfo>("reading the device's version");
  if (info_.protocol != link::kProtocolVersion || info_.image != link::kImageVersion) {
    throw Error(ExitCode::kVersion, "version-mismatch",
                "the device speaks protocol " + std::to_string(info_.protocol) + ", scene image " +
                    std::to_string(info_.image) + "; this thimble speaks " +
                    std::to_string(link::kProtocolVersion) + " and " + std::to_string(link::kImageVersion),
                info_.protocol < link::kProtocolVersion || info_.image < link::kImageVersion
                    ? "the device is older: install the firmware of this thimble's release on it"
                    : "this thimble is older: install the host tools of the device's release");
  }
  services_.claim_address();
  if (info_.frame_bytes == link::kFdDataBytes) services_.use_fd();
}

// --- Data

link::DeviceState Device::state() { return services_.state(); }

std::string Device::text(std::uint16_t did) { return services_.text(did); }

std::vector<Device::Inside> Device::inside() {
  std::vector<Inside> all;
  std::istringstream lines(services_.text(link::kDidInside));
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    Inside solid;
    if (words >> solid.arm >> solid.object && words.get() == ' ' && std::getline(words, solid.name))
      all.push_back(solid);
  }
  return all;
}

link::Lateness Device::lateness() { return services_.record<link::Lateness>("reading how late ticks are"); }

link::HostOrders Device::orders() {
  return services_.record<link::HostOrders>("reading the count of orders");
}

std::uint32_t Device::param_bits(const firmware::ParamRow& row) {
  const Bytes answer = services_.demand(read_request(row.id), std::string("reading ") + row.name);
  if (answer.size() != 7) services_.refused(std::string("reading ") + row.name, Nrc::kIncorrectLength);
  std::uint32_t bits = 0;  // little-endian, like the records
  for (std::size_t i = 0; i < 4; ++i) bits |= static_cast<std::uint32_t>(answer[3 + i]) << (8U * i);
  return bits;
}

double Device::read_param(const firmware::ParamRow& row) {
  const std::uint32_t bits = param_bits(row);
  if (row.type == firmware::ParamType::kFloat) return static_cast<double>(std::bit_cast<float>(bits));
  return static_cast<double>(bits);
}

void Device::write_param(const firmware::ParamRow& row, double value) {
  if (row.type == firmware::ParamType::kUnsigned &&
      !(value >= static_cast<double>(row.min) && value <= static_cast<double>(row.max) &&
        std::trunc(value) == value)) {
    std::ostringstream cause;
    cause << value << " is not a value of " << row.name << ": a whole number from " << row.min << " to "
          << row.max;
    throw Error(ExitCode::kUsage, "bad-value", cause.str(), "choose a value in that range");
  }
  const std::uint32_t bits = row.type == firmware::ParamType::kFloat
                                 ? std::bit_cast<std::uint32_t>(static_cast<float>(value))
                                 : static_cast<std::uint32_t>(value);
  if (marks(row) && bits <= 0xFFFFU) {
    (void)mark(row, static_cast<std::uint16_t>(bits));
    return;
  }
  services_.enter(Session::kExtended);
  services_.demand(write_request(row.id, bits), std::string("setting ") + row.name);
}

// A write whose answer does not come may have been lost, or come late. What Marked counts tells it, also when it is asked again before the next
// try. A session may have ended over the waiting.
link::Marked Device::mark(const firmware::ParamRow& row, std::uint16_t value) {
  const auto marked = [&] { return services_.record<link::Marked>("reading the tick of a mark"); };
  const std::uint32_t before = marked().count;
  while (true) {
    services_.enter(Session::kExtended);
    if (const link::Marked late = marked(); late.count == before + 1) return late;
    const std::optional<ServiceClient::Answer> answer = services_.request_once(write_request(row.id, value));
    if (answer && answer->code != Nrc::kOk)
      services_.refused(std::string("setting ") + row.name, answer->code);
    const link::Marked now = marked();  // Error kLinkLost where nothing is answered any more
    if (answer || now.count == before + 1) return now;
  }
}

void Device::save_params() {
  services_.enter(Session::kExtended);
  services_.demand(routine_request(Routine::kSaveParameters), "saving the parameters");
}

std::vector<std::uint8_t> Device::faults() {
  const Bytes answer = services_.demand({byte_of(Service::kReadFaults), 0x02, 0xFF}, "reading the faults");
  std::vector<std::uint8_t> numbers;
  for (std::size_t at = 3; at + 4 <= answer.size(); at += 4) numbers.push_back(answer[at + 2]);
  return numbers;
}

std::vector<link::FreezeFrame> Device::freeze_frames(std::uint8_t fault) {
  const ServiceClient::Answer answer =
      services_.request({byte_of(Service::kReadFaults), 0x04, 0, 0, fault, 0xFF});
  std::vector<link::FreezeFrame> frames;
  if (answer.code != Nrc::kOk) return frames;
  constexpr std::size_t kRecord = 4 + link::wire_size<link::FreezeFrame>();
  for (std::size_t at = 6; at + kRecord <= answer.bytes.size(); at += kRecord) {
    link::FreezeFrame frame;
    if (link::decode(std::span(answer.bytes).subspan(at + 4), frame)) frames.push_back(frame);
  }
  return frames;
}

void Device::clear_faults(const std::function<bool()>& outdated) {
  services_.enter(Session::kExtended);
  if (outdated && outdated()) {
    throw Error(ExitCode::kRefused, "refused", "clearing the faults was given up: a stop came meanwhile",
                "clear them again");
  }
  services_.demand({byte_of(Service::kClearFaults), 0xFF, 0xFF, 0xFF}, "clearing the faults");
}

// --- Modes

bool Device::wait_for_mode(Mode wanted, Micros wait_us, const std::string& what,
                           const std::function<bool()>& stopping) {
  wait_us = std::max(wait_us, services_.patience_us());
  const Micros deadline_us = now_us() + wait_us;
  while (true) {
    const link::DeviceState now = state();
    if (now.mode == wanted) return true;
    if (now.fault != 0) services_.faulted(what, now.fault);
    if (stopping && stopping()) return false;
    if (now_us() > deadline_us) {
      throw Error(ExitCode::kRefused, "not-in-time",
                  what + " did not end within " + std::to_string(wait_us / 1'000'000) +
                      " s: the device is still " + name(now.mode),
                  wanted == Mode::kReady ? "move the arm to its home position" : "see `thimble info`");
    }
    services_.wait_until(now_us() + kModePoll_us);
  }
}

void Device::home(Micros wait_us, const std::function<bool()>& stopping) {
  services_.enter(Session::kExtended);
  services_.demand(routine_request(Routine::kHome), "homing");
  if (!wait_for_mode(Mode::kReady, wait_us, "homing", stopping)) disarm();
}

void Device::arm(Micros wait_us) {
  take_command();
  services_.demand({byte_of(Service::kTesterPresent), 0x00},
                   "the keep-alive");  // arming needs a live link and does not feed it
  const ServiceClient::Answer answer = services_.request(routine_request(Routine::kArm));
  // A repeated request is refused because the device is armed. But another program's arm is no reason to say that it is.
  if (answer.code != Nrc::kOk) {
    const link::DeviceState now = state();
    if (now.mode != Mode::kArmed || now.commander != services_.address())
      services_.refused("arming", answer.code);
  }
  wait_for_mode(Mode::kArmed, wait_us, "arming");
}

void Device::send_stop() { services_.send(link::to_frame(link::EmergencyStop{}, 0)); }

Stopped Device::stop(Micros wait_us) {
  return host::stop([this](const link::CanFrame& frame) { services_.send(frame); },
                    [this](Micros deadline_us) { return services_.telemetry(deadline_us); },
                    services_.options().node, wait_us);
}

void Device::disarm(Micros wait_us) { static_cast<void>(disarm_by(services_, wait_us)); }

Mode disarm(std::unique_ptr<Transport> transport, DeviceOptions options, Micros wait_us) {
  options.needs_place = false;
  ServiceClient services(std::move(transport), options);
  return disarm_by(services, wait_us);
}

link::ArmImages Device::arm_images() {
  return services_.record<link::ArmImages>("reading which arms are stored");
}

std::optional<link::MeasuredCurrents> Device::measured_currents() {
  const ServiceClient::Answer answer =
      services_.request(ServiceClient::read_request(link::MeasuredCurrents::kId));
  link::MeasuredCurrents measured;
  if (answer.code != Nrc::kOk || !link::decode(std::span(answer.bytes).subspan(3), measured))
    return std::nullopt;
  return measured;
}

void Device::restart() {
  services_.enter(Session::kExtended);
  services_.demand({byte_of(Service::kReset), static_cast<std::uint8_t>(link::Reset::kHard)}, "restarting");
}

UploadResult Device::upload(std::span<const std::byte> image, const UploadOptions& options,
                            const UploadListener& progress) {
  return upload_image(services_, image, options, progress);
}

// --- Telemetry

void Device::keep_alive() { services_.keep_alive(); }

void Device::set_listener(std::function<void(const link::CanFrame&)> heard) {
  services_.set_listener(std::move(heard));
}

std::optional<link::CanFrame> Device::telemetry(Micros deadline_us) {
  return services_.telemetry(deadline_us);
}

}  // namespace thimble::host

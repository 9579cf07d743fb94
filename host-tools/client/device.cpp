#include "host-tools/client/device.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "firmware/faults.h"
#include "host-tools/error.h"

namespace thimble::host {
namespace {

using link::CanFrame;
using link::Micros;
using link::Nrc;
using link::Routine;
using link::Service;
using link::Session;
using Bytes = std::vector<std::uint8_t>;

constexpr std::size_t kSmallestBlock = 64;
constexpr Micros kBlockAnswer_us = 100'000;       // no block is given up sooner
constexpr unsigned kMaxStalls = 20;               // failures in a row without a byte of progress
constexpr Micros kAfterPending_us = 5'000'000;    // P2*
constexpr Micros kLongestAnswer_us = 60'000'000;  // however often the device says "pending"
constexpr Micros kSwitch_us = 1'000'000;          // a tick takes the new scene
constexpr Micros kBusy_us = 2'000'000;            // how often "busy, repeat" is believed
constexpr Micros kLongestPause_us = 30'000;       // after a broken answer: many times a short one's length
constexpr Micros kModePoll_us = 20'000;
constexpr Micros kRateKnown_us = 5'000'000;  // a simulator on a slow machine takes long for half a second

std::uint8_t byte_of(Service service) { return static_cast<std::uint8_t>(service); }

void put_u16(Bytes& bytes, std::uint32_t value) {
  bytes.push_back(static_cast<std::uint8_t>(value >> 8U));
  bytes.push_back(static_cast<std::uint8_t>(value));
}

void put_u32(Bytes& bytes, std::uint32_t value) {
  put_u16(bytes, value >> 16U);
  put_u16(bytes, value);
}

std::uint32_t u32_at(std::span<const std::uint8_t> bytes, std::size_t at) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < 4; ++i) value = value << 8U | bytes[at + i];
  return value;
}

constexpr std::uint8_t kStart = 0x01, kStop = 0x02, kResults = 0x03;

Bytes routine_request(Routine routine, std::uint8_t action = kStart) {
  Bytes request = {byte_of(Service::kRoutine), action};
  put_u16(request, static_cast<std::uint16_t>(routine));
  return request;
}

Bytes read_request(std::uint16_t did) {
  Bytes request = {byte_of(Service::kReadData)};
  put_u16(request, did);
  return request;
}

// How many bytes behind the service an answer repeats of its request.
std::size_t echo_size(std::uint8_t service) {
  switch (static_cast<Service>(service)) {
    case Service::kSession:
    case Service::kReset:
    case Service::kReadFaults:
    case Service::kTransferData:
    case Service::kTesterPresent:
      return 1;
    case Service::kReadData:
    case Service::kWriteData:
      return 2;
    case Service::kRoutine:
      return 3;
    case Service::kClearFaults:
    case Service::kRequestDownload:
    case Service::kTransferExit:
      return 0;
  }
  return 0;
}

bool answers(std::span<const std::uint8_t> answer, const Bytes& request) {
  const std::size_t echo = echo_size(request[0]);
  return answer.size() >= 1 + echo && answer[0] == (request[0] | link::kPositive) &&
         std::equal(request.begin() + 1, request.begin() + 1 + static_cast<std::ptrdiff_t>(echo),
                    answer.begin() + 1);
}

bool refuses(std::span<const std::uint8_t> answer, const Bytes& request) {
  return answer.size() == 3 && answer[0] == link::kNegative && answer[1] == request[0];
}

std::string fault_sentence(std::uint8_t number) {
  const firmware::FaultRow* row = firmware::find_fault(static_cast<firmware::Fault>(number));
  if (row == nullptr) return "fault " + std::to_string(number);
  return "fault " + std::to_string(number) + " (" + row->name + "): " + row->cause;
}

// What to do about the reasons that a device gives most; they come as a list, "not_homed,no_scene".
std::string remedy_of(const std::string& reasons) {
  constexpr std::array<std::pair<const char*, const char*>, 10> kRemedies = {{
      {"not_homed", "home the arm (`thimble home`)"},
      {"no_scene", "send a scene (`thimble upload`)"},
      {"dead_man_released", "hold the dead-man switch"},
      {"e_stop_pressed", "release the e-stop"},
      {"moves_not_allowed", "keep hands off the arm, then allow it to move (`thimble scan --allow-moves`)"},
      {"host_renders", "give the scene back its forces (`thimble param set host_forces 0`)"},
      {"in_contact", "move the tip off the scene's surfaces"},
      {"outside_workspace", "move the tip back into the workspace"},
      {"too_many", "leave some out; the limits are in `thimble info`"},
      {"fault_latched", "clear the fault (`thimble fault list`, `thimble fault clear`)"},
  }};
  std::string remedy;
  for (const auto& [reason, what] : kRemedies) {
    if (reasons.find(reason) != std::string::npos) remedy += (remedy.empty() ? "" : "; ") + std::string(what);
  }
  return remedy.empty() ? "remove what the device names, then repeat" : remedy;
}

[[noreturn]] void faulted(const std::string& what, std::uint8_t number) {
  const firmware::FaultRow* row = firmware::find_fault(static_cast<firmware::Fault>(number));
  throw Error(
      ExitCode::kFaulted, "device-faulted", what + ": the device has " + fault_sentence(number),
      row == nullptr ? "see `thimble fault list`" : std::string(row->remedy) + " (`thimble fault clear`)");
}

}  // namespace

std::uint32_t crc32(std::span<const std::byte> bytes) {
  constexpr std::array<std::uint32_t, 256> kTable = [] {
    std::array<std::uint32_t, 256> table{};
    for (std::uint32_t i = 0; i < table.size(); ++i) {
      std::uint32_t remainder = i;
      for (int bit = 0; bit < 8; ++bit)
        remainder = remainder >> 1U ^ ((remainder & 1U) != 0 ? 0xEDB88320U : 0U);
      table[i] = remainder;
    }
    return table;
  }();
  std::uint32_t crc = ~0U;
  for (const std::byte b : bytes) crc = crc >> 8U ^ kTable[(crc ^ static_cast<std::uint8_t>(b)) & 0xFFU];
  return ~crc;
}

std::string mode_name(std::uint8_t mode) {
  constexpr std::array<const char*, 6> kNames = {"disarmed", "homing",  "ready",
                                                 "armed",    "damping", "faulted"};
  return mode < kNames.size() ? kNames[mode] : "mode " + std::to_string(mode);
}

Device::Device(std::unique_ptr<Transport> transport, const DeviceOptions& options)
    : transport_(std::move(transport)),
      options_(options),
      channel_(link::request_id(options.node), link::response_id(options.node), link::IsoTpConfig{}) {
  transport_->listen_to(options.node);
  const Bytes answer = demand(read_request(link::LinkInfo::kId), "reading the device's version");
  if (!link::decode(std::span(answer).subspan(3), info_)) {
    throw Error(ExitCode::kVersion, "version-mismatch", "the device's version record is too short",
                "install the firmware that belongs to this thimble");
  }
  if (info_.protocol != link::kProtocolVersion || info_.image != link::kImageVersion) {
    throw Error(ExitCode::kVersion, "version-mismatch",
                "the device speaks protocol " + std::to_string(info_.protocol) + ", scene image " +
                    std::to_string(info_.image) + "; this thimble speaks " +
                    std::to_string(link::kProtocolVersion) + " and " + std::to_string(link::kImageVersion),
                "install the firmware and the host tools of one release");
  }
  channel_.config().fd = info_.frame_bytes == link::kFdDataBytes && transport_->carries_fd();
}

// --- Requests

void Device::pump(Micros deadline_us) {
  CanFrame frame;
  while (channel_.next_frame(frame, now_us())) transport_->send(frame);
  const Micros gap = channel_.gap(now_us());
  if (gap != 0) deadline_us = std::min(deadline_us, now_us() + gap);
  if (const std::optional<CanFrame> got = transport_->receive(deadline_us)) {
    if (heard_ && !got->extended) heard_(*got);
    static_cast<void>(channel_.on_frame(*got, now_us()));
  }
  channel_.poll(now_us());
}

std::optional<Device::Answer> Device::try_request(const Bytes& request, unsigned tries, Micros answer_us) {
  channel_.config().flow_timeout_us = channel_.config().receive_timeout_us = answer_us;
  for (unsigned i = 0; i < tries; ++i) {
    channel_.abort();
    static_cast<void>(channel_.take_error());
    if (!channel_.send(request, now_us())) throw std::logic_error("a request has 1 to 4095 bytes");
    const Micros last_us = now_us() + kLongestAnswer_us;
    Micros deadline_us = now_us() + answer_us;
    // Another host's request may have cut the answer short. If both asked again at once, each would cut the
    // other's, again and again.
    bool broke_off = false;
    const auto pause = [&] {
      std::uniform_int_distribution<Micros> pause_us(0, kLongestPause_us);
      deadline_us = std::min(deadline_us, now_us() + pause_us(pauses_));
    };
    while (now_us() < std::min(deadline_us, last_us)) {
      const bool moving = channel_.sending() || channel_.receiving();
      pump(std::min(deadline_us, last_us));
      // The answer's time begins when the request has left, and starts anew while an answer comes in; both
      // have deadlines of their own in the channel.
      if (moving && (channel_.sending() || channel_.receiving())) deadline_us = now_us() + answer_us;
      if (channel_.take_error() != link::IsoTpError::kNone) {
        broke_off = true;
        pause();
      }
      const std::span<const std::uint8_t> answer = channel_.received();
      if (answer.empty()) continue;
      if (answers(answer, request)) {
        Answer result{Nrc::kOk, Bytes(answer.begin(), answer.end())};
        channel_.release();
        return result;
      }
      if (refuses(answer, request)) {
        const auto code = static_cast<Nrc>(answer[2]);
        channel_.release();
        if (code != Nrc::kResponsePending) return Answer{code, {}};
        deadline_us = now_us() + kAfterPending_us;
        continue;
      }
      channel_.release();  // the late answer to an earlier request, or another host's
      if (broke_off) pause();
    }
  }
  return std::nullopt;
}

Device::Answer Device::request(const Bytes& request) {
  const Micros busy_until_us = now_us() + kBusy_us;
  std::optional<Answer> answer = try_request(request, options_.tries, options_.answer_us);
  while (answer && answer->code == Nrc::kBusyRepeatRequest && now_us() < busy_until_us) {
    const Micros pause_us = now_us() + kModePoll_us;
    while (now_us() < pause_us) pump(pause_us);
    answer = try_request(request, options_.tries, options_.answer_us);
  }
  if (!answer) {
    throw Error(ExitCode::kLinkLost, "no-answer",
                "the device did not answer within " +
                    std::to_string(options_.answer_us * options_.tries / 1000) + " ms",
                "check that it is a Thimble device, that it runs, and its node number");
  }
  return std::move(*answer);
}

Bytes Device::demand(const Bytes& request_bytes, const std::string& what) {
  Answer answer = request(request_bytes);
  if (answer.code != Nrc::kOk) refused(what, answer.code);
  return std::move(answer.bytes);
}

void Device::refused(const std::string& what, Nrc code) {
  std::string why = link::name(code);
  std::string remedy = "see `thimble info` for the state of the device";
  if (code == Nrc::kConditionsNotCorrect || code == Nrc::kDownloadNotAccepted ||
      code == Nrc::kProgrammingFailure) {
    const link::DeviceState now = state();
    if (now.fault != 0 && code == Nrc::kConditionsNotCorrect) faulted(what, now.fault);
    const std::string reason = text(link::kDidRefusal);
    if (!reason.empty()) {
      why = reason;
      remedy = remedy_of(reason);
    }
  } else if (code == Nrc::kRequestOutOfRange) {
    remedy = "check the value against its limits (`thimble param list`, `thimble info`)";
  } else if (code == Nrc::kServiceNotSupported || code == Nrc::kSubFunctionNotSupported) {
    remedy = "install the firmware that belongs to this thimble";
  }
  throw Error(ExitCode::kRefused, "refused", what + " was refused: " + why, remedy);
}

void Device::enter(Session session) {
  demand({byte_of(Service::kSession), static_cast<std::uint8_t>(session)}, "opening a session");
}

// --- Data

link::DeviceState Device::state() {
  const Bytes answer = demand(read_request(link::DeviceState::kId), "reading the state");
  link::DeviceState state;
  if (!link::decode(std::span(answer).subspan(3), state)) {
    throw Error(ExitCode::kVersion, "version-mismatch", "the device's state record is too short",
                "install the firmware that belongs to this thimble");
  }
  return state;
}

link::Lateness Device::lateness() {
  const Bytes answer = demand(read_request(link::Lateness::kId), "reading how late ticks are");
  link::Lateness late;
  static_cast<void>(link::decode(std::span(answer).subspan(3), late));
  return late;
}

std::string Device::text(std::uint16_t did) {
  const Answer answer = request(read_request(did));
  if (answer.code != Nrc::kOk) return {};
  return {answer.bytes.begin() + 3, answer.bytes.end()};
}

std::uint32_t Device::param_bits(const firmware::ParamRow& row) {
  const Bytes answer = demand(read_request(row.id), std::string("reading ") + row.name);
  if (answer.size() != 7) refused(std::string("reading ") + row.name, Nrc::kIncorrectLength);
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
  const std::string what = std::string("setting ") + row.name;
  enter(Session::kExtended);
  const std::uint32_t bits = row.type == firmware::ParamType::kFloat
                                 ? std::bit_cast<std::uint32_t>(static_cast<float>(value))
                                 : static_cast<std::uint32_t>(value);
  Bytes request = {byte_of(Service::kWriteData)};
  put_u16(request, row.id);
  for (std::size_t i = 0; i < 4; ++i) request.push_back(static_cast<std::uint8_t>(bits >> (8U * i)));
  demand(request, what);
}

void Device::save_params() {
  enter(Session::kExtended);
  demand(routine_request(Routine::kSaveParameters), "saving the parameters");
}

std::vector<std::uint8_t> Device::faults() {
  const Bytes answer = demand({byte_of(Service::kReadFaults), 0x02, 0xFF}, "reading the faults");
  std::vector<std::uint8_t> numbers;
  for (std::size_t at = 3; at + 4 <= answer.size(); at += 4) numbers.push_back(answer[at + 2]);
  return numbers;
}

std::vector<link::FreezeFrame> Device::freeze_frames(std::uint8_t fault) {
  const Answer answer = request({byte_of(Service::kReadFaults), 0x04, 0, 0, fault, 0xFF});
  std::vector<link::FreezeFrame> frames;
  if (answer.code != Nrc::kOk) return frames;
  constexpr std::size_t kRecord = 4 + link::wire_size<link::FreezeFrame>();
  for (std::size_t at = 6; at + kRecord <= answer.bytes.size(); at += kRecord) {
    link::FreezeFrame frame;
    if (link::decode(std::span(answer.bytes).subspan(at + 4), frame)) frames.push_back(frame);
  }
  return frames;
}

void Device::clear_faults() {
  enter(Session::kExtended);
  demand({byte_of(Service::kClearFaults), 0xFF, 0xFF, 0xFF}, "clearing the faults");
}

// --- Modes

bool Device::wait_for_mode(std::uint8_t wanted, Micros wait_us, const std::string& what,
                           const std::function<bool()>& stopping) {
  const Micros deadline_us = now_us() + wait_us;
  while (true) {
    const link::DeviceState now = state();
    if (now.mode == wanted) return true;
    if (now.fault != 0) faulted(what, now.fault);
    if (stopping && stopping()) return false;
    if (now_us() > deadline_us) {
      throw Error(ExitCode::kRefused, "not-in-time",
                  what + " did not end within " + std::to_string(wait_us / 1'000'000) +
                      " s: the device is still " + mode_name(now.mode),
                  wanted == kModeReady ? "move the arm to its home position" : "see `thimble info`");
    }
    const Micros pause_us = now_us() + kModePoll_us;
    while (now_us() < pause_us) pump(pause_us);
  }
}

void Device::home(Micros wait_us, const std::function<bool()>& stopping) {
  enter(Session::kExtended);
  demand(routine_request(Routine::kHome), "homing");
  if (!wait_for_mode(kModeReady, wait_us, "homing", stopping)) disarm();
}

void Device::arm(Micros wait_us) {
  enter(Session::kExtended);
  demand({byte_of(Service::kTesterPresent), 0x00},
         "the keep-alive");  // arming needs a live link and does not feed it
  const Answer answer = request(routine_request(Routine::kArm));
  // A repeated request finds the device armed already.
  if (answer.code != Nrc::kOk && state().mode != kModeArmed) refused("arming", answer.code);
  wait_for_mode(kModeArmed, wait_us, "arming");
}

void Device::disarm(Micros wait_us) {
  demand(routine_request(Routine::kDisarm), "disarming");
  const Micros deadline_us = now_us() + wait_us;
  while (true) {
    const link::DeviceState now = state();
    if (now.mode != kModeArmed && now.mode != kModeDamping) return;
    if (now_us() > deadline_us) {
      throw Error(ExitCode::kRefused, "not-in-time", "the device is still " + mode_name(now.mode),
                  "press the e-stop, then see `thimble info`");
    }
  }
}

// --- Guarded moves

void Device::restart() {
  enter(Session::kExtended);
  demand({byte_of(Service::kReset), static_cast<std::uint8_t>(link::Reset::kHard)}, "restarting");
}

void Device::start_move(const link::MoveOrder& order) {
  enter(Session::kExtended);
  Bytes start = routine_request(Routine::kMove);
  const std::size_t head = start.size();
  start.resize(head + link::wire_size<link::MoveOrder>());
  if (link::encode(order, std::span(start).subspan(head)) == 0)
    throw std::logic_error("the order has its size");
  const Answer answer = request(start);
  // A repeated request finds the move under way.
  if (answer.code != Nrc::kOk && move_state().phase == 0) refused("the move", answer.code);
}

link::MoveState Device::move_state() {
  const Bytes answer = demand(read_request(link::MoveState::kId), "reading the move's state");
  link::MoveState state;
  if (!link::decode(std::span(answer).subspan(3), state))
    refused("reading the move's state", Nrc::kIncorrectLength);
  return state;
}

std::vector<link::MoveSample> Device::move_samples() {
  const Bytes answer = demand(routine_request(Routine::kMove, kResults), "reading what the move measured");
  std::vector<link::MoveSample> samples;
  constexpr std::size_t kEach = link::wire_size<link::MoveSample>();
  for (std::size_t at = 4; at + kEach <= answer.size(); at += kEach) {
    link::MoveSample sample;
    if (link::decode(std::span(answer).subspan(at), sample)) samples.push_back(sample);
  }
  return samples;
}

void Device::end_move() {
  enter(Session::kExtended);
  demand(routine_request(Routine::kMove, kStop), "ending the move");
}

// --- Traces

void Device::start_trace() {
  enter(Session::kExtended);
  const Answer answer = request(routine_request(Routine::kTrace));
  // A repeated request finds it running.
  if (answer.code != Nrc::kOk && trace_state().phase != static_cast<std::uint8_t>(link::TracePhase::kRunning))
    refused("starting the trace", answer.code);
}

void Device::end_trace() {
  enter(Session::kExtended);
  demand(routine_request(Routine::kTrace, kStop), "ending the trace");
}

link::TraceState Device::trace_state() {
  const Bytes answer = demand(read_request(link::TraceState::kId), "reading the trace's state");
  link::TraceState state;
  if (!link::decode(std::span(answer).subspan(3), state))
    refused("reading the trace's state", Nrc::kIncorrectLength);
  return state;
}

std::pair<link::TraceStart, std::vector<link::TraceArm>> Device::trace_start() {
  enter(Session::kExtended);
  const Bytes answer = demand(routine_request(Routine::kTrace, kResults), "reading how the trace began");
  std::pair<link::TraceStart, std::vector<link::TraceArm>> result;
  std::span<const std::uint8_t> rest = std::span(answer).subspan(4);
  if (!link::decode(rest, result.first)) refused("reading how the trace began", Nrc::kIncorrectLength);
  rest = rest.subspan(link::wire_size<link::TraceStart>());
  result.second.resize(result.first.arms);
  for (link::TraceArm& arm : result.second) {
    if (!link::decode(rest, arm)) refused("reading how the trace began", Nrc::kIncorrectLength);
    rest = rest.subspan(link::wire_size<link::TraceArm>());
  }
  return result;
}

// --- Forces of the program's own

void Device::take_over(double readings_per_s) {
  const firmware::ParamRow& decimation = *firmware::find_param("telemetry_decimation");
  double rate_Hz = 0;
  const Micros deadline_us = now_us() + kRateKnown_us;
  while (rate_Hz <= 0) {  // measured over half a second after its start
    rate_Hz = static_cast<double>(state().tick_rate_Hz);
    if (now_us() > deadline_us) {
      throw Error(ExitCode::kRefused, "not-in-time", "the device does not tell how fast its loop is",
                  "see `thimble info`: does it run?");
    }
  }
  const double before = read_param(decimation);
  write_param(*firmware::find_param("host_forces"), 1);
  write_param(decimation,
              std::clamp(std::floor(rate_Hz / readings_per_s), 1.0, static_cast<double>(decimation.max)));
  if (!decimation_before_) decimation_before_ = before;
  try {
    arm();
  } catch (const Error& error) {
    if (error.code == ExitCode::kRefused) release_forces();  // a link that is lost would only be lost again
    throw;
  }
  for (Rendered& arm : rendered_) arm.newest.reset();
}

void Device::hand_back() {
  disarm();
  release_forces();
}

void Device::release_forces() {
  write_param(*firmware::find_param("host_forces"), 0);
  if (decimation_before_) write_param(*firmware::find_param("telemetry_decimation"), *decimation_before_);
  decimation_before_.reset();
}

void Device::order_force(const std::array<double, 3>& force_N, unsigned arm) {
  if (arm >= info_.arms || arm >= rendered_.size() ||
      !std::ranges::all_of(force_N, [](double f) { return std::isfinite(f); })) {
    throw Error(ExitCode::kUsage, "bad-force", "a force has three numbers, and an arm that the device has",
                "check what the program calculates");
  }
  link::ForceOrder order;
  order.x_N = static_cast<float>(force_N[0]);
  order.y_N = static_cast<float>(force_N[1]);
  order.z_N = static_cast<float>(force_N[2]);
  order.arm = static_cast<std::uint8_t>(arm);
  order.sequence = ++rendered_[arm].sequence;
  transport_->send(link::to_frame(order, options_.node));
}

// The pose comes before the force of the same tick.
void Device::take_reading(const CanFrame& frame) {
  link::Pose pose;
  link::Force force;
  link::Status status;
  link::Emergency emergency;
  if (link::from_frame(frame, options_.node, pose)) {
    if (pose.arm < rendered_.size()) rendered_[pose.arm].pose = pose;
  } else if (link::from_frame(frame, options_.node, force)) {
    const unsigned arm = force.arm_contacts >> 6U;
    if (arm >= rendered_.size()) return;
    const link::Pose& at = rendered_[arm].pose;
    if (at.sequence != force.sequence) return;  // of another tick
    TipReading reading;
    reading.position_m = {static_cast<double>(at.x_m), static_cast<double>(at.y_m),
                          static_cast<double>(at.z_m)};
    reading.force_N = {static_cast<double>(force.x_N), static_cast<double>(force.y_N),
                       static_cast<double>(force.z_N)};
    reading.limiters = static_cast<std::uint8_t>(force.arm_contacts >> 2U & 0xFU);
    reading.sequence = force.sequence;
    reading.heard_us = now_us();
    rendered_[arm].newest = reading;
  } else if (link::from_frame(frame, options_.node, emergency)) {
    if (emergency.fault != 0) faulted("rendering", emergency.fault);
  } else if (link::from_frame(frame, options_.node, status) && decimation_before_ &&
             status.mode != kModeArmed) {
    if (status.fault != 0) faulted("rendering", status.fault);
    throw Error(ExitCode::kRefused, "not-armed", "the device is " + mode_name(status.mode) + ", not armed",
                "was it disarmed, or the dead-man switch released? Then take over again");
  }
}

std::optional<TipReading> Device::next_tip(Micros deadline_us, unsigned arm) {
  std::optional<TipReading>& newest = rendered_.at(arm).newest;
  while (true) {
    // What waits already is read first, so that an old reading is not taken for the newest.
    const std::optional<CanFrame> frame = telemetry(newest ? 0 : deadline_us);
    if (!frame) return std::exchange(newest, std::nullopt);
    take_reading(*frame);
  }
}

link::HostOrders Device::orders() {
  const Bytes answer = demand(read_request(link::HostOrders::kId), "reading the count of orders");
  link::HostOrders orders;
  static_cast<void>(link::decode(std::span(answer).subspan(3), orders));
  return orders;
}

// --- Upload

UploadResult Device::upload(std::span<const std::byte> image, const UploadOptions& options,
                            const std::function<void(const UploadProgress&)>& progress) {
  const auto length = static_cast<std::uint32_t>(image.size());
  UploadResult result;
  result.bytes = length;
  result.crc = options.crc.value_or(crc32(image));
  const Micros start_us = now_us();
  const auto seconds = [&] { return static_cast<double>(now_us() - start_us) * 1e-6; };

  Bytes prepare = routine_request(Routine::kPrepareDownload);
  put_u32(prepare, length);
  put_u32(prepare, result.crc);

  const auto lost = [&](std::uint32_t sent) {
    throw Error(
        ExitCode::kLinkLost, "upload-stalled",
        "the upload got no further than " + std::to_string(sent) + " of " + std::to_string(length) + " bytes",
        "check the link, then repeat the command: it goes on from there");
  };

  // A block that fails tells nothing about what the device has of it: it is asked, and smaller blocks follow,
  // because ISO-TP repeats nothing and a lossy link loses the longer ones.
  std::size_t most = link::kMaxBlockBytes;  // what the device takes at once
  std::size_t block = most;
  // An answer that is lost is noticed sooner than elsewhere: four times what the last block took.
  Micros patience_us = options_.answer_us;
  unsigned stalls = 0;
  bool first = true;
  std::uint32_t sent = 0;
  std::uint32_t begun_at = 0;
  const auto stalled = [&] {
    block = std::max(kSmallestBlock, block / 2);
    if (++stalls > kMaxStalls) lost(sent);
  };
  for (bool complete = false; !complete;) {
    enter(Session::kProgramming);
    const Bytes has = demand(prepare, "the upload");
    if (has.size() != 8 || u32_at(has, 4) > length) refused("the upload", Nrc::kIncorrectLength);
    sent = u32_at(has, 4);
    if (first) result.resumed_from = begun_at = sent;
    begun_at = std::min(begun_at, sent);
    first = false;

    Bytes download = {byte_of(Service::kRequestDownload), 0x00, 0x44};
    put_u32(download, sent);
    put_u32(download, length - sent);
    const Answer accepted = request(download);
    if (accepted.code == Nrc::kRequestSequenceError || accepted.code == Nrc::kNotInThisSession) {
      stalled();
      continue;
    }
    if (accepted.code ==
        Nrc::kRequestOutOfRange) {  // these are not the numbers of the upload that was prepared last
      throw Error(ExitCode::kRefused, "other-upload", "another host began an upload of its own in between",
                  "let it end, then repeat");
    }
    if (accepted.code != Nrc::kOk) refused("the upload", accepted.code);
    if (accepted.bytes.size() >= 4) {
      const std::size_t request = static_cast<std::size_t>(accepted.bytes[2]) << 8U | accepted.bytes[3];
      if (request > 2) most = std::min(most, request - 2);
      block = std::min(block, most);
    }

    std::uint8_t counter = 1;
    bool broken = false;
    while (sent < length && !broken) {
      const std::size_t bytes = std::min<std::size_t>(block, length - sent);
      Bytes transfer = {byte_of(Service::kTransferData), counter};
      transfer.reserve(2 + bytes);
      for (const std::byte b : image.subspan(sent, bytes)) transfer.push_back(static_cast<std::uint8_t>(b));
      const Micros asked_us = now_us();
      const std::optional<Answer> answer =
          try_request(transfer, 1, std::min(patience_us, options_.answer_us));
      if (answer && answer->code == Nrc::kOk) {
        sent += static_cast<std::uint32_t>(bytes);
        ++counter;
        stalls = 0;
        patience_us = std::max(kBlockAnswer_us, 4 * (now_us() - asked_us));
        block = std::min(most, block + block / 8 + 1);
        const double rate = (sent - begun_at) / std::max(seconds(), 1e-6);
        if (progress) progress({sent, length, result.resumed_from, rate});
      } else if (answer && answer->code == Nrc::kProgrammingFailure) {
        refused("the upload", answer->code);
      } else {
        ++result.retried_blocks;
        stalled();
        broken = true;
      }
    }
    if (broken) continue;

    const Answer exit = request({byte_of(Service::kTransferExit)});
    if (exit.code == Nrc::kRequestSequenceError || exit.code == Nrc::kNotInThisSession) {
      stalled();
    } else if (exit.code == Nrc::kProgrammingFailure && text(link::kDidRefusal) == "wrong_crc") {
      throw Error(ExitCode::kVerification, "wrong-crc",
                  "what the device received is not what was announced (wrong_crc)",
                  "compile the image again if it is a file, and repeat; the running scene is untouched");
    } else if (exit.code != Nrc::kOk) {
      refused("the image", exit.code);
    } else {
      complete = true;
    }
  }
  result.seconds = seconds();
  result.bytes_per_s = (length - begun_at) / std::max(result.seconds, 1e-6);

  const Answer activated = request(routine_request(Routine::kActivate));
  if (activated.code == Nrc::kOk && !options.verify) return result;
  bool running = false;
  const Micros deadline_us = now_us() + kSwitch_us;
  while (!running && now_us() < deadline_us) {
    const link::DeviceState now = state();
    running = now.scene_bytes == length && now.scene_crc == result.crc;
  }
  // A repeated request may find nothing left to activate: what runs decides.
  if (activated.code != Nrc::kOk && !running) refused("running the scene", activated.code);
  if (!running) {
    throw Error(ExitCode::kVerification, "verification-failed",
                "the device runs another image than the one uploaded", "repeat the upload");
  }
  return result;
}

// --- Telemetry

void Device::keep_alive() {
  const Bytes request = {byte_of(Service::kTesterPresent), link::kSuppressPositive};
  channel_.abort();
  if (!channel_.send(request, now_us())) return;
  CanFrame frame;
  while (channel_.next_frame(frame, now_us())) transport_->send(frame);
}

std::optional<CanFrame> Device::telemetry(Micros deadline_us) {
  while (std::optional<CanFrame> frame = transport_->receive(deadline_us)) {
    if (frame->extended) continue;
    if (heard_) heard_(*frame);
    return frame;
  }
  return std::nullopt;
}

}  // namespace thimble::host

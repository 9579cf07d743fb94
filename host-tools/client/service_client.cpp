#include "host-tools/client/service_client.h"

#include <algorithm>
#include <chrono>
#include <stdexcept>
#include <utility>

#include "firmware/core/faults.h"
#include "host-tools/client/arm_record.h"
#include "host-tools/client/host_name.h"
#include "host-tools/client/printable.h"
#include "host-tools/client/remedies.h"
#include "host-tools/client/requests.h"

namespace thimble::host {
namespace {

using link::CanFrame;
using link::Micros;
using link::Nrc;
using link::Service;

// Of what is asked once: the device repeats "response pending" each second, and must not end the session meanwhile.
constexpr Micros kOncePending_us = link::kHostTimeout_us / 2;
constexpr Micros kLongestAnswer_us = 60'000'000;  // bound for an answer that stays pending
constexpr Micros kBusy_us = 10'000'000;  // bound for an answer that stays "busy, repeat": an upload may end
constexpr Micros kRestart_us =
    17'000'000;  // bound for "restarting": the audit record may have to wait for room (AuditLog::kInterval_s)
constexpr Micros kOtherArm_us =
    2'000'000;  // another program has armed the arm: perhaps it only arms, and ends
constexpr Micros kBusyPause_us = 20'000;
constexpr unsigned kClaimsAWait = 8;        // in the time that an answer may take: frames may be lost
constexpr Micros kPlacePause_us = 200'000;  // between two claims while all places are taken
// All places are taken, perhaps by programs that have ended without a word: so long until such a place is free.
constexpr Micros kPlaceWait_us = link::kHostTimeout_us + 2'000'000;

// How many bytes behind the service an answer repeats of its request.
std::size_t echo_size(std::uint8_t service) {
  switch (static_cast<Service>(service)) {
    case Service::kSession:
    case Service::kReset:
    case Service::kReadFaults:
    case Service::kTransferData:
    case Service::kTesterPresent:
    case Service::kAuthentication:
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

}  // namespace

ServiceClient::ServiceClient(std::unique_ptr<Transport> transport, const DeviceOptions& options)
    : transport_(std::move(transport)), options_(options), claim_(options.node) {
  listen();
  static_cast<void>(claim_until(now_us() + options_.answer_us));
}

ServiceClient::~ServiceClient() {
  if (!transport_ || !claim_.granted()) return;  // moved from, or nothing to release
  try {
    transport_->send(claim_.release());
  } catch (const Error&) {  // the link is gone: the device frees the place by itself
  }
}

// --- The address

void ServiceClient::listen() {
  transport_->listen_to(options_.node, claim_.address());
  channel_.set_ids(link::request_id(options_.node, claim_.address()),
                   link::response_id(options_.node, claim_.address()));
}

void ServiceClient::claim_address() {
  if (!claim_.granted() && !claim_until(now_us() + options_.answer_us * options_.tries)) {
    throw Error(ExitCode::kLinkLost, "no-address", "the device gave this program no address on the link",
                "check the link; a link that loses most frames carries no claim");
  }
}

bool ServiceClient::claim_until(Micros deadline_us) {
  Micros place_by_us = 0;
  while (now_us() < deadline_us) {
    transport_->send(claim_.claim(now_us()));
    claim_refused_ = false;
    const Micros again_us = now_us() + options_.answer_us / kClaimsAWait;
    while (claim_.stale(now_us()) && !claim_refused_ && now_us() < again_us) pump(again_us);
    if (!claim_.stale(now_us())) {
      name_told_ = false;  // the place may be a new one
      return true;
    }
    if (!claim_refused_) continue;
    if (!options_.needs_place) {
      claim_.forget();
      listen();
      return false;
    }
    if (place_by_us == 0) place_by_us = now_us() + kPlaceWait_us;
    if (now_us() > place_by_us) {
      throw Error(ExitCode::kRefused, "hosts-full",
                  "the device serves " + std::to_string(link::kMaxHosts) +
                      " programs at once, and so many are connected",
                  "end one of the programs that use the device, then repeat");
    }
    deadline_us = std::max(deadline_us, now_us() + kPlacePause_us + options_.answer_us);
    wait_until(now_us() + kPlacePause_us);
  }
  return false;
}

void ServiceClient::take_service_frame(const CanFrame& frame) {
  switch (claim_.on_frame(frame)) {
    case HostClaim::Grant::kNew:
      claims_ = true;
      return listen();
    case HostClaim::Grant::kRefused:
      claim_refused_ = true;
      return;
    case HostClaim::Grant::kSame:
      return;
    case HostClaim::Grant::kNone:
      static_cast<void>(channel_.on_frame(frame, now_us()));
  }
}

// --- Frames

void ServiceClient::pump(Micros deadline_us) {
  CanFrame sent;
  while (channel_.next_frame(sent, now_us())) transport_->send(sent);
  const Micros gap = channel_.gap(now_us());
  if (gap != 0) deadline_us = std::min(deadline_us, now_us() + gap);
  if (const std::optional<CanFrame> got = transport_->receive(deadline_us)) {
    if (got->extended) {
      take_service_frame(*got);
    } else if (heard_) {
      for (const CanFrame& frame : classic_frames(*got, options_.node)) heard_(frame);
    }
  }
  channel_.poll(now_us());
}

void ServiceClient::wait_until(Micros deadline_us) {
  while (now_us() < deadline_us) pump(deadline_us);
}

std::optional<CanFrame> ServiceClient::telemetry(Micros deadline_us) {
  while (unread_.empty()) {
    const std::optional<CanFrame> got = transport_->receive(deadline_us);
    if (!got) return std::nullopt;
    if (got->extended) {
      take_service_frame(*got);
      continue;
    }
    for (const CanFrame& frame : classic_frames(*got, options_.node)) {
      if (heard_) heard_(frame);
      unread_.push_back(frame);
    }
  }
  const CanFrame frame = unread_.front();
  unread_.pop_front();
  return frame;
}

void ServiceClient::keep_alive() {
  if (claim_.stale(now_us()))
    transport_->send(claim_.claim(now_us()));  // its grant comes with the next frames
  say({byte_of(Service::kTesterPresent), link::kSuppressPositive});
}

void ServiceClient::say(const Bytes& request) {
  channel_.abort();
  if (!channel_.send(request, now_us())) return;
  CanFrame sent;
  while (channel_.next_frame(sent, now_us())) transport_->send(sent);
}

// --- Requests

std::optional<ServiceClient::Answer> ServiceClient::try_request(const Bytes& request, unsigned tries,
                                                                Micros answer_us, Micros pending_us) {
  channel_.config().flow_timeout_us = channel_.config().receive_timeout_us = answer_us;
  if (claims_ && claim_.stale(now_us())) static_cast<void>(claim_until(now_us() + answer_us));
  for (unsigned i = 0; i < tries; ++i) {
    // The device may have restarted, and know the address no more. The grant comes while the answer is awaited.
    if (i > 0) name_told_ = false;
    if (i > 0 && claim_.granted()) transport_->send(claim_.claim(now_us()));
    channel_.abort();
    static_cast<void>(channel_.take_error());
    const Micros asked_us = now_us();
    if (!channel_.send(request, asked_us)) throw std::logic_error("a request has 1 to 4095 bytes");
    std::optional<Answer> answer = await_answer(request, answer_us, pending_us);
    if (!answer) continue;
    claim_.confirm(asked_us);
    return answer;
  }
  return std::nullopt;
}

std::optional<ServiceClient::Answer> ServiceClient::await_answer(const Bytes& request, Micros answer_us,
                                                                 Micros pending_us) {
  const std::uint8_t address = claim_.address();
  const Micros last_us = now_us() + kLongestAnswer_us;
  Micros deadline_us = now_us() + answer_us;
  while (now_us() < std::min(deadline_us, last_us)) {
    const bool moving = channel_.sending() || channel_.receiving();
    pump(std::min(deadline_us, last_us));
    if (claim_.address() != address)
      return std::nullopt;  // the request left from an address that is none any more
    // The deadline starts anew while the request is being sent or the answer received: the channel has deadlines of its
    // own for both.
    if (moving && (channel_.sending() || channel_.receiving())) deadline_us = now_us() + answer_us;
    if (channel_.take_error() != link::IsoTpError::kNone)
      return std::nullopt;  // a frame was lost: it is repeated at once
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
      deadline_us = now_us() + pending_us;
      continue;
    }
    channel_.release();  // the late answer to an earlier request
  }
  return std::nullopt;
}

template <class Ask>
std::optional<ServiceClient::Answer> ServiceClient::insist(const Ask& ask) {
  const Micros asked_us = now_us();
  std::optional<Answer> answer = ask();
  // More than once: the place that has proven it may have been lost.
  for (unsigned i = 0; i < options_.tries && answer && answer->code == Nrc::kAuthenticationRequired; ++i) {
    authenticate();
    answer = ask();
  }
  while (answer && now_us() < asked_us + passes_within(*answer) && !(options_.hurry && options_.hurry())) {
    wait_until(now_us() + kBusyPause_us);
    answer = ask();
  }
  return answer;
}

// What is refused may be accepted within so long after it was asked first.
Micros ServiceClient::passes_within(const Answer& answer) {
  const bool busy = answer.code == Nrc::kBusyRepeatRequest;
  if (!busy && answer.code != Nrc::kConditionsNotCorrect) return 0;
  if (!has_place()) return busy ? kBusy_us : 0;
  const std::string reason = text(link::kDidRefusal);  // empty: the device has restarted since the answer
  if (busy) return reason.empty() || reason == "restarting" ? kRestart_us : kBusy_us;
  return reason == "other_hosts_arm" ? kOtherArm_us : 0;
}

ServiceClient::Answer ServiceClient::request(const Bytes& request) {
  return *insist([&] { return std::optional(ask(request)); });
}

std::optional<ServiceClient::Answer> ServiceClient::request_once(const Bytes& request) {
  return insist([&] { return try_request(request, 1, options_.answer_us, kOncePending_us); });
}

ServiceClient::Answer ServiceClient::ask(const Bytes& request) {
  // Tries that a spoiled answer has ended cost no time: they do not count.
  const Micros deadline_us = now_us() + patience_us();
  std::optional<Answer> answer;
  do answer = try_request(request, options_.tries, options_.answer_us);
  while (!answer && now_us() < deadline_us);
  if (!answer) {
    throw Error(ExitCode::kLinkLost, "no-answer",
                "the device did not answer within " + std::to_string(patience_us() / 1000) + " ms",
                "check that it is a Thimble device, that it runs, and its node number");
  }
  return std::move(*answer);
}

// One exchange. A sequence error says that a proof was repeated, because its answer was lost or late: then the device may have taken the
// proof or not, and who asks next sees.
void ServiceClient::authenticate() {
  if (!options_.prove) {
    throw Error(ExitCode::kPermission, "no-key", "the device takes commands only from who has its key",
                "use a program that has the key");
  }
  const auto taken = [this](const Answer& answer) {
    if (answer.code != Nrc::kOk && answer.code != Nrc::kRequestSequenceError)
      refused("the proof of the key", answer.code);
    return answer.code == Nrc::kOk;
  };
  const Answer given = ask(challenge_request());
  if (!taken(given)) return;
  link::Challenge challenge;
  if (given.bytes.size() < kChallengeAt + challenge.size())
    refused("the proof of the key", Nrc::kIncorrectLength);
  std::copy_n(given.bytes.begin() + kChallengeAt, challenge.size(), challenge.begin());
  (void)taken(ask(proof_request(options_.prove(options_.node, claim_.address(), challenge))));
  tell_time();
}

Bytes ServiceClient::read_request(std::uint16_t did) { return host::read_request(did); }

Bytes ServiceClient::demand(const Bytes& request_bytes, const std::string& what) {
  Answer answer = request(request_bytes);
  if (answer.code != Nrc::kOk) refused(what, answer.code);
  return std::move(answer.bytes);
}

Bytes ServiceClient::demand_without_place(const Bytes& request_bytes, const std::string& what) {
  struct Restore {
    bool& needs_place;
    bool before;
    ~Restore() { needs_place = before; }
  } const restore{options_.needs_place, options_.needs_place};
  options_.needs_place = false;
  return demand(request_bytes, what);
}

void ServiceClient::enter(link::Session session) {
  demand({byte_of(Service::kSession), static_cast<std::uint8_t>(session)}, "opening a session");
  if (!name_told_) {
    name_told_ = true;
    Bytes tell = {byte_of(Service::kWriteData)};
    put_u16(tell, link::kDidHostName);
    const std::string name = host_name(options_.program);
    tell.insert(tell.end(), name.begin(), name.end());
    (void)request(tell);  // a device may do without
  }
  tell_time();
}

// A device with a key takes it only from who has proven that it has it: then it is told after the proof.
void ServiceClient::tell_time() {
  if (time_told_) return;
  Bytes tell = routine_request(link::Routine::kTellTime);
  const auto now_s =
      static_cast<std::uint32_t>(std::chrono::system_clock::to_time_t(std::chrono::system_clock::now()));
  for (const unsigned shift : {24U, 16U, 8U, 0U}) tell.push_back(static_cast<std::uint8_t>(now_s >> shift));
  time_told_ = ask(tell).code != Nrc::kAuthenticationRequired;  // a device may do without
}

link::DeviceState ServiceClient::state() { return record<link::DeviceState>("reading the state"); }

std::string ServiceClient::text(std::uint16_t did) {
  const Answer answer = request(read_request(did));
  if (answer.code != Nrc::kOk) return {};
  return printable(std::string(answer.bytes.begin() + 3, answer.bytes.end()));
}

// --- Errors

void ServiceClient::refused(const std::string& what, Nrc code) {
  std::string why = link::name(code);
  std::string remedy = "see `thimble info` for the state of the device";
  if (claim_refused_) {
    // The answers to the questions below would be longer than a frame.
    remedy = "end one of the programs that use the device, then repeat";
  } else if (code == Nrc::kConditionsNotCorrect || code == Nrc::kDownloadNotAccepted ||
             code == Nrc::kProgrammingFailure || code == Nrc::kBusyRepeatRequest) {
    const link::DeviceState now = state();
    const std::string reason = text(link::kDidRefusal);
    if (now.fault != 0 && code == Nrc::kConditionsNotCorrect && !is_of_its_own(reason))
      faulted(what, now.fault);
    if (reason == "other_host_commands" || reason == "other_hosts_arm") {
      const std::string name = text(link::kDidCommander);
      throw Error(ExitCode::kCommanded, "other-program",
                  what + " was refused: another program" + (name.empty() ? "" : " (" + name + ")") +
                      (reason == "other_hosts_arm" ? " has armed the device" : " commands it"),
                  remedy_of(reason));
    }
    if (!reason.empty()) {
      why = reason;
      remedy = remedy_of(reason);
    }
  } else if (code == Nrc::kOwnershipVerificationFailed || code == Nrc::kAuthenticationRequired ||
             code == Nrc::kRequiredTimeDelayNotExpired) {
    throw Error(ExitCode::kPermission, "wrong-key", what + " was refused: " + why,
                code == Nrc::kRequiredTimeDelayNotExpired
                    ? "a wrong key was tried a moment ago; repeat the command in some seconds"
                    : "use the key file that belongs to this device (--key)");
  } else if (code == Nrc::kNotInThisSession) {
    why = "the device has restarted meanwhile, or has not heard of this program for too long";
    remedy = "repeat the command";
  } else if (code == Nrc::kRequestOutOfRange) {
    remedy = "check the value against its limits (`thimble param list`, `thimble info`)";
  } else if (code == Nrc::kServiceNotSupported || code == Nrc::kSubFunctionNotSupported) {
    remedy = "install the firmware that belongs to this thimble";
  }
  throw Error(ExitCode::kRefused, "refused", what + " was refused: " + why, remedy);
}

void ServiceClient::faulted(const std::string& what, std::uint8_t fault) {
  const firmware::FaultRow* row = firmware::find_fault(static_cast<firmware::Fault>(fault));
  std::string sentence = "fault " + std::to_string(fault);
  if (row != nullptr) sentence += std::string(" (") + row->name + "): " + row->cause;
  throw Error(
      ExitCode::kFaulted, "device-faulted", what + ": the device has " + sentence,
      row == nullptr ? "see `thimble fault list`" : std::string(row->remedy) + " (`thimble fault clear`)");
}

void ServiceClient::too_short(const std::string& what) {
  throw Error(ExitCode::kVersion, "version-mismatch", what + ": the device's record is too short",
              "install the firmware that belongs to this thimble");
}

}  // namespace thimble::host

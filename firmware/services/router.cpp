#include "firmware/services/router.h"

#include <algorithm>

namespace thimble::firmware {

using link::CanFrame;
using link::Micros;

namespace {

// The request in a frame that holds a whole one; else empty.
std::span<const std::uint8_t> single_frame(const CanFrame& frame) noexcept {
  const std::span<const std::uint8_t> data = frame.bytes();
  const std::size_t size = data.empty() ? 0 : data[0];  // 1 to 7: its first byte
  const bool single = size >= 1 && size < link::kClassicDataBytes && data.size() > size;
  return single ? data.subspan(1, size) : std::span<const std::uint8_t>();
}

}  // namespace

// The figure of docs/link.md, "Memory": of the bare-metal boards, whose pointers have 4 bytes.
static_assert(sizeof(void*) != 4 || sizeof(Router) == 38'752);

Router::Router(RequestHandler& handler, std::uint8_t node, const link::IsoTpConfig& config) noexcept
    : handler_(handler), node_(node), config_(config) {}

// --- Hosts

bool Router::on_frame(const CanFrame& frame, Micros now) noexcept {
  link::HostClaim claim;
  if (link::from_frame(frame, node_, claim)) {
    on_claim(claim, now);
    return true;
  }
  if (!frame.extended || frame.remote ||
      (frame.id & link::kRequestMask) != (link::request_id(node_) & link::kRequestMask))
    return false;
  const auto address = static_cast<std::uint8_t>(frame.id);
  std::optional<std::size_t> index = hosts_.with_address(address);
  if (!index && address == link::kTesterAddress) index = tester_place(frame, now);
  if (!index) return true;  // of a host whose place has ended: it claims one again
  Place& place = places_[*index];
  hosts_.heard(*index, now);
  if (place.pending && is_urgent(frame)) {  // the request that was pending is given up, without an answer
    handler_.give_up(place.host);
    place.pending = false;
    place.channel.release();
  }
  static_cast<void>(place.channel.on_frame(frame, now));
  place.channel.config().fd = frame.fd;  // an answer has the format of its request
  serve(place, now);
  return true;
}

void Router::on_claim(const link::HostClaim& claim, Micros now) noexcept {
  if (claim.action == link::ClaimAction::kRelease) {
    if (const auto index = hosts_.with_key(claim.key)) leave(*index);
    return;
  }
  if (const auto claimed = hosts_.claim(claim.key, now)) {
    if (claimed->is_new) open(claimed->place, now);
    places_[claimed->place].grant_due = true;
    places_[claimed->place].leaving = false;
    if (refused_ && refused_->key == claim.key) refused_.reset();
  } else {
    refused_ = link::HostGrant{claim.key,
                               0};  // a refusal that has not left yet is replaced: that host will ask again
  }
}

// The place for a request of a tester that has none; nothing when all are taken.
std::optional<std::size_t> Router::tester_place(const CanFrame& frame, Micros now) noexcept {
  const std::uint8_t kind = frame.size == 0 ? 0xF0 : frame.data[0] & 0xF0U;
  if (kind > 0x10) return std::nullopt;  // begins no request: what is left of one whose place has ended
  const auto claimed = hosts_.tester(now);
  if (!claimed) {
    answer_without_place(frame, now);
    return std::nullopt;
  }
  open(claimed->place, now);
  return claimed->place;
}

bool Router::is_urgent(const CanFrame& frame) const noexcept { return handler_.urgent(single_frame(frame)); }

// All places are taken. A request that is one frame is handled in the default session, so that a tester can
// always disarm; all else, and an answer that needs more than a frame, is answered "busy".
void Router::answer_without_place(const CanFrame& frame, Micros now) noexcept {
  const std::span<const std::uint8_t> data = frame.bytes();
  const std::span<const std::uint8_t> request = single_frame(frame);
  const bool single = !request.empty();
  const bool first = data.size() >= link::kClassicDataBytes && (data[0] & 0xF0U) == 0x10;
  if (!single && !first) return;
  CanFrame out;
  out.id = link::response_id(node_);
  out.extended = true;
  out.fd = out.bit_rate_switch = frame.fd;
  out.size = link::kClassicDataBytes;
  const std::uint8_t service = single ? request[0] : data[2];
  Nrc result = Nrc::kBusyRepeatRequest;
  if (single) {
    Host nobody;
    nobody.address = link::kTesterAddress;
    link::ByteWriter answer(std::span(out.data).subspan(1, link::kClassicDataBytes - 1));
    answer.put(static_cast<std::uint8_t>(service | link::kPositive));
    Call call{nobody, request, now, answer};
    result = handle(call);
    if (result == Nrc::kResponsePending) handler_.give_up(nobody);
    if (result == Nrc::kResponsePending || result == Nrc::kResponseTooLong) result = Nrc::kBusyRepeatRequest;
    handler_.session_ended(nobody);
    // There is no place to keep the session in.
    if (result == Nrc::kOk && nobody.session != link::Session::kDefault) result = Nrc::kBusyRepeatRequest;
    if (result == Nrc::kOk && call.sign_of_life) handler_.host_alive(call.host, now);
    if (result == Nrc::kOk && call.suppressible && (call.request[1] & link::kSuppressPositive) != 0) return;
    out.data[0] = static_cast<std::uint8_t>(answer.size());
  }
  if (result != Nrc::kOk) out.data = {3, link::kNegative, service, static_cast<std::uint8_t>(result)};
  placeless_answer_ = out;
}

void Router::open(std::size_t index, Micros now) noexcept {
  Place& place = places_[index];
  const std::uint8_t address = hosts_.address(index);
  place.channel.config() = config_;
  place.channel.set_ids(link::response_id(node_, address), link::request_id(node_, address));
  place.host = {};
  place.host.address = address;
  place.grant_due = place.leaving = place.pending = false;
  hosts_.heard(index, now);
}

void Router::leave(std::size_t index) noexcept {
  Place& place = places_[index];
  place.leaving = true;
  if (place.pending) return;  // what was begun is ended first
  if (place.host.restart) handler_.restart(*place.host.restart);
  handler_.session_ended(place.host);
  place.channel.abort();
  place.host.session = link::Session::kDefault;
  hosts_.free(index);
}

const Host* Router::host(std::uint8_t address) const noexcept {
  const auto index = hosts_.with_address(address);
  return index ? &places_[*index].host : nullptr;
}

// --- Requests

void Router::poll(Micros now) noexcept {
  turn_ = (turn_ + 1) % places_.size();
  for (std::size_t i = 0; i < places_.size(); ++i) {
    const std::size_t index = (turn_ + i) % places_.size();
    if (hosts_.taken(index)) poll(index, now);
  }
}

void Router::poll(std::size_t index, Micros now) noexcept {
  Place& place = places_[index];
  place.channel.poll(now);
  // A PDU that was given up is the host's to repeat: nothing of it is kept here.
  static_cast<void>(place.channel.take_error());
  serve(place, now);
  if (place.host.restart && !place.channel.sending()) {
    handler_.restart(*place.host.restart);
    place.host.restart.reset();
  }
  // The host's silence begins when it has its answer.
  if (place.channel.sending() || !place.channel.received().empty()) hosts_.heard(index, now);
  if (!place.leaving && hosts_.expired(index, now)) place.host.vanished = true;
  if (place.leaving || place.host.vanished) leave(index);
}

void Router::serve(Place& place, Micros now) noexcept {
  const std::span<const std::uint8_t> request = place.channel.received();
  if (request.empty()) return;
  if (place.channel.sending()) {
    if (place.pending) return;
    place.channel.abort_send();  // the host has given up the last answer, or will ask again
  }
  link::ByteWriter answer(answer_);
  answer.put(static_cast<std::uint8_t>(request[0] | link::kPositive));
  Call call{place.host, request, now, answer};
  const bool was_pending = call.again = place.pending;
  Nrc result = handle(call);
  if (result == Nrc::kResponsePending) {
    result = judge_pending(place, now);
    if (result == Nrc::kOk) return;
  }
  place.pending = result == Nrc::kResponsePending;

  const bool suppress =
      result == Nrc::kOk && !was_pending && call.suppressible && (request[1] & link::kSuppressPositive) != 0;
  if (result == Nrc::kOk && call.sign_of_life) handler_.host_alive(call.host, now);
  const std::array<std::uint8_t, 3> refusal = {link::kNegative, request[0],
                                               static_cast<std::uint8_t>(result)};
  const std::span<const std::uint8_t> said =
      result == Nrc::kOk ? std::span<const std::uint8_t>(answer_.data(), answer.size()) : refusal;
  // The sender is idle and the answer has 1 to 4095 bytes: it cannot refuse.
  if (!suppress) static_cast<void>(place.channel.send(said, now));
  if (!place.pending) place.channel.release();
}

Nrc Router::handle(Call& call) noexcept {
  const Nrc result = handler_.handle(call);
  return result == Nrc::kOk && call.answer.overflowed() ? Nrc::kResponseTooLong : result;
}

Nrc Router::judge_pending(Place& place, Micros now) noexcept {
  if (!place.pending) {
    place.pending_since_us = now;
  } else if (now - place.pending_since_us > kPendingLimit_us) {
    handler_.give_up(place.host);
    return Nrc::kGeneralReject;
  } else if (now - place.pending_told_us < kPendingInterval_us) {
    return Nrc::kOk;
  }
  place.pending_told_us = now;
  return Nrc::kResponsePending;
}

// --- Frames to send: first what tells hosts their addresses, then the answers; each host in turn.

bool Router::next_frame(CanFrame& frame, Micros now) noexcept {
  if (refused_) {
    frame = link::to_frame(*refused_, node_);
    refused_.reset();
    return true;
  }
  if (placeless_answer_) {
    frame = *placeless_answer_;
    placeless_answer_.reset();
    return true;
  }
  for (std::size_t i = 0; i < places_.size(); ++i) {
    const std::size_t index = (turn_ + i) % places_.size();
    if (!hosts_.taken(index)) continue;
    Place& place = places_[index];
    if (place.grant_due) {
      place.grant_due = false;
      // The key is the table's: the host that has the place now.
      frame = link::to_frame(link::HostGrant{hosts_.key(index), hosts_.address(index)}, node_);
      return true;
    }
    if (!place.channel.next_frame(frame, now)) continue;
    turn_ = (index + 1) % places_.size();
    return true;
  }
  return false;
}

}  // namespace thimble::firmware

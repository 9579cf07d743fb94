#include "firmware/link/service_server.h"

#include <algorithm>

namespace thimble::firmware::link {
namespace {

constexpr std::uint8_t kStartRoutine = 0x01;
constexpr std::uint8_t kStopRoutine = 0x02;
constexpr std::uint8_t kRoutineResults = 0x03;
constexpr std::uint8_t kAllFreezeFrames = 0xFF;
constexpr std::size_t kMaxDataIdentifiers = 8;  // in one request

[[nodiscard]] std::uint16_t u16_at(std::span<const std::uint8_t> bytes, std::size_t at) noexcept {
  return static_cast<std::uint16_t>(bytes[at] << 8U | bytes[at + 1]);
}

[[nodiscard]] std::uint32_t u32_at(std::span<const std::uint8_t> bytes, std::size_t at) noexcept {
  return static_cast<std::uint32_t>(u16_at(bytes, at)) << 16U | u16_at(bytes, at + 2);
}

// A fault as the three bytes of a trouble code.
void put_fault(ByteWriter& out, std::uint8_t number) noexcept {
  out.put(0);
  out.put(0);
  out.put(number);
}

[[nodiscard]] bool has_sub_function(std::uint8_t service) noexcept {
  switch (static_cast<Service>(service)) {
    case Service::kSession:
    case Service::kReset:
    case Service::kReadFaults:
    case Service::kRoutine:
    case Service::kTesterPresent:
      return true;
    case Service::kClearFaults:
    case Service::kReadData:
    case Service::kWriteData:
    case Service::kRequestDownload:
    case Service::kTransferData:
    case Service::kTransferExit:
      return false;
  }
  return false;
}

[[nodiscard]] bool is_routine(std::span<const std::uint8_t> request, Routine routine) noexcept {
  return request.size() >= 4 && request[0] == static_cast<std::uint8_t>(Service::kRoutine) &&
         u16_at(request, 2) == static_cast<std::uint16_t>(routine);
}

}  // namespace

const char* name(Nrc code) noexcept {
  switch (code) {
    case Nrc::kOk:
      return "ok";
    case Nrc::kGeneralReject:
      return "general_reject";
    case Nrc::kServiceNotSupported:
      return "service_not_supported";
    case Nrc::kSubFunctionNotSupported:
      return "sub_function_not_supported";
    case Nrc::kIncorrectLength:
      return "incorrect_length";
    case Nrc::kResponseTooLong:
      return "response_too_long";
    case Nrc::kBusyRepeatRequest:
      return "busy_repeat_request";
    case Nrc::kConditionsNotCorrect:
      return "conditions_not_correct";
    case Nrc::kRequestSequenceError:
      return "request_sequence_error";
    case Nrc::kRequestOutOfRange:
      return "request_out_of_range";
    case Nrc::kDownloadNotAccepted:
      return "download_not_accepted";
    case Nrc::kTransferSuspended:
      return "transfer_suspended";
    case Nrc::kProgrammingFailure:
      return "programming_failure";
    case Nrc::kWrongBlockCounter:
      return "wrong_block_counter";
    case Nrc::kResponsePending:
      return "response_pending";
    case Nrc::kNotInThisSession:
      return "not_in_this_session";
  }
  return "unknown";
}

// --- ByteWriter

void ByteWriter::put(std::uint8_t value) noexcept { put(std::span<const std::uint8_t>(&value, 1)); }

void ByteWriter::put_u16(std::uint16_t value) noexcept {
  put(static_cast<std::uint8_t>(value >> 8U));
  put(static_cast<std::uint8_t>(value));
}

void ByteWriter::put_u32(std::uint32_t value) noexcept {
  put_u16(static_cast<std::uint16_t>(value >> 16U));
  put_u16(static_cast<std::uint16_t>(value));
}

void ByteWriter::put(std::span<const std::uint8_t> bytes) noexcept {
  if (bytes.size() > out_.size() - size_) {
    overflowed_ = true;
    return;
  }
  std::ranges::copy(bytes, out_.begin() + static_cast<std::ptrdiff_t>(size_));
  size_ += bytes.size();
}

void ByteWriter::put_text(const char* text) noexcept {
  if (text == nullptr) return;
  while (*text != '\0' && !overflowed_) put(static_cast<std::uint8_t>(*text++));
}

void ByteWriter::advance(std::size_t bytes) noexcept {
  if (bytes > out_.size() - size_) {
    overflowed_ = true;
    return;
  }
  size_ += bytes;
}

// --- ServiceServer

void ServiceServer::end_download() noexcept { prepared_ = downloading_ = finished_ = false; }

ServiceServer::ServiceServer(ServiceBackend& backend, std::uint8_t node, const IsoTpConfig& config,
                             std::uint16_t block_bytes) noexcept
    : backend_(backend), block_bytes_(block_bytes), channel_(response_id(node), request_id(node), config) {}

bool ServiceServer::on_frame(const CanFrame& frame, Micros now) noexcept {
  if (!channel_.on_frame(frame, now)) return false;
  channel_.config().fd = frame.fd;  // answer as one is asked
  handle(now);
  return true;
}

void ServiceServer::poll(Micros now) noexcept {
  channel_.poll(now);
  // A PDU that was given up is the host's to repeat: nothing of it is kept here.
  static_cast<void>(channel_.take_error());
  handle(now);
  if (reset_due_ && !channel_.sending()) {
    reset_due_ = false;
    backend_.reset(reset_kind_);
  }
  const bool busy = channel_.receiving() || channel_.sending() || !channel_.received().empty();
  if (busy) {
    last_request_us_ = now;
  } else if (session_ != Session::kDefault && now - last_request_us_ > kSessionTimeout_us) {
    session_ = Session::kDefault;
    end_download();
  }
}

bool ServiceServer::next_frame(CanFrame& frame, Micros now) noexcept {
  return channel_.next_frame(frame, now);
}

void ServiceServer::handle(Micros now) noexcept {
  const std::span<const std::uint8_t> request = channel_.received();
  if (request.empty()) return;
  if (channel_.sending()) {
    if (pending_) return;
    channel_.abort_send();  // its host has given it up, or will ask again (docs/link.md)
  }
  last_request_us_ = now;

  ByteWriter out(response_);
  out.put(static_cast<std::uint8_t>(request[0] | kPositive));
  Nrc result = dispatch(request, out);
  if (result == Nrc::kOk && out.overflowed()) result = Nrc::kResponseTooLong;

  if (result == Nrc::kResponsePending) {
    if (!pending_) {
      pending_ = true;
      pending_since_us_ = now;
    } else if (now - pending_since_us_ > kPendingLimit_us) {
      result = Nrc::kGeneralReject;
    } else if (now - pending_told_us_ < kPendingInterval_us) {
      return;
    }
  }
  const bool told_pending = pending_;
  if (result == Nrc::kResponsePending) {
    pending_told_us_ = now;
  } else {
    pending_ = false;
  }

  const bool suppress = result == Nrc::kOk && !told_pending && request.size() > 1 &&
                        has_sub_function(request[0]) && (request[1] & kSuppressPositive) != 0;
  if (result == Nrc::kOk && !is_routine(request, Routine::kArm)) backend_.host_alive(now);
  const std::array<std::uint8_t, 3> refusal = {kNegative, request[0], static_cast<std::uint8_t>(result)};
  const std::span<const std::uint8_t> answer =
      result == Nrc::kOk ? std::span<const std::uint8_t>(response_.data(), out.size()) : refusal;
  // The sender is idle and the answer is 1..4095 bytes: it cannot refuse.
  if (!suppress) static_cast<void>(channel_.send(answer, now));
  if (result != Nrc::kResponsePending) channel_.release();
}

Nrc ServiceServer::dispatch(std::span<const std::uint8_t> request, ByteWriter& out) noexcept {
  const bool open = session_ != Session::kDefault;
  const bool programming = session_ == Session::kProgramming;
  switch (static_cast<Service>(request[0])) {
    case Service::kSession:
      return session_control(request, out);
    case Service::kReadFaults:
      return read_faults(request, out);
    case Service::kReadData:
      return read_data(request, out);
    case Service::kTesterPresent:
      return tester_present(request, out);
    case Service::kRoutine:
      // Disarming is never a question of the session.
      return open || is_routine(request, Routine::kDisarm) ? routine(request, out) : Nrc::kNotInThisSession;
    case Service::kReset:
      return open ? ecu_reset(request, out) : Nrc::kNotInThisSession;
    case Service::kClearFaults:
      return open ? clear_faults(request, out) : Nrc::kNotInThisSession;
    case Service::kWriteData:
      return open ? write_data(request, out) : Nrc::kNotInThisSession;
    case Service::kRequestDownload:
      return programming ? request_download(request, out) : Nrc::kNotInThisSession;
    case Service::kTransferData:
      return programming ? transfer_data(request, out) : Nrc::kNotInThisSession;
    case Service::kTransferExit:
      return programming ? transfer_exit(request, out) : Nrc::kNotInThisSession;
  }
  return Nrc::kServiceNotSupported;
}

Nrc ServiceServer::session_control(std::span<const std::uint8_t> request, ByteWriter& out) noexcept {
  if (request.size() != 2) return Nrc::kIncorrectLength;
  const auto session = static_cast<Session>(request[1] & ~kSuppressPositive);
  if (session != Session::kDefault && session != Session::kProgramming && session != Session::kExtended) {
    return Nrc::kSubFunctionNotSupported;
  }
  session_ = session;
  end_download();
  out.put(static_cast<std::uint8_t>(session));
  out.put_u16(50);   // P2 in ms: an answer comes within
  out.put_u16(500);  // P2* in 10 ms: after a "response pending"
  return Nrc::kOk;
}

Nrc ServiceServer::ecu_reset(std::span<const std::uint8_t> request, ByteWriter& out) noexcept {
  if (request.size() != 2) return Nrc::kIncorrectLength;
  const auto kind = static_cast<Reset>(request[1] & ~kSuppressPositive);
  if (kind != Reset::kHard && kind != Reset::kSoft) return Nrc::kSubFunctionNotSupported;
  reset_kind_ = kind;
  reset_due_ = true;
  out.put(static_cast<std::uint8_t>(kind));
  return Nrc::kOk;
}

Nrc ServiceServer::clear_faults(std::span<const std::uint8_t> request, ByteWriter& /*out*/) noexcept {
  if (request.size() != 4) return Nrc::kIncorrectLength;
  const bool all = request[1] == 0xFF && request[2] == 0xFF && request[3] == 0xFF;
  return all ? backend_.clear_faults() : Nrc::kRequestOutOfRange;
}

Nrc ServiceServer::read_faults(std::span<const std::uint8_t> request, ByteWriter& out) noexcept {
  if (request.size() < 2) return Nrc::kIncorrectLength;
  const std::uint8_t kind = request[1] & static_cast<std::uint8_t>(~kSuppressPositive);
  out.put(kind);
  const std::size_t faults = backend_.fault_count();
  switch (kind) {
    case 0x01:    // how many match the status mask
    case 0x02: {  // which
      if (request.size() != 3) return Nrc::kIncorrectLength;
      out.put(kFaultActive | kFaultConfirmed);
      std::uint16_t matches = 0;
      for (std::size_t i = 0; i < faults; ++i) {
        const FaultRecord record = backend_.fault(i);
        if ((record.status & request[2]) == 0) continue;
        ++matches;
        if (kind == 0x02) {
          put_fault(out, record.number);
          out.put(record.status);
        }
      }
      if (kind == 0x01) {
        out.put(0x01);  // the codes are formatted by ISO 14229-1
        out.put_u16(matches);
      }
      return Nrc::kOk;
    }
    case 0x04: {  // freeze frames
      if (request.size() != 6) return Nrc::kIncorrectLength;
      const std::uint8_t number = request[4];
      const std::uint8_t which = request[5];
      if (request[2] != 0 || request[3] != 0) return Nrc::kRequestOutOfRange;
      for (std::size_t i = 0; i < faults; ++i) {
        const FaultRecord record = backend_.fault(i);
        if (record.number != number) continue;
        put_fault(out, number);
        out.put(record.status);
        for (std::size_t frame = 0; frame < kMaxFreezeFrames; ++frame) {
          const auto frame_number = static_cast<std::uint8_t>(frame + 1);
          if (which != kAllFreezeFrames && which != frame_number) continue;
          std::array<std::uint8_t, wire_size<FreezeFrame>()> bytes{};
          ByteWriter data(bytes);
          if (!backend_.freeze_frame(number, frame, data)) break;
          out.put(frame_number);
          out.put(1);  // data identifiers in it
          out.put_u16(FreezeFrame::kId);
          out.put(std::span<const std::uint8_t>(bytes).first(data.size()));
        }
        return Nrc::kOk;
      }
      return Nrc::kRequestOutOfRange;
    }
    default:
      return Nrc::kSubFunctionNotSupported;
  }
}

Nrc ServiceServer::read_data(std::span<const std::uint8_t> request, ByteWriter& out) noexcept {
  const std::size_t count = (request.size() - 1) / 2;
  if (request.size() % 2 == 0 || count == 0 || count > kMaxDataIdentifiers) return Nrc::kIncorrectLength;
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint16_t did = u16_at(request, 1 + 2 * i);
    out.put_u16(did);
    if (did == kDidSession) {
      out.put(static_cast<std::uint8_t>(session_));
      continue;
    }
    const Nrc result = backend_.read_data(did, out);
    if (result != Nrc::kOk) return result;
  }
  return Nrc::kOk;
}

Nrc ServiceServer::write_data(std::span<const std::uint8_t> request, ByteWriter& out) noexcept {
  if (request.size() < 4) return Nrc::kIncorrectLength;
  const std::uint16_t did = u16_at(request, 1);
  out.put_u16(did);
  return backend_.write_data(did, request.subspan(3));
}

Nrc ServiceServer::routine(std::span<const std::uint8_t> request, ByteWriter& out) noexcept {
  if (request.size() < 4) return Nrc::kIncorrectLength;
  const std::uint8_t action = request[1] & static_cast<std::uint8_t>(~kSuppressPositive);
  const auto which = static_cast<Routine>(u16_at(request, 2));
  const std::span<const std::uint8_t> arguments = request.subspan(4);
  out.put(action);
  out.put_u16(static_cast<std::uint16_t>(which));
  if (which == Routine::kMove) return move_routine(action, arguments, out);
  if (which == Routine::kTrace) return trace_routine(action, arguments, out);
  if (action != kStartRoutine) return Nrc::kSubFunctionNotSupported;

  if (which == Routine::kPrepareDownload) {
    if (session_ != Session::kProgramming) return Nrc::kNotInThisSession;
    if (arguments.size() != 8) return Nrc::kIncorrectLength;
    end_download();
    const std::uint32_t length = u32_at(arguments, 0);
    std::uint32_t has = 0;
    const Nrc result = backend_.prepare_download(length, u32_at(arguments, 4), has);
    if (result != Nrc::kOk) return result;
    prepared_ = true;
    length_ = length;
    offset_ = has;
    out.put_u32(has);
    return Nrc::kOk;
  }
  if (!arguments.empty()) return Nrc::kIncorrectLength;
  switch (which) {
    case Routine::kArm:
      return backend_.arm();
    case Routine::kDisarm:
      return backend_.disarm();
    case Routine::kHome:
      return backend_.home();
    case Routine::kActivate:
      return backend_.activate();
    case Routine::kSaveParameters:
      return backend_.save_parameters();
    case Routine::kPrepareDownload:
    case Routine::kMove:
    case Routine::kTrace:
      break;
  }
  return Nrc::kRequestOutOfRange;
}

Nrc ServiceServer::move_routine(std::uint8_t action, std::span<const std::uint8_t> arguments,
                                ByteWriter& out) noexcept {
  if (action == kStartRoutine) {
    MoveOrder order;
    if (arguments.size() != wire_size<MoveOrder>() || !decode(arguments, order)) return Nrc::kIncorrectLength;
    return backend_.start_move(order);
  }
  if (!arguments.empty()) return Nrc::kIncorrectLength;
  if (action == kStopRoutine) return backend_.end_move();
  return action == kRoutineResults ? backend_.move_samples(out) : Nrc::kSubFunctionNotSupported;
}

Nrc ServiceServer::trace_routine(std::uint8_t action, std::span<const std::uint8_t> arguments,
                                 ByteWriter& out) noexcept {
  if (!arguments.empty()) return Nrc::kIncorrectLength;
  if (action == kStartRoutine) return backend_.start_trace();
  if (action == kStopRoutine) return backend_.end_trace();
  return action == kRoutineResults ? backend_.trace_start(out) : Nrc::kSubFunctionNotSupported;
}

// 34 00 44 offset(4) bytes to come(4): the prepared image from where the controller's copy ends.
Nrc ServiceServer::request_download(std::span<const std::uint8_t> request, ByteWriter& out) noexcept {
  if (request.size() != 11) return Nrc::kIncorrectLength;
  if (request[1] != 0x00 || request[2] != 0x44) return Nrc::kRequestOutOfRange;
  if (!prepared_) return Nrc::kRequestSequenceError;
  if (u32_at(request, 3) != offset_ || u32_at(request, 7) != length_ - offset_)
    return Nrc::kRequestOutOfRange;
  downloading_ = true;
  last_block_ = 0;
  any_block_ = false;
  out.put(0x20);
  out.put_u16(static_cast<std::uint16_t>(block_bytes_ + kMaxPduBytes - kMaxBlockBytes));
  return Nrc::kOk;
}

Nrc ServiceServer::transfer_data(std::span<const std::uint8_t> request, ByteWriter& out) noexcept {
  if (request.size() < 3) return Nrc::kIncorrectLength;
  if (!downloading_) return Nrc::kRequestSequenceError;
  const std::uint8_t block = request[1];
  const std::span<const std::uint8_t> data = request.subspan(2);
  if (data.size() > block_bytes_) return Nrc::kRequestOutOfRange;
  out.put(block);
  if (any_block_ && block == last_block_) return Nrc::kOk;  // our answer was lost: it is stored already
  if (block != static_cast<std::uint8_t>(last_block_ + 1)) return Nrc::kWrongBlockCounter;
  if (data.size() > length_ - offset_) return Nrc::kTransferSuspended;
  const Nrc result = backend_.write_download(offset_, data);
  if (result == Nrc::kResponsePending) return result;
  if (result != Nrc::kOk) {
    end_download();
    return result;
  }
  offset_ += static_cast<std::uint32_t>(data.size());
  last_block_ = block;
  any_block_ = true;
  return Nrc::kOk;
}

Nrc ServiceServer::transfer_exit(std::span<const std::uint8_t> request, ByteWriter& /*out*/) noexcept {
  if (request.size() != 1) return Nrc::kIncorrectLength;
  if (finished_) return Nrc::kOk;  // our answer was lost
  if (!downloading_ || offset_ != length_) return Nrc::kRequestSequenceError;
  const Nrc result = backend_.finish_download();
  if (result != Nrc::kResponsePending) end_download();
  finished_ = result == Nrc::kOk;
  return result;
}

Nrc ServiceServer::tester_present(std::span<const std::uint8_t> request, ByteWriter& out) noexcept {
  if (request.size() != 2) return Nrc::kIncorrectLength;
  if ((request[1] & ~kSuppressPositive) != 0) return Nrc::kSubFunctionNotSupported;
  out.put(0);
  return Nrc::kOk;
}

}  // namespace thimble::firmware::link

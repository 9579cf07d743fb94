#include "firmware/link/iso_tp.h"

#include <algorithm>

namespace thimble::firmware::link {
namespace {

// The upper half of a frame's first byte (ISO 15765-2 table 9).
constexpr std::uint8_t kSingle = 0x00;
constexpr std::uint8_t kFirst = 0x10;
constexpr std::uint8_t kConsecutive = 0x20;
constexpr std::uint8_t kFlowControl = 0x30;

constexpr std::uint8_t kContinue = 0;
constexpr std::uint8_t kWait = 1;
constexpr std::uint8_t kOverflowStatus = 2;

constexpr std::uint8_t kPadding = 0xCC;  // few stuff bits

// Table 20. Reserved values count as the longest.
[[nodiscard]] Micros gap_of_st_min(std::uint8_t st_min) noexcept {
  if (st_min <= 0x7F) return Micros{1000} * st_min;
  if (st_min >= 0xF1 && st_min <= 0xF9) return Micros{100} * (st_min - 0xF0U);
  return 127'000;
}

// Sizes the frame: classic frames always have 8 bytes, FD frames at least 8.
void finish_frame(CanFrame& frame, std::size_t used, bool fd) noexcept {
  frame.fd = fd;
  frame.bit_rate_switch = fd;
  frame.size = fd ? fd_size(std::max(used, kClassicDataBytes)) : std::uint8_t{kClassicDataBytes};
  std::fill(frame.data.begin() + static_cast<std::ptrdiff_t>(used), frame.data.begin() + frame.size,
            kPadding);
}

// Copies as much of `from` as fits behind `used` into a frame of `capacity` bytes; returns the bytes copied.
std::size_t fill(CanFrame& frame, std::size_t used, std::size_t capacity,
                 std::span<const std::uint8_t> from) noexcept {
  const std::size_t bytes = std::min(capacity - used, from.size());
  std::copy_n(from.begin(), bytes, frame.data.begin() + static_cast<std::ptrdiff_t>(used));
  return bytes;
}

[[nodiscard]] bool expired(Micros since, Micros timeout, Micros now) noexcept {
  return now - since > timeout;
}

}  // namespace

const char* name(IsoTpError error) noexcept {
  switch (error) {
    case IsoTpError::kNone:
      return "none";
    case IsoTpError::kSendTimeout:
      return "send_timeout";
    case IsoTpError::kFlowTimeout:
      return "flow_timeout";
    case IsoTpError::kReceiveTimeout:
      return "receive_timeout";
    case IsoTpError::kWrongSequence:
      return "wrong_sequence";
    case IsoTpError::kUnexpectedPdu:
      return "unexpected_pdu";
    case IsoTpError::kOverflow:
      return "overflow";
    case IsoTpError::kInvalidFlowControl:
      return "invalid_flow_control";
    case IsoTpError::kTooManyWaits:
      return "too_many_waits";
  }
  return "unknown";
}

// --- Sender

bool IsoTpSender::start(std::span<const std::uint8_t> pdu, bool fd, Micros now) noexcept {
  if (busy() || pdu.empty() || pdu.size() > pdu_.size()) return false;
  std::ranges::copy(pdu, pdu_.begin());
  size_ = pdu.size();
  sent_ = 0;
  fd_ = fd;
  waits_ = 0;
  not_before_us_ = now;
  deadline_from_us_ = now;
  error_ = IsoTpError::kNone;
  state_ = State::kFirst;
  return true;
}

bool IsoTpSender::next_frame(CanFrame& frame, Micros now) noexcept {
  const std::size_t capacity = fd_ ? kFdDataBytes : kClassicDataBytes;
  const std::span<const std::uint8_t> rest(pdu_.data() + sent_, size_ - sent_);
  std::size_t used = 0;

  if (state_ == State::kFirst) {
    const bool short_single = size_ < kClassicDataBytes;
    if (short_single) {
      frame.data[used++] = static_cast<std::uint8_t>(kSingle | size_);
    } else if (fd_ && size_ + 2 <= capacity) {
      frame.data[used++] = kSingle;
      frame.data[used++] = static_cast<std::uint8_t>(size_);
    } else {
      frame.data[used++] = static_cast<std::uint8_t>(kFirst | size_ >> 8U);
      frame.data[used++] = static_cast<std::uint8_t>(size_);
    }
    const std::size_t copied = fill(frame, used, capacity, rest);
    sent_ += copied;
    finish_frame(frame, used + copied, fd_);
    state_ = sent_ == size_ ? State::kIdle : State::kWaitFlow;
    sequence_ = 1;
    deadline_from_us_ = now;
    return true;
  }

  if (state_ == State::kConsecutive && now >= not_before_us_) {
    frame.data[used++] = static_cast<std::uint8_t>(kConsecutive | (sequence_ & 0x0FU));
    const std::size_t copied = fill(frame, used, capacity, rest);
    sent_ += copied;
    finish_frame(frame, used + copied, fd_);
    ++sequence_;
    not_before_us_ = now + gap_us_;
    deadline_from_us_ = now;
    if (sent_ == size_) {
      state_ = State::kIdle;
    } else if (block_limited_ && --block_left_ == 0) {
      state_ = State::kWaitFlow;
      waits_ = 0;
    }
    return true;
  }
  return false;
}

void IsoTpSender::on_flow_control(std::span<const std::uint8_t> data, const IsoTpConfig& config,
                                  Micros now) noexcept {
  if (state_ != State::kWaitFlow || data.size() < 3) return;
  const std::uint8_t status = data[0] & 0x0FU;
  if (status == kContinue) {
    block_left_ = data[1];
    block_limited_ = block_left_ != 0;
    gap_us_ = gap_of_st_min(data[2]);
    not_before_us_ = now;
    deadline_from_us_ = now;
    state_ = State::kConsecutive;
  } else if (status == kWait) {
    deadline_from_us_ = now;
    if (++waits_ > kMaxWaits) fail(IsoTpError::kTooManyWaits);
  } else {
    fail(status == kOverflowStatus ? IsoTpError::kOverflow : IsoTpError::kInvalidFlowControl);
  }
  poll(config, now);
}

void IsoTpSender::poll(const IsoTpConfig& config, Micros now) noexcept {
  switch (state_) {
    case State::kIdle:
      break;
    case State::kWaitFlow:
      if (expired(deadline_from_us_, config.flow_timeout_us, now)) fail(IsoTpError::kFlowTimeout);
      break;
    case State::kFirst:
    case State::kConsecutive:
      if (expired(std::max(deadline_from_us_, not_before_us_), config.send_timeout_us, now) &&
          now > not_before_us_) {
        fail(IsoTpError::kSendTimeout);
      }
      break;
  }
}

Micros IsoTpSender::gap(Micros now) const noexcept {
  return state_ == State::kConsecutive && not_before_us_ > now ? not_before_us_ - now : 0;
}

void IsoTpSender::fail(IsoTpError error) noexcept {
  error_ = error;
  state_ = State::kIdle;
}

IsoTpError IsoTpSender::take_error() noexcept {
  const IsoTpError error = error_;
  error_ = IsoTpError::kNone;
  return error;
}

// --- Receiver

void IsoTpReceiver::begin(std::span<const std::uint8_t> first_bytes, std::size_t size, const CanFrame& frame,
                          Micros now) noexcept {
  if (receiving_) error_ = IsoTpError::kUnexpectedPdu;
  receiving_ = false;
  flow_due_ = false;
  if (complete_) return;  // nobody took the last one yet
  size_ = size;
  got_ = std::min(first_bytes.size(), size);
  std::copy_n(first_bytes.begin(), got_, pdu_.begin());
  fd_ = frame.fd;
  frame_bytes_ = frame.size;
  last_us_ = now;
  if (got_ == size_) {
    complete_ = true;
    return;
  }
  receiving_ = true;
  flow_due_ = true;
  sequence_ = 1;
}

void IsoTpReceiver::on_frame(const CanFrame& frame, const IsoTpConfig& config, Micros now) noexcept {
  const std::span<const std::uint8_t> data = frame.bytes();
  if (data.empty()) return;
  const std::uint8_t low = data[0] & 0x0FU;

  switch (data[0] & 0xF0U) {
    case kSingle: {
      const bool escaped = low == 0 && data.size() > kClassicDataBytes;
      if (!escaped) {
        // An FD frame of more than 8 bytes must use the escape.
        if (low == 0 || data.size() > kClassicDataBytes || data.size() < std::size_t{low} + 1) return;
        begin(data.subspan(1), low, frame, now);
        return;
      }
      const std::size_t size = data[1];
      if (size < kClassicDataBytes - 1 || data.size() < size + 2) return;
      begin(data.subspan(2), size, frame, now);
      return;
    }
    case kFirst: {
      if (data.size() < kClassicDataBytes) return;
      const std::size_t size = static_cast<std::size_t>(low) << 8U | data[1];
      if (size == 0) {  // a length of 32 bits: longer than any PDU of ours
        abort();
        overflow_due_ = true;
        error_ = IsoTpError::kOverflow;
        return;
      }
      // What fits a single frame of this size must come in one.
      if (size < (data.size() == kClassicDataBytes ? kClassicDataBytes : data.size() - 1U)) return;
      begin(data.subspan(2), size, frame, now);
      return;
    }
    case kConsecutive: {
      if (!receiving_) return;
      const std::size_t left = size_ - got_;
      const bool last = left < frame_bytes_;
      const bool whole =
          last ? data.size() >= left + 1 && data.size() <= frame_bytes_ : data.size() == frame_bytes_;
      if (low != (sequence_ & 0x0FU) || !whole || flow_due_) {
        abort();
        error_ = IsoTpError::kWrongSequence;
        return;
      }
      const std::size_t bytes = std::min(left, data.size() - 1);
      std::copy_n(data.begin() + 1, bytes, pdu_.begin() + static_cast<std::ptrdiff_t>(got_));
      got_ += bytes;
      ++sequence_;
      last_us_ = now;
      if (got_ == size_) {
        receiving_ = false;
        complete_ = true;
      } else if (config.block_size != 0 && --block_left_ == 0) {
        flow_due_ = true;
      }
      return;
    }
    default:
      return;  // flow control is the sender's; the rest is reserved
  }
}

void IsoTpReceiver::poll(const IsoTpConfig& config, Micros now) noexcept {
  if (receiving_ && expired(last_us_, config.receive_timeout_us, now)) {
    abort();
    error_ = IsoTpError::kReceiveTimeout;
  }
}

bool IsoTpReceiver::next_flow_control(CanFrame& frame, const IsoTpConfig& config) noexcept {
  if (!flow_due_ && !overflow_due_) return false;
  frame.data[0] = static_cast<std::uint8_t>(kFlowControl | (overflow_due_ ? kOverflowStatus : kContinue));
  frame.data[1] = config.block_size;
  frame.data[2] = config.st_min;
  finish_frame(frame, 3, config.fd);
  block_left_ = config.block_size;
  flow_due_ = overflow_due_ = false;
  return true;
}

IsoTpError IsoTpReceiver::take_error() noexcept {
  const IsoTpError error = error_;
  error_ = IsoTpError::kNone;
  return error;
}

// --- Channel

bool IsoTpChannel::on_frame(const CanFrame& frame, Micros now) noexcept {
  if (!frame.extended || frame.remote || frame.id != receive_id_) return false;
  if (frame.size != 0 && (frame.data[0] & 0xF0U) == kFlowControl) {
    sender_.on_flow_control(frame.bytes(), config_, now);
  } else {
    receiver_.on_frame(frame, config_, now);
  }
  return true;
}

void IsoTpChannel::poll(Micros now) noexcept {
  sender_.poll(config_, now);
  receiver_.poll(config_, now);
}

bool IsoTpChannel::next_frame(CanFrame& frame, Micros now) noexcept {
  CanFrame next;
  if (!receiver_.next_flow_control(next, config_) && !sender_.next_frame(next, now)) return false;
  next.id = transmit_id_;
  next.extended = true;
  frame = next;
  return true;
}

void IsoTpChannel::abort() noexcept {
  sender_.abort();
  receiver_.abort();
  receiver_.release();
}

IsoTpError IsoTpChannel::take_error() noexcept {
  const IsoTpError error = sender_.take_error();
  return error != IsoTpError::kNone ? error : receiver_.take_error();
}

}  // namespace thimble::firmware::link

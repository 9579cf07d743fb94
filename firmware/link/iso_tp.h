// ISO 15765-2 (ISO-TP): PDUs of 1 to 4095 bytes over CAN frames of 8 or 64 bytes, with flow control.
//
// Who calls it: firmware/services/router.h on the controller, one channel for each host, and the host's client; always from
// one context:
//
//   channel.send(pdu, now);                          // copies; one at a time each way
//   channel.on_frame(frame, now);                    // frames with the peer's id
//   channel.poll(now);                               // deadlines
//   while (channel.next_frame(frame, now)) ...       // what is to be sent now
//   if (!channel.received().empty()) { ...; channel.release(); }
//
// Every wait ends: in a frame or, after its timeout, in an error that error() shows once. A PDU arrives whole
// or not at all; ISO-TP itself cannot see that exactly 16 frames in a row were lost or exchanged, hence the
// CRC above it.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "firmware/link/can_frame.h"

namespace thimble::firmware::link {

struct IsoTpConfig {
  bool fd = false;              // send in FD frames; a server follows its peer
  std::uint8_t block_size = 0;  // frames between two flow controls that we ask of the peer; 0: no limit
  std::uint8_t st_min = 0;  // gap between frames that we ask of the peer: 0..0x7F ms, 0xF1..0xF9 100..900 us
  Micros send_timeout_us = 1'000'000;     // N_As: a frame waits for next_frame()
  Micros flow_timeout_us = 1'000'000;     // N_Bs: a flow control from the peer
  Micros receive_timeout_us = 1'000'000;  // N_Cr: the next frame from the peer
};

enum class IsoTpError : std::uint8_t {
  kNone,
  kSendTimeout,         // nobody took our frames
  kFlowTimeout,         // no flow control came
  kReceiveTimeout,      // the peer stopped in the middle
  kWrongSequence,       // a frame was lost, repeated or exchanged
  kUnexpectedPdu,       // a new PDU began in the middle of another (the new one is taken)
  kOverflow,            // the peer has no room, or its PDU is longer than ours
  kInvalidFlowControl,  // a reserved flow status
  kTooManyWaits,        // the peer said "wait" more than kMaxWaits times
};
[[nodiscard]] const char* name(IsoTpError error) noexcept;

class IsoTpSender {
 public:
  static constexpr std::size_t kMaxPdu = 4095;
  static constexpr unsigned kMaxWaits = 16;  // N_WFTmax

  // False when one is on its way or the size is not 1..4095.
  [[nodiscard]] bool start(std::span<const std::uint8_t> pdu, bool fd, Micros now) noexcept;
  void on_flow_control(std::span<const std::uint8_t> data, const IsoTpConfig& config, Micros now) noexcept;
  void poll(const IsoTpConfig& config, Micros now) noexcept;
  [[nodiscard]] bool next_frame(CanFrame& frame, Micros now) noexcept;  // sets data, size and fd, not the id
  void abort() noexcept { state_ = State::kIdle; }

  [[nodiscard]] bool busy() const noexcept { return state_ != State::kIdle; }
  // Microseconds until next_frame() will have something again because of the peer's STmin; 0: now or not at
  // all.
  [[nodiscard]] Micros gap(Micros now) const noexcept;
  [[nodiscard]] IsoTpError take_error() noexcept;

 private:
  enum class State : std::uint8_t { kIdle, kFirst, kWaitFlow, kConsecutive };
  void fail(IsoTpError error) noexcept;

  State state_ = State::kIdle;
  IsoTpError error_ = IsoTpError::kNone;
  bool fd_ = false;
  std::uint8_t sequence_ = 0;
  std::uint8_t block_left_ = 0;  // 0 with no limit
  bool block_limited_ = false;
  unsigned waits_ = 0;
  Micros gap_us_ = 0;
  Micros not_before_us_ = 0;
  Micros deadline_from_us_ = 0;
  std::size_t size_ = 0;
  std::size_t sent_ = 0;
  std::array<std::uint8_t, kMaxPdu> pdu_{};
};

class IsoTpReceiver {
 public:
  void on_frame(const CanFrame& frame, const IsoTpConfig& config, Micros now) noexcept;
  void poll(const IsoTpConfig& config, Micros now) noexcept;
  [[nodiscard]] bool next_flow_control(CanFrame& frame, const IsoTpConfig& config) noexcept;

  [[nodiscard]] std::span<const std::uint8_t> received() const noexcept {
    return complete_ ? std::span<const std::uint8_t>(pdu_.data(), size_) : std::span<const std::uint8_t>();
  }
  void release() noexcept { complete_ = false; }
  void abort() noexcept { receiving_ = flow_due_ = overflow_due_ = false; }
  [[nodiscard]] bool fd() const noexcept { return fd_; }  // the last PDU came in FD frames
  [[nodiscard]] bool receiving() const noexcept { return receiving_; }
  [[nodiscard]] IsoTpError take_error() noexcept;

 private:
  void begin(std::span<const std::uint8_t> first_bytes, std::size_t size, const CanFrame& frame,
             Micros now) noexcept;

  bool complete_ = false;
  bool receiving_ = false;
  bool flow_due_ = false;
  bool overflow_due_ = false;
  bool fd_ = false;
  IsoTpError error_ = IsoTpError::kNone;
  std::uint8_t sequence_ = 0;
  std::uint8_t block_left_ = 0;
  std::uint8_t frame_bytes_ = 8;  // RX_DL: the size of the first frame; all but the last have it too
  Micros last_us_ = 0;
  std::size_t size_ = 0;
  std::size_t got_ = 0;
  std::array<std::uint8_t, IsoTpSender::kMaxPdu> pdu_{};
};

// Both directions over one pair of 29-bit ids.
class IsoTpChannel {
 public:
  IsoTpChannel() noexcept = default;  // set_ids() follows
  IsoTpChannel(std::uint32_t transmit_id, std::uint32_t receive_id, const IsoTpConfig& config = {}) noexcept
      : transmit_id_(transmit_id), receive_id_(receive_id), config_(config) {}

  // Another peer: what is under way with the last one is given up.
  void set_ids(std::uint32_t transmit_id, std::uint32_t receive_id) noexcept {
    abort();
    transmit_id_ = transmit_id;
    receive_id_ = receive_id;
  }

  // False when one is on its way or the size is not 1..4095.
  [[nodiscard]] bool send(std::span<const std::uint8_t> pdu, Micros now) noexcept {
    return sender_.start(pdu, config_.fd, now);
  }
  // False: the frame is not the peer's. A PDU that comes while received() is not released yet is dropped.
  bool on_frame(const CanFrame& frame, Micros now) noexcept;
  void poll(Micros now) noexcept;
  [[nodiscard]] bool next_frame(CanFrame& frame, Micros now) noexcept;

  [[nodiscard]] std::span<const std::uint8_t> received() const noexcept { return receiver_.received(); }
  [[nodiscard]] bool received_fd() const noexcept { return receiver_.fd(); }
  void release() noexcept { receiver_.release(); }
  void abort_send() noexcept { sender_.abort(); }
  void abort() noexcept;

  [[nodiscard]] bool sending() const noexcept { return sender_.busy(); }
  [[nodiscard]] bool receiving() const noexcept { return receiver_.receiving(); }
  [[nodiscard]] Micros gap(Micros now) const noexcept { return sender_.gap(now); }
  // Why the last PDU was given up, once; a failure to send comes first.
  [[nodiscard]] IsoTpError take_error() noexcept;

  IsoTpConfig& config() noexcept { return config_; }

 private:
  std::uint32_t transmit_id_ = 0;
  std::uint32_t receive_id_ = 0;
  IsoTpConfig config_;
  IsoTpSender sender_;
  IsoTpReceiver receiver_;
};

}  // namespace thimble::firmware::link

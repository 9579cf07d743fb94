// The controller's end of the services: ISO-TP and request handling over an abstract backend.
//
// Who calls it: the controller, always from one context (the background one), as
//
//   server.on_frame(frame, now);                        // every frame received; false: not for the services
//   server.poll(now);                                   // often (every 10 ms or faster): deadlines and
//   pending work while (server.next_frame(frame, now)) send(frame);  // after the real-time frames, as far as
//   the bus takes them
//
// No heap, no I/O; about 8.5 kB. Every wait has a deadline, so a host that vanishes leaves the server ready
// for the next.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "firmware/link/can_frame.h"
#include "firmware/link/iso_tp.h"
#include "firmware/link/messages.h"
#include "firmware/link/services.h"

namespace thimble::firmware::link {

// Appends to a buffer that is large enough or remembers that it was not.
class ByteWriter {
 public:
  explicit ByteWriter(std::span<std::uint8_t> out) noexcept : out_(out) {}
  void put(std::uint8_t value) noexcept;
  void put_u16(std::uint16_t value) noexcept;  // big-endian, as ISO 14229 has it
  void put_u32(std::uint32_t value) noexcept;  // big-endian
  void put(std::span<const std::uint8_t> bytes) noexcept;
  void put_text(const char* text) noexcept;  // without its end; null counts as empty
  template <class Message>
  void put_record(const Message& message) noexcept;  // a record of messages.def

  [[nodiscard]] std::size_t size() const noexcept { return size_; }
  [[nodiscard]] bool overflowed() const noexcept { return overflowed_; }
  [[nodiscard]] std::span<std::uint8_t> free_space() noexcept { return out_.subspan(size_); }
  void advance(std::size_t bytes) noexcept;  // after writing into free_space()

 private:
  std::span<std::uint8_t> out_;
  std::size_t size_ = 0;
  bool overflowed_ = false;
};

struct FaultRecord {
  std::uint8_t number = 0;  // of firmware/core/faults.def; never 0
  std::uint8_t status = 0;  // kFaultActive | kFaultConfirmed
};

// What the controller does for the services. A function that returns Nrc::kResponsePending has begun
// something longer: it is called again with the same arguments at every poll() until it returns something
// else (at most kPendingLimit_us, then it is given up and the host gets kGeneralReject). None may block.
class ServiceBackend {
 public:
  // Appends the value of a data identifier: a record, a text (services.h) or a parameter (params.def).
  // kRequestOutOfRange: there is none.
  [[nodiscard]] virtual Nrc read_data(std::uint16_t did, ByteWriter& out) noexcept = 0;
  // kRequestOutOfRange: no such parameter, or the value is not allowed; kIncorrectLength;
  // kConditionsNotCorrect: not now.
  [[nodiscard]] virtual Nrc write_data(std::uint16_t did, std::span<const std::uint8_t> data) noexcept = 0;

  // kConditionsNotCorrect when refused; kDidRefusal then says why.
  [[nodiscard]] virtual Nrc arm() noexcept = 0;
  [[nodiscard]] virtual Nrc disarm() noexcept = 0;
  [[nodiscard]] virtual Nrc home() noexcept = 0;      // kOk: homing began; the mode tells when it is done
  [[nodiscard]] virtual Nrc activate() noexcept = 0;  // the finished download becomes the running scene

  // kConditionsNotCorrect: the motors are on; kProgrammingFailure: the store refused.
  [[nodiscard]] virtual Nrc save_parameters() noexcept = 0;

  // A guarded move. kRequestOutOfRange: the order's values; kConditionsNotCorrect: not now. move_samples appends
  // MoveSamples, and has kRequestSequenceError while the arm goes or comes back.
  [[nodiscard]] virtual Nrc start_move(const MoveOrder& order) noexcept = 0;
  [[nodiscard]] virtual Nrc end_move() noexcept = 0;
  [[nodiscard]] virtual Nrc move_samples(ByteWriter& out) noexcept = 0;

  // A trace. trace_start appends a TraceStart and the TraceArms, and has kRequestSequenceError before the first trace.
  [[nodiscard]] virtual Nrc start_trace() noexcept = 0;
  [[nodiscard]] virtual Nrc end_trace() noexcept = 0;
  [[nodiscard]] virtual Nrc trace_start(ByteWriter& out) noexcept = 0;

  // A download into the spare slot: the running scene is never touched. prepare sets `has` to the bytes of
  // this very image (same length, same CRC-32) already held, which is `length` when it is complete;
  // kDownloadNotAccepted: too long.
  [[nodiscard]] virtual Nrc prepare_download(std::uint32_t length, std::uint32_t crc,
                                             std::uint32_t& has) noexcept = 0;
  // Offsets come in order, beginning at `has`. kProgrammingFailure: the store refused.
  [[nodiscard]] virtual Nrc write_download(std::uint32_t offset,
                                           std::span<const std::uint8_t> data) noexcept = 0;
  // Every byte is there: check length, CRC and the image itself. kProgrammingFailure: the image is bad
  // (kDidRefusal says how), and it is forgotten.
  [[nodiscard]] virtual Nrc finish_download() noexcept = 0;

  [[nodiscard]] virtual std::size_t fault_count() const noexcept = 0;  // faults since the last clear
  [[nodiscard]] virtual FaultRecord fault(std::size_t index) const noexcept = 0;
  [[nodiscard]] virtual Nrc clear_faults() noexcept = 0;
  // Appends freeze frame `index` (0 = oldest; FreezeFrame of messages.def) of a fault; false: it has no such
  // frame.
  [[nodiscard]] virtual bool freeze_frame(std::uint8_t fault, std::size_t index,
                                          ByteWriter& out) const noexcept = 0;

  // Called after the positive response has left.
  virtual void reset(Reset kind) noexcept = 0;
  // A valid request was answered positively, arming excepted: what host supervision watches.
  virtual void host_alive(Micros now) noexcept = 0;

 protected:
  ~ServiceBackend() = default;
};

class ServiceServer {
 public:
  static constexpr Micros kSessionTimeout_us = 5'000'000;   // S3 of ISO 14229
  static constexpr Micros kPendingInterval_us = 1'000'000;  // between two "response pending"
  static constexpr Micros kPendingLimit_us = 30'000'000;

  // block_bytes: the most that a block of a download may hold.
  ServiceServer(ServiceBackend& backend, std::uint8_t node, const IsoTpConfig& config = {},
                std::uint16_t block_bytes = kMaxBlockBytes) noexcept;

  bool on_frame(const CanFrame& frame, Micros now) noexcept;
  void poll(Micros now) noexcept;
  bool next_frame(CanFrame& frame, Micros now) noexcept;

  [[nodiscard]] Session session() const noexcept { return session_; }
  [[nodiscard]] bool downloading() const noexcept { return downloading_; }

 private:
  void handle(Micros now) noexcept;
  void end_download() noexcept;
  [[nodiscard]] Nrc dispatch(std::span<const std::uint8_t> request, ByteWriter& out) noexcept;
  [[nodiscard]] Nrc session_control(std::span<const std::uint8_t> request, ByteWriter& out) noexcept;
  [[nodiscard]] Nrc ecu_reset(std::span<const std::uint8_t> request, ByteWriter& out) noexcept;
  [[nodiscard]] Nrc clear_faults(std::span<const std::uint8_t> request, ByteWriter& out) noexcept;
  [[nodiscard]] Nrc read_faults(std::span<const std::uint8_t> request, ByteWriter& out) noexcept;
  [[nodiscard]] Nrc read_data(std::span<const std::uint8_t> request, ByteWriter& out) noexcept;
  [[nodiscard]] Nrc write_data(std::span<const std::uint8_t> request, ByteWriter& out) noexcept;
  [[nodiscard]] Nrc routine(std::span<const std::uint8_t> request, ByteWriter& out) noexcept;
  [[nodiscard]] Nrc move_routine(std::uint8_t action, std::span<const std::uint8_t> arguments,
                                 ByteWriter& out) noexcept;
  [[nodiscard]] Nrc trace_routine(std::uint8_t action, std::span<const std::uint8_t> arguments,
                                  ByteWriter& out) noexcept;
  [[nodiscard]] Nrc request_download(std::span<const std::uint8_t> request, ByteWriter& out) noexcept;
  [[nodiscard]] Nrc transfer_data(std::span<const std::uint8_t> request, ByteWriter& out) noexcept;
  [[nodiscard]] Nrc transfer_exit(std::span<const std::uint8_t> request, ByteWriter& out) noexcept;
  [[nodiscard]] Nrc tester_present(std::span<const std::uint8_t> request, ByteWriter& out) noexcept;

  ServiceBackend& backend_;
  std::uint16_t block_bytes_;
  IsoTpChannel channel_;
  std::array<std::uint8_t, kMaxPduBytes> response_{};

  Session session_ = Session::kDefault;
  Micros last_request_us_ = 0;

  bool pending_ = false;  // the request in channel_ is handled again at the next poll
  Micros pending_since_us_ = 0;
  Micros pending_told_us_ = 0;

  bool reset_due_ = false;
  Reset reset_kind_ = Reset::kSoft;

  // The download: an image is prepared_ (length_, and offset_ bytes of it held); while downloading_, blocks
  // are taken.
  bool prepared_ = false;
  bool downloading_ = false;
  bool finished_ = false;  // the last download ended well
  std::uint32_t length_ = 0;
  std::uint32_t offset_ = 0;
  std::uint8_t last_block_ = 0;
  bool any_block_ = false;
};

template <class Message>
void ByteWriter::put_record(const Message& message) noexcept {
  const std::size_t bytes = encode(message, free_space());
  if (bytes == 0) overflowed_ = true;
  size_ += bytes;
}

}  // namespace thimble::firmware::link

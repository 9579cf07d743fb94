// The controller's end of the services: hosts and their addresses, requests from frames to a handler, and answers from the
// handler to frames. It contains the rules of ISO 15765-2 and ISO 14229-1 that hold for every service, and none of one service.
//
// Who calls it: the controller, always from the background context, as
//
//   router.on_frame(frame, now);                        // every frame received; false: not for the services
//   router.poll(now);                                   // every 10 ms or more often: deadlines and pending requests
//   while (router.next_frame(frame, now)) send(frame);  // after the real-time frames, as far as the bus takes them
//
// Every host has a place of its own: address, ISO-TP channel, session, and one request at a time. A request that comes while
// the host's last one is not answered yet is dropped; where it is urgent, the last one is given up instead. What other hosts do has no
// effect on it. A place is free again when its host was silent for link::kHostTimeout_us.
//
// No heap, no I/O; about 38 kB, most of it the ISO-TP buffers of link::kMaxHosts hosts.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "firmware/link/can_frame.h"
#include "firmware/link/host_address.h"
#include "firmware/link/iso_tp.h"
#include "firmware/link/services.h"
#include "firmware/services/call.h"
#include "firmware/services/host_table.h"

namespace thimble::firmware {

// What the services do; none of the functions may block.
class RequestHandler {
 public:
  // kResponsePending: not finished. handle() is then called again at every poll until it returns another result. After
  // kPendingLimit_us the host gets kGeneralReject, and give_up() is called.
  [[nodiscard]] virtual Nrc handle(Call& call) noexcept = 0;
  // Whether a request goes before one of the same host that is pending: a disarm.
  [[nodiscard]] virtual bool urgent(std::span<const std::uint8_t> request) const noexcept = 0;
  virtual void give_up(Host& host) noexcept = 0;  // the host's pending request
  // The host left, or was silent for too long.
  virtual void session_ended(Host& host) noexcept = 0;
  // It had a positive answer, and Call::sign_of_life was not taken away.
  virtual void host_alive(const Host& host, link::Micros now) noexcept = 0;
  virtual void restart(link::Reset kind) noexcept = 0;  // asked for by a host that has had its answer

 protected:
  ~RequestHandler() = default;
};

class Router {
 public:
  static constexpr link::Micros kSessionTimeout_us = link::kHostTimeout_us;  // S3 of ISO 14229
  static constexpr link::Micros kPendingInterval_us = 1'000'000;             // between two "response pending"
  static constexpr link::Micros kPendingLimit_us = 30'000'000;

  Router(RequestHandler& handler, std::uint8_t node, const link::IsoTpConfig& config = {}) noexcept;

  bool on_frame(const link::CanFrame& frame, link::Micros now) noexcept;
  void poll(link::Micros now) noexcept;
  [[nodiscard]] bool next_frame(link::CanFrame& frame, link::Micros now) noexcept;

  // Of the host with an address; null: nobody has it.
  [[nodiscard]] const Host* host(std::uint8_t address) const noexcept;

 private:
  struct Place {
    link::IsoTpChannel channel;
    Host host;
    bool grant_due = false;
    bool leaving = false;  // released while a request was pending: free once that has ended
    bool pending = false;  // the request in the channel is handled again at the next poll
    link::Micros pending_since_us = 0;
    link::Micros pending_told_us = 0;
  };

  void on_claim(const link::HostClaim& claim, link::Micros now) noexcept;
  [[nodiscard]] std::optional<std::size_t> tester_place(const link::CanFrame& frame,
                                                        link::Micros now) noexcept;
  void answer_without_place(const link::CanFrame& frame, link::Micros now) noexcept;
  [[nodiscard]] bool is_urgent(const link::CanFrame& frame) const noexcept;
  void open(std::size_t index, link::Micros now) noexcept;
  void leave(std::size_t index) noexcept;
  void poll(std::size_t index, link::Micros now) noexcept;
  void serve(Place& place, link::Micros now) noexcept;
  // What is to be said of a pending request now; kOk: nothing.
  [[nodiscard]] Nrc judge_pending(Place& place, link::Micros now) noexcept;
  [[nodiscard]] Nrc handle(Call& call) noexcept;

  RequestHandler& handler_;
  std::uint8_t node_;
  link::IsoTpConfig config_;
  HostTable hosts_;
  std::array<Place, HostTable::kPlaces> places_;
  std::array<std::uint8_t, link::kMaxPduBytes> answer_{};  // of the request that is handled now
  std::size_t turn_ = 0;                    // the place that sends first, and is polled first: each in turn
  std::optional<link::HostGrant> refused_;  // a claim while all places were taken
  std::optional<link::CanFrame> placeless_answer_;  // to a tester while all places were taken
};

}  // namespace thimble::firmware

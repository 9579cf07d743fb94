// Requests to a device and their answers: UDS services over ISO-TP (docs/link.md), with deadlines and repeats, from an address
// that the program claims for itself (host_claim.h).
// Device (device.h) and upload_image() (upload.h) use it; a program uses Device. One thread.
//
// Errors: kLinkLost, the device did not answer in time. kRefused, the answer is negative, or as many other hosts are
// connected as the device serves. kCommanded, another program commands the device. kPermission, it
// wants a proof of its key, and there is none, or it is wrong. kFaulted, the answer is negative because the device has a fault. kVersion, a record is
// shorter than this version of the link says. The transport's errors pass through.
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "firmware/link/iso_tp.h"
#include "firmware/link/messages.h"
#include "firmware/link/proof.h"
#include "firmware/link/services.h"
#include "host-tools/client/host_claim.h"
#include "host-tools/client/transport.h"
#include "host-tools/error.h"

namespace thimble::host {

// Proves to the board with this node number that the host with this address has its key (key_file.h). May throw Error.
using Prover =
    std::function<link::Proof(std::uint8_t node, std::uint8_t address, const link::Challenge& challenge)>;

struct DeviceOptions {
  std::uint8_t node = 1;
  link::Micros answer_us = 400'000;  // how long one try waits for an answer
  unsigned tries = 5;
  // False: where the device serves as many hosts as it can, do not wait until a place is free, and send from
  // link::kTesterAddress. The device answers that address in single frames (demand_without_place()).
  bool needs_place = true;
  Prover
      prove;  // called where the device takes commands only from who has its key; empty: it is not to be commanded then
  // While a request waits for another program: true, something urgent waits behind it, and it is given up. Empty: nothing does.
  std::function<bool()> hurry;
  std::string program;  // in the name that this host tells the device (host_name.h)
};

class ServiceClient {
 public:
  using Bytes = std::vector<std::uint8_t>;
  struct Answer {
    link::Nrc code = link::Nrc::kOk;
    Bytes bytes;  // the whole answer if it is positive, else empty
  };

  // Claims an address. A device that gives none in time may be of another version: then requests leave from
  // link::kTesterAddress until claim_address() has one.
  ServiceClient(std::unique_ptr<Transport> transport, const DeviceOptions& options);
  ServiceClient(ServiceClient&&) = default;
  ServiceClient& operator=(ServiceClient&&) = delete;  // it would have two addresses
  ~ServiceClient();

  // So long an answer is waited for, all tries together.
  [[nodiscard]] link::Micros patience_us() const { return options_.answer_us * options_.tries; }

  // Claims one if there is none yet. Error kLinkLost: the device gives none.
  void claim_address();

  // Sends `request` and waits for its answer, `tries` times `answer_us` each. Nothing: there was none. Answers to other
  // requests are skipped.
  // pending_us: how long to wait for more after "response pending" (P2*).
  [[nodiscard]] std::optional<Answer> try_request(const Bytes& request, unsigned tries,
                                                  link::Micros answer_us,
                                                  link::Micros pending_us = 5'000'000);
  // The same with the tries of the options; repeats while the device answers "busy", at most kBusy_us, and once it has proven that it has
  // the key where that is needed. Error kLinkLost without an answer.
  [[nodiscard]] Answer request(const Bytes& request);
  // The same for what must not be done twice. Where its answer does not come, it is not repeated, because it may have been done: nothing.
  [[nodiscard]] std::optional<Answer> request_once(const Bytes& request);
  // The positive answer. `what` begins the message of the error: "<what> was refused: <reason>".
  Bytes demand(const Bytes& request, const std::string& what);
  // The same for a request and an answer of one frame each in the default session, as disarming: it does not wait for a place.
  // When the device has none, the request leaves from link::kTesterAddress.
  Bytes demand_without_place(const Bytes& request, const std::string& what);
  [[nodiscard]] std::uint8_t address() const { return claim_.address(); }
  // False: the device had no place when this program asked last.
  [[nodiscard]] bool has_place() const { return !claim_refused_; }
  // Throws the error for a negative answer; asks the device for its reason.
  [[noreturn]] void refused(const std::string& what, link::Nrc code);
  [[noreturn]] void faulted(const std::string& what, std::uint8_t fault);

  // Opens a session. The first one tells the device the time: it may have been off, and its motors have cooled (docs/safety.md). The first
  // one in a place, and after every silence or lost answer, tells this host's name.
  void enter(link::Session session);
  [[nodiscard]] link::DeviceState state();
  // A record of text; empty if the device refuses to give it.
  [[nodiscard]] std::string text(std::uint16_t did);
  [[nodiscard]] static Bytes read_request(std::uint16_t did);
  // A record of messages.def. `what` as in demand(): "reading the state".
  template <class Record>
  [[nodiscard]] Record record(const std::string& what) {
    const Bytes answer = demand(read_request(Record::kId), what);
    Record record;
    if (!link::decode(std::span(answer).subspan(3), record)) too_short(what);
    return record;
  }

  // Handles frames until `deadline_us`.
  void wait_until(link::Micros deadline_us);
  // A tester-present that asks for no answer.
  void keep_alive();
  // A request in one frame, whose answer nobody waits for.
  void say(const Bytes& request);
  void send(const link::CanFrame& frame) { transport_->send(frame); }
  // The next real-time frame of the device; nothing after `deadline_us`.
  [[nodiscard]] std::optional<link::CanFrame> telemetry(link::Micros deadline_us);
  // Called with every real-time frame, also with those that come while an answer is awaited. It must not make requests.
  void set_listener(std::function<void(const link::CanFrame&)> heard) { heard_ = std::move(heard); }

  // From now on with FD frames, if the transport carries them.
  void use_fd() { channel_.config().fd = transport_->carries_fd(); }
  [[nodiscard]] const DeviceOptions& options() const { return options_; }

 private:
  void pump(link::Micros deadline_us);
  void take_service_frame(const link::CanFrame& frame);
  void listen();
  // Claims, again and again until `deadline_us`. False: no grant came; or there is no place and options_.needs_place is false, so
  // requests leave from link::kTesterAddress. Error kRefused: no place became free.
  bool claim_until(link::Micros deadline_us);
  // try_request() with the tries of the options. Error kLinkLost without an answer.
  [[nodiscard]] Answer ask(const Bytes& request);
  // Repeats `answer`, which ask() gave, as request() says.
  template <class Ask>
  [[nodiscard]] std::optional<Answer> insist(const Ask& ask);
  [[nodiscard]] link::Micros passes_within(const Answer& answer);
  // Service 29.
  void authenticate();
  void tell_time();
  [[nodiscard]] std::optional<Answer> await_answer(const Bytes& request, link::Micros answer_us,
                                                   link::Micros pending_us);
  [[noreturn]] static void too_short(const std::string& what);

  std::unique_ptr<Transport> transport_;
  DeviceOptions options_;
  HostClaim claim_;
  bool claims_ = false;         // the device grants places: it has granted one
  bool claim_refused_ = false;  // the device's last word
  link::IsoTpChannel channel_;
  bool time_told_ = false;
  bool name_told_ = false;  // in this place, as far as is known
  std::function<void(const link::CanFrame&)> heard_;
  std::deque<link::CanFrame> unread_;  // of a CAN FD frame that stands for several
};

}  // namespace thimble::host

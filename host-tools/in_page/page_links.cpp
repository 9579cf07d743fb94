#include "host-tools/in_page/page_links.h"

#include <algorithm>
#include <utility>

#include "firmware/link/messages.h"
#include "host-tools/error.h"
#include "host-tools/in_page/exports.h"

// Leaves the module for this time, or until the page goes on earlier: Binaryen's Asyncify puts the stack away and back.
THIMBLE_IMPORT(void, wait)(double ms);

namespace thimble::host {

void wait_for_page(link::Micros time_us) { page_wait(static_cast<double>(time_us) * 1e-3); }

namespace {

constexpr std::string_view kOpen = "O\r";

// The next of `frames`, once there is one.
template <class Lost>
std::optional<link::CanFrame> next_of(std::deque<link::CanFrame>& frames, link::Micros deadline_us,
                                      const Lost& throw_if_lost) {
  while (frames.empty()) {
    throw_if_lost();
    const link::Micros now = now_us();
    if (now >= deadline_us) return std::nullopt;
    wait_for_page(deadline_us - now);
  }
  const link::CanFrame frame = frames.front();
  frames.pop_front();
  return frame;
}

}  // namespace

class InnerLink::End final : public Transport {
 public:
  explicit End(InnerLink& inner) : inner_(inner) { inner_.to_host_.clear(); }
  void send(const link::CanFrame& frame) override { inner_.to_board_.push_back(frame); }
  std::optional<link::CanFrame> receive(link::Micros deadline_us) override {
    return next_of(inner_.to_host_, deadline_us, [] {});
  }

 private:
  InnerLink& inner_;
};

std::unique_ptr<Transport> InnerLink::connect() { return std::make_unique<End>(*this); }

std::optional<link::CanFrame> InnerLink::receive() {
  if (to_board_.empty()) return std::nullopt;
  const link::CanFrame frame = to_board_.front();
  to_board_.pop_front();
  return frame;
}

class SerialLink::End final : public Transport {
 public:
  explicit End(SerialLink& serial) : serial_(serial) {
    // As SlcanTransport: ends a channel that was left open, 1 Mbit/s, open.
    serial_.frames_.clear();
    serial_.parser_ = {};
    serial_.out_ += "\rC\rS8\rO\r";
  }
  ~End() override { serial_.out_ += "C\r"; }
  void send(const link::CanFrame& frame) override {
    link::SlcanLine line;
    serial_.out_.append(line.data(), link::encode_slcan(frame, line));
    // A closed channel hears it, and does not say so.
    if (!frame.extended && frame.id == link::EmergencyStop::kId) serial_.out_ += kOpen;
  }
  std::optional<link::CanFrame> receive(link::Micros deadline_us) override {
    return next_of(serial_.frames_, deadline_us, [this] { serial_.throw_if_closed(); });
  }

 private:
  SerialLink& serial_;
};

std::unique_ptr<Transport> SerialLink::connect() {
  throw_if_closed();
  return std::make_unique<End>(*this);
}

void SerialLink::throw_if_closed() const {
  if (open_) return;
  throw Error(ExitCode::kLinkLost, "port-closed", "the serial port is closed",
              "plug the device in, and choose its port again");
}

void SerialLink::set_open(bool open) {
  open_ = open;
  frames_.clear();
  out_.clear();
}

void SerialLink::take(std::string_view bytes) {
  constexpr std::size_t kMostFrames = 65536;  // that nobody has taken
  for (const char byte : bytes)
    if (parser_.push(byte) == link::SlcanParser::Event::kFrame && frames_.size() < kMostFrames)
      frames_.push_back(parser_.frame());
}

}  // namespace thimble::host

#include "board/posix/link_ports.h"

#include <algorithm>
#include <ctime>

namespace thimble::board {
namespace {

constexpr std::uint64_t kFlushPeriod_us = 1000;

}  // namespace

std::vector<std::string> LinkPorts::uris() const {
  std::vector<std::string> all;
  for (const auto& port : ports_) {
    for (std::string& uri : port->uris()) all.push_back(std::move(uri));
  }
  return all;
}

void LinkPorts::wait(std::uint64_t timeout_us) {
  polled_.clear();
  for (const auto& port : ports_) {
    port->add_to(polled_);
    if (port->waiting()) timeout_us = std::min(timeout_us, kFlushPeriod_us);
  }
  const timespec timeout{static_cast<time_t>(timeout_us / 1'000'000),
                         static_cast<long>(timeout_us % 1'000'000 * 1000)};
  static_cast<void>(ppoll(polled_.data(), polled_.size(), &timeout, nullptr));
  for (const auto& port : ports_) port->read();
}

std::optional<firmware::link::CanFrame> LinkPorts::receive() {
  for (const auto& port : ports_) {
    if (auto frame = port->receive()) return frame;
  }
  return std::nullopt;
}

void LinkPorts::send(const firmware::link::CanFrame& frame) {
  for (const auto& port : ports_) port->send(frame);
}

void LinkPorts::flush() {
  for (const auto& port : ports_) port->flush();
}

std::uint64_t LinkPorts::dropped() const {
  std::uint64_t frames = 0;
  for (const auto& port : ports_) frames += port->dropped();
  return frames;
}

std::uint32_t LinkPorts::classic_bits_per_s() const {
  std::uint32_t slowest = 0;
  for (const auto& port : ports_) {
    const std::uint32_t rate = port->classic_bits_per_s();
    if (rate != 0 && (slowest == 0 || rate < slowest)) slowest = rate;
  }
  return slowest;
}

std::optional<std::string> LinkPorts::news() {
  std::string all;
  for (const auto& port : ports_) {
    const std::string one = port->trouble();
    if (!one.empty()) all += (all.empty() ? "" : "; ") + one;
  }
  if (all == trouble_) return std::nullopt;
  trouble_ = all;
  return all.empty() ? "the link is whole again" : all;
}

}  // namespace thimble::board

#include "board/sim/live_loop.h"

#include <algorithm>
#include <chrono>
#include <utility>

namespace thimble::board {
namespace {

// If the simulation is late by more than this, simulated time is skipped instead of caught up, because a
// burst of ticks would be worse. This is also the longest delay of the link: with 0.1 s a request took 2 s
// where the simulation is slower than real time (0.7 under sanitizers).
constexpr double kMostBehind_s = 0.02;
constexpr double kSlice_s = 0.002;
// Of a flooded link: a full bus of 1 Mbit/s carries 9000 frames a second, one of 8 Mbit/s some 40 000.
constexpr double kMostFlood_Hz = 1e5;
constexpr firmware::link::CanFrame kNobodys{.id = 0x7FF, .size = 8};

std::uint64_t steady_us() {
  return static_cast<std::uint64_t>(std::chrono::duration_cast<std::chrono::microseconds>(
                                        std::chrono::steady_clock::now().time_since_epoch())
                                        .count());
}

}  // namespace

LiveLoop::LiveLoop(Carrier& carrier, Start start)
    : carrier_(carrier), start_(std::move(start)), board_(start_("power_on")), last_us_(steady_us()) {}

void LiveLoop::send_all() {
  for (firmware::link::CanFrame out; board_->controller().next_frame(out, steady_us());)
    to_hosts_.send(out, steady_us(), *board_);
  while (const std::optional<firmware::link::CanFrame> out = to_hosts_.receive(steady_us())) {
    carrier_.send(*out);
    if (!out->extended) sent_.push_back(*out);
  }
}

void LiveLoop::hear_all(double due_s) {
  while (const std::optional<firmware::link::CanFrame> frame = carrier_.receive())
    from_hosts_.send(*frame, steady_us(), *board_);
  const double rate_Hz = std::min(board_->injected(Injection::kLinkFlood).value_or(0), kMostFlood_Hz);
  for (flood_ += rate_Hz * due_s; flood_ >= 1; --flood_) from_hosts_.send(kNobodys, steady_us(), *board_);
  while (const std::optional<firmware::link::CanFrame> frame = from_hosts_.receive(steady_us())) {
    board_->controller().on_frame(*frame, steady_us());
    send_all();
  }
}

void LiveLoop::round(const std::function<void(const Round&)>& each) {
  const std::uint64_t time_us = steady_us();
  double due_s = static_cast<double>(time_us - last_us_) * 1e-6;
  last_us_ = time_us;
  if (due_s > kMostBehind_s) {
    skipped_s_ += due_s - kMostBehind_s;
    due_s = kMostBehind_s;
  }
  sent_.clear();
  // In slices: the recorder has room for Recorder::kEntries ticks.
  double left_s = due_s;
  for (; left_s > kSlice_s; left_s -= kSlice_s) {
    board_->step(kSlice_s);
    send_all();
  }
  board_->step(left_s);
  send_all();

  hear_all(due_s);
  board_->controller().tell_link_losses(static_cast<std::uint32_t>(carrier_.dropped()));
  board_->controller().poll(steady_us());
  send_all();
  if (each) each({*board_, sent_, time_us});
  if (board_->controller().take_reset()) board_ = start_("host");
}

}  // namespace thimble::board

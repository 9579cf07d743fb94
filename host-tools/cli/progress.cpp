#include "host-tools/cli/progress.h"

#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <utility>

#include "host-tools/cli/output.h"

namespace thimble::host {
namespace {

constexpr link::Micros kFirst_us = 1'000'000, kRedraw_us = 200'000;

unsigned tenth_of(double share) { return static_cast<unsigned>(10 * std::clamp(share, 0.0, 1.0)); }

// "12 s", "3 min", "2.5 h".
std::string in_words(double seconds) {
  if (seconds < 100) return fmt::format("{:.0f} s", seconds);
  if (seconds < 6000) return fmt::format("{:.0f} min", seconds / 60);
  return fmt::format("{:.1f} h", seconds / 3600);
}

}  // namespace

Progress::Progress(bool quiet, double begun_at, bool tenths)
    : quiet_(quiet),
      terminal_(isatty(STDERR_FILENO) != 0),
      tenths_(tenths),
      begun_at_(begun_at),
      begin_us_(now_us()),
      tenth_(tenth_of(begun_at)) {}

bool Progress::is_due() const {
  if (quiet_ || !terminal_) return false;
  const link::Micros now = now_us();
  return now - begin_us_ >= kFirst_us && now - shown_us_ >= kRedraw_us;
}

void Progress::draw(std::string_view line) {
  shown_us_ = now_us();
  drawn_ = true;
  fmt::print(stderr, "\r\x1b[K");
  say(stderr, "{}", line);
  std::fflush(stderr);
}

void Progress::show(std::string_view what) {
  if (is_due()) draw(what);
}

void Progress::show(double share, std::string_view what) {
  const double seconds = static_cast<double>(now_us() - begin_us_) * 1e-6;
  show(share, what, share > begun_at_ ? seconds * (1 - share) / (share - begun_at_) : 0);
}

void Progress::show(double share, std::string_view what, double left_s) {
  const bool is_tenth = !quiet_ && !terminal_ && tenths_ && tenth_of(share) != tenth_;
  if (!is_tenth && !is_due()) return;
  const std::string left = share < 1 && left_s > 0 ? fmt::format(", {} left", in_words(left_s)) : "";
  if (!is_tenth) {
    draw(fmt::format("{:.0f} %  {}{}", 100 * share, what, left));
    return;
  }
  tenth_ = tenth_of(share);
  say(stderr, "{} %  {}{}\n", 10 * tenth_, what, left);
}

void Progress::end() {
  if (drawn_) fmt::print(stderr, "\r\x1b[K");
  drawn_ = false;
}

Busy::Busy(bool quiet, std::string what) : progress_(quiet), what_(std::move(what)) {
  if (!quiet && isatty(STDERR_FILENO) != 0) watcher_ = std::thread([this] { watch(); });
}

Busy::~Busy() {
  {
    const std::lock_guard lock(mutex_);
    done_ = true;
  }
  ended_.notify_all();
  if (watcher_.joinable()) watcher_.join();
}

void Busy::watch() {
  const link::Micros begin_us = now_us();
  std::unique_lock lock(mutex_);
  while (!ended_.wait_for(lock, std::chrono::milliseconds(500), [this] { return done_; }))
    progress_.show(fmt::format("{}: {} s", what_, (now_us() - begin_us) / 1'000'000));
}

void erase_progress() {
  if (isatty(STDERR_FILENO) != 0) fmt::print(stderr, "\r\x1b[K");
}

}  // namespace thimble::host

// libgpiod 1.x. Each line is a separate request: version 1 of the kernel interface uses one file per line
// with edges.
#include <fcntl.h>
#include <gpiod.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>

#include "board/linux/gpio.h"

namespace thimble::board {
namespace gpio {

struct CloseChip {
  void operator()(gpiod_chip* chip) const noexcept { gpiod_chip_close(chip); }
  void operator()(gpiod_line* line) const noexcept { gpiod_line_close_chip(line); }
};
using Chip = std::unique_ptr<gpiod_chip, CloseChip>;
using Line = std::unique_ptr<gpiod_line, CloseChip>;

}  // namespace gpio

namespace {

using gpio::Chip;
using gpio::Line;

constexpr const char* kConsumer = "thimble-board";

Line find_on(const std::string& path, const std::string& name) {
  Chip chip(gpiod_chip_open(path.c_str()));
  Line line(chip ? gpiod_chip_find_line(chip.get(), name.c_str()) : nullptr);
  if (line) (void)chip.release();  // the line closes it
  return line;
}

// Not gpiod_line_find(), which gives up at the first chip that it may not open.
Line find(const std::string& name) {
  int refused = 0;  // a chip that could not be opened may have the line
  for (const auto& entry : std::filesystem::directory_iterator("/dev")) {
    if (!entry.path().filename().string().starts_with("gpiochip")) continue;
    errno = 0;
    if (Line line = find_on(entry.path(), name)) return line;
    if (errno != 0 && errno != ENOENT) refused = errno;
  }
  if (refused != 0) throw GpioError(name, std::strerror(refused), refused);
  throw GpioError(name, "no chip has a line of this name", ENOENT);
}

int flags(const GpioLine& line) noexcept {
  int bits = line.active_low ? GPIOD_LINE_REQUEST_FLAG_ACTIVE_LOW : 0;
  if (line.bias == GpioBias::kPullDown) bits |= GPIOD_LINE_REQUEST_FLAG_BIAS_PULL_DOWN;
  if (line.bias == GpioBias::kPullUp) bits |= GPIOD_LINE_REQUEST_FLAG_BIAS_PULL_UP;
  return bits;
}

[[noreturn]] void fail(const GpioLine& line, int error) {
  throw GpioError(line.name, std::strerror(error), error);
}

}  // namespace

std::string gpio_library() { return std::string("libgpiod ") + gpiod_version_string(); }

bool gpio_chip_has_line(const std::string& chip, const std::string& name) {
  return find_on(chip, name) != nullptr;
}

struct GpioInputs::Impl {
  std::vector<Line> lines;
  std::array<gpiod_line_event, kEdgesPerLine> events;
};

GpioInputs::GpioInputs(std::span<const GpioLine> lines) : impl_(std::make_unique<Impl>()) {
  if (lines.size() > kMaxLines) throw GpioError(lines[kMaxLines].name, "one input too many", E2BIG);
  for (const GpioLine& line : lines) {
    impl_->lines.push_back(find(line.name));
    gpiod_line* request = impl_->lines.back().get();
    if (gpiod_line_request_both_edges_events_flags(request, kConsumer, flags(line)) != 0) fail(line, errno);
    const int fd = gpiod_line_event_get_fd(request);
    if (fcntl(fd, F_SETFL, fcntl(fd, F_GETFL) | O_NONBLOCK) != 0) fail(line, errno);
  }
}

GpioInputs::~GpioInputs() = default;

bool GpioInputs::levels(std::span<bool> active) noexcept {
  for (std::size_t i = 0; i < impl_->lines.size(); ++i) {
    const int level = gpiod_line_get_value(impl_->lines[i].get());
    if (level < 0) return false;
    active[i] = level == 1;
  }
  return true;
}

std::optional<GpioInputs::Edges> GpioInputs::edges() noexcept {
  std::size_t count = 0;
  bool lost = false;
  for (std::size_t i = 0; i < impl_->lines.size(); ++i) {
    const int fd = gpiod_line_event_get_fd(impl_->lines[i].get());
    const int got = gpiod_line_event_read_fd_multiple(fd, impl_->events.data(), kEdgesPerLine);
    if (got < 0 && errno != EAGAIN) return std::nullopt;
    lost = lost || got == static_cast<int>(kEdgesPerLine);
    for (int event = 0; event < got; ++event) {
      const gpiod_line_event& from = impl_->events[static_cast<std::size_t>(event)];
      edges_[count++] = {static_cast<std::uint64_t>(from.ts.tv_sec) * 1'000'000'000U +
                             static_cast<std::uint64_t>(from.ts.tv_nsec),
                         static_cast<std::uint8_t>(i), from.event_type == GPIOD_LINE_EVENT_RISING_EDGE};
    }
  }
  std::sort(edges_.begin(), edges_.begin() + static_cast<std::ptrdiff_t>(count),
            [](const GpioEdge& a, const GpioEdge& b) { return a.time_ns < b.time_ns; });
  return Edges{std::span<const GpioEdge>(edges_.data(), count), lost};
}

struct GpioOutput::Impl {
  Line line;
};

GpioOutput::GpioOutput(const GpioLine& line) : impl_(std::make_unique<Impl>()) {
  impl_->line = find(line.name);
  if (gpiod_line_request_output_flags(impl_->line.get(), kConsumer, flags(line), 0) != 0) fail(line, errno);
}

GpioOutput::~GpioOutput() { (void)set(false); }

bool GpioOutput::set(bool active) noexcept {
  return gpiod_line_set_value(impl_->line.get(), active ? 1 : 0) == 0;
}

}  // namespace thimble::board

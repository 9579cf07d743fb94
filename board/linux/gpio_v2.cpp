// libgpiod 2.x. The lines of one chip are one request: one system call reads them all.
#include <fcntl.h>
#include <gpiod.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>

#include "board/linux/gpio.h"

namespace thimble::board {
namespace gpio {

template <auto kFree>
struct Free {
  template <typename T>
  void operator()(T* object) const noexcept {
    kFree(object);
  }
};
using Chip = std::unique_ptr<gpiod_chip, Free<gpiod_chip_close>>;
using Settings = std::unique_ptr<gpiod_line_settings, Free<gpiod_line_settings_free>>;
using LineConfig = std::unique_ptr<gpiod_line_config, Free<gpiod_line_config_free>>;
using RequestConfig = std::unique_ptr<gpiod_request_config, Free<gpiod_request_config_free>>;
using Request = std::unique_ptr<gpiod_line_request, Free<gpiod_line_request_release>>;
using EdgeBuffer = std::unique_ptr<gpiod_edge_event_buffer, Free<gpiod_edge_event_buffer_free>>;

}  // namespace gpio

namespace {

using namespace gpio;

constexpr const char* kConsumer = "thimble-board";

struct Place {
  std::string chip;
  unsigned offset = 0;
};

Place find(const std::string& name) {
  int refused = 0;  // a chip that could not be opened may have the line
  std::vector<std::string> chips;
  for (const auto& entry : std::filesystem::directory_iterator("/dev"))
    if (gpiod_is_gpiochip_device(entry.path().c_str())) chips.push_back(entry.path().string());
  std::sort(chips.begin(), chips.end());
  for (const std::string& path : chips) {
    const Chip chip(gpiod_chip_open(path.c_str()));
    if (!chip) {
      refused = errno;
      continue;
    }
    const int offset = gpiod_chip_get_line_offset_from_name(chip.get(), name.c_str());
    if (offset >= 0) return {path, static_cast<unsigned>(offset)};
  }
  if (refused != 0) throw GpioError(name, std::strerror(refused), refused);
  throw GpioError(name, "no chip has a line of this name", ENOENT);
}

Settings settings_of(const GpioLine& line, bool output) {
  Settings settings(gpiod_line_settings_new());
  if (!settings) throw std::bad_alloc();
  const gpiod_line_bias bias = line.bias == GpioBias::kPullDown ? GPIOD_LINE_BIAS_PULL_DOWN
                               : line.bias == GpioBias::kPullUp ? GPIOD_LINE_BIAS_PULL_UP
                                                                : GPIOD_LINE_BIAS_AS_IS;
  gpiod_line_settings_set_active_low(settings.get(), line.active_low);
  gpiod_line_settings_set_output_value(settings.get(), GPIOD_LINE_VALUE_INACTIVE);
  if (gpiod_line_settings_set_bias(settings.get(), bias) != 0 ||
      gpiod_line_settings_set_direction(
          settings.get(), output ? GPIOD_LINE_DIRECTION_OUTPUT : GPIOD_LINE_DIRECTION_INPUT) != 0 ||
      (!output && gpiod_line_settings_set_edge_detection(settings.get(), GPIOD_LINE_EDGE_BOTH) != 0))
    throw GpioError(line.name, std::strerror(errno), errno);
  return settings;
}

Request request(const std::string& chip_path, const LineConfig& lines, std::size_t edges,
                const std::string& name) {
  const Chip chip(gpiod_chip_open(chip_path.c_str()));
  const RequestConfig config(gpiod_request_config_new());
  if (!config) throw std::bad_alloc();
  gpiod_request_config_set_consumer(config.get(), kConsumer);
  gpiod_request_config_set_event_buffer_size(config.get(), edges);
  Request made(chip ? gpiod_chip_request_lines(chip.get(), config.get(), lines.get()) : nullptr);
  if (!made) throw GpioError(name, std::strerror(errno), errno);
  return made;
}

}  // namespace

std::string gpio_library() { return std::string("libgpiod ") + gpiod_api_version(); }

bool gpio_chip_has_line(const std::string& chip, const std::string& name) {
  const Chip opened(gpiod_chip_open(chip.c_str()));
  return opened && gpiod_chip_get_line_offset_from_name(opened.get(), name.c_str()) >= 0;
}

struct GpioInputs::Impl {
  struct OfChip {
    std::string chip;
    std::string first_line;
    gpio::LineConfig config;
    gpio::Request request;
    gpio::EdgeBuffer buffer;
    std::vector<unsigned> offsets;
    std::vector<std::size_t> line;  // index among the inputs for each offset
  };
  std::vector<OfChip> chips;
  std::array<gpiod_line_value, kMaxLines> values;
};

GpioInputs::GpioInputs(std::span<const GpioLine> lines) : impl_(std::make_unique<Impl>()) {
  if (lines.size() > kMaxLines) throw GpioError(lines[kMaxLines].name, "one input too many", E2BIG);
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const Place place = find(lines[i].name);
    auto chip = std::find_if(impl_->chips.begin(), impl_->chips.end(),
                             [&](const Impl::OfChip& one) { return one.chip == place.chip; });
    if (chip == impl_->chips.end()) {
      impl_->chips.push_back(
          {place.chip, lines[i].name, LineConfig(gpiod_line_config_new()), nullptr, nullptr, {}, {}});
      chip = impl_->chips.end() - 1;
      if (!chip->config) throw std::bad_alloc();
    }
    chip->offsets.push_back(place.offset);
    chip->line.push_back(i);
    const Settings settings = settings_of(lines[i], false);
    if (gpiod_line_config_add_line_settings(chip->config.get(), &place.offset, 1, settings.get()) != 0)
      throw GpioError(lines[i].name, std::strerror(errno), errno);
  }
  for (Impl::OfChip& chip : impl_->chips) {
    const std::size_t edges = chip.offsets.size() * kEdgesPerLine;
    chip.request = request(chip.chip, chip.config, edges, chip.first_line);
    chip.buffer.reset(gpiod_edge_event_buffer_new(edges));
    if (!chip.buffer) throw std::bad_alloc();
    const int fd = gpiod_line_request_get_fd(chip.request.get());
    if (fcntl(fd, F_SETFL, fcntl(fd, F_GETFL) | O_NONBLOCK) != 0)
      throw GpioError(chip.first_line, std::strerror(errno), errno);
  }
}

GpioInputs::~GpioInputs() = default;

bool GpioInputs::levels(std::span<bool> active) noexcept {
  for (const Impl::OfChip& chip : impl_->chips) {
    if (gpiod_line_request_get_values(chip.request.get(), impl_->values.data()) != 0) return false;
    for (std::size_t i = 0; i < chip.line.size(); ++i)
      active[chip.line[i]] = impl_->values[i] == GPIOD_LINE_VALUE_ACTIVE;
  }
  return true;
}

std::optional<GpioInputs::Edges> GpioInputs::edges() noexcept {
  std::size_t count = 0;
  bool lost = false;
  for (const Impl::OfChip& chip : impl_->chips) {
    const std::size_t most = chip.offsets.size() * kEdgesPerLine;
    const int got = gpiod_line_request_read_edge_events(chip.request.get(), chip.buffer.get(), most);
    if (got < 0 && errno != EAGAIN) return std::nullopt;
    lost = lost || got == static_cast<int>(most);
    for (int event = 0; event < got; ++event) {
      gpiod_edge_event* from =
          gpiod_edge_event_buffer_get_event(chip.buffer.get(), static_cast<unsigned long>(event));
      const auto at =
          std::find(chip.offsets.begin(), chip.offsets.end(), gpiod_edge_event_get_line_offset(from));
      edges_[count++] = {
          gpiod_edge_event_get_timestamp_ns(from),
          static_cast<std::uint8_t>(chip.line[static_cast<std::size_t>(at - chip.offsets.begin())]),
          gpiod_edge_event_get_event_type(from) == GPIOD_EDGE_EVENT_RISING_EDGE};
    }
  }
  std::sort(edges_.begin(), edges_.begin() + static_cast<std::ptrdiff_t>(count),
            [](const GpioEdge& a, const GpioEdge& b) { return a.time_ns < b.time_ns; });
  return Edges{std::span<const GpioEdge>(edges_.data(), count), lost};
}

struct GpioOutput::Impl {
  Request request;
  unsigned offset = 0;
};

GpioOutput::GpioOutput(const GpioLine& line) : impl_(std::make_unique<Impl>()) {
  const Place place = find(line.name);
  const LineConfig config(gpiod_line_config_new());
  const Settings settings = settings_of(line, true);
  if (!config || gpiod_line_config_add_line_settings(config.get(), &place.offset, 1, settings.get()) != 0)
    throw GpioError(line.name, std::strerror(errno), errno);
  impl_->request = request(place.chip, config, 0, line.name);
  impl_->offset = place.offset;
}

GpioOutput::~GpioOutput() { (void)set(false); }

bool GpioOutput::set(bool active) noexcept {
  return gpiod_line_request_set_value(impl_->request.get(), impl_->offset,
                                      active ? GPIOD_LINE_VALUE_ACTIVE : GPIOD_LINE_VALUE_INACTIVE) == 0;
}

}  // namespace thimble::board

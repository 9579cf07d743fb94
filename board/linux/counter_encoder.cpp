#include "board/linux/counter_encoder.h"

#include <sys/ioctl.h>

#include <algorithm>
#include <charconv>
#include <fstream>

namespace thimble::board {
namespace {

namespace fs = std::filesystem;

constexpr const char* kDevices = "/sys/bus/counter/devices";
constexpr const char* kFunction = "quadrature x4";

std::string first_line(const fs::path& file) {
  std::ifstream in(file);
  std::string line;
  std::getline(in, line);
  return line;
}

void write_setting(const fs::path& file, const std::string& value) {
  const Descriptor out = open_file(file, O_WRONLY);
  if (write(out.get(), value.data(), value.size()) != static_cast<ssize_t>(value.size()))
    throw std::system_error(errno, std::generic_category(), file.string() + ": " + value);
}

// The count's folder; configures the count for an encoder.
fs::path set_up(const CounterPlace& joint) {
  fs::path count = find_counter(joint.device) / ("count" + std::to_string(joint.count));
  if (!fs::exists(count / "count"))
    throw std::system_error(ENOENT, std::generic_category(), (count / "count").string());
  if (fs::exists(count / "function") && first_line(count / "function") != kFunction)
    write_setting(count / "function", kFunction);
  if (fs::exists(count / "ceiling")) {
    const std::string wanted = std::to_string(UINT32_MAX >> (32U - joint.bits));
    if (first_line(count / "ceiling") != wanted) write_setting(count / "ceiling", wanted);
  }
  if (fs::exists(count / "enable") && first_line(count / "enable") != "1")
    write_setting(count / "enable", "1");
  return count;
}

}  // namespace

fs::path find_counter(const std::string& device) {
  std::error_code failed;
  for (const auto& entry : fs::directory_iterator(kDevices, failed))
    if (entry.path().filename() == device || first_line(entry.path() / "name") == device) return entry.path();
  throw std::system_error(ENOENT, std::generic_category(), "counter \"" + device + "\"");
}

CounterPoll::CounterPoll(const std::array<CounterPlace, kArmJoints>& joints) {
  for (std::size_t j = 0; j < joints.size(); ++j)
    if (!joints[j].device.empty()) files_[j] = open_file(set_up(joints[j]) / "count", O_RDONLY);
}

std::optional<EncoderSample> CounterPoll::read(std::uint64_t now_ns) noexcept {
  EncoderSample sample;
  sample.time_ns = now_ns;
  for (std::size_t j = 0; j < files_.size(); ++j) {
    if (!files_[j].is_open()) continue;
    std::array<char, 24> text;
    const ssize_t size = pread(files_[j].get(), text.data(), text.size(), 0);
    std::uint64_t value = 0;
    if (size <= 0 || std::from_chars(text.data(), text.data() + size, value).ec != std::errc{})
      return std::nullopt;
    sample.counts[j] = static_cast<std::uint32_t>(value);
  }
  return sample;
}

CounterEvents::CounterEvents(const std::array<CounterPlace, kArmJoints>& joints, counter_event_type event) {
  fs::path device;
  for (std::size_t j = 0; j < joints.size(); ++j) {
    count_of_[j] = -1;
    if (joints[j].device.empty()) continue;
    device = fs::path("/dev") / find_counter(joints[j].device).filename();
    (void)set_up(joints[j]);
    count_of_[j] = static_cast<int>(joints[j].count);
    all_ |= 1U << j;
  }
  device_ = open_file(device, O_RDONLY | O_NONBLOCK);
  for (const int count : count_of_) {
    if (count < 0) continue;
    counter_watch watch{};
    watch.component.type = COUNTER_COMPONENT_COUNT;
    watch.component.scope = COUNTER_SCOPE_COUNT;
    watch.component.parent = static_cast<__u8>(count);
    watch.event = static_cast<__u8>(event);
    if (ioctl(device_.get(), COUNTER_ADD_WATCH_IOCTL, &watch) != 0)
      throw std::system_error(errno, std::generic_category(), device.string() + ": watch a count");
  }
  if (ioctl(device_.get(), COUNTER_ENABLE_EVENTS_IOCTL) != 0)
    throw std::system_error(errno, std::generic_category(), device.string() + ": enable events");
}

std::optional<EncoderSample> CounterEvents::read(std::uint64_t) noexcept {
  std::optional<EncoderSample> newest;
  const ssize_t size = ::read(device_.get(), events_.data(), sizeof(events_));
  const std::size_t count = size > 0 ? static_cast<std::size_t>(size) / sizeof(counter_event) : 0;
  for (std::size_t i = 0; i < count; ++i) {
    const counter_event& event = events_[i];
    const auto at = std::find(count_of_.begin(), count_of_.end(), int{event.watch.component.parent});
    if (event.status != 0 || at == count_of_.end()) continue;
    const auto joint = static_cast<std::size_t>(at - count_of_.begin());
    if (event.timestamp != gathered_.time_ns) joints_gathered_ = 0;
    gathered_.time_ns = event.timestamp;
    gathered_.counts[joint] = static_cast<std::uint32_t>(event.value);
    joints_gathered_ |= 1U << joint;
    if (joints_gathered_ == all_) newest = gathered_;
  }
  return newest;
}

}  // namespace thimble::board

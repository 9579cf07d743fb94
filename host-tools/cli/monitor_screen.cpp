#include "host-tools/cli/monitor_screen.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "firmware/core/faults.h"
#include "host-tools/client/flag_names.h"

namespace thimble::host {
namespace {

namespace link = firmware::link;

constexpr int kLeftSteps = 5;       // without a frame that tells of a solid: the tip has left it
constexpr std::size_t kPast = 400;  // steps of a curve that are kept; no terminal is wider

float size(const link::Force& force) { return std::hypot(force.x_N, force.y_N, force.z_N); }

float full_scale(float most_N) {
  for (const float full : {1.0F, 2.0F, 5.0F, 10.0F, 20.0F, 50.0F})
    if (most_N <= full) return full;
  return 100.0F;
}

// Characters of UTF-8 text, each one column wide.
std::size_t columns_of(const std::string& text) {
  return static_cast<std::size_t>(std::ranges::count_if(text, [](char c) { return (c & 0xC0) != 0x80; }));
}

std::string cut(std::string text, std::size_t columns) {
  std::size_t at = 0;
  for (std::size_t seen = 0; at < text.size(); ++at) {
    if ((text[at] & 0xC0) != 0x80 && seen++ == columns) break;
  }
  text.resize(at);
  return text + '\n';
}

std::string limiter_names(std::uint8_t bits) {
  const std::vector<std::string> names = flag_names<link::Limiter>(bits);
  return names.empty() ? "none" : fmt::format("{}", fmt::join(names, ", "));
}

std::string status_line(const link::Status& status, const std::string& stopped_by) {
  const firmware::FaultRow* const fault = firmware::find_fault(static_cast<firmware::Fault>(status.fault));
  return fmt::format(
      "{}{}   {}   {:.0f} Hz, worst tick {:.1f} us   limiters: {}", link::name(status.mode),
      stopped_by.empty() ? "" : fmt::format(" ({})", stopped_by),
      status.fault == 0 || fault == nullptr ? "no fault" : fmt::format("FAULT {}", fault->name),
      status.tick_rate_Hz, 1e6F * status.worst_tick_s, limiter_names(status.limiters));
}

}  // namespace

void MonitorScreen::take(const link::CanFrame& frame) {
  link::visit_messages([&](auto message) {
    if constexpr (decltype(message)::kIsFrame) {
      if (link::from_frame(frame, node_, message)) take(message);
    }
  });
}

void MonitorScreen::take(const link::Pose& pose) {
  if (pose.arm < arms_.size()) arms_[pose.arm].pose = pose;
}

void MonitorScreen::take(const link::Force& force) {
  if (force.arm >= arms_.size()) return;
  Arm& arm = arms_[force.arm];
  arm.seen = true;
  arm.force = force;
  arm.most_N = std::max(arm.most_N, size(force));
}

void MonitorScreen::take(const link::Inside& inside) {
  if (inside.arm < arms_.size()) arms_[inside.arm].inside[inside.object] = 0;
}

void MonitorScreen::step() {
  for (Arm& arm : arms_) {
    std::erase_if(arm.inside, [](const auto& entry) { return entry.second >= kLeftSteps; });
    for (auto& [object, age] : arm.inside) ++age;
    if (!arm.seen) continue;
    if (arm.past_N.size() == kPast) arm.past_N.erase(arm.past_N.begin());
    arm.past_N.push_back(arm.most_N);
    arm.most_N = 0.0F;
  }
}

// A bar from the middle to the right, or to the left for a negative value.
std::string MonitorScreen::bar(float value, float full, std::size_t half) const {
  const auto filled = static_cast<std::size_t>(
      std::min(std::round(std::fabs(value) / full * static_cast<float>(half)), static_cast<float>(half)));
  std::string blocks;
  for (std::size_t i = 0; i < filled; ++i) blocks += utf8_ ? "█" : "#";
  const std::string rest(half - filled, ' ');
  const std::string empty(half, ' ');
  return value < 0.0F ? rest + blocks + '|' + empty : empty + '|' + blocks + rest;
}

std::string MonitorScreen::curve(const Arm& arm, float full, std::size_t columns) const {
  constexpr std::array<const char*, 9> kBlocks = {" ", "▁", "▂", "▃", "▄", "▅", "▆", "▇", "█"};
  constexpr std::array<const char*, 9> kAscii = {" ", ".", ".", "-", "-", "=", "=", "#", "#"};
  std::string text;
  const std::size_t from = arm.past_N.size() - std::min(arm.past_N.size(), columns);
  for (std::size_t i = from; i < arm.past_N.size(); ++i) {
    const auto level =
        static_cast<std::size_t>(std::clamp(std::ceil(8.0F * arm.past_N[i] / full), 0.0F, 8.0F));
    text += (utf8_ ? kBlocks : kAscii)[level];
  }
  return text;
}

std::string MonitorScreen::text(std::size_t columns) const {
  std::string all = cut(
      fmt::format("{}   {}", title_, status_ ? status_line(*status_, stopped_by_) : "waiting for its status"),
      columns);
  for (std::size_t i = 0; i < arms_.size(); ++i) {
    const Arm& arm = arms_[i];
    if (!arm.seen) continue;
    const float most_N = std::accumulate(arm.past_N.begin(), arm.past_N.end(), size(arm.force),
                                         [](float a, float b) { return std::max(a, b); });
    const float full = full_scale(most_N);
    all += cut(fmt::format("arm {}   x {:7.2f}   y {:7.2f}   z {:7.2f} mm   contacts {}", i,
                           1e3F * arm.pose.x_m, 1e3F * arm.pose.y_m, 1e3F * arm.pose.z_m, arm.force.contacts),
               columns);
    for (const auto& [object, age] : arm.inside) {
      const auto name = names_.find(object);
      all += cut(fmt::format("  inside {}: move out",
                             name == names_.end() ? fmt::format("object {}", object) : name->second),
                 columns);
    }
    constexpr std::size_t kLabel = 16;
    const std::size_t half =
        columns > kLabel + 20 ? std::min<std::size_t>((columns - kLabel - 1) / 2, 30) : 0;
    for (const auto& [name, value] :
         {std::pair{"Fx", arm.force.x_N}, std::pair{"Fy", arm.force.y_N}, std::pair{"Fz", arm.force.z_N}}) {
      all += cut(fmt::format("  {} {:7.2f} N  {}", name, value, bar(value, full, half)), columns);
    }
    const std::string label = fmt::format("  |F| {:6.2f} N  ", size(arm.force));
    const std::string scale = fmt::format("  most {:.2f} of {:g} N", most_N, full);
    const std::size_t left = columns - std::min(columns, columns_of(label) + columns_of(scale));
    all += cut(fmt::format("{}{}{}", label, curve(arm, full, left), scale), columns);
  }
  return all;
}

}  // namespace thimble::host

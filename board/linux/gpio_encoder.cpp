#include "board/linux/gpio_encoder.h"

#include <algorithm>
#include <cerrno>

namespace thimble::board {
namespace {

std::vector<GpioLine> lines_of(const std::array<std::array<std::string, 2>, kArmJoints>& names) {
  std::vector<GpioLine> lines;
  for (const auto& joint : names)
    for (const std::string& name : joint)
      if (!name.empty()) lines.push_back({name, false, GpioBias::kAsIs});
  return lines;
}

}  // namespace

GpioEncoder::GpioEncoder(const std::array<std::array<std::string, 2>, kArmJoints>& lines)
    : inputs_(lines_of(lines)) {
  for (std::size_t j = 0; j < lines.size(); ++j)
    if (!lines[j][0].empty()) joint_of_[pairs_++] = j;
  if (!start_again()) throw GpioError(lines[joint_of_[0]][0], "its level cannot be read", EIO);
}

std::optional<EncoderSample> GpioEncoder::read(std::uint64_t now_ns) noexcept {
  if (blind_ticks_ > 0) {
    if (--blind_ticks_ == 0 && !start_again()) blind_ticks_ = kBlindTicks;
    return std::nullopt;
  }
  if (!follow()) {
    blind_ticks_ = kBlindTicks;
    return std::nullopt;
  }
  EncoderSample sample;
  sample.time_ns = now_ns;
  for (std::size_t j = 0; j < joints_.size(); ++j) sample.counts[j] = joints_[j].count();
  return sample;
}

// False: an edge was lost, or the chip is gone.
bool GpioEncoder::follow() noexcept {
  const auto seen = inputs_.edges();
  if (!seen || seen->lost) return false;
  for (const GpioEdge& edge : seen->edges)
    joints_[joint_of_[edge.line / 2U]].edge(edge.line % 2 == 0 ? QuadratureLine::kA : QuadratureLine::kB,
                                            edge.active);
  return std::none_of(joints_.begin(), joints_.end(), [](const Quadrature& joint) { return joint.lost(); });
}

// Edges that arrive during this call appear as lost in the next follow(), which then starts again.
bool GpioEncoder::start_again() noexcept {
  if (!inputs_.edges() || !inputs_.levels(levels_)) return false;
  for (std::size_t i = 0; i < pairs_; ++i) joints_[joint_of_[i]].reset(levels_[2 * i], levels_[2 * i + 1]);
  return true;
}

}  // namespace thimble::board

#include "kinematics/velocity.h"

#include <algorithm>
#include <cmath>

namespace thimble::kinematics {
namespace {

constexpr int kRing = VelocityEstimator::kMaxWindow + 1;

}  // namespace

VelocityEstimator::VelocityEstimator(float period_s) noexcept : rate_Hz_(1.0F / period_s) {
  const float readings = kMaxWindow_s / period_s + 0.5F;
  window_ = readings >= static_cast<float>(kMaxWindow) ? kMaxWindow
            : readings < 1.0F                          ? 1
                                                       : static_cast<int>(readings);
}

void VelocityEstimator::reset(std::int32_t counts) noexcept {
  history_.fill(counts);
  const auto last = static_cast<std::uint32_t>(window_);
  sum_ = (last + 1) * static_cast<std::uint32_t>(counts);
  moment_ = last * (last + 1) / 2 * static_cast<std::uint32_t>(counts);
}

std::int32_t VelocityEstimator::before(int ticks) const noexcept {
  return history_[static_cast<std::size_t>(head_ < ticks ? head_ - ticks + kRing : head_ - ticks)];
}

void VelocityEstimator::add(std::int32_t counts) noexcept {
  const auto oldest = static_cast<std::uint32_t>(before(window_));
  moment_ += sum_ - static_cast<std::uint32_t>(window_ + 1) * oldest;  // all others are a tick older
  sum_ += static_cast<std::uint32_t>(counts) - oldest;
  head_ = head_ + 1 == kRing ? 0 : head_ + 1;
  history_[static_cast<std::size_t>(head_)] = counts;
}

float VelocityEstimator::update(std::int32_t counts, std::uint32_t periods) noexcept {
  constexpr float kBand = 1.0F;  // maximum deviation of a reading from the line, counts
  if (periods > 1) {
    const std::int32_t from = history_[static_cast<std::size_t>(head_)];
    const float per_period = static_cast<float>(counts - from) / static_cast<float>(periods);
    const float half = per_period < 0.0F ? -0.5F : 0.5F;
    for (auto before = static_cast<int>(std::min<std::uint32_t>(periods - 1, kMaxWindow)); before > 0;
         --before)
      add(counts - static_cast<std::int32_t>(per_period * static_cast<float>(before) + half));
  }
  add(counts);

  // Readings relative to the newest one, x(i) that of i ticks ago: exact in a float, and so are the sums of x(i) and of i x(i).
  const auto x = [&](int i) { return static_cast<float>(before(i) - counts); };
  const auto newest = static_cast<std::uint32_t>(counts), last = static_cast<std::uint32_t>(window_);
  auto sum = static_cast<float>(static_cast<std::int32_t>(sum_ - (last + 1) * newest));
  auto moment = static_cast<float>(static_cast<std::int32_t>(moment_ - last * (last + 1) / 2 * newest));

  // The longest window whose least-squares line x(i) = intercept - slope i stays within the band. What was off the line of a longer window
  // is looked at first, for most often it is off this one too.
  int off = 0;
  for (int n = window_;; --n) {
    const float count = static_cast<float>(n + 1), middle = 0.5F * static_cast<float>(n);
    const float slope = (middle * sum - moment) / (count * (count * count - 1.0F) / 12.0F);
    const float intercept = sum / count + slope * middle;
    const auto is_off = [&](int i, float ago) { return std::abs(x(i) - (intercept - slope * ago)) > kBand; };
    bool fits = off > n || !is_off(off, static_cast<float>(off));
    float ago = 0;
    for (int i = 0; i <= n && fits; ++i, ++ago) {
      fits = !is_off(i, ago);
      if (!fits) off = i;
    }
    if (fits || n == 1) return slope * rate_Hz_;
    sum -= x(n);
    moment -= static_cast<float>(n) * x(n);
  }
}

}  // namespace thimble::kinematics

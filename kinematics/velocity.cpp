#include "kinematics/velocity.h"

#include <algorithm>

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

void VelocityEstimator::reset(std::int32_t counts) noexcept { history_.fill(counts); }

void VelocityEstimator::add(std::int32_t counts) noexcept {
  head_ = head_ + 1 == kRing ? 0 : head_ + 1;
  history_[static_cast<std::size_t>(head_)] = counts;
}

float VelocityEstimator::update(std::int32_t counts, std::uint64_t periods) noexcept {
  constexpr float kBand = 1.0F;  // maximum deviation of a reading from the line, counts
  if (periods > 1) {
    const std::int32_t from = history_[static_cast<std::size_t>(head_)];
    const float per_period = static_cast<float>(counts - from) / static_cast<float>(periods);
    const float half = per_period < 0.0F ? -0.5F : 0.5F;
    for (auto before = static_cast<int>(std::min<std::uint64_t>(periods - 1, kMaxWindow)); before > 0;
         --before)
      add(counts - static_cast<std::int32_t>(per_period * static_cast<float>(before) + half));
  }
  add(counts);

  // x[i]: the reading i ticks ago relative to the newest one; the difference is exact in a float.
  std::array<float, kRing> x;
  float sum = 0.0F, moment = 0.0F;  // sums of x[i] and i x[i]
  for (int i = 0; i <= window_; ++i) {
    const int at = head_ - i < 0 ? head_ - i + kRing : head_ - i;
    const float difference = static_cast<float>(history_[static_cast<std::size_t>(at)] - counts);
    x[static_cast<std::size_t>(i)] = difference;
    sum += difference;
    moment += static_cast<float>(i) * difference;
  }

  // The longest window whose least-squares line x(i) = intercept - slope i stays within the band.
  for (int n = window_;; --n) {
    const float count = static_cast<float>(n + 1), middle = 0.5F * static_cast<float>(n);
    const float slope = (middle * sum - moment) / (count * (count * count - 1.0F) / 12.0F);
    const float intercept = sum / count + slope * middle;
    bool fits = true;
    for (int i = 0; i <= n && fits; ++i) {
      const float off = x[static_cast<std::size_t>(i)] - (intercept - slope * static_cast<float>(i));
      fits = off <= kBand && off >= -kBand;
    }
    if (fits || n == 1) return slope * rate_Hz_;
    sum -= x[static_cast<std::size_t>(n)];
    moment -= static_cast<float>(n) * x[static_cast<std::size_t>(n)];
  }
}

}  // namespace thimble::kinematics

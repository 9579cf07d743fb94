// The velocity estimate beside its definition; its lag and noise on the Premium's encoders at 4 kHz, compared with a fixed window of 15 ms.
#include "kinematics/velocity.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <deque>
#include <functional>
#include <random>
#include <vector>

#include "kinematics/built_in_arms.h"

namespace thimble::kinematics {
namespace {

constexpr double kPeriod_s = 1.0 / 4000.0;

struct Motion {
  std::function<double(double)> position_m, velocity_m_s;
};

Motion sine(double frequency_Hz, double amplitude_m) {
  const double w = 2 * M_PI * frequency_Hz;
  return {[=](double t) { return amplitude_m * std::sin(w * t); },
          [=](double t) { return amplitude_m * w * std::cos(w * t); }};
}

struct Quality {
  double lag_s, noise_m_s;  // the delay that explains the estimate best, and the RMS error that it leaves
};

// estimate: counts -> counts per second.
Quality measure(const Motion& motion, double metres_per_count,
                const std::function<double(std::int32_t)>& estimate) {
  std::vector<double> speed;
  const int ticks = 8000, settle = 400;
  for (int k = 0; k < ticks; ++k) {
    const auto counts =
        static_cast<std::int32_t>(std::floor(motion.position_m(k * kPeriod_s) / metres_per_count));
    speed.push_back(estimate(counts) * metres_per_count);
  }
  Quality best{0, 1e9};
  for (double lag = -2e-3; lag < 12e-3; lag += 5e-5) {
    double sum = 0;
    for (int k = settle; k < ticks; ++k) {
      const double error = speed[static_cast<std::size_t>(k)] - motion.velocity_m_s(k * kPeriod_s - lag);
      sum += error * error;
    }
    const double rms = std::sqrt(sum / (ticks - settle));
    if (rms < best.noise_m_s) best = {lag, rms};
  }
  return best;
}

std::function<double(std::int32_t)> adaptive() {
  return [estimator = VelocityEstimator(static_cast<float>(kPeriod_s))](std::int32_t counts) mutable {
    return static_cast<double>(estimator.update(counts));
  };
}

std::function<double(std::int32_t)> window_15_ms() {
  return [past = std::deque<std::int32_t>(60, 0)](std::int32_t counts) mutable {
    const double speed = (counts - past.front()) / (60 * kPeriod_s);
    past.pop_front();
    past.push_back(counts);
    return speed;
  };
}

TEST(Velocity, LagAndNoiseOnThePremium) {
  const ArmData m = built_in_arm("premium-1.5");
  const TwoLinkGeometry& links = std::get<TwoLinkGeometry>(m.geometry.platform);
  const double lever_m[] = {static_cast<double>(links.upper_link_m), static_cast<double>(links.upper_link_m),
                            static_cast<double>(links.forearm_m)};
  std::array<double, 3> square{};
  std::array<int, 3> motions{};
  std::printf("motion            joint | adaptive: lag ms, noise mm/s | 15 ms window: lag ms, noise mm/s\n");
  for (const auto& [frequency_Hz, amplitude_m] :
       {std::pair{0.5, .05}, {1.0, .03}, {2.0, .005}, {2.0, .02}, {5.0, .005}, {5.0, .02}, {8.0, .005}}) {
    for (int j = 0; j < 3; ++j) {
      const double metres_per_count =
          static_cast<double>(m.axis[static_cast<std::size_t>(j)].rad_per_count()) * lever_m[j];
      const Motion motion = sine(frequency_Hz, amplitude_m);
      const Quality ours = measure(motion, metres_per_count, adaptive());
      const Quality plain = measure(motion, metres_per_count, window_15_ms());
      std::printf("%4.1f Hz %5.1f mm       %d |         %5.2f   %6.2f        |          %5.2f   %6.2f\n",
                  frequency_Hz, 1e3 * amplitude_m, j + 1, 1e3 * ours.lag_s, 1e3 * ours.noise_m_s,
                  1e3 * plain.lag_s, 1e3 * plain.noise_m_s);
      EXPECT_LE(ours.lag_s, 1.001e-3);
      square[static_cast<std::size_t>(j)] += ours.noise_m_s * ours.noise_m_s;
      ++motions[static_cast<std::size_t>(j)];
    }
  }
  for (std::size_t j = 0; j < 3; ++j) {
    const double rms = std::sqrt(square[j] / motions[j]);
    std::printf("joint %zu over all motions: %.2f mm/s RMS\n", j + 1, 1e3 * rms);
    EXPECT_LE(rms, 5e-3);
  }
}

// Constant speed is the quantiser's worst case: its error repeats instead of averaging out.
void expect_little_noise(double rate_Hz) {
  const double period_s = 1 / rate_Hz;
  const ArmData m = built_in_arm("premium-1.5");
  const TwoLinkGeometry& links = std::get<TwoLinkGeometry>(m.geometry.platform);
  const double metres_per_count =
      static_cast<double>(m.axis[1].rad_per_count() * links.upper_link_m);  // the coarsest
  double sum = 0, worst = 0, worst_speed = 0;
  int speeds = 0;
  for (double v = 5e-4; v < .5; v *= 1.03, ++speeds) {
    VelocityEstimator estimator(static_cast<float>(period_s));
    estimator.reset(0);
    double square = 0;
    const int ticks = static_cast<int>(1.5 * rate_Hz), settle = static_cast<int>(0.1 * rate_Hz);
    for (int k = 0; k < ticks; ++k) {
      const double speed = static_cast<double>(estimator.update(
                               static_cast<std::int32_t>(v * k * period_s / metres_per_count))) *
                           metres_per_count;
      if (k >= settle) square += (speed - v) * (speed - v);
    }
    square /= ticks - settle;
    sum += square;
    if (square > worst) worst = square, worst_speed = v;
  }
  std::printf(
      "%.0f Hz, constant speeds .5 mm/s to .5 m/s, joint 2: %.2f mm/s RMS, worst %.2f mm/s RMS at %.1f "
      "mm/s\n",
      rate_Hz, 1e3 * std::sqrt(sum / speeds), 1e3 * std::sqrt(worst), 1e3 * worst_speed);
  // One edge a window is the worst: with counts of c the line's slope then has variance 1.2 v c / W - v^2, at
  // most (.6 c / W)^2.
  const double window_s = std::min(static_cast<double>(VelocityEstimator::kMaxWindow_s),
                                   VelocityEstimator::kMaxWindow * period_s);
  EXPECT_LE(std::sqrt(worst), .6 * metres_per_count / window_s);
}

TEST(Velocity, NoiseOverConstantSpeeds) {
  for (const double rate_Hz : {1000.0, 4000.0, 10000.0, 20000.0}) expect_little_noise(rate_Hz);
}

// Up to five periods between two readings, at random. Without the time that has passed, a gap of five reads five times the speed.
TEST(Velocity, LostReadingsDoNotRaiseIt) {
  std::mt19937 random(5);
  double worst = 0;
  for (double counts_per_tick = 3.0; counts_per_tick < 300.0; counts_per_tick *= 1.3) {
    VelocityEstimator estimator(static_cast<float>(kPeriod_s));
    std::int64_t tick = 0;
    for (int reading = 0; reading < 3000; ++reading) {
      const auto periods = static_cast<std::uint32_t>(random() % 4 == 0 ? 1 + random() % 5 : 1);
      tick += periods;
      const auto counts = static_cast<std::int32_t>(counts_per_tick * static_cast<double>(tick));
      const double speed = static_cast<double>(estimator.update(counts, periods)) * kPeriod_s;
      if (reading > 40) worst = std::max(worst, std::abs(speed - counts_per_tick) / counts_per_tick);
    }
  }
  std::printf("lost readings: worst error %.1f %%\n", 100 * worst);
  EXPECT_LE(worst, 0.1);
}

// The longest window of readings that a least-squares line fits, by the words of the header. counts: newest last.
float by_definition(const std::vector<std::int32_t>& counts, int longest, float rate_Hz) {
  for (int n = longest;; --n) {
    const auto x = [&](int i) {
      return static_cast<float>(counts[counts.size() - 1 - static_cast<std::size_t>(i)] - counts.back());
    };
    float sum = 0, moment = 0;
    for (int i = 0; i <= n; ++i) {
      sum += x(i);
      moment += static_cast<float>(i) * x(i);
    }
    const float count = static_cast<float>(n + 1), middle = 0.5F * static_cast<float>(n);
    const float slope = (middle * sum - moment) / (count * (count * count - 1.0F) / 12.0F);
    const float intercept = sum / count + slope * middle;
    bool fits = true;
    for (int i = 0; i <= n; ++i)
      fits = fits && std::abs(x(i) - (intercept - slope * static_cast<float>(i))) <= 1.0F;
    if (fits || n == 1) return slope * rate_Hz;
  }
}

// Hands that rest, push, tremble and hit, at every rate.
TEST(Velocity, IsItsDefinitionBitForBit) {
  std::mt19937 random(7);
  const auto below = [&](unsigned most) { return static_cast<int>(random() % most); };
  for (const float rate_Hz : {100.0F, 1000.0F, 4000.0F, 10000.0F, 20000.0F, 25000.0F}) {
    const float period_s = 1.0F / rate_Hz;
    const int longest = std::clamp(static_cast<int>(std::lround(VelocityEstimator::kMaxWindow_s / period_s)),
                                   1, VelocityEstimator::kMaxWindow);
    for (int run = 0; run < 30; ++run) {
      VelocityEstimator estimator(period_s);
      const auto begin = static_cast<std::int32_t>(random());
      estimator.reset(begin / 2);
      std::vector<std::int32_t> counts(VelocityEstimator::kMaxWindow + 1, begin / 2);
      float at = 0, speed = 0, push = 0;
      for (int k = 0; k < 1000; ++k) {
        if (below(50) == 0) push = static_cast<float>(below(200) - 100) * 1e-2F;
        if (below(200) == 0) speed = static_cast<float>(below(600) - 300);
        if (below(100) == 0) speed = push = 0;
        speed = std::clamp(speed + push, -300.0F, 300.0F);
        at += speed;
        counts.push_back(begin / 2 + static_cast<std::int32_t>(at) + (run % 2 == 0 ? 0 : below(3)));
        ASSERT_EQ(estimator.update(counts.back()), by_definition(counts, longest, 1.0F / period_s))
            << rate_Hz << " Hz, run " << run << ", tick " << k;
      }
    }
  }
}

TEST(Velocity, StandsStillAtExactlyZero) {
  VelocityEstimator estimator(static_cast<float>(kPeriod_s));
  estimator.reset(-123456789);
  for (int k = 0; k < 100; ++k) EXPECT_EQ(estimator.update(-123456789), 0.0F);
}

TEST(Velocity, AStraightLineIsExact) {
  VelocityEstimator estimator(static_cast<float>(kPeriod_s));
  estimator.reset(0);
  float speed = 0;
  for (int k = 1; k <= 50; ++k) speed = estimator.update(7 * k);
  EXPECT_FLOAT_EQ(speed, 28000.0F);
}

// After a sudden stop the window shortens at once: no more than a few ticks of the old speed remain.
TEST(Velocity, AnImpactIsSeenWithinAMillisecond) {
  VelocityEstimator estimator(static_cast<float>(kPeriod_s));
  estimator.reset(0);
  std::int32_t counts = 0;
  for (int k = 0; k < 50; ++k) (void)estimator.update(counts += 5);
  int ticks = 0;
  while (std::abs(estimator.update(counts)) > 2000.0F && ticks < 100) ++ticks;  // a tenth of the speed
  std::printf("ticks until a stop is seen: %d\n", ticks);
  EXPECT_LE(ticks, 4);
}

TEST(Velocity, AnyRateFitsTheWindow) {
  for (const double rate_Hz : {100.0, 1000.0, 4000.0, 10000.0, 20000.0}) {
    VelocityEstimator estimator(static_cast<float>(1 / rate_Hz));
    estimator.reset(0);
    float speed = 0;
    for (int k = 1; k <= 200; ++k) speed = estimator.update(3 * k);
    EXPECT_NEAR(speed, 3 * rate_Hz, 1e-3 * rate_Hz);
  }
}

}  // namespace
}  // namespace thimble::kinematics

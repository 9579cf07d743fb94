#include "tests/support/ideal_run.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <utility>

namespace thimble::test {
namespace {

std::uint32_t work_units() {
  const char* text = std::getenv("THIMBLE_WORK");  // NOLINT(concurrency-mt-unsafe): before any thread
  return text == nullptr ? control::Work::kNoBound
                         : static_cast<std::uint32_t>(std::strtoul(text, nullptr, 10));
}

}  // namespace

bool work_is_bounded() { return work_units() != control::Work::kNoBound; }

IdealRun::IdealRun(const SceneImage& image, double rate_Hz) : period_s_(1.0 / rate_Hz) {
  renderer_.bind(image.view());
  renderer_.bound_work(work_units());
}

IdealRun::IdealRun(SceneImage&& image, double rate_Hz) : period_s_(1.0 / rate_Hz), own_(std::move(image)) {
  renderer_.bind(own_->view());
  renderer_.bound_work(work_units());
}

const Felt& IdealRun::step(const Eigen::Vector3d& p) {
  const Felt before = felt_;
  std::array<control::Tip, 1> tips;
  tips[0].position_m = p.cast<float>();
  felt_.tip_m = tips[0].position_m.cast<double>();
  const Eigen::Vector3d travel =
      started_ ? Eigen::Vector3d(felt_.tip_m - before.tip_m) : Eigen::Vector3d::Zero();
  tips[0].velocity_m_s = (travel / period_s_).cast<float>();
  std::array<control::Touch, 1> touches;
  renderer_.tick(tips, static_cast<float>(period_s_), touches);
  felt_.force_N = touches[0].force_N.cast<double>();
  felt_.god_object_m = touches[0].god_object_m.cast<double>();
  felt_.ball_m = renderer_.ball_centre_m(0).cast<double>();
  felt_.contacts = touches[0].contacts;
  felt_.inside = renderer_.inside(0) != 0;
  if (started_) {
    work_J_ += before.force_N.dot(travel);
    work_mean_J_ += 0.5 * (before.force_N + felt_.force_N).dot(travel);
    force_variation_N_ += (felt_.force_N - before.force_N).norm();
    longest_step_m_ = std::max(longest_step_m_, travel.norm());
  }
  deepest_m_ = std::max(deepest_m_, (felt_.god_object_m - felt_.tip_m).norm());
  started_ = true;
  return felt_;
}

const Felt& IdealRun::move(const Eigen::Vector3d& p, double step_m) {
  const Eigen::Vector3d from = felt_.tip_m;
  const int steps = std::max(1, static_cast<int>(std::ceil((p - from).norm() / step_m)));
  for (int i = 1; i <= steps; ++i) step(from + (p - from) * (1.0 * i / steps));
  return felt_;
}

void IdealRun::restart(const Eigen::Vector3d& p) {
  renderer_.reset();
  started_ = false;
  work_J_ = work_mean_J_ = longest_step_m_ = deepest_m_ = force_variation_N_ = 0.0;
  step(p);
}

}  // namespace thimble::test

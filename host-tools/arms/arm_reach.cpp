#include "host-tools/arms/arm_reach.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cstddef>

namespace thimble::host {
namespace {

using kinematics::PerAxis;
using kinematics::Posture;

constexpr int kPostures = 4096;
constexpr std::size_t kStarts = 12;
constexpr int kSteps = 60, kHalvings = 8;
constexpr std::array<int, kinematics::kMaxJoints> kBases{2, 3, 5, 7, 11, 13, 17};

// The radical inverse of i (Halton's sequence), which fills the unit interval evenly.
double radical_inverse(int i, int base) {
  double value = 0, digit = 1;
  for (; i > 0; i /= base) {
    digit /= base;
    value += digit * (i % base);
  }
  return value;
}

double lower(const kinematics::ArmData& arm, int j) {
  return static_cast<double>(arm.axis.at(static_cast<std::size_t>(j)).lower);
}
double upper(const kinematics::ArmData& arm, int j) {
  return static_cast<double>(arm.axis.at(static_cast<std::size_t>(j)).upper);
}

// A damped step of the axes that moves the tip by `way`; axes that would leave their limits stay there.
PerAxis<double> step_of(const kinematics::ArmData& arm, const Posture<double>& posture,
                        const PerAxis<double>& axes, int count, const Eigen::Vector3d& way) {
  constexpr double kDamping = 1e-4;
  Eigen::Matrix<double, 3, kinematics::kMaxJoints> jacobian = posture.jacobian;
  PerAxis<double> step = PerAxis<double>::Zero();
  for (int round = 0; round < count; ++round) {
    Eigen::Matrix3d square = jacobian * jacobian.transpose();
    square += (kDamping * square.trace() + 1e-12) * Eigen::Matrix3d::Identity();
    step = jacobian.transpose() * square.ldlt().solve(way);
    bool is_free = true;
    for (int j = 0; j < count; ++j) {
      const bool is_held =
          (axes[j] <= lower(arm, j) && step[j] < 0) || (axes[j] >= upper(arm, j) && step[j] > 0);
      if (!is_held) continue;
      jacobian.col(j).setZero();
      is_free = false;
    }
    if (is_free) break;
  }
  return step;
}

}  // namespace

bool ArmReach::tip_at(const PerAxis<double>& axes, Posture<double>& posture) const {
  arm_.move_to(axes, posture);
  return posture.tip_m.allFinite();
}

ArmReach::ArmReach(const kinematics::ArmData& arm) : data_(arm), arm_(data_) {
  samples_.reserve(kPostures + 1);
  samples_.push_back({arm_.home(), arm_.home_posture().tip_m});
  for (int i = 1; i <= kPostures; ++i) {
    PerAxis<double> axes = PerAxis<double>::Zero();
    for (int j = 0; j < arm_.axes(); ++j) {
      const double part = radical_inverse(i, kBases.at(static_cast<std::size_t>(j)));
      axes[j] = lower(data_, j) + part * (upper(data_, j) - lower(data_, j));
    }
    Posture<double> posture = arm_.home_posture();
    if (arm_.limit(axes) == 0 && tip_at(axes, posture)) samples_.push_back({axes, posture.tip_m});
  }
}

double ArmReach::improved_m(const Sample& from, const Nearest& place) const {
  Posture<double> posture = arm_.home_posture();
  PerAxis<double> axes = from.axes;
  if (!tip_at(axes, posture)) return (place(from.tip_m) - from.tip_m).norm();
  Eigen::Vector3d way = place(posture.tip_m) - posture.tip_m;
  for (int step = 0; step < kSteps && way.norm() > kReachTolerance_m; ++step) {
    PerAxis<double> change = step_of(data_, posture, axes, arm_.axes(), way);
    bool better = false;
    for (int halving = 0; halving < kHalvings && !better; ++halving, change *= 0.5) {
      PerAxis<double> next = axes + change;
      for (int j = 0; j < arm_.axes(); ++j) next[j] = std::clamp(next[j], lower(data_, j), upper(data_, j));
      Posture<double> there = posture;
      if (arm_.limit(next) != 0 || !tip_at(next, there)) continue;
      const Eigen::Vector3d left = place(there.tip_m) - there.tip_m;
      if (!(left.norm() < way.norm())) continue;
      better = true;
      axes = next;
      posture = there;
      way = left;
    }
    if (!better) break;
  }
  return way.norm();
}

double ArmReach::nearest_m(const Nearest& place) const {
  struct Start {
    double away_m;
    const Sample* sample;
  };
  std::vector<Start> starts;
  starts.reserve(samples_.size());
  for (const Sample& sample : samples_)
    starts.push_back({(place(sample.tip_m) - sample.tip_m).norm(), &sample});
  const std::size_t count = std::min(kStarts, starts.size());
  std::ranges::partial_sort(starts, starts.begin() + static_cast<std::ptrdiff_t>(count), {}, &Start::away_m);
  double nearest_m = starts.front().away_m;
  for (std::size_t i = 0; i < count && nearest_m > kReachTolerance_m; ++i)
    nearest_m = std::min(nearest_m, improved_m(*starts[i].sample, place));
  return nearest_m;
}

}  // namespace thimble::host

#include "host-tools/sweep/measures.h"

#include <algorithm>
#include <cmath>

namespace thimble::host {
namespace {

using Eigen::Vector3d;

struct Extent {
  double low = std::numeric_limits<double>::infinity();
  double high = -std::numeric_limits<double>::infinity();

  void add(double value) {
    low = std::min(low, value);
    high = std::max(high, value);
  }
  [[nodiscard]] double swing() const { return high > low ? high - low : 0; }
};

// Of one arm.
class ArmMeasures {
 public:
  ArmMeasures(const MeasuredRun& run, Measured& all) : run_(run), all_(all) {}

  void add(const board::LogRow& row) {
    const double force_N = row.force_N.norm();
    all_.peak_force_N = std::max(all_.peak_force_N, force_N);
    if (row.contacts != 0) {
      all_.contact_s += 1 / run_.options.rate_Hz;
      sum_N_ += force_N;
      ++touching_;
    } else if (touched_) {
      ++all_.contacts_lost;
    }
    if (last_tip_m_) all_.work_J += .5 * (row.force_N + last_N_).dot(row.tip_m - *last_tip_m_);
    if (row.time_s >= run_.steady_from_s) add_steady(row);
    touched_ = row.contacts != 0;
    last_N_ = row.force_N;
    last_tip_m_ = row.tip_m;
  }
  void finish() {
    if (steady_rows_ == 0) return;
    all_.steady_force_N = std::max(all_.steady_force_N, steady_N_ / static_cast<double>(steady_rows_));
    all_.force_swing_N = std::max(all_.force_swing_N, force_N_.swing());
    for (const Extent& extent : tip_m_) all_.tip_swing_m = std::max(all_.tip_swing_m, extent.swing());
    if (steady_rows_ > 1)
      all_.tip_speed_rms_m_s =
          std::max(all_.tip_speed_rms_m_s, std::sqrt(speed2_ / static_cast<double>(steady_rows_ - 1)));
  }
  [[nodiscard]] double sum_N() const { return sum_N_; }
  [[nodiscard]] std::uint64_t touching() const { return touching_; }

 private:
  void add_steady(const board::LogRow& row) {
    const double force_N = run_.along ? row.force_N.dot(*run_.along) : row.force_N.norm();
    steady_N_ += force_N;
    force_N_.add(force_N);
    if (run_.along)
      tip_m_[0].add(row.tip_m.dot(*run_.along));
    else
      for (std::size_t i = 0; i < 3; ++i) tip_m_.at(i).add(row.tip_m[static_cast<Eigen::Index>(i)]);
    if (steady_rows_++ == 0) return;
    const Vector3d moved_m = row.tip_m - *last_tip_m_;
    const double way_m = run_.along ? moved_m.dot(*run_.along) : moved_m.norm();
    speed2_ += std::pow(way_m * run_.options.rate_Hz, 2);
  }

  const MeasuredRun& run_;
  Measured& all_;
  bool touched_ = false;
  std::uint64_t touching_ = 0, steady_rows_ = 0;
  double sum_N_ = 0, steady_N_ = 0, speed2_ = 0;
  Extent force_N_;
  std::array<Extent, 3> tip_m_;
  Vector3d last_N_ = Vector3d::Zero();
  std::optional<Vector3d> last_tip_m_;
};

}  // namespace

std::span<const MeasureColumn> measure_columns() {
  static constexpr std::array<MeasureColumn, 9> kColumns = {{
      {"peak_force_N", &Measured::peak_force_N, false},
      {"mean_force_N", &Measured::mean_force_N, false},
      {"contact_s", &Measured::contact_s, false},
      {"contacts_lost", &Measured::contacts_lost, false},
      {"work_J", &Measured::work_J, false},
      {"steady_force_N", &Measured::steady_force_N, true},
      {"force_swing_N", &Measured::force_swing_N, true},
      {"tip_swing_m", &Measured::tip_swing_m, true},
      {"tip_speed_rms_m_s", &Measured::tip_speed_rms_m_s, true},
  }};
  return kColumns;
}

Measured measure(const MeasuredRun& run, const std::function<void()>& go_on) {
  Measured all;
  std::vector<ArmMeasures> arms(control::kMaxArms, ArmMeasures(run, all));
  const board::SimulationResult result =
      board::simulate(run.image, run.path, run.options, [&](const board::LogRow& row) {
        go_on();
        arms.at(static_cast<std::size_t>(row.arm)).add(row);
      });
  all.status = result.status;
  all.detail = result.detail;
  double sum_N = 0;
  std::uint64_t touching = 0;
  for (ArmMeasures& arm : arms) {
    arm.finish();
    sum_N += arm.sum_N();
    touching += arm.touching();
  }
  if (touching > 0) all.mean_force_N = sum_N / static_cast<double>(touching);
  return all;
}

}  // namespace thimble::host

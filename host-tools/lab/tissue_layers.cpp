#include "host-tools/lab/tissue_layers.h"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "host-tools/error.h"

namespace thimble::host {
namespace {

constexpr double kStepsPerVoxel = 4.0;
constexpr double kMaxSteps = 10000.0;  // k-means takes their square

std::string with_commas(const Eigen::Vector3d& p) {
  std::ostringstream text;
  text << p.x() << "," << p.y() << "," << p.z();
  return text.str();
}

// The box of the world that holds all voxels, to the middle of the outermost ones.
std::string extent_of(const Volume& volume) {
  Eigen::Vector3d lo = volume.world().translation();
  Eigen::Vector3d hi = lo;
  for (int corner = 1; corner < 8; ++corner) {
    const Eigen::Vector3d last = (volume.size().array() - 1).cast<double>();
    const Eigen::Vector3d p = volume.world() * Eigen::Vector3d((corner & 1) != 0 ? last.x() : 0.0,
                                                               (corner & 2) != 0 ? last.y() : 0.0,
                                                               (corner & 4) != 0 ? last.z() : 0.0);
    lo = lo.cwiseMin(p);
    hi = hi.cwiseMax(p);
  }
  return "from " + with_commas(lo) + " to " + with_commas(hi) + " mm";
}

struct LayerRun {
  std::size_t kind;
  std::size_t begin;
  std::size_t end;
  double sum;
  [[nodiscard]] std::size_t size() const { return end - begin; }
  [[nodiscard]] double mean() const { return sum / static_cast<double>(size()); }
};

void join_equals(std::vector<LayerRun>& runs) {
  std::vector<LayerRun> joined;
  for (const LayerRun& run : runs) {
    if (!joined.empty() && joined.back().kind == run.kind) {
      joined.back().end = run.end;
      joined.back().sum += run.sum;
    } else {
      joined.push_back(run);
    }
  }
  runs = joined;
}

// Removes the gaps before the first and behind the last tissue.
void trim_gaps(std::vector<LayerRun>& runs, const std::vector<TissueKind>& kinds) {
  const auto is_gap = [&](const LayerRun& run) { return kinds[run.kind].stiffness_N_m == 0.0; };
  const auto first = std::find_if_not(runs.begin(), runs.end(), is_gap);
  const auto last = std::find_if_not(runs.rbegin(), runs.rend(), is_gap).base();
  if (first == runs.end()) {
    throw Error(ExitCode::kBadInput, "no-tissue", "the line meets no tissue",
                "choose another line, or other intensities");
  }
  runs = std::vector<LayerRun>(first, last);
}

}  // namespace

LineProfile profile_along(const Volume& volume, const Eigen::Vector3d& from_mm, const Eigen::Vector3d& to_mm,
                          const std::string& name) {
  const double length_mm = (to_mm - from_mm).norm();
  const double voxel_mm = volume.world().linear().colwise().norm().minCoeff();
  const double steps = std::ceil(length_mm / voxel_mm * kStepsPerVoxel);
  if (!(steps >= 1.0 && steps <= kMaxSteps)) {
    throw Error(ExitCode::kBadInput, "bad-line",
                name + ": the line from " + with_commas(from_mm) + " to " + with_commas(to_mm) + " mm is " +
                    std::to_string(length_mm / voxel_mm) +
                    " voxels long, allowed is more than 0 and at most " +
                    std::to_string(kMaxSteps / kStepsPerVoxel),
                "choose other ends");
  }
  const Eigen::Affine3d to_voxel = volume.world().inverse();
  LineProfile profile;
  profile.step_mm = length_mm / steps;
  for (double i = 0.5; i < steps; i += 1.0) {
    const Eigen::Vector3d p = from_mm + (to_mm - from_mm) * (i / steps);
    const Eigen::Vector3d at = to_voxel * p;
    const Eigen::Vector3i voxel = at.array().round().cast<int>();
    if (!(at.cwiseAbs().maxCoeff() < 1.0e6) || !volume.holds(voxel)) {
      throw Error(
          ExitCode::kBadInput, "outside-volume",
          name + ": the line leaves the volume at " + with_commas(p) + " mm; it reaches " + extent_of(volume),
          "choose ends inside the volume");
    }
    const double value = volume.at(voxel);
    if (!std::isfinite(value)) {
      throw Error(ExitCode::kBadInput, "bad-volume",
                  name + ": the voxel at " + with_commas(p) + " mm is no number",
                  "choose another line, or repair the volume");
    }
    profile.values.push_back(value);
  }
  return profile;
}

std::vector<TissueLayer> layers_of(const LineProfile& profile, const std::vector<TissueKind>& kinds,
                                   double thinnest_mm) {
  std::vector<LayerRun> runs;
  for (std::size_t i = 0; i < profile.values.size(); ++i) {
    const std::optional<std::size_t> kind = kind_of(kinds, profile.values[i]);
    if (!kind) {
      std::ostringstream text;
      text << "the intensity " << profile.values[i] << " at "
           << (static_cast<double>(i) + 0.5) * profile.step_mm << " mm of the line belongs to no tissue";
      throw Error(ExitCode::kBadInput, "unknown-intensity", text.str(),
                  "add a row to the table; one without stiffness is a gap, such as air");
    }
    runs.push_back({*kind, i, i + 1, profile.values[i]});
  }
  join_equals(runs);
  trim_gaps(runs, kinds);

  while (runs.size() > 1) {
    const auto thinnest = std::min_element(
        runs.begin(), runs.end(), [](const LayerRun& a, const LayerRun& b) { return a.size() < b.size(); });
    if (static_cast<double>(thinnest->size()) * profile.step_mm >= thinnest_mm) break;
    const bool is_first = thinnest == runs.begin();
    const bool is_last = std::next(thinnest) == runs.end();
    const auto distance = [&](const LayerRun& other) { return std::abs(other.mean() - thinnest->mean()); };
    const bool to_next =
        is_first || (!is_last && distance(*std::next(thinnest)) < distance(*std::prev(thinnest)));
    thinnest->kind = to_next ? std::next(thinnest)->kind : std::prev(thinnest)->kind;
    join_equals(runs);
  }

  trim_gaps(runs, kinds);
  std::vector<TissueLayer> layers;
  layers.reserve(runs.size());
  for (const LayerRun& run : runs) {
    layers.push_back({run.kind, static_cast<double>(run.begin) * profile.step_mm,
                      static_cast<double>(run.end) * profile.step_mm, run.mean()});
  }
  return layers;
}

}  // namespace thimble::host

#include "host-tools/compiler/potential_solver.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>

#include "control/scene/limits.h"
#include "host-tools/compiler/multigrid.h"
#include "host-tools/compiler/scene_value.h"
#include "host-tools/error.h"

namespace thimble::host {
namespace {

using Eigen::Vector3d;

constexpr std::size_t kMargin =
    2;  // points outside the solid on each side that the controller gets: the spline's window
constexpr std::size_t kRinging =
    6;  // more of them while the spline is fitted: where the samples end it rings
constexpr double kOnSurface = 1.0e-6;  // of a step: nearer to the surface than this is on it
constexpr double kTooNear =
    0.3;  // of a step: a sample so near to the wall makes the extension's slope uncertain
constexpr std::size_t kMostPoints = 3;  // that an extension looks at, inwards
constexpr double kResidual = 1.0e-9;
constexpr int kMostIterations = 200;
constexpr double kBefore = 0.3;  // share of the time until the equations are known, and that of solving them
constexpr double kSolving = 0.5;

[[noreturn]] void refuse(const std::string& slug, const std::string& place, const std::string& cause,
                         const std::string& remedy) {
  throw Error(ExitCode::kBadInput, slug, place + " " + cause, remedy);
}

// How far along from a to b, 0 to 1, the distance changes its sign from below zero.
template <typename Distance>
double crossing(const Distance& distance, const Vector3d& a, const Vector3d& b) {
  double lo = 0;
  double hi = 1;
  constexpr int kHalvings = 50;
  for (int i = 0; i < kHalvings; ++i) {
    const double middle = 0.5 * (lo + hi);
    (distance(a + middle * (b - a)) < 0.0 ? lo : hi) = middle;
  }
  return 0.5 * (lo + hi);
}

// What a point of the grid is.
enum Place : unsigned char { kOutside, kUnknown, kFirstInclusion };

class Solver {
 public:
  Solver(const PotentialProblem& problem, const std::function<void(double)>& progress)
      : problem_(problem), progress_(progress) {
    potential_.grid = potential_grid(problem);
    for (std::size_t& count : potential_.grid.count) count += 2 * kRinging;
    potential_.grid.origin_m.array() -= static_cast<double>(kRinging) * problem.step_m;
    stride_ = {1, grid().count[0], grid().count[0] * grid().count[1]};
  }

  Potential solve() {
    mark();
    number_unknowns();
    solve_inside();
    extend();
    fit();
    return without_ringing();
  }

 private:
  // The end of one arm of the stencil, `steps` away: at an unknown, or at a known value.
  struct Arm {
    double steps = 1;
    std::int32_t unknown = kNoUnknown;
    double value = 0;
  };

  [[nodiscard]] const Grid& grid() const { return potential_.grid; }

  void mark() {
    place_.assign(grid().size(), kOutside);
    potential_.inside.assign(grid().size(), 0);
    std::vector<std::size_t> held(problem_.inclusions.size(), 0);
    for (std::size_t i = 0; i < grid().size(); ++i) {
      const Vector3d p = grid().point(i);
      const bool inside = problem_.shape.distance_m(p) < -kOnSurface * grid().step_m;
      if (inside) {
        potential_.inside[i] = 1;
        place_[i] = kUnknown;
      }
      for (std::size_t k = 0; k < problem_.inclusions.size(); ++k) {
        if (!(problem_.inclusions[k].solid.distance_m(p) < 0.0)) continue;
        const std::string& where = problem_.inclusions[k].place;
        if (!inside) {
          refuse("inclusion-outside", where, "reaches out of the field's shape",
                 "make it smaller, or move it inwards");
        }
        if (place_[i] != kUnknown) {
          refuse("inclusions-meet", where, "meets an earlier inclusion", "move them apart");
        }
        place_[i] = static_cast<unsigned char>(kFirstInclusion + k);
        ++held[k];
      }
    }
    for (std::size_t k = 0; k < held.size(); ++k) {
      if (held[k] == 0) {
        refuse("inclusion-too-small", problem_.inclusions[k].place,
               "holds no point of the grid of " + number(grid().step_m) + " m",
               "make the step_m smaller or the inclusion larger");
      }
    }
  }

  void number_unknowns() {
    unknown_.assign(grid().size(), kNoUnknown);
    for (std::size_t i = 0; i < grid().size(); ++i) {
      if (place_[i] != kUnknown) continue;
      unknown_[i] = static_cast<std::int32_t>(point_.size());
      point_.push_back(i);
    }
    constexpr std::size_t kLeastPoints = 27;
    if (point_.size() < kLeastPoints) {
      refuse("field-too-coarse", problem_.place,
             "has " + std::to_string(point_.size()) + " points of the grid of " + number(grid().step_m) +
                 " m inside, at least " + std::to_string(kLeastPoints) + " are needed",
             "make step_m smaller");
    }
  }

  [[nodiscard]] Arm arm(std::size_t from, std::size_t axis, bool forwards) const {
    const std::size_t to = forwards ? from + stride_[axis] : from - stride_[axis];
    if (place_[to] == kUnknown) return {1.0, unknown_[to], 0.0};
    const Vector3d a = grid().point(from);
    const Vector3d b = grid().point(to);
    if (place_[to] == kOutside) {
      const double steps = crossing([&](const Vector3d& p) { return problem_.shape.distance_m(p); }, a, b);
      return {std::max(steps, kOnSurface), kNoUnknown, 0.0};
    }
    const PotentialProblem::Inclusion& inclusion = problem_.inclusions[place_[to] - kFirstInclusion];
    const double steps = crossing([&](const Vector3d& p) { return -inclusion.solid.distance_m(p); }, a, b);
    return {std::max(steps, kOnSurface), kNoUnknown, inclusion.potential};
  }

  // The share of a cell about p that lies in a region: sources that begin between points keep their amount.
  [[nodiscard]] double source_at(const Vector3d& p) const {
    double source = problem_.source;
    for (const PotentialProblem::Region& region : problem_.regions) {
      source += region.source * std::clamp(0.5 - region.solid.distance_m(p) / grid().step_m, 0.0, 1.0);
    }
    return source;
  }

  void solve_inside() {
    const auto size = static_cast<Eigen::Index>(point_.size());
    std::vector<StencilRow> rows(point_.size());
    Eigen::VectorXd right(size);
    for (std::size_t k = 0; k < rows.size(); ++k) {
      StencilRow& row = rows[k];
      const std::size_t i = point_[k];
      std::array<double, 6> value{};
      for (std::size_t end = 0; end < 6; ++end) {
        const Arm found = arm(i, end / 2, end % 2 == 1);
        row.to[end] = found.unknown;
        row.steps[end] = found.steps;
        value[end] = found.value;
      }
      row.set_weights();
      double& known = right[static_cast<Eigen::Index>(k)];
      known = grid().step_m * grid().step_m * source_at(grid().point(i)) / row.diagonal;
      for (std::size_t end = 0; end < 6; ++end) known += row.weight[end] * value[end];
    }
    equations_.emplace(std::move(rows), grid().count, unknown_);
    const Multigrid::Solution found =
        equations_->solve(right, kResidual, kMostIterations, [this](double residual) {
          const double share = static_cast<double>(std::ilogb(residual)) / std::ilogb(kResidual);
          if (progress_) progress_(kBefore + kSolving * std::clamp(share, 0.0, 1.0));
        });
    if (!found.solved) {
      refuse("field-not-solved", problem_.place,
             "is not solved after " + std::to_string(found.iterations) + " iterations: the residual is " +
                 number(found.residual),
             "change step_m a little");
    }
    const Eigen::VectorXd& solution = found.values;
    potential_.samples.assign(grid().size(), 0.0);
    for (std::size_t i = 0; i < grid().size(); ++i) {
      if (place_[i] == kUnknown) potential_.samples[i] = solution[unknown_[i]];
      if (place_[i] >= kFirstInclusion) {
        potential_.samples[i] = problem_.inclusions[place_[i] - kFirstInclusion].potential;
      }
    }
  }

  // An arm of an unknown, as solve_inside() found it.
  [[nodiscard]] Arm known_arm(std::size_t from, std::size_t axis, bool forwards) const {
    const StencilRow& row = equations_->rows()[static_cast<std::size_t>(unknown_[from])];
    const std::size_t end = 2 * axis + (forwards ? 1 : 0);
    const unsigned char place = place_[forwards ? from + stride_[axis] : from - stride_[axis]];
    return {row.steps[end], row.to[end],
            place >= kFirstInclusion ? problem_.inclusions[place - kFirstInclusion].potential : 0.0};
  }

  // The value at -back steps of the polynomial through (0, 0) and the points (steps, value).
  static double extended(std::span<const std::pair<double, double>> points, double back) {
    if (points.size() > 1 && points[0].first < kTooNear) points = points.subspan(1);
    double sum = 0;
    for (const auto& [steps, value] : points) {
      double weight = -back / steps * value;
      for (const auto& [other, unused] : points) {
        if (other != steps) weight *= (back + other) / (other - steps);
      }
      sum += weight;
    }
    return sum;
  }

  // The extension through a wall to `to` behind it, along one grid line that meets unknowns before it meets anything else.
  bool extend_along(std::size_t to, std::size_t axis, bool forwards, double& value, double& weight) const {
    const auto next = [&](std::size_t i) { return forwards ? i + stride_[axis] : i - stride_[axis]; };
    const std::size_t position = to / stride_[axis] % grid().count[axis];
    std::size_t left = forwards ? grid().count[axis] - 1 - position : position;
    std::size_t at = to;
    std::size_t layers = 0;
    do {
      if (left-- == 0 || ++layers > kMargin + kRinging) return false;
      at = next(at);
    } while (place_[at] == place_[to]);
    if (place_[at] != kUnknown) return false;
    const Arm wall = known_arm(at, axis, !forwards);
    std::array<std::pair<double, double>, kMostPoints + 1> points;
    std::size_t count = 0;
    while (count < kMostPoints) {
      points[count] = {wall.steps + static_cast<double>(count), potential_.samples[at] - wall.value};
      ++count;
      const Arm end = known_arm(at, axis, forwards);
      if (end.unknown == kNoUnknown) {
        points[count] = {points[count - 1].first + end.steps, end.value - wall.value};
        ++count;
        break;
      }
      at = next(at);
    }
    const double back = static_cast<double>(layers) - wall.steps;
    value = wall.value + extended(std::span(points).first(count), back);
    const double square = (back + 0.1) * (back + 0.1);
    weight = 1.0 / (square * square);  // a line that only grazes the wall says little
    return true;
  }

  // Behind its walls the potential goes on as before them, so that its slope is right up to them.
  void extend() {
    std::vector<unsigned char> filled(grid().size(), 0);
    std::vector<std::size_t> front;
    for (std::size_t i = 0; i < grid().size(); ++i) {
      if (place_[i] == kUnknown) continue;
      double sum = 0;
      double weights = 0;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        for (const bool forwards : {false, true}) {
          double value = 0;
          double weight = 0;
          if (!extend_along(i, axis, forwards, value, weight)) continue;
          sum += weight * value;
          weights += weight;
        }
      }
      if (weights > 0.0) {
        // Around a wall's edges the extension may turn back: not beyond what the wall holds.
        const double held = potential_.samples[i];
        potential_.samples[i] =
            place_[i] == kOutside ? std::min(sum / weights, held) : std::max(sum / weights, held);
        filled[i] = 1;
        front.push_back(i);
      }
    }
    // Farther behind, level: the mean of what is known next to each point, layer by layer.
    while (!front.empty()) {
      std::vector<std::size_t> layer;
      for (const std::size_t i : front) {
        each_neighbour(i, [&](std::size_t j) {
          if (filled[j] == 0 && place_[j] == place_[i]) {
            filled[j] = 2;
            layer.push_back(j);
          }
        });
      }
      for (const std::size_t i : layer) {
        double sum = 0;
        int count = 0;
        each_neighbour(i, [&](std::size_t j) {
          if (filled[j] == 1 && place_[j] == place_[i]) {
            sum += potential_.samples[j];
            ++count;
          }
        });
        potential_.samples[i] = sum / count;
      }
      for (const std::size_t i : layer) filled[i] = 1;
      front = std::move(layer);
    }
  }

  template <typename Visit>
  void each_neighbour(std::size_t i, const Visit& visit) const {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::size_t position = i / stride_[axis] % grid().count[axis];
      if (position > 0) visit(i - stride_[axis]);
      if (position + 1 < grid().count[axis]) visit(i + stride_[axis]);
    }
  }

  // Coefficients whose spline passes through the samples: (c[-1] + 4 c[0] + c[1]) / 6 = u along each axis in turn; the first
  // and the last are the samples themselves (far outside).
  void fit() {
    potential_.coefficients = potential_.samples;
    std::vector<double>& c = potential_.coefficients;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::size_t count = grid().count[axis];
      std::vector<double> factor(count);
      for (std::size_t start = 0; start < grid().size(); ++start) {
        if (start / stride_[axis] % count != 0) continue;
        const auto at = [&](std::size_t k) -> double& { return c[start + k * stride_[axis]]; };
        factor[0] = 0.0;
        for (std::size_t k = 1; k + 1 < count; ++k) {
          const double pivot = 4.0 - factor[k - 1];
          factor[k] = 1.0 / pivot;
          at(k) = (6.0 * at(k) - at(k - 1)) / pivot;
        }
        for (std::size_t k = count - 2; k > 0; --k) at(k) -= factor[k] * at(k + 1);
      }
    }
  }

  [[nodiscard]] Potential without_ringing() const {
    Potential kept;
    kept.grid = potential_grid(problem_);
    for (std::size_t i = 0; i < kept.grid.size(); ++i) {
      const std::size_t x = i % kept.grid.count[0] + kRinging;
      const std::size_t y = i / kept.grid.count[0] % kept.grid.count[1] + kRinging;
      const std::size_t z = i / kept.grid.count[0] / kept.grid.count[1] + kRinging;
      const std::size_t from = x + stride_[1] * y + stride_[2] * z;
      kept.samples.push_back(potential_.samples[from]);
      kept.inside.push_back(potential_.inside[from]);
      kept.coefficients.push_back(potential_.coefficients[from]);
    }
    return kept;
  }

  const PotentialProblem& problem_;
  const std::function<void(double)>& progress_;
  Potential potential_;
  std::array<std::size_t, 3> stride_{};
  std::vector<unsigned char> place_;
  std::vector<std::int32_t> unknown_;  // its number, at each point of the grid
  std::vector<std::size_t> point_;     // of each unknown
  std::optional<Multigrid> equations_;
};

}  // namespace

Grid potential_grid(const PotentialProblem& problem) {
  Grid grid;
  grid.step_m = problem.step_m;
  double size = 1;
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    const double half =
        std::ceil(problem.shape.reach_m()[axis] / problem.step_m) + static_cast<double>(kMargin);
    grid.origin_m[axis] = -half * problem.step_m;
    size *= 2.0 * half + 1.0;
    grid.count[static_cast<std::size_t>(axis)] = static_cast<std::size_t>(2.0 * half + 1.0);
  }
  if (size > static_cast<double>(control::kMaxFieldSamples)) {
    const auto counts = [&](std::size_t axis) { return std::to_string(grid.count[axis]); };
    refuse("too-many-samples", problem.place,
           "needs a grid of " + counts(0) + " x " + counts(1) + " x " + counts(2) + " = " +
               std::to_string(static_cast<std::uint64_t>(size)) + " samples, at most " +
               std::to_string(control::kMaxFieldSamples) + " are allowed",
           "make step_m larger");
  }
  return grid;
}

Potential solve_potential(const PotentialProblem& problem, const std::function<void(double)>& progress) {
  const bool lifted = problem.source > 0.0 || !problem.inclusions.empty() || !problem.regions.empty();
  if (!lifted) {
    refuse("empty-field", problem.place, "has nothing that raises the potential: there would be no force",
           "give it a source, regions or inclusions");
  }
  return Solver(problem, progress).solve();
}

}  // namespace thimble::host

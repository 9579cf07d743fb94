#include "host-tools/compiler/multigrid.h"

#include <cmath>
#include <utility>

namespace thimble::host {
namespace {

constexpr std::size_t kCoarsest = 100;  // unknowns: so few are solved by sweeps alone
constexpr int kCoarsestSweeps = 30;

double at(const Eigen::VectorXd& u, std::int32_t row) { return row == kNoUnknown ? 0.0 : u[row]; }

double neighbours(const StencilRow& row, const Eigen::VectorXd& u) {
  double sum = 0;
  for (std::size_t arm = 0; arm < 6; ++arm) sum += row.weight[arm] * at(u, row.to[arm]);
  return sum;
}

// The coarse points next to a fine position along one axis: one, or the two beside it with half the weight each.
struct Beside {
  std::array<std::size_t, 2> point;
  std::size_t points;
};
Beside beside(std::size_t fine) { return {{fine / 2, fine / 2 + 1}, 1 + fine % 2}; }

// Calls visit(coarse row, weight) for the unknowns that the value at a fine point is interpolated from.
template <typename Level, typename Visit>
void each_parent(const Level& fine, const Level& coarse, std::size_t row, const Visit& visit) {
  const std::size_t i = fine.point[row];
  const Beside x = beside(i % fine.count[0]);
  const Beside y = beside(i / fine.count[0] % fine.count[1]);
  const Beside z = beside(i / fine.count[0] / fine.count[1]);
  const double weight = 1.0 / static_cast<double>(x.points * y.points * z.points);
  for (std::size_t c = 0; c < z.points && z.point[c] < coarse.count[2]; ++c) {
    for (std::size_t b = 0; b < y.points && y.point[b] < coarse.count[1]; ++b) {
      for (std::size_t a = 0; a < x.points && x.point[a] < coarse.count[0]; ++a) {
        const std::int32_t parent =
            coarse.unknown_at[x.point[a] + coarse.count[0] * (y.point[b] + coarse.count[1] * z.point[c])];
        if (parent != kNoUnknown) visit(parent, weight);
      }
    }
  }
}

}  // namespace

void StencilRow::set_weights() {
  diagonal = 0;
  for (std::size_t low = 0; low < 6; low += 2) diagonal += 2.0 / (steps[low] * steps[low + 1]);
  for (std::size_t arm = 0; arm < 6; ++arm)
    weight[arm] = 2.0 / (steps[arm] * (steps[arm] + steps[arm ^ 1U])) / diagonal;
}

Multigrid::Multigrid(std::vector<StencilRow> rows, const std::array<std::size_t, 3>& count,
                     std::vector<std::int32_t> unknown_at) {
  Level finest{std::move(rows), count, std::move(unknown_at), {}};
  finest.point.resize(finest.rows.size());
  for (std::size_t i = 0; i < finest.unknown_at.size(); ++i) {
    if (finest.unknown_at[i] != kNoUnknown)
      finest.point[static_cast<std::size_t>(finest.unknown_at[i])] = static_cast<std::uint32_t>(i);
  }
  levels_.push_back(std::move(finest));
  while (levels_.back().rows.size() > kCoarsest) {
    Level next = coarser(levels_.back());
    if (next.rows.empty()) break;
    levels_.push_back(std::move(next));
  }
}

// Every second point along each axis; an arm reaches two fine steps, or to the boundary before.
Multigrid::Level Multigrid::coarser(const Level& fine) {
  Level coarse;
  for (std::size_t axis = 0; axis < 3; ++axis) coarse.count[axis] = (fine.count[axis] + 1) / 2;
  const auto fine_at = [&](std::size_t x, std::size_t y, std::size_t z) {
    return fine.unknown_at[2 * (x + fine.count[0] * (y + fine.count[1] * z))];
  };
  coarse.unknown_at.assign(coarse.count[0] * coarse.count[1] * coarse.count[2], kNoUnknown);
  std::vector<std::int32_t> coarse_of(fine.rows.size(), kNoUnknown);
  std::vector<std::int32_t> fine_of;
  std::size_t i = 0;
  for (std::size_t z = 0; z < coarse.count[2]; ++z) {
    for (std::size_t y = 0; y < coarse.count[1]; ++y) {
      for (std::size_t x = 0; x < coarse.count[0]; ++x, ++i) {
        const std::int32_t same = fine_at(x, y, z);
        if (same == kNoUnknown) continue;
        coarse.unknown_at[i] = static_cast<std::int32_t>(fine_of.size());
        coarse_of[static_cast<std::size_t>(same)] = coarse.unknown_at[i];
        fine_of.push_back(same);
        coarse.point.push_back(static_cast<std::uint32_t>(i));
      }
    }
  }
  for (const std::int32_t same : fine_of) {
    const StencilRow& near = fine.rows[static_cast<std::size_t>(same)];
    StencilRow row;
    for (std::size_t arm = 0; arm < 6; ++arm) {
      row.to[arm] = kNoUnknown;
      row.steps[arm] = 0.5 * near.steps[arm];
      if (near.to[arm] == kNoUnknown) continue;
      const StencilRow& far = fine.rows[static_cast<std::size_t>(near.to[arm])];
      row.steps[arm] += 0.5 * far.steps[arm];
      if (far.to[arm] != kNoUnknown) row.to[arm] = coarse_of[static_cast<std::size_t>(far.to[arm])];
    }
    row.set_weights();
    coarse.rows.push_back(row);
  }
  return coarse;
}

Multigrid::Vector Multigrid::residual(const Level& level, const Vector& right, const Vector& u) {
  Vector rest(right.size());
  for (Eigen::Index row = 0; row < right.size(); ++row)
    rest[row] = right[row] - u[row] + neighbours(level.rows[static_cast<std::size_t>(row)], u);
  return rest;
}

// A V-cycle from zero: one Gauss-Seidel sweep there, one back.
Multigrid::Vector Multigrid::cycle(std::size_t depth, const Vector& right) const {
  const Level& level = levels_[depth];
  const bool coarsest = depth + 1 == levels_.size();
  Vector u = Vector::Zero(right.size());
  const auto relax = [&](Eigen::Index row) {
    u[row] = right[row] + neighbours(level.rows[static_cast<std::size_t>(row)], u);
  };
  for (int sweep = 0; sweep < (coarsest ? kCoarsestSweeps : 1); ++sweep) {
    for (Eigen::Index row = 0; row < right.size(); ++row) relax(row);
  }
  if (!coarsest) {
    const Level& coarse = levels_[depth + 1];
    const Vector rest = residual(level, right, u);
    Vector coarse_right = Vector::Zero(static_cast<Eigen::Index>(coarse.rows.size()));
    for (std::size_t row = 0; row < level.rows.size(); ++row) {
      const double amount = rest[static_cast<Eigen::Index>(row)] * level.rows[row].diagonal;
      each_parent(level, coarse, row,
                  [&](std::int32_t parent, double weight) { coarse_right[parent] += weight * amount; });
    }
    // An eighth: the mean of the points around. Times 4: the square of the step.
    for (std::size_t row = 0; row < coarse.rows.size(); ++row)
      coarse_right[static_cast<Eigen::Index>(row)] *= 0.5 / coarse.rows[row].diagonal;
    const Vector correction = cycle(depth + 1, coarse_right);
    for (std::size_t row = 0; row < level.rows.size(); ++row) {
      each_parent(level, coarse, row, [&](std::int32_t parent, double weight) {
        u[static_cast<Eigen::Index>(row)] += weight * correction[parent];
      });
    }
  }
  for (Eigen::Index row = right.size(); row-- > 0;) relax(row);
  return u;
}

Multigrid::Solution Multigrid::solve(const Vector& right, double least_residual, int most_iterations,
                                     const std::function<void(double)>& progress) const {
  const Level& level = levels_.front();
  const Vector zero = Vector::Zero(right.size());
  const auto times = [&](const Vector& u) -> Vector { return -residual(level, zero, u); };
  const double scale = right.norm();
  Solution found{zero, 0, scale > 0.0 ? 1.0 : 0.0, true};
  if (!(scale > 0.0)) return found;
  Vector r = right;
  const Vector& shadow = right;
  Vector p = zero;
  Vector v = zero;
  double rho = 1;
  double alpha = 1;
  double omega = 1;
  while (found.iterations < most_iterations && found.residual > least_residual) {
    ++found.iterations;
    const double rho_before = std::exchange(rho, shadow.dot(r));
    p = r + rho / rho_before * alpha / omega * (p - omega * v);
    const Vector step = cycle(0, p);
    v = times(step);
    alpha = rho / shadow.dot(v);
    const Vector s = r - alpha * v;
    const Vector second = cycle(0, s);
    const Vector t = times(second);
    omega = s.norm() > 0.0 ? t.dot(s) / t.squaredNorm() : 0.0;  // zero: the first half has solved it
    found.values += alpha * step + omega * second;
    r = s - omega * t;
    found.residual = r.norm() / scale;
    if (!std::isfinite(found.residual)) break;
    if (progress) progress(found.residual);
  }
  // What the recurrence lost by rounding is in the true residual.
  found.residual = residual(level, right, found.values).norm() / scale;
  found.solved = found.residual <= 10.0 * least_residual;
  return found;
}

}  // namespace thimble::host

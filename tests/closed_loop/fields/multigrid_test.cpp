// The multigrid solver against a direct solution, on random parts of a grid with random arms.
#include "host-tools/compiler/multigrid.h"

#include <gtest/gtest.h>

#include <Eigen/Sparse>
#include <Eigen/SparseLU>
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "tests/support/figure.h"
#include "tests/support/random.h"
#include "tests/support/sanitizers.h"

namespace thimble::test {
namespace {

using host::kNoUnknown;
using host::StencilRow;

struct System {
  std::array<std::size_t, 3> count{};
  std::vector<std::int32_t> unknown_at;
  std::vector<StencilRow> rows;
};

// Balls and slabs, some a point or a sheet thin, with holes. Arms to the boundary of 1e-6 of a step or more.
System random_system(Random& random) {
  System system;
  for (std::size_t& count : system.count) count = 5 + random.below(20);
  const auto [nx, ny, nz] = system.count;
  std::vector<bool> in(nx * ny * nz, false);
  for (std::uint64_t part = 3 + random.below(4); part-- > 0;) {
    const Eigen::Vector3d centre(random.uniform(0, static_cast<double>(nx)),
                                 random.uniform(0, static_cast<double>(ny)),
                                 random.uniform(0, static_cast<double>(nz)));
    const bool fill = part > 0 || random.below(2) == 0;
    const Eigen::Vector3d size(random.uniform(0.3, 12), random.uniform(0.3, 12), random.uniform(0.3, 12));
    for (std::size_t i = 0; i < in.size(); ++i) {
      const std::array<std::size_t, 3> at{i % nx, i / nx % ny, i / nx / ny};
      const Eigen::Vector3d p(static_cast<double>(at[0]), static_cast<double>(at[1]),
                              static_cast<double>(at[2]));
      const bool rim = p.minCoeff() < 1 || p.x() > static_cast<double>(nx) - 2 ||
                       p.y() > static_cast<double>(ny) - 2 || p.z() > static_cast<double>(nz) - 2;
      if (!rim && (p - centre).cwiseQuotient(size).norm() < 1) in[i] = fill;
    }
  }
  system.unknown_at.assign(in.size(), kNoUnknown);
  std::vector<std::size_t> point;
  for (std::size_t i = 0; i < in.size(); ++i) {
    if (!in[i]) continue;
    system.unknown_at[i] = static_cast<std::int32_t>(point.size());
    point.push_back(i);
  }
  const std::array<std::size_t, 3> stride{1, nx, nx * ny};
  for (const std::size_t i : point) {
    StencilRow row;
    for (std::size_t arm = 0; arm < 6; ++arm) {
      const std::size_t end = arm % 2 == 1 ? i + stride[arm / 2] : i - stride[arm / 2];
      row.to[arm] = system.unknown_at[end];
      row.steps[arm] =
          row.to[arm] != kNoUnknown ? 1.0 : std::pow(10.0, -random.uniform(0, 6) * random.uniform(0, 1));
    }
    row.set_weights();
    system.rows.push_back(row);
  }
  return system;
}

TEST(Multigrid, IsTheDirectSolution) {
  Random random(11);
  double worst = 0;
  int most_iterations = 0;
  for (int run = 0; run < (kUnderSanitizers ? 20 : 150); ++run) {
    const System system = random_system(random);
    const auto size = static_cast<Eigen::Index>(system.rows.size());
    if (size == 0) continue;
    std::vector<Eigen::Triplet<double>> entries;
    Eigen::VectorXd right(size);
    for (Eigen::Index row = 0; row < size; ++row) {
      const StencilRow& stencil = system.rows[static_cast<std::size_t>(row)];
      entries.emplace_back(row, row, 1.0);
      for (std::size_t arm = 0; arm < 6; ++arm)
        if (stencil.to[arm] != kNoUnknown) entries.emplace_back(row, stencil.to[arm], -stencil.weight[arm]);
      right[row] = random.uniform(0.0, 1.0) / stencil.diagonal;
    }
    Eigen::SparseMatrix<double> matrix(size, size);
    matrix.setFromTriplets(entries.begin(), entries.end());
    Eigen::SparseLU<Eigen::SparseMatrix<double>> direct(matrix);
    const Eigen::VectorXd expected = direct.solve(right);
    const host::Multigrid equations(system.rows, system.count, system.unknown_at);
    const auto found = equations.solve(right, 1e-9, 200);
    EXPECT_TRUE(found.solved) << "run " << run << ", " << size << " unknowns, residual " << found.residual;
    most_iterations = std::max(most_iterations, found.iterations);
    worst = std::max(worst, (found.values - expected).cwiseAbs().maxCoeff() / expected.cwiseAbs().maxCoeff());
  }
  figure("multigrid off the direct solution, of the largest value", worst, "1e-7");
  figure("most iterations", most_iterations, "20");
  EXPECT_LT(worst, 1e-7);
  EXPECT_LE(most_iterations, 20);
}

// The iterations do not grow with the grid: a cube, and a cube with a small one cut out of its middle.
TEST(Multigrid, TakesAsManyIterationsOnAFinerGrid) {
  for (const bool hollow : {false, true}) {
    for (const std::size_t side : {10U, 21U, 42U, 85U}) {
      if (kUnderSanitizers && side > 42) continue;
      const std::size_t count = side + 2;
      const auto inside = [&](std::size_t i) {
        const std::array<std::size_t, 3> p{i % count, i / count % count, i / count / count};
        const auto within = [&](std::size_t lo, std::size_t hi) {
          return std::all_of(p.begin(), p.end(), [&](std::size_t x) { return x >= lo && x < hi; });
        };
        return within(1, side + 1) && !(hollow && within(count / 2, count / 2 + 1 + side / 20));
      };
      std::vector<std::int32_t> unknown_at(count * count * count, kNoUnknown);
      std::int32_t number = 0;
      for (std::size_t i = 0; i < unknown_at.size(); ++i)
        if (inside(i)) unknown_at[i] = number++;
      std::vector<StencilRow> rows;
      const std::array<std::size_t, 3> stride{1, count, count * count};
      for (std::size_t i = 0; i < unknown_at.size(); ++i) {
        if (unknown_at[i] == kNoUnknown) continue;
        StencilRow row;
        for (std::size_t arm = 0; arm < 6; ++arm) {
          row.to[arm] = unknown_at[arm % 2 == 1 ? i + stride[arm / 2] : i - stride[arm / 2]];
          row.steps[arm] = row.to[arm] != kNoUnknown ? 1.0 : 0.37;
        }
        row.set_weights();
        rows.push_back(row);
      }
      const Eigen::VectorXd right = Eigen::VectorXd::Constant(number, 1e-3);
      const auto found = host::Multigrid(rows, {count, count, count}, unknown_at).solve(right, 1e-9, 200);
      EXPECT_TRUE(found.solved);
      figure(std::string(hollow ? "hollow cube" : "cube") + ", side " + std::to_string(side) + ": iterations",
             found.iterations, "12");
      EXPECT_LE(found.iterations, 12);
    }
  }
}

}  // namespace
}  // namespace thimble::test

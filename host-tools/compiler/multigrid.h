// Linear equations of the seven-point stencil on a part of a grid, solved by BiCGSTAB with a multigrid cycle before it. Used by
// the potential solver.
//
// Where the stencil ends at a boundary its arm is shorter than a step (Shortley and Weller 1938), so the equations are not
// symmetric: BiCGSTAB (van der Vorst 1992). The cycle takes the same equations on every second point, with the arms that these
// have (Trottenberg, Oosterlee and Schueller 2001, section 2): the number of iterations does not depend on the size of the grid.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

namespace thimble::host {

inline constexpr std::int32_t kNoUnknown = -1;

// One unknown: the arms of its stencil, in the order -x, +x, -y, +y, -z, +z.
struct StencilRow {
  std::array<std::int32_t, 6> to{};  // the unknown at the arm's end; kNoUnknown: a boundary
  std::array<double, 6> steps{};     // length of the arm, in steps of the grid; 1 to an unknown
  std::array<double, 6> weight{};    // u - sum of weight * u at the arms' ends = h^2 source / diagonal
  double diagonal = 0;               // of the stencil of -h^2 laplace; its rows are divided by it

  // Of `to` and `steps`.
  void set_weights();
};

class Multigrid {
 public:
  using Vector = Eigen::VectorXd;

  // `unknown_at`: at each point of the grid, x fastest, the index of its row, or kNoUnknown.
  Multigrid(std::vector<StencilRow> rows, const std::array<std::size_t, 3>& count,
            std::vector<std::int32_t> unknown_at);

  [[nodiscard]] const std::vector<StencilRow>& rows() const { return levels_.front().rows; }

  struct Solution {
    Vector values;
    int iterations = 0;
    double residual = 0;  // relative, as 2-norms
    bool solved = false;
  };
  // With the right sides divided by the diagonals. `progress` is called after each iteration with the residual.
  [[nodiscard]] Solution solve(const Vector& right, double residual, int most_iterations,
                               const std::function<void(double)>& progress = {}) const;

 private:
  struct Level {
    std::vector<StencilRow> rows;
    std::array<std::size_t, 3> count{};
    std::vector<std::int32_t> unknown_at;
    std::vector<std::uint32_t> point;  // of each row
  };
  static Level coarser(const Level& fine);
  static Vector residual(const Level& level, const Vector& right, const Vector& u);
  [[nodiscard]] Vector cycle(std::size_t depth, const Vector& right) const;

  std::vector<Level> levels_;
};

}  // namespace thimble::host

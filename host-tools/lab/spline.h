// Control points of a uniform cubic B-spline that passes through given values: what the renderer's stiffness map needs
// to feel at each scanned point what was measured there. Source: de Boor, A Practical Guide to Splines. The ends are
// natural (no curvature): other conditions follow the edge better where values are exact, and throw their noise far
// about where they are measured.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace thimble::host {

// values: columns x rows, u fastest, each at least 2. Returns (columns + 2) x (rows + 2): a frame of one control point
// more on each side, so that the four about any place within the values exist.
[[nodiscard]] std::vector<double> spline_control_points(std::span<const double> values, std::size_t columns,
                                                        std::size_t rows);

// The spline of such control points: its value, and its slopes per cell. u, v: in cells from the first value. Beyond the values it goes on
// straight.
struct SplinePlace {
  double value = 0, du = 0, dv = 0;
};
[[nodiscard]] SplinePlace spline_at(std::span<const double> control, std::size_t columns, std::size_t rows,
                                    double u, double v);

}  // namespace thimble::host

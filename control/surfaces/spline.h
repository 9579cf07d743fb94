// Uniform bicubic B-splines over a grid of control points. Value and gradient depend on the 4 x 4 points
// around a place only, so the cost does not depend on the size of the grid. C2 everywhere. Textures and
// stiffness maps are such grids.
//
// Source: the paper, section 5.1. Control point (i, j) stands at u = i, v = j, in cells.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace thimble::control {

inline constexpr std::size_t kSplineWindow = 4;  // control points that a place depends on, in each direction

// Outside the grid: a texture repeats, a map keeps the values of its border.
enum class Beyond : std::uint8_t { kPeriodic, kClamped };

// The window of one direction: the indices of the control points, their weights, and the slopes of the
// weights per cell.
struct SplineWindow {
  std::array<std::uint32_t, kSplineWindow> index{};
  std::array<float, kSplineWindow> weight{};
  std::array<float, kSplineWindow> slope{};
};

struct SplineSample {
  float value = 0.0F;
  float du = 0.0F;  // per cell
  float dv = 0.0F;
};

// count: control points in this direction, at least 1.
inline SplineWindow spline_window(float cells, std::uint32_t count, Beyond beyond) noexcept {
  const auto size = static_cast<float>(count);
  float at = beyond == Beyond::kPeriodic ? cells - size * std::floor(cells / size)
                                         : std::clamp(cells, -2.0F, size + 1.0F);
  if (!(at >= -2.0F && at <= size + 1.0F)) at = 0.0F;  // NaN cannot be converted to an index
  const float cell = std::floor(at);
  const auto first = static_cast<std::int32_t>(cell) - 1;  // -3 to count
  const auto size_cells = static_cast<std::int32_t>(count);
  SplineWindow window;
  if (beyond == Beyond::kPeriodic) {
    std::int32_t index = (first + 3 * size_cells) % size_cells;
    for (std::uint32_t& kept : window.index) {
      kept = static_cast<std::uint32_t>(index);
      if (++index == size_cells) index = 0;
    }
  } else {
    for (std::size_t i = 0; i < kSplineWindow; ++i)
      window.index[i] = static_cast<std::uint32_t>(
          std::clamp<std::int32_t>(first + static_cast<std::int32_t>(i), 0, size_cells - 1));
  }
  const float t = at - cell;
  const float s = 1.0F - t;
  window.weight = {s * s * s / 6.0F, (4.0F - 3.0F * t * t * (1.0F + s)) / 6.0F,
                   (4.0F - 3.0F * s * s * (1.0F + t)) / 6.0F, t * t * t / 6.0F};
  window.slope = {-0.5F * s * s, 0.5F * t * (3.0F * t - 4.0F), -0.5F * s * (3.0F * s - 4.0F), 0.5F * t * t};
  return window;
}

// points: u fastest, `columns` a row. Reads the 16 points of the two windows.
inline SplineSample spline_sample(const float* points, std::uint32_t columns, const SplineWindow& u,
                                  const SplineWindow& v) noexcept {
  SplineSample sample;
  for (std::size_t j = 0; j < kSplineWindow; ++j) {
    const float* row = points + std::size_t{columns} * v.index[j];
    float value = 0.0F;
    float slope = 0.0F;
    for (std::size_t i = 0; i < kSplineWindow; ++i) {
      value += u.weight[i] * row[u.index[i]];
      slope += u.slope[i] * row[u.index[i]];
    }
    sample.value += v.weight[j] * value;
    sample.du += v.weight[j] * slope;
    sample.dv += v.slope[j] * value;
  }
  return sample;
}

}  // namespace thimble::control

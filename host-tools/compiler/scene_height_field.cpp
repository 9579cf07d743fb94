#include "host-tools/compiler/scene_height_field.h"

#include <algorithm>
#include <cstdint>
#include <vector>

#include "control/scene/limits.h"
#include "host-tools/error.h"

namespace thimble::host {
namespace {

// The bottom's inner ring has a point for this many of its rim: a few long triangles remain in its middle.
constexpr std::uint32_t kCoarser = 16;

// Points along the edge of a rectangle, counter-clockwise as seen from above, from its first corner.
struct Ring {
  std::uint32_t along_x;  // steps
  std::uint32_t along_y;
  std::vector<std::uint32_t> points;

  [[nodiscard]] std::uint32_t at(std::size_t i) const { return points[i % points.size()]; }
  template <typename Visit>
  void each(const Visit& visit) const {
    for (std::uint32_t x = 0; x < along_x; ++x) visit(x, 0U);
    for (std::uint32_t y = 0; y < along_y; ++y) visit(along_x, y);
    for (std::uint32_t x = along_x; x > 0; --x) visit(x, along_y);
    for (std::uint32_t y = along_y; y > 0; --y) visit(0U, y);
  }
};

class BlockBuilder {
 public:
  BlockBuilder(const HeightGrid& grid, TriangleSoup& soup) : grid_(grid), soup_(soup) {}

  void top() {
    for (std::uint32_t y = 0; y + 1 < rows(); ++y) {
      for (std::uint32_t x = 0; x + 1 < columns(); ++x) {
        const std::uint32_t a = point(x, y);
        const std::uint32_t b = point(x + 1, y);
        const std::uint32_t c = point(x + 1, y + 1);
        const std::uint32_t d = point(x, y + 1);
        if ((x + y) % 2 == 0) {
          add({a, b, c});
          add({a, c, d});
        } else {
          add({a, b, d});
          add({b, c, d});
        }
      }
    }
  }

  // Walls down from the rim to the same number of points of the bottom.
  void walls_and_bottom(const Eigen::Vector2d& size_m, double bottom_m) {
    Ring foot{columns() - 1, rows() - 1, {}};
    std::vector<std::uint32_t> rim;
    foot.each([&](std::uint32_t x, std::uint32_t y) { rim.push_back(point(x, y)); });
    const auto bottom_point = [&](double x, double y) {
      soup_.vertices_m.emplace_back(x, y, bottom_m);
      return static_cast<std::uint32_t>(soup_.vertices_m.size() - 1);
    };
    for (const std::uint32_t v : rim)
      foot.points.push_back(bottom_point(soup_.vertices_m[v].x(), soup_.vertices_m[v].y()));
    for (std::uint32_t i = 0; i < foot.points.size(); ++i) {
      const std::uint32_t next = rim[(i + 1) % rim.size()];
      add({rim[i], foot.at(i), foot.at(i + 1)});
      add({rim[i], foot.at(i + 1), next});
    }
    if (std::min(foot.along_x, foot.along_y) >= kCoarser * 4) {
      Ring inner{foot.along_x / kCoarser - 2, foot.along_y / kCoarser - 2, {}};
      const Eigen::Array2d cells(inner.along_x + 2, inner.along_y + 2);
      inner.each([&](std::uint32_t x, std::uint32_t y) {
        const Eigen::Array2d part = Eigen::Array2d(x + 1, y + 1) / cells - 0.5;
        inner.points.push_back(bottom_point(part.x() * size_m.x(), part.y() * size_m.y()));
      });
      join(foot, inner);
      foot = std::move(inner);
    }
    close(foot);
  }

  [[nodiscard]] std::uint32_t columns() const { return static_cast<std::uint32_t>(grid_.columns); }
  [[nodiscard]] std::uint32_t rows() const { return static_cast<std::uint32_t>(grid_.rows); }
  [[nodiscard]] std::uint32_t point(std::uint32_t x, std::uint32_t y) const { return y * columns() + x; }

 private:
  // Between the rim of the bottom and a coarser ring inside it: from each edge to the nearest point of the other ring.
  // Without that ring, thousands of points are on few lines: triangles lower than their points are exact.
  void join(const Ring& outer, const Ring& inner) {
    std::uint32_t o = 0;
    std::uint32_t g = 0;
    const auto side = [&](std::uint32_t outer_steps, std::uint32_t inner_steps) {
      std::uint32_t passed = 0;
      for (std::uint32_t i = 0; i < outer_steps; ++i, ++o) {
        const std::uint32_t nearest = ((2 * i + 1) * inner_steps + outer_steps) / (2 * outer_steps);
        for (; passed < nearest; ++passed, ++g) add({outer.at(o), inner.at(g), inner.at(g + 1)});
        add({outer.at(o), inner.at(g), outer.at(o + 1)});
      }
    };
    side(outer.along_x, inner.along_x);
    side(outer.along_y, inner.along_y);
    side(outer.along_x, inner.along_x);
    side(outer.along_y, inner.along_y);
  }

  // The area of a ring, in bands across it from its first corner to the opposite one: every band is as wide as a step.
  void close(const Ring& ring) {
    const std::uint32_t end = ring.along_x + ring.along_y;
    const auto left = [&](std::uint32_t i) { return ring.at(ring.points.size() - i); };
    for (std::uint32_t i = 0; i < end; ++i) {
      if (i > 0) add({left(i), ring.at(i + 1), ring.at(i)});
      if (i + 1 < end) add({left(i), left(i + 1), ring.at(i + 1)});
    }
  }

  void add(std::array<std::uint32_t, 3> t) { soup_.triangles.push_back(t); }

  const HeightGrid& grid_;
  TriangleSoup& soup_;
};

}  // namespace

HeightFieldShape read_height_field(const Value& value) {
  const ScenePart part(value, "height_field");
  HeightFieldShape shape;
  shape.file = part.text("file");
  shape.place = part.at("file").place();
  const std::array<double, 2> size_m = part.pair("size_m");
  shape.size_m = {size_m[0], size_m[1]};
  shape.height_m = part.number("height_m");
  shape.thickness_m = part.number("thickness_m");
  shape.crease_deg = part.number("crease_deg");
  return shape;
}

TriangleSoup height_field_soup(const HeightFieldShape& shape, const HeightGrid& grid,
                               const std::string& name) {
  const auto [low, high] = std::minmax_element(grid.values.begin(), grid.values.end());
  const double bottom_m = shape.height_m * *low - shape.thickness_m;
  if (bottom_m < -kMaxCoordinate || shape.height_m * *high > kMaxCoordinate) {
    throw Error(ExitCode::kBadInput, "heights-out-of-range",
                name + ": the block reaches from " + number(bottom_m) + " to " +
                    number(shape.height_m * *high) + " m, allowed is from " + number(-kMaxCoordinate) +
                    " to " + number(kMaxCoordinate) + " m",
                "set \"height_m\" (metres for the value 1; 0.001 for numbers in mm)");
  }
  TriangleSoup soup;
  const Eigen::Array2d last(static_cast<double>(grid.columns - 1), static_cast<double>(grid.rows - 1));
  for (std::size_t y = 0; y < grid.rows; ++y) {
    for (std::size_t x = 0; x < grid.columns; ++x) {
      const Eigen::Array2d part = Eigen::Array2d(static_cast<double>(x), static_cast<double>(y)) / last - 0.5;
      soup.vertices_m.emplace_back(part.x() * shape.size_m.x(), part.y() * shape.size_m.y(),
                                   shape.height_m * grid.at(x, y));
    }
  }
  BlockBuilder block(grid, soup);
  block.top();
  block.walls_and_bottom(shape.size_m, bottom_m);
  if (soup.triangles.size() > control::kMaxTriangles) {
    throw Error(ExitCode::kBadInput, "too-many-samples",
                name + ": the grid is " + std::to_string(grid.columns) + " x " + std::to_string(grid.rows) +
                    " values; with its walls it has " + std::to_string(soup.triangles.size()) +
                    " triangles, at most " + std::to_string(control::kMaxTriangles) + " are allowed",
                "make the grid coarser along its long side");
  }
  return soup;
}

}  // namespace thimble::host

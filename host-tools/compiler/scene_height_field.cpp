#include "host-tools/compiler/scene_height_field.h"

#include <algorithm>
#include <cstdint>
#include <vector>

#include "host-tools/error.h"

namespace thimble::host {
namespace {

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
          add({a, b, c}, false);
          add({a, c, d}, false);
        } else {
          add({a, b, d}, false);
          add({b, c, d}, false);
        }
      }
    }
  }

  // Walls down from the rim, which is given counter-clockwise; one point below each of the rim's.
  void walls(const std::vector<std::uint32_t>& rim, double bottom_m) {
    below_.assign(soup_.vertices_m.size(), 0);
    for (const std::uint32_t v : rim) {
      below_[v] = static_cast<std::uint32_t>(soup_.vertices_m.size());
      const Eigen::Vector3d& p = soup_.vertices_m[v];
      soup_.vertices_m.emplace_back(p.x(), p.y(), bottom_m);
    }
    for (std::size_t i = 0; i < rim.size(); ++i) {
      const std::uint32_t a = rim[i];
      const std::uint32_t b = rim[(i + 1) % rim.size()];
      add({a, below_[a], below_[b]}, false);
      add({a, below_[b], b}, false);
    }
  }

  // Strips across the shorter way and a fan from each end of the first and the last line between them: no
  // corner has more faces than the controller goes round.
  void bottom() {
    const bool along_x = columns() >= rows();
    const std::uint32_t length = along_x ? columns() : rows();
    const std::uint32_t width = along_x ? rows() : columns();
    const auto at = [&](std::uint32_t i, std::uint32_t j) {
      return below_[along_x ? point(i, j) : point(j, i)];
    };
    const auto strip = [&](std::uint32_t i) {  // from line i to i + 1
      add({at(i, 0), at(i + 1, width - 1), at(i + 1, 0)}, !along_x);
      add({at(i, 0), at(i, width - 1), at(i + 1, width - 1)}, !along_x);
    };
    const auto fan = [&](std::uint32_t edge, std::uint32_t line, bool turned) {
      const std::uint32_t middle = (width - 1) / 2;
      for (std::uint32_t j = 0; j + 1 < width; ++j) {
        add({at(edge, j), at(edge, j + 1), at(line, j < middle ? 0 : width - 1)}, turned);
      }
      add({at(edge, middle), at(line, width - 1), at(line, 0)}, turned);
    };
    if (length == 2) return strip(0);
    fan(0, 1, !along_x);
    for (std::uint32_t i = 1; i + 2 < length; ++i) strip(i);
    fan(length - 1, length - 2, along_x);
  }

  [[nodiscard]] std::uint32_t columns() const { return static_cast<std::uint32_t>(grid_.columns); }
  [[nodiscard]] std::uint32_t rows() const { return static_cast<std::uint32_t>(grid_.rows); }
  [[nodiscard]] std::uint32_t point(std::uint32_t x, std::uint32_t y) const { return y * columns() + x; }

 private:
  void add(std::array<std::uint32_t, 3> t, bool turned) {
    if (turned) std::swap(t[1], t[2]);
    soup_.triangles.push_back(t);
  }

  const HeightGrid& grid_;
  TriangleSoup& soup_;
  std::vector<std::uint32_t> below_;  // the bottom's point for each point of the rim
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
  std::vector<std::uint32_t> rim;
  for (std::uint32_t x = 0; x + 1 < block.columns(); ++x) rim.push_back(block.point(x, 0));
  for (std::uint32_t y = 0; y + 1 < block.rows(); ++y) rim.push_back(block.point(block.columns() - 1, y));
  for (std::uint32_t x = block.columns() - 1; x > 0; --x) rim.push_back(block.point(x, block.rows() - 1));
  for (std::uint32_t y = block.rows() - 1; y > 0; --y) rim.push_back(block.point(0, y));
  block.walls(rim, bottom_m);
  block.bottom();
  return soup;
}

}  // namespace thimble::host

// The columns of a log for what a scene does beside the fingertips: bounds, moving objects, control elements, tissues. Their names
// begin with the name of the object in the scene. CSV logs and the arrays of the Python package have the same columns.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "board/sim/simulation.h"

namespace thimble::scene {
struct Body;
}

namespace thimble::host {

// One quantity. With several components it is one field of a Python array and several columns of a CSV file.
struct SceneField {
  std::string name;                  // ball.position_m
  std::vector<std::string> columns;  // ball.x_m, ball.y_m, ball.z_m
};

class SceneColumns {
 public:
  SceneColumns() = default;  // none
  // Of a scene image. An image that is not valid has none: whoever runs it says why.
  explicit SceneColumns(std::span<const std::byte> image);

  [[nodiscard]] std::span<const SceneField> fields() const { return fields_; }
  // The values of all columns in their order, in a buffer that the next call overwrites. SI units; true is 1.
  [[nodiscard]] std::span<const double> values(const board::LogRow& row) const;

 private:
  void add(std::string name, std::vector<std::string> columns);
  void add_bounds();
  void add_body(const std::string& label, std::uint8_t object, const scene::Body& body);
  void add_tissue(const std::string& label, std::uint8_t object);

  std::vector<SceneField> fields_;
  std::vector<std::function<void(const board::LogRow&, std::vector<double>&)>> write_;
  mutable std::vector<double> values_;
};

}  // namespace thimble::host

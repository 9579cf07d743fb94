#include "host-tools/compiler/scene_value.h"

#include <vector>

namespace thimble::host {

std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) {
    row[j] = j;
  }
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t changed = diagonal + (a[i - 1] == b[j - 1] ? 0U : 1U);
      diagonal = row[j];
      row[j] = std::min({row[j] + 1, row[j - 1] + 1, changed});
    }
  }
  return row[b.size()];
}

std::string number(double value) { return nlohmann::json(value).dump(); }

std::string describe(const Range& range) {
  return std::string("a number ") + (range.least_excluded ? "above " : "from ") + number(range.least) +
         (range.least_excluded ? " and at most " : " to ") + number(range.most) +
         (*range.unit != '\0' ? " " : "") + range.unit;
}

}  // namespace thimble::host

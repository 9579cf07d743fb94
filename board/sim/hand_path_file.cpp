#include "board/sim/hand_path_file.h"

#include <array>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>
#include <optional>
#include <string>
#include <string_view>

namespace thimble::board {
namespace {

constexpr std::array<std::string_view, 5> kColumns = {"time_s", "x_m", "y_m", "z_m", "arm"};
constexpr std::size_t kTime = 0, kArm = 4;

std::string_view trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(" \t\r");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t\r") - first + 1);
}

std::vector<std::string_view> split(std::string_view line) {
  std::vector<std::string_view> cells;
  while (true) {
    const std::size_t comma = line.find(',');
    cells.push_back(trimmed(line.substr(0, comma)));
    if (comma == std::string_view::npos) return cells;
    line.remove_prefix(comma + 1);
  }
}

std::optional<std::size_t> column_named(std::string_view name) {
  for (std::size_t i = 0; i < kColumns.size(); ++i) {
    if (kColumns[i] == name) return i;
  }
  return std::nullopt;
}

}  // namespace

std::vector<PathPoint> read_hand_path(const std::filesystem::path& file) {
  std::ifstream in(file);
  if (!in) throw HandPathError(file.string() + ": " + std::strerror(errno));

  std::size_t line_number = 0;
  const auto fail = [&](const std::string& what) {
    throw HandPathError(file.string() + ":" + std::to_string(line_number) + ": " + what);
  };

  std::vector<std::size_t> columns;  // the meaning of each cell of a row
  std::vector<PathPoint> points;
  std::array<double, 2> last_time_s;
  last_time_s.fill(-std::numeric_limits<double>::infinity());
  for (std::string text; std::getline(in, text);) {
    ++line_number;
    std::string_view line(text);
    if (line_number == 1 && line.starts_with("\xEF\xBB\xBF"))
      line.remove_prefix(3);  // byte order mark, written by spreadsheets
    line = trimmed(line);
    if (line.empty()) continue;
    const std::vector<std::string_view> cells = split(line);

    if (columns.empty()) {
      std::array<bool, kColumns.size()> seen{};
      for (const std::string_view cell : cells) {
        const std::optional<std::size_t> column = column_named(cell);
        if (!column)
          fail("unknown column '" + std::string(cell) + "'; the header is time_s,x_m,y_m,z_m[,arm]");
        if (seen[*column]) fail("column '" + std::string(cell) + "' is repeated");
        seen[*column] = true;
        columns.push_back(*column);
      }
      for (std::size_t i = 0; i < kArm; ++i) {
        if (!seen[i])
          fail("column '" + std::string(kColumns[i]) +
               "' is missing; the header is time_s,x_m,y_m,z_m[,arm]");
      }
      continue;
    }

    if (cells.size() != columns.size()) {
      fail(std::to_string(cells.size()) + " cells where the header has " + std::to_string(columns.size()));
    }
    std::array<double, kColumns.size()> values{};
    for (std::size_t i = 0; i < cells.size(); ++i) {
      double& value = values[columns[i]];
      const auto [end, error] = std::from_chars(cells[i].data(), cells[i].data() + cells[i].size(), value);
      if (error != std::errc() || end != cells[i].data() + cells[i].size() || !std::isfinite(value)) {
        fail(std::string(kColumns[columns[i]]) + " is '" + std::string(cells[i]) + "', not a finite number");
      }
    }
    if (values[kArm] != 0.0 && values[kArm] != 1.0) fail("arm is neither 0 nor 1");
    const int arm = values[kArm] == 1.0 ? 1 : 0;
    double& last_s = last_time_s[static_cast<std::size_t>(arm)];
    if (values[kTime] <= last_s) fail("time_s does not rise");
    last_s = values[kTime];
    points.push_back({values[kTime], {values[1], values[2], values[3]}, arm});
  }
  if (columns.empty()) fail("the file is empty; the header is time_s,x_m,y_m,z_m[,arm]");
  if (points.empty()) fail("no row follows the header");
  return points;
}

}  // namespace thimble::board

#include "board/sim/hand_path_file.h"

#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <string_view>

#include "board/files/csv.h"
#include "board/files/text_file.h"

namespace thimble::board {
namespace {

constexpr std::array<std::string_view, 5> kColumns = {"time_s", "x_m", "y_m", "z_m", "arm"};
constexpr std::size_t kTime = 0, kArm = 4;
constexpr std::string_view kHeader = "time_s,x_m,y_m,z_m[,arm]";
// Beyond what anybody simulates; within, the differences and speeds of a path are finite, and its ticks can be counted.
constexpr double kMostTime_s = 1e6, kMostPlace_m = 1e3, kLeastStep_s = 1e-9;

std::vector<PathPoint> read(CsvReader csv) {
  if (!csv.next()) csv.fail("the file is empty; the header is " + std::string(kHeader));
  const std::vector<std::size_t> columns = csv.columns(kColumns, kArm, kHeader);
  std::vector<PathPoint> points;
  std::array<double, 2> last_time_s;
  last_time_s.fill(-std::numeric_limits<double>::infinity());
  while (csv.next()) {
    csv.check_width(columns.size());
    std::array<double, kColumns.size()> values{};
    for (std::size_t i = 0; i < columns.size(); ++i) {
      const std::optional<double> value = csv.number(i);
      if (!value) {
        csv.fail(std::string(kColumns.at(columns[i])) + " is '" + std::string(csv.cells()[i]) +
                 "', not a finite number");
      }
      values.at(columns[i]) = *value;
    }
    for (std::size_t i = 0; i < kArm; ++i) {
      const double most = i == kTime ? kMostTime_s : kMostPlace_m;
      if (std::abs(values[i]) > most)
        csv.fail(std::string(kColumns[i]) + " is not within " + std::to_string(static_cast<int>(most)) +
                 " of 0");
    }
    if (values[kArm] != 0.0 && values[kArm] != 1.0) csv.fail("arm is neither 0 nor 1");
    const int arm = values[kArm] == 1.0 ? 1 : 0;
    double& last_s = last_time_s[static_cast<std::size_t>(arm)];
    if (values[kTime] <= last_s) csv.fail("time_s does not rise");
    if (values[kTime] - last_s < kLeastStep_s) csv.fail("time_s rises by less than 1 ns");
    last_s = values[kTime];
    points.push_back({values[kTime], {values[1], values[2], values[3]}, arm});
  }
  if (points.empty()) csv.fail("no row follows the header");
  return points;
}

}  // namespace

std::vector<PathPoint> read_hand_path(const std::filesystem::path& file) {
  try {
    return read(CsvReader(read_text(file), file.string()));
  } catch (const FileError& error) {
    throw HandPathError(error.what());
  } catch (const CsvError& error) {
    throw HandPathError(error.what());
  }
}

}  // namespace thimble::board

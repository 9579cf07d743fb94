#include <algorithm>
#include <array>
#include <limits>
#include <optional>
#include <string>

#include "board/files/csv.h"
#include "host-tools/error.h"
#include "host-tools/files/input_file.h"
#include "host-tools/lab/run_log.h"

namespace thimble::host {
namespace {

constexpr std::size_t kCells = 12;

std::vector<board::LogRow> read_rows(board::CsvReader csv) {
  if (!csv.next()) csv.fail("it is empty");
  if (csv.row() != kLogHeader && !csv.row().starts_with(std::string(kLogHeader) + ','))
    csv.fail("the header does not begin with " + std::string(kLogHeader));
  const std::size_t columns = csv.cells().size();
  std::vector<board::LogRow> rows;
  std::array<double, 2> last_s;
  last_s.fill(-std::numeric_limits<double>::infinity());
  while (csv.next()) {
    std::array<double, kCells> cells{};
    bool numbers = csv.cells().size() == columns;
    for (std::size_t i = 0; numbers && i < kCells; ++i) {
      const std::optional<double> value = csv.number(i);
      numbers = value.has_value();
      cells[i] = value.value_or(0);
    }
    if (!numbers)
      csv.fail("'" + std::string(csv.row().substr(0, 60)) + "' is no row of " + std::to_string(columns) +
               " numbers");
    if (cells[1] != 0 && cells[1] != 1) csv.fail("arm is neither 0 nor 1");
    board::LogRow row;
    row.time_s = cells[0];
    row.arm = static_cast<int>(cells[1]);
    row.tip_m = {cells[2], cells[3], cells[4]};
    row.proxy_m = {cells[5], cells[6], cells[7]};
    row.force_N = {cells[8], cells[9], cells[10]};
    row.contacts = cells[11] > 0 ? static_cast<int>(std::min(cells[11], 3.0)) : 0;
    double& last = last_s[static_cast<std::size_t>(row.arm)];
    if (!(row.time_s > last)) csv.fail("time_s does not rise");
    last = row.time_s;
    rows.push_back(row);
  }
  return rows;
}

}  // namespace

std::vector<board::LogRow> read_run_log(const std::filesystem::path& file) {
  const std::string text = read_input(file);
  try {
    return read_rows(board::CsvReader(text, file.string()));
  } catch (const board::CsvError& error) {
    throw Error(ExitCode::kBadInput, "bad-log", error.what(),
                "give a recording, or a log of `thimble simulate` or `thimble replay`");
  }
}

}  // namespace thimble::host

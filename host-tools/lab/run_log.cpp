#include "host-tools/lab/run_log.h"

#include <array>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <limits>
#include <string>
#include <string_view>

#include "host-tools/error.h"
#include "host-tools/files/input_file.h"

namespace thimble::host {
namespace {

constexpr std::string_view kLogHeader =
    "time_s,arm,tip_x_m,tip_y_m,tip_z_m,proxy_x_m,proxy_y_m,proxy_z_m,force_x_N,force_y_N,force_z_N,contacts";
constexpr std::size_t kCells = 12;

// False: not so many numbers, or one that is none.
bool parse(std::string_view line, std::array<double, kCells>& cells) {
  for (std::size_t i = 0; i < kCells; ++i) {
    const std::size_t comma = line.find(',');
    if ((comma == std::string_view::npos) != (i + 1 == kCells)) return false;
    const std::string_view cell = line.substr(0, comma);
    const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), cells[i]);
    if (error != std::errc() || end != cell.data() + cell.size() || !std::isfinite(cells[i])) return false;
    if (i + 1 < kCells) line.remove_prefix(comma + 1);
  }
  return true;
}

}  // namespace

void write_log_header(std::ostream& out) { out << kLogHeader << '\n'; }

void write_log_row(std::ostream& out, const board::LogRow& row) {
  std::array<char, 320> line{};
  const int size = std::snprintf(
      line.data(), line.size(), "%.9g,%d,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%d\n", row.time_s,
      row.arm, row.tip_m.x(), row.tip_m.y(), row.tip_m.z(), row.proxy_m.x(), row.proxy_m.y(), row.proxy_m.z(),
      row.force_N.x(), row.force_N.y(), row.force_N.z(), row.contacts);
  out.write(line.data(), size);
}

std::vector<board::LogRow> read_run_log(const std::filesystem::path& file) {
  std::ifstream in = open_input(file);
  std::size_t number = 0;
  const auto fail = [&](const std::string& what) {
    throw Error(ExitCode::kBadInput, "bad-log", file.string() + ":" + std::to_string(number) + ": " + what,
                "give a recording, or a log of `thimble simulate` or `thimble replay`");
  };
  std::vector<board::LogRow> rows;
  std::array<double, 2> last_s;
  last_s.fill(-std::numeric_limits<double>::infinity());
  for (std::string line; std::getline(in, line);) {
    ++number;
    if (!line.empty() && line.back() == '\r') line.pop_back();
    if (number == 1) {
      if (line != kLogHeader) fail("the header is not " + std::string(kLogHeader));
      continue;
    }
    if (line.empty()) continue;
    std::array<double, kCells> cells{};
    if (!parse(line, cells)) fail("'" + line.substr(0, 60) + "' is no row of twelve numbers");
    if (cells[1] != 0 && cells[1] != 1) fail("arm is neither 0 nor 1");
    board::LogRow row;
    row.time_s = cells[0];
    row.arm = static_cast<int>(cells[1]);
    row.tip_m = {cells[2], cells[3], cells[4]};
    row.proxy_m = {cells[5], cells[6], cells[7]};
    row.force_N = {cells[8], cells[9], cells[10]};
    row.contacts = cells[11] > 0 ? static_cast<int>(std::min(cells[11], 3.0)) : 0;
    double& last = last_s[static_cast<std::size_t>(row.arm)];
    if (!(row.time_s > last)) fail("time_s does not rise");
    last = row.time_s;
    rows.push_back(row);
  }
  if (number == 0) fail("it is empty");
  return rows;
}

}  // namespace thimble::host

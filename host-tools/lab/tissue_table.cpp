#include "host-tools/lab/tissue_table.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>
#include <locale>
#include <sstream>
#include <string_view>

#include "control/scene/limits.h"
#include "host-tools/error.h"

namespace thimble::host {
namespace {

struct Column {
  std::string_view name;
  double TissueKind::*value;
  double least;
  double most;
};
constexpr double kAny = 1.0e30;
constexpr std::array<Column, 6> kNumbers{
    {{"from", &TissueKind::from, -kAny, kAny},
     {"to", &TissueKind::to, -kAny, kAny},
     {"stiffness_N_m", &TissueKind::stiffness_N_m, 0.0, static_cast<double>(control::kMaxStiffness_N_m)},
     {"tear_N", &TissueKind::tear_N, 0.0, static_cast<double>(control::kMaxTear_N)},
     {"friction_N", &TissueKind::friction_N, 0.0, static_cast<double>(control::kMaxTear_N)},
     {"viscosity_N_s_m2", &TissueKind::viscosity_N_s_m2, 0.0,
      static_cast<double>(control::kMaxViscosity_N_s_m2)}}};
constexpr std::size_t kMaxNameBytes = 64;

std::vector<std::string> cells_of(const std::string& line) {
  std::vector<std::string> cells;
  std::istringstream stream(line);
  for (std::string cell; std::getline(stream, cell, ',');) {
    const std::size_t first = cell.find_first_not_of(" \t\r");
    cells.push_back(
        first == std::string::npos ? "" : cell.substr(first, cell.find_last_not_of(" \t\r") - first + 1));
  }
  return cells;
}

std::optional<double> number_in(const std::string& text) {
  std::istringstream stream(text);
  stream.imbue(std::locale::classic());
  double value = 0.0;
  if (!(stream >> value) || stream.peek() != std::istringstream::traits_type::eof()) return std::nullopt;
  return value;
}

class TableReader {
 public:
  explicit TableReader(const std::filesystem::path& file) : file_(file) {}

  std::vector<TissueKind> read() {
    std::ifstream stream(file_);
    if (!stream) fail(std::strerror(errno));
    std::vector<TissueKind> kinds;
    std::vector<std::string> header;
    for (std::string line; std::getline(stream, line);) {
      ++line_;
      const std::vector<std::string> cells = cells_of(line);
      if (cells.empty() || (cells.size() == 1 && cells[0].empty()) || cells[0].starts_with('#')) continue;
      if (header.empty()) {
        header = cells;
        check_header(header);
      } else {
        kinds.push_back(row(header, cells));
        check_overlap(kinds);
      }
    }
    if (kinds.empty()) fail("has no tissue");
    return kinds;
  }

 private:
  [[noreturn]] void fail(const std::string& what) const {
    std::string place = file_.string();
    if (line_ > 0) place.append(":").append(std::to_string(line_));
    throw Error(ExitCode::kBadInput, "bad-layers", place + ": " + what,
                "correct the table; docs/cli.md says what it holds");
  }

  void check_header(const std::vector<std::string>& header) const {
    std::vector<std::string> wanted{"name"};
    for (const Column& column : kNumbers) wanted.emplace_back(column.name);
    std::vector<std::string> given = header;
    std::sort(given.begin(), given.end());
    std::sort(wanted.begin(), wanted.end());
    if (given != wanted)
      fail("the columns are not name,from,to,stiffness_N_m,tear_N,friction_N,viscosity_N_s_m2");
  }

  [[nodiscard]] TissueKind row(const std::vector<std::string>& header,
                               const std::vector<std::string>& cells) const {
    if (cells.size() != header.size())
      fail(std::to_string(cells.size()) + " cells where the header has " + std::to_string(header.size()));
    TissueKind kind;
    for (std::size_t i = 0; i < cells.size(); ++i) {
      if (header[i] == "name") {
        kind.name = cells[i];
        continue;
      }
      const auto* const column = std::find_if(kNumbers.begin(), kNumbers.end(),
                                              [&](const Column& each) { return each.name == header[i]; });
      const std::optional<double> value = number_in(cells[i]);
      if (!value || !(*value >= column->least && *value <= column->most)) {
        std::ostringstream text;
        text << header[i] << " is '" << cells[i] << "', allowed is a number from " << column->least << " to "
             << column->most;
        fail(text.str());
      }
      kind.*(column->value) = *value;
    }
    if (kind.name.empty() || kind.name.size() > kMaxNameBytes) fail("name is not a text of 1 to 64 bytes");
    if (!(kind.from < kind.to)) fail("from is not below to");
    if (kind.stiffness_N_m == 0.0 && kind.tear_N > 0.0)
      fail("tears, and has no stiffness to come to that force");
    return kind;
  }

  void check_overlap(const std::vector<TissueKind>& kinds) const {
    const TissueKind& last = kinds.back();
    for (std::size_t i = 0; i + 1 < kinds.size(); ++i) {
      if (kinds[i].from < last.to && last.from < kinds[i].to)
        fail(last.name + " overlaps " + kinds[i].name + " in intensity");
    }
  }

  std::filesystem::path file_;
  std::size_t line_ = 0;
};

}  // namespace

std::vector<TissueKind> read_tissue_table(const std::filesystem::path& file) {
  return TableReader(file).read();
}

std::optional<std::size_t> kind_of(const std::vector<TissueKind>& kinds, double value) {
  for (std::size_t i = 0; i < kinds.size(); ++i) {
    if (kinds[i].from <= value && value < kinds[i].to) return i;
  }
  return std::nullopt;
}

std::vector<TissueKind> kinds_by_k_means(std::vector<double> values, std::size_t count) {
  std::sort(values.begin(), values.end());
  // Equal values belong together: n points with weights.
  std::vector<double> points;
  std::vector<double> weight{0.0};  // sums over the points before, so that any range costs two look-ups
  std::vector<double> first{0.0};
  std::vector<double> second{0.0};
  const double middle = values[values.size() / 2];  // sums of small numbers round less
  for (const double value : values) {
    if (points.empty() || value != points.back()) {
      points.push_back(value);
      weight.push_back(weight.back());
      first.push_back(first.back());
      second.push_back(second.back());
    }
    const double x = value - middle;
    weight.back() += 1.0;
    first.back() += x;
    second.back() += x * x;
  }
  const std::size_t n = points.size();
  const std::size_t classes = std::min(count, n);
  const auto cost = [&](std::size_t begin,
                        std::size_t end) {  // the squares about the mean of points begin to end - 1
    const double w = weight[end] - weight[begin];
    const double s = first[end] - first[begin];
    return std::max(second[end] - second[begin] - s * s / w, 0.0);
  };
  // least[c][e]: the first e points in c + 1 classes; begin[c][e]: where the last of them begins.
  std::vector<std::vector<double>> least(classes,
                                         std::vector<double>(n + 1, std::numeric_limits<double>::infinity()));
  std::vector<std::vector<std::size_t>> begin(classes, std::vector<std::size_t>(n + 1, 0));
  for (std::size_t end = 1; end <= n; ++end) least[0][end] = cost(0, end);
  for (std::size_t c = 1; c < classes; ++c) {
    for (std::size_t end = c + 1; end <= n; ++end) {
      for (std::size_t b = c; b < end; ++b) {
        const double with = least[c - 1][b] + cost(b, end);
        if (with < least[c][end]) {
          least[c][end] = with;
          begin[c][end] = b;
        }
      }
    }
  }

  // Soft tissue gives way at about 1 N to a biopsy needle (Okamura, Simone, O'Leary 2004); the rest is a scale to tell classes by.
  std::vector<TissueKind> kinds(classes);
  std::size_t end = n;
  for (std::size_t c = classes; c-- > 0;) {
    const std::size_t start = begin[c][end];
    const double rank = static_cast<double>(c) / static_cast<double>(classes);
    TissueKind& kind = kinds[c];
    kind.name = "tissue " + std::to_string(c);
    kind.from = start == 0 ? -kAny : 0.5 * (points[start - 1] + points[start]);
    kind.to = c + 1 == classes ? kAny : kinds[c + 1].from;
    kind.stiffness_N_m = std::round(200.0 + 600.0 * rank);
    kind.tear_N = std::round(10.0 * (0.4 + 2.4 * rank)) / 10.0;
    kind.friction_N = std::round(100.0 * (0.05 + 0.25 * rank)) / 100.0;
    kind.viscosity_N_s_m2 = std::round(10.0 + 40.0 * rank);
    end = start;
  }
  if (classes > 1) kinds[0] = {.name = "air", .from = kinds[0].from, .to = kinds[0].to};
  return kinds;
}

}  // namespace thimble::host

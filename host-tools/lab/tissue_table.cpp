#include "host-tools/lab/tissue_table.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <sstream>
#include <string_view>

#include "board/files/csv.h"
#include "board/files/text_file.h"
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
constexpr std::string_view kHeader = "name,from,to,stiffness_N_m,tear_N,friction_N,viscosity_N_s_m2";

std::vector<std::string_view> column_names() {
  std::vector<std::string_view> names{"name"};
  for (const Column& column : kNumbers) names.push_back(column.name);
  return names;
}

TissueKind read_kind(const board::CsvReader& csv, const std::vector<std::size_t>& columns) {
  csv.check_width(columns.size());
  TissueKind kind;
  for (std::size_t i = 0; i < columns.size(); ++i) {
    const std::string cell(csv.cells()[i]);
    if (columns[i] == 0) {
      kind.name = cell;
      continue;
    }
    const Column& column = kNumbers.at(columns[i] - 1);
    const std::optional<double> value = csv.number(i);
    if (!value || !(*value >= column.least && *value <= column.most)) {
      std::ostringstream text;
      text << column.name << " is '" << cell << "', allowed is a number from " << column.least << " to "
           << column.most;
      csv.fail(text.str());
    }
    kind.*(column.value) = *value;
  }
  if (kind.name.empty() || kind.name.size() > kMaxNameBytes) csv.fail("name is not a text of 1 to 64 bytes");
  if (!(kind.from < kind.to)) csv.fail("from is not below to");
  if (kind.stiffness_N_m == 0.0 && kind.tear_N > 0.0)
    csv.fail("tears, and has no stiffness to come to that force");
  return kind;
}

std::vector<TissueKind> read_kinds(board::CsvReader csv) {
  const std::vector<std::string_view> names = column_names();
  if (!csv.next()) csv.fail("has no tissue");
  const std::vector<std::size_t> columns = csv.columns(names, names.size(), kHeader);
  std::vector<TissueKind> kinds;
  while (csv.next()) {
    kinds.push_back(read_kind(csv, columns));
    const TissueKind& last = kinds.back();
    for (std::size_t i = 0; i + 1 < kinds.size(); ++i) {
      if (kinds[i].from < last.to && last.from < kinds[i].to)
        csv.fail(last.name + " overlaps " + kinds[i].name + " in intensity");
    }
  }
  if (kinds.empty()) csv.fail("has no tissue");
  return kinds;
}

}  // namespace

std::vector<TissueKind> read_tissue_table(const std::filesystem::path& file) {
  constexpr const char* kRemedy = "correct the table; docs/cli.md says what it holds";
  try {
    return read_kinds(board::CsvReader(board::read_text(file), file.string(), '#'));
  } catch (const board::FileError& error) {
    throw Error(ExitCode::kBadInput, "bad-layers", error.what(), kRemedy);
  } catch (const board::CsvError& error) {
    throw Error(ExitCode::kBadInput, "bad-layers", error.what(), kRemedy);
  }
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

  // A biopsy needle punctures soft tissue at about 1 N (Okamura, Simone, O'Leary 2004); the other values only distinguish the classes.
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

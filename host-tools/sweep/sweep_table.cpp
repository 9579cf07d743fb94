#include "host-tools/sweep/sweep_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <sstream>
#include <vector>

namespace thimble::host {
namespace {

constexpr std::size_t kWidth = 120;  // of a line of text

std::vector<std::string> cells_of(const std::string& line) {
  std::vector<std::string> cells;
  std::istringstream in(line);
  for (std::string cell; std::getline(in, cell, ',');) cells.push_back(cell);
  if (line.ends_with(',')) cells.emplace_back();
  return cells;
}

std::string wrapped(const std::string& text) {
  std::istringstream in(text);
  std::string lines;
  std::size_t width = 0;
  for (std::string word; in >> word;) {
    if (width > 0 && width + 1 + word.size() > kWidth) {
      lines += "\n";
      width = 0;
    }
    lines.append(width == 0 ? "" : " ").append(word);
    width += (width == 0 ? 0 : 1) + word.size();
  }
  return lines + "\n";
}

std::string cut(const std::string& cell, int digits) {
  char* end = nullptr;
  const double value = std::strtod(cell.c_str(), &end);
  if (end == cell.c_str() || value == 0) return cell;
  const double unit = std::pow(10.0, std::floor(std::log10(std::abs(value))) + 1 - digits);
  // A whole number of units may be a little less in binary.
  return fmt::format("{:.{}g}", std::trunc(value / unit * (1 + 1e-12)) * unit, digits + 6);
}

// A cell of Markdown.
std::string escaped(const std::string& text) {
  std::string escaped;
  for (const char c : text) escaped.append(c == '|' ? "\\" : "").append(1, c);
  return escaped;
}

std::string named(const SweepAxis& axis, std::size_t value) {
  return fmt::format("{}{}{}", axis.values[value].text, axis.unit.empty() ? "" : " ", axis.unit);
}

std::size_t column_of(const std::vector<std::string>& names, const std::string& name) {
  return static_cast<std::size_t>(std::ranges::find(names, name) - names.begin());
}

class Page {
 public:
  Page(const SweepPlan& plan, const std::string& head, const SweepResults& results)
      : plan_(plan), results_(results), names_(cells_of(head.substr(head.find('\n') + 1))) {
    if (!names_.empty() && names_.back().ends_with('\n')) names_.back().pop_back();
  }

  [[nodiscard]] std::string tables() const {
    std::string text;
    // Each combination of the other axes, in the order of the runs.
    for (std::size_t run = 0; run < plan_.runs(); ++run) {
      const std::vector<std::size_t> place = plan_.place(run);
      if (place[plan_.table->rows] != 0 || place[plan_.table->columns] != 0) continue;
      text += title(place) + table(place);
    }
    return text;
  }

 private:
  [[nodiscard]] std::string title(const std::vector<std::size_t>& place) const {
    std::string title;
    for (std::size_t i = 0; i < place.size(); ++i)
      if (i != plan_.table->rows && i != plan_.table->columns)
        title += fmt::format("{}{}", title.empty() ? "" : ", ", named(plan_.axes[i], place[i]));
    return title.empty() ? title : fmt::format("\n## {}\n", title);
  }
  [[nodiscard]] std::string table(std::vector<std::size_t> place) const {
    const SweepAxis& rows = plan_.axes[plan_.table->rows];
    const SweepAxis& columns = plan_.axes[plan_.table->columns];
    std::string text = fmt::format("\n| {} |", escaped(rows.label.empty() ? rows.what : rows.label)),
                rule = "|---|";
    for (std::size_t column = 0; column < columns.values.size(); ++column) {
      text += fmt::format(" {} |", escaped(named(columns, column)));
      rule += "---|";
    }
    text += "\n" + rule + "\n";
    for (std::size_t row = 0; row < rows.values.size(); ++row) {
      text += fmt::format("| {} |", escaped(named(rows, row)));
      place[plan_.table->rows] = row;
      for (std::size_t column = 0; column < columns.values.size(); ++column) {
        place[plan_.table->columns] = column;
        text += fmt::format(" {} |", cell(place));
      }
      text += "\n";
    }
    return text;
  }
  [[nodiscard]] std::string cell(const std::vector<std::size_t>& place) const {
    std::size_t run = 0;
    for (std::size_t i = 0; i < place.size(); ++i) run = run * plan_.axes[i].values.size() + place[i];
    const std::vector<std::string> cells = cells_of(results_.line(run));
    const std::string& status = cells[column_of(names_, "status")];
    const std::string value = cut(cells[column_of(names_, plan_.table->value)], plan_.table->digits);
    if (status == "all-stable") return fmt::format(">= {}", value);
    return value.empty() ? status : value;
  }

  const SweepPlan& plan_;
  const SweepResults& results_;
  std::vector<std::string> names_;
};

}  // namespace

std::string table_page(const SweepPlan& plan, const std::string& head, const SweepResults& results,
                       const std::string& made_by) {
  std::string text =
      fmt::format("# {}\n\n{}", plan.name,
                  wrapped(fmt::format("Made by `{}`; every run gives the same figures.", made_by)));
  if (!plan.description.empty()) text += fmt::format("\n{}", wrapped(plan.description));
  return text + Page(plan, head, results).tables();
}

}  // namespace thimble::host

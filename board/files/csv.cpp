#include "board/files/csv.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <utility>

namespace thimble::board {
namespace {

constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view kBlank = " \t\r";
  const std::size_t first = text.find_first_not_of(kBlank);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kBlank) - first + 1);
}

}  // namespace

CsvReader::CsvReader(std::string_view text, std::string name, char comment)
    : text_(text), name_(std::move(name)), comment_(comment) {
  if (text_.starts_with(kByteOrderMark)) offset_ = kByteOrderMark.size();
}

bool CsvReader::next() {
  while (offset_ < text_.size()) {
    ++line_;
    const std::size_t end = text_.find('\n', offset_);
    whole_ = end != std::string_view::npos;
    std::string_view line = text_.substr(offset_, end - offset_);
    offset_ = whole_ ? end + 1 : text_.size();
    if (comment_ != '\0') line = line.substr(0, line.find(comment_));
    row_ = line = trimmed(line);
    if (line.empty()) continue;
    cells_.clear();
    for (bool more = true; more;) {
      const std::size_t comma = line.find(',');
      more = comma != std::string_view::npos;
      cells_.push_back(trimmed(line.substr(0, comma)));
      line.remove_prefix(more ? comma + 1 : line.size());
    }
    return true;
  }
  return false;
}

std::optional<double> CsvReader::number(std::size_t cell) const {
  const std::string_view text = cells_.at(cell);
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

std::string CsvReader::place() const { return line_ == 0 ? name_ : name_ + ":" + std::to_string(line_); }

void CsvReader::fail(const std::string& what) const { throw CsvError(place() + ": " + what); }

std::vector<std::size_t> CsvReader::columns(std::span<const std::string_view> names, std::size_t required,
                                            std::string_view header) const {
  const std::string wanted = "; the header is " + std::string(header);
  std::vector<std::size_t> columns;
  for (const std::string_view cell : cells_) {
    const auto found = std::find(names.begin(), names.end(), cell);
    if (found == names.end()) fail("unknown column '" + std::string(cell.substr(0, 60)) + "'" + wanted);
    const auto column = static_cast<std::size_t>(found - names.begin());
    if (std::find(columns.begin(), columns.end(), column) != columns.end())
      fail("column '" + std::string(cell) + "' is given twice");
    columns.push_back(column);
  }
  for (std::size_t i = 0; i < required; ++i) {
    if (std::find(columns.begin(), columns.end(), i) == columns.end())
      fail("column '" + std::string(names[i]) + "' is missing" + wanted);
  }
  return columns;
}

void CsvReader::check_width(std::size_t columns) const {
  if (cells_.size() != columns)
    fail(std::to_string(cells_.size()) + " cells where the header has " + std::to_string(columns));
}

}  // namespace thimble::board

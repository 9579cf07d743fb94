// Rows of a CSV file, with file and line in every error. The readers of hand paths, height grids, tissue tables, scan logs and
// simulation logs use it.
//
// Cells are separated by commas; blanks around them do not count. Numbers have a decimal point in every locale. Lines end with
// LF or CR LF; empty lines are skipped, and a byte order mark at the start of the text.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace thimble::board {

// what(): "file:line: what is wrong".
class CsvError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

class CsvReader {
 public:
  // `text` must outlive it. `name` stands in errors. comment: the rest of a line from this character on is skipped; 0: none.
  CsvReader(std::string_view text, std::string name, char comment = '\0');

  // Goes to the next row; false at the end of the text.
  bool next();
  [[nodiscard]] const std::vector<std::string_view>& cells() const { return cells_; }
  [[nodiscard]] std::string_view row() const { return row_; }  // the whole line, without blanks at its ends
  [[nodiscard]] bool whole() const {
    return whole_;
  }  // the line ends with LF: the file was not cut short in it
  [[nodiscard]] std::size_t line() const { return line_; }  // from 1; 0 before the first row
  [[nodiscard]] std::size_t offset() const {
    return offset_;
  }  // bytes of the text up to the end of this line

  // A finite number; nothing: the cell is none.
  [[nodiscard]] std::optional<double> number(std::size_t cell) const;

  [[nodiscard]] std::string place() const;                // "file:line"
  [[noreturn]] void fail(const std::string& what) const;  // CsvError
  // Takes the row as the header. The result says for each cell which of `names` it is; they may stand in any order. The first
  // `required` of them must be there, none may be there twice. `header` is how the error writes the header.
  [[nodiscard]] std::vector<std::size_t> columns(std::span<const std::string_view> names,
                                                 std::size_t required, std::string_view header) const;
  // Fails unless the row has as many cells as the header.
  void check_width(std::size_t columns) const;

 private:
  std::string_view text_;
  std::string name_;
  char comment_;
  std::string_view row_;
  std::vector<std::string_view> cells_;
  std::size_t line_ = 0;
  std::size_t offset_ = 0;
  bool whole_ = true;
};

}  // namespace thimble::board

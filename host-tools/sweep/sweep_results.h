// The results of a sweep: a CSV file, a line a run, in the order of the runs. While runs are missing, the lines are in files beside it, which
// grow run by run: FILE.runs, or FILE.runs.2-of-8 of a part. Whoever works with the file continues with what all of them have.
//
//   # thimble sweep, plan 1a2b3c4d
//   run,arm,rate_Hz,status,peak_force_N,...
//   0,premium-1.5,1000,ok,3.7,...
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "host-tools/files/file_lock.h"
#include "host-tools/files/growing_file.h"

namespace thimble::host {

class SweepResults {
 public:
  // Reads what is there. head: two lines; columns: cells of each line. Error kBadInput: a file is no results of this plan, or damaged.
  SweepResults(std::filesystem::path file, std::string head, std::size_t columns, std::size_t runs);

  [[nodiscard]] std::size_t runs() const { return lines_.size(); }
  [[nodiscard]] std::size_t done() const { return done_; }
  [[nodiscard]] bool is_whole() const { return done_ == lines_.size(); }
  [[nodiscard]] bool has(std::size_t run) const { return !lines_.at(run).empty(); }
  [[nodiscard]] const std::string& line(std::size_t run) const { return lines_.at(run); }
  // Of the runs that are there, those whose `status` is neither ok nor the end of a search.
  [[nodiscard]] std::size_t failed() const;
  void read_again();  // what other programs have written since

  // From now on lines can be added. part: of the name of the growing file, as "2-of-8"; empty: of all. What follows the last whole line of that
  // file is cut off. Error kRefused: another program adds to it, or it cannot be written (kPermission).
  void open(const std::string& part);
  void add(std::size_t run, const std::string& line);  // the system has it when it returns
  // All runs are there: writes the file and removes the growing ones.
  void finish();

 private:
  [[nodiscard]] std::vector<std::filesystem::path> growing() const;
  [[nodiscard]] std::size_t read(const std::filesystem::path& file, bool grows);  // bytes of whole lines

  std::filesystem::path file_;
  std::string head_;
  std::size_t columns_;
  std::vector<std::string> lines_;
  std::size_t done_ = 0;
  std::filesystem::path own_;
  std::optional<FileLock> lock_;
  GrowingFile out_;
};

}  // namespace thimble::host

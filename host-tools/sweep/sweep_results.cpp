#include "host-tools/sweep/sweep_results.h"

#include <algorithm>
#include <charconv>
#include <utility>

#include "host-tools/error.h"
#include "host-tools/files/input_file.h"
#include "host-tools/files/output_file.h"

namespace thimble::host {
namespace {

// The end of a name: ".2-of-8".
bool is_part(std::string_view text) {
  const auto skip = [&text](std::string_view what) {
    const bool has = text.starts_with(what);
    if (has) text.remove_prefix(what.size());
    return has;
  };
  const auto skip_digits = [&text] {
    const std::size_t digits = std::min(text.find_first_not_of("0123456789"), text.size());
    text.remove_prefix(digits);
    return digits > 0;
  };
  return skip(".") && skip_digits() && skip("-of-") && skip_digits() && text.empty();
}

std::string_view cell_of(std::string_view line, std::size_t column) {
  for (; column > 0; --column) line.remove_prefix(std::min(line.find(','), line.size() - 1) + 1);
  return line.substr(0, line.find_first_of(",\n"));
}

}  // namespace

SweepResults::SweepResults(std::filesystem::path file, std::string head, std::size_t columns,
                           std::size_t runs)
    : file_(std::move(file)), head_(std::move(head)), columns_(columns), lines_(runs) {
  read_again();
}

void SweepResults::read_again() {
  if (std::filesystem::exists(file_)) static_cast<void>(read(file_, false));
  for (const std::filesystem::path& each : growing())
    if (each != own_) static_cast<void>(read(each, true));
}

std::vector<std::filesystem::path> SweepResults::growing() const {
  std::vector<std::filesystem::path> found;
  const std::filesystem::path folder = file_.has_parent_path() ? file_.parent_path() : ".";
  const std::string name = file_.filename().string() + ".runs";
  std::error_code gone;  // another program may end and remove its file
  for (std::filesystem::directory_iterator each(folder, gone), end; !gone && each != end;
       each.increment(gone)) {
    const std::string other = each->path().filename().string();
    if (other == name || (other.starts_with(name) && is_part(std::string_view(other).substr(name.size()))))
      found.push_back(file_.parent_path() / other);
  }
  std::ranges::sort(found);
  return found;
}

std::size_t SweepResults::read(const std::filesystem::path& file, bool grows) {
  const std::string text = read_input(file);
  if (grows && head_.starts_with(text)) return 0;  // interrupted in the head
  if (!text.starts_with(head_))
    throw Error(ExitCode::kBadInput, "wrong-results",
                file.string() +
                    ":1: these are not the results of this plan: another plan made them, or the plan, its "
                    "scene, its path, its arm or Thimble has changed since",
                "give another --output, or remove the file");
  std::size_t begin = head_.size(), number = 3;
  for (std::size_t end = 0; (end = text.find('\n', begin)) != std::string::npos; begin = end + 1, ++number) {
    const std::string_view line = std::string_view(text).substr(begin, end - begin);
    std::size_t run = lines_.size();
    const auto [rest, error] = std::from_chars(line.data(), line.data() + line.size(), run);
    const bool a_run =
        error == std::errc() && run < lines_.size() && rest != line.data() + line.size() && *rest == ',';
    if (!a_run || static_cast<std::size_t>(std::ranges::count(line, ',')) + 1 != columns_)
      throw Error(ExitCode::kBadInput, "bad-results",
                  file.string() + ":" + std::to_string(number) + ": it is not a line of a run",
                  "remove this line; its run is done again");
    if (lines_[run].empty()) ++done_;
    lines_[run] = line;
  }
  return begin;
}

std::size_t SweepResults::failed() const {
  const std::string_view names = std::string_view(head_).substr(head_.find('\n') + 1);
  std::size_t column = 0;  // an axis may be a pointer with this word in it
  while (column + 1 < columns_ && cell_of(names, column) != "status") ++column;
  return static_cast<std::size_t>(std::ranges::count_if(lines_, [column](const std::string& line) {
    if (line.empty()) return false;
    const std::string_view status = cell_of(line, column);
    return status != "ok" && status != "all-stable";
  }));
}

void SweepResults::open(const std::string& part) {
  own_ = file_;
  own_ += part.empty() ? ".runs" : ".runs." + part;
  lock_.emplace(own_);
  if (!lock_->held())
    throw Error(ExitCode::kRefused, "sweep-in-use", "another sweep adds to " + own_.string(),
                "wait until it has ended, or give another --output");
  out_.open(own_, std::filesystem::exists(own_) ? read(own_, true) : 0, head_);
}

void SweepResults::add(std::size_t run, const std::string& line) {
  out_.stream() << line + "\n";
  out_.flush();
  if (lines_.at(run).empty()) ++done_;
  lines_[run] = line;
}

void SweepResults::finish() {
  OutputFile output(file_);
  output.stream() << head_;
  for (const std::string& line : lines_) output.stream() << line << '\n';
  output.commit();
  std::error_code gone;
  for (const std::filesystem::path& each : growing()) std::filesystem::remove(each, gone);
}

}  // namespace thimble::host

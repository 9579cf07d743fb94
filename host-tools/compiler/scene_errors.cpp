#include "host-tools/compiler/scene_errors.h"

#include <algorithm>
#include <charconv>
#include <nlohmann/json.hpp>
#include <utility>

namespace thimble::host {
namespace {

// "name:LINE: "; 0: the cause does not begin so.
std::size_t line_in(const std::string& cause, const std::string& name, std::size_t& end) {
  if (!cause.starts_with(name + ":")) return 0;
  std::size_t line = 0;
  const char* const last = cause.data() + cause.size();
  const auto read = std::from_chars(cause.data() + name.size() + 1, last, line);
  if (read.ec != std::errc() || last - read.ptr < 2 || read.ptr[0] != ':' || read.ptr[1] != ' ') return 0;
  end = static_cast<std::size_t>(read.ptr - cause.data()) + 2;
  return line;
}

// Of the first byte that no JSON has; none in valid JSON.
std::size_t syntax_error(const std::string& plain) {
  try {
    const nlohmann::json valid = nlohmann::json::parse(plain);
  } catch (const nlohmann::json::parse_error& error) {
    return error.byte > 0 ? error.byte - 1 : 0;
  } catch (const nlohmann::json::exception&) {  // a number out of range, without a place
  }
  return std::string::npos;
}

}  // namespace

board::JsonDocument parse_commented(const std::string& text, const std::string& name,
                                    const std::string& what) {
  try {
    return {without_comments(text), name, what};
  } catch (const board::JsonError& error) {
    const std::string remedy =
        error.name == "bad-json" && error.remedy.starts_with("correct the file")
            ? "correct the file: it has to be JSON in UTF-8; comments are allowed, trailing commas are not"
            : error.remedy;
    throw board::JsonError(error.name, error.what(), remedy);
  }
}

SceneErrors::SceneErrors(ExitCode exit_code, std::vector<SceneIssue> found)
    : Error(exit_code, found.front().name, found.front().cause, found.front().remedy),
      issues(std::move(found)) {
  if (issues.size() <= kMost) return;
  more = issues.size() - kMost;
  issues.resize(kMost);
}

std::string SceneIssues::pointer_in(const std::string& cause, const std::string& pointer) const {
  std::size_t end = 0;
  if (line_in(cause, name_, end) == 0) return pointer;
  const std::string_view rest = std::string_view(cause).substr(end);
  std::string longest;
  for (const auto& [each, unused] : values_) {
    if (each.size() > longest.size() && rest.starts_with(each) &&
        (rest.size() == each.size() || rest[each.size()] == ' ' || rest[each.size()] == ':'))
      longest = each;
  }
  return longest;
}

TextPlace SceneIssues::place_of(const SceneIssue& issue) const {
  if (const auto value = values_.find(issue.pointer); value != values_.end())
    return place_at(text_, issue.name == "unknown-key" ? value->second.key : value->second.begin);
  std::size_t unused = 0;
  const std::size_t line = line_in(issue.cause, name_, unused);
  const std::size_t offset = line == 0 ? std::string::npos : syntax_error(without_comments(text_));
  const TextPlace place = offset == std::string::npos ? TextPlace{} : place_at(text_, offset);
  return place.line == line ? place : TextPlace{std::max<std::size_t>(line, 1), 1};
}

void SceneIssues::add(const Error& error, const std::string& pointer) {
  if (issues_.empty()) {
    code_ = error.code;
    // What is not valid JSON, or nested too deep, has no values.
    if (error.name != "bad-json") values_ = find_values(without_comments(text_));
  }
  SceneIssue issue{error.name, error.cause, error.remedy, pointer_in(error.cause, pointer), {}};
  const auto is_known = [&issue](const SceneIssue& other) {
    return other.cause == issue.cause || (other.pointer == issue.pointer && other.name == issue.name &&
                                          issue.name != "missing-key" && !issue.pointer.empty());
  };
  if (std::ranges::any_of(issues_, is_known)) return;
  if (issues_.size() == kMost) throw Full{};
  issue.place = place_of(issue);
  issues_.push_back(std::move(issue));
}

void SceneIssues::raise() {
  std::stable_sort(issues_.begin() + 1, issues_.end(), [](const SceneIssue& a, const SceneIssue& b) {
    return std::pair(a.place.line, a.place.column) < std::pair(b.place.line, b.place.column);
  });
  throw SceneErrors(code_, std::move(issues_));
}

}  // namespace thimble::host

// Everything that is wrong in a scene file at once: for a person who corrects it, and for an editor that shows it in the text.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "board/files/json_document.h"
#include "host-tools/compiler/scene_text.h"
#include "host-tools/error.h"

namespace thimble::host {

struct SceneIssue {
  std::string name;
  std::string cause;  // with file, line and pointer
  std::string remedy;
  std::string pointer;  // to the value, or to what lacks one
  TextPlace place;
};

// As an Error it is the first one: that which a reader meets first. The others follow by their places in the file.
class SceneErrors : public Error {
 public:
  static constexpr std::size_t kMost = 20;

  SceneErrors(ExitCode exit_code, std::vector<SceneIssue> found);

  std::vector<SceneIssue> issues;  // at most kMost
  std::size_t more = 0;            // that were found beyond these
};

// A file with comments as JSON; `what`: "the scene". Its error says that comments are allowed, which the reader of JSON alone does not know.
[[nodiscard]] board::JsonDocument parse_commented(const std::string& text, const std::string& name,
                                                  const std::string& what);

// Collects them for the text of a file. `name` is the file's in messages.
class SceneIssues {
 public:
  SceneIssues(const std::string& text, std::string name) : text_(text), name_(std::move(name)) {}

  struct Full {};
  static constexpr std::size_t kMost = 200;  // so that a text of errors takes no longer than another

  // Throws Full instead of adding one to kMost. An error that the collection has already, or about a value that has one of this name, is left out. `pointer`: where it belongs if its
  // cause names no place in the file.
  void add(const Error& error, const std::string& pointer = "");
  [[nodiscard]] bool empty() const { return issues_.empty(); }
  [[noreturn]] void raise();

 private:
  // Of the value that the cause names after the file and its line; otherwise `pointer`.
  [[nodiscard]] std::string pointer_in(const std::string& cause, const std::string& pointer) const;
  [[nodiscard]] TextPlace place_of(const SceneIssue& issue) const;

  const std::string& text_;
  std::string name_;
  ValueRanges values_;  // of text that is JSON
  ExitCode code_ = ExitCode::kBadInput;
  std::vector<SceneIssue> issues_;
};

}  // namespace thimble::host

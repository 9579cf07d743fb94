#include "board/files/json_document.h"

#include <algorithm>
#include <utility>
#include <vector>

namespace thimble::board {
namespace {

constexpr std::size_t kMaxNesting = 32;
// Of a JSON pointer. Every value has its own, so without a limit memory grows with the square of the file.
constexpr std::size_t kMaxPointerBytes = 256;

std::size_t line_at(const std::string& text, std::size_t offset) {
  std::size_t line = 1;
  for (std::size_t i = 0; i < std::min(offset, text.size()); ++i) {
    line += text[i] == '\n' ? 1U : 0U;
  }
  return line;
}

// nlohmann's "[json.exception.parse_error.101] parse error at line 3, column 2: syntax error ..." without its
// prefix.
std::string reason(const std::string& what) {
  const std::size_t colon = what.find(": ");
  return what.find("parse error at") == std::string::npos || colon == std::string::npos
             ? what.substr(std::min(what.size(), what.find("] ") + 2))
             : what.substr(colon + 2);
}

}  // namespace

std::string pointer_step(const std::string& key) {
  std::string step;
  for (const char c : key) {
    step += c == '~' ? "~0" : c == '/' ? "~1" : std::string(1, c);
  }
  return step;
}

JsonDocument::JsonDocument(const std::string& text, std::string name, std::string root)
    : name_(std::move(name)), root_name_(std::move(root)) {
  constexpr const char* kRemedy =
      "correct the file: it has to be JSON in UTF-8, without comments or trailing commas";
  // nlohmann's parser takes a NUL byte for the end of the text, and passes over what follows.
  if (const std::size_t nul = text.find('\0'); nul != std::string::npos)
    throw JsonError("bad-json", name_ + ":" + std::to_string(line_at(text, nul)) + ": a NUL byte", kRemedy);
  std::size_t depth = 0;
  bool in_string = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (in_string) {
      in_string = text[i] != '"';
      i += text[i] == '\\' ? 1U : 0U;
    } else if (text[i] == '"') {
      in_string = true;
    } else if (text[i] == '{' || text[i] == '[') {
      if (++depth > kMaxNesting) {
        throw JsonError("bad-json",
                        name_ + ":" + std::to_string(line_at(text, i)) + ": nested deeper than " +
                            std::to_string(kMaxNesting),
                        kRemedy);
      }
    } else if ((text[i] == '}' || text[i] == ']') && depth > 0) {
      --depth;
    }
  }
  try {
    root_ = nlohmann::json::parse(text);
  } catch (const nlohmann::json::parse_error& error) {
    throw JsonError("bad-json",
                    name_ + ":" + std::to_string(line_at(text, error.byte > 0 ? error.byte - 1 : 0)) + ": " +
                        reason(error.what()),
                    kRemedy);
  } catch (
      const nlohmann::json::exception& error) {  // "number overflow parsing '1e999'" comes without a place
    const std::string why = reason(error.what());
    const std::size_t quote = why.find('\'');
    const std::string token = why.substr(std::min(quote, why.size() - 1) + 1, why.rfind('\'') - quote - 1);
    throw JsonError("bad-json", name_ + ":" + std::to_string(line_at(text, text.find(token))) + ": " + why,
                    kRemedy);
  }
  find_lines(text);
}

// Walks through text that has been parsed as JSON already, and notes the line of every value.
void JsonDocument::find_lines(const std::string& text) {
  struct Level {
    std::string pointer;
    bool is_object;
    std::size_t index;  // of the element that comes next in an array
  };
  std::vector<Level> levels;
  std::string pointer;  // of the value that comes next
  std::size_t line = 1;
  bool key_next = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (c == '\n') {
      ++line;
    }
    if (c == ' ' || c == '\t' || c == '\r' || c == '\n' || c == ':' ||
        (static_cast<unsigned char>(c) >= 0x80)) {
      continue;  // the last: a byte order mark
    }
    if (c == ',') {
      if (levels.back().is_object) {
        key_next = true;
      } else {
        pointer = levels.back().pointer + "/" + std::to_string(++levels.back().index);
      }
      continue;
    }
    if (c == '}' || c == ']') {
      levels.pop_back();
      key_next = false;
      continue;
    }
    const std::size_t begin = i;
    if (c == '"') {
      for (++i; text[i] != '"'; ++i) {
        i += text[i] == '\\' ? 1U : 0U;
      }
      if (key_next) {
        const auto key = nlohmann::json::parse(text.substr(begin, i + 1 - begin)).get<std::string>();
        pointer = levels.back().pointer + "/" + pointer_step(key);
        key_next = false;
        if (pointer.size() > kMaxPointerBytes)
          throw JsonError("bad-json",
                          name_ + ":" + std::to_string(line) + ": the key and those around it have " +
                              std::to_string(pointer.size()) + " bytes, at most " +
                              std::to_string(kMaxPointerBytes) + " are allowed",
                          "shorten the key");
        if (const auto first = line_of_.find(pointer); first != line_of_.end()) {
          throw JsonError("duplicate-key",
                          name_ + ":" + std::to_string(line) + ": " + pointer +
                              " is given twice (first in line " + std::to_string(first->second) + ")",
                          "remove one of them");
        }
        line_of_[pointer] = line;
        continue;
      }
    }
    line_of_.try_emplace(pointer, line);
    if (c == '{' || c == '[') {
      levels.push_back({pointer, c == '{', 0});
      key_next = c == '{';
      if (c == '[') {
        pointer += "/0";
      }
    } else if (c != '"') {
      i = std::min(text.find_first_of(",]} \t\r\n", i), text.size()) - 1;  // a number or a word
    }
  }
}

std::string JsonDocument::place(const std::string& pointer) const {
  std::string known = pointer;
  auto found = line_of_.find(known);
  while (found == line_of_.end() && !known.empty()) {
    known.resize(known.rfind('/'));
    found = line_of_.find(known);
  }
  const std::size_t line = found == line_of_.end() ? 1 : found->second;
  return name_ + ":" + std::to_string(line) + ": " + (pointer.empty() ? root_name_ : pointer);
}

}  // namespace thimble::board

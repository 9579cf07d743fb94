#include "host-tools/compiler/scene_text.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "host-tools/compiler/scene_value.h"
#include "host-tools/error.h"

namespace thimble::host {
namespace {

constexpr std::string_view kBlanks = " \t\r\n";

// The end of the string that begins at `at`: behind its closing quote.
std::size_t string_end(std::string_view text, std::size_t at) {
  for (++at; at < text.size() && text[at] != '"'; ++at) at += text[at] == '\\' ? 1U : 0U;
  return std::min(at + 1, text.size());
}

class Walk {
 public:
  explicit Walk(std::string_view plain) : plain_(plain) {}

  ValueRanges find() {
    value("", std::nullopt);
    return std::move(found_);
  }

 private:
  // Over blanks and a byte order mark.
  void skip() {
    while (at_ < plain_.size() && (kBlanks.find(plain_[at_]) != std::string_view::npos ||
                                   static_cast<unsigned char>(plain_[at_]) >= 0x80U))
      ++at_;
  }
  [[nodiscard]] bool is_at(char c) const { return at_ < plain_.size() && plain_[at_] == c; }

  // Values below a pointer that JsonDocument would refuse as too long are not noted: all those pointers would take too much memory.
  static constexpr std::size_t kMostPointerBytes = 256;
  [[nodiscard]] static std::string below(const std::string& pointer, const std::string& step) {
    return pointer.size() > kMostPointerBytes ? pointer.substr(0, kMostPointerBytes + 1)
                                              : pointer + "/" + step;
  }

  // Nested at most as deep as board::JsonDocument allows.
  void value(const std::string& pointer, std::optional<std::size_t> key) {
    skip();
    const std::size_t begin = at_;
    if (is_at('{') || is_at('[')) {
      members(pointer, plain_[at_] == '{');
    } else if (is_at('"')) {
      at_ = string_end(plain_, at_);
    } else {
      at_ = std::min(plain_.find_first_of(",]} \t\r\n", at_), plain_.size());
    }
    if (pointer.size() <= kMostPointerBytes) found_[pointer] = {key.value_or(begin), begin, at_};
  }

  void members(const std::string& pointer, bool is_object) {
    ++at_;
    for (std::size_t index = 0; at_ < plain_.size();) {
      skip();
      if (is_at(',')) {
        ++at_;
      } else if (is_at('}') || is_at(']')) {
        ++at_;
        return;
      } else if (is_object) {
        const std::size_t key = at_;
        at_ = string_end(plain_, at_);
        const auto name = nlohmann::json::parse(plain_.substr(key, at_ - key)).get<std::string>();
        skip();
        ++at_;  // the colon
        value(below(pointer, board::pointer_step(name)), key);
      } else {
        value(below(pointer, std::to_string(index++)), std::nullopt);
      }
    }
  }

  std::string_view plain_;
  std::size_t at_ = 0;
  ValueRanges found_;
};

std::string as_people_write(double value) {
  std::string text = number(value);
  if (text.ends_with(".0")) text.resize(text.size() - 2);
  return text;
}

// In one line.
std::string folded(std::string_view plain) {
  std::string line;
  while (!plain.empty()) {
    const bool is_blank = kBlanks.find(plain[0]) != std::string_view::npos;
    const std::size_t end = plain[0] == '"' ? string_end(plain, 0)
                            : is_blank      ? std::min(plain.find_first_not_of(kBlanks), plain.size())
                                            : 1;
    line.append(is_blank ? " " : plain.substr(0, end));
    plain.remove_prefix(end);
  }
  return line;
}

// The last member of an object that has one.
const ValueRange& last_member(const ValueRanges& values, const std::string& pointer) {
  const ValueRange* last = nullptr;
  for (auto each = values.upper_bound(pointer + "/");
       each != values.end() && each->first.starts_with(pointer + "/"); ++each) {
    const bool is_member = each->first.find('/', pointer.size() + 1) == std::string::npos;
    if (is_member && (last == nullptr || each->second.end > last->end)) last = &each->second;
  }
  return *last;
}

// Between a member and what is before it: one line's end and the indentation, or the blanks in a line.
std::string gap_before(const std::string& text, const ValueRange& member) {
  const std::size_t begin = text.find_last_not_of(kBlanks, member.key - 1) + 1;
  std::string gap = text.substr(begin, member.key - begin);
  const std::size_t line = gap.rfind('\n');
  if (line == std::string::npos) return text[begin - 1] == '{' ? " " : gap;
  return gap.substr(line > 0 && gap[line - 1] == '\r' ? line - 1 : line);
}

// What the text would mean without the key.
bool is_default(const std::string& key, double value) {
  const std::vector<double>& usual = key_of(scene_kind("material"), key).default_numbers;
  return !usual.empty() && usual.front() == value;
}

}  // namespace

std::string without_comments(std::string text) {
  for (std::size_t at = 0; at < text.size();) {
    if (text[at] == '"') {
      at = string_end(text, at);
      continue;
    }
    const std::string_view two = std::string_view(text).substr(at, 2);
    std::size_t end = at;
    if (two == "//") end = std::min(text.find_first_of("\r\n", at), text.size());
    if (two == "/*") {
      end = text.find("*/", at + 2);
      if (end == std::string::npos) return text;
      end += 2;
    }
    for (std::size_t i = at; i < end; ++i)
      if (kBlanks.find(text[i]) == std::string_view::npos) text[i] = ' ';
    at = std::max(end, at + 1);
  }
  return text;
}

TextPlace place_at(std::string_view text, std::size_t offset) {
  const std::string_view before = text.substr(0, offset);
  const std::size_t line = before.rfind('\n') + 1;  // npos + 1 is 0
  const auto is_begin = [](char c) { return (static_cast<unsigned char>(c) & 0xC0U) != 0x80U; };
  return {1 + static_cast<std::size_t>(std::ranges::count(before, '\n')),
          1 + static_cast<std::size_t>(std::ranges::count_if(before.substr(line), is_begin))};
}

ValueRanges find_values(std::string_view plain) { return Walk(plain).find(); }

std::string with_material(const std::string& text, std::size_t object, const std::string& key, double value) {
  std::string material = "/objects/" + std::to_string(object) + "/material";
  const std::string plain = without_comments(text);
  const ValueRanges values = find_values(plain);
  if (!values.contains(material))
    throw Error(ExitCode::kBadInput, "no-material", "object " + std::to_string(object) + " has no material",
                "give it one in the scene file: a force field needs none");
  const ValueRange& given = values.at(material);
  const auto raw = [&](const ValueRange& at) {
    return std::string_view(plain).substr(at.begin, at.end - at.begin);
  };
  const ValueRange* shared = nullptr;
  if (plain[given.begin] == '"') {
    const nlohmann::json name = nlohmann::json::parse(raw(given));
    material = "/materials/" + board::pointer_step(name.get<std::string>());
    std::size_t users = 0;
    for (std::size_t i = 0; values.contains("/objects/" + std::to_string(i)); ++i) {
      const auto other = values.find("/objects/" + std::to_string(i) + "/material");
      if (other == values.end()) continue;
      if (plain[other->second.begin] == '"' && nlohmann::json::parse(raw(other->second)) == name) ++users;
    }
    if (users > 1) shared = &values.at(material);
  }
  const auto found = values.find(material + "/" + key);
  if (found == values.end() ? is_default(key, value)
                            : nlohmann::json::parse(raw(found->second)) == nlohmann::json(value))
    return text;
  if (shared != nullptr) {
    std::string own = text;
    own.replace(given.begin, given.end - given.begin, folded(raw(*shared)));
    return with_material(own, object, key, value);
  }
  std::string changed = text;
  if (found != values.end())
    return changed.replace(found->second.begin, found->second.end - found->second.begin,
                           as_people_write(value));
  const ValueRange& last = last_member(values, material);
  std::string member(",");
  member.append(gap_before(text, last))
      .append(1, '"')
      .append(key)
      .append("\": ")
      .append(as_people_write(value));
  return changed.insert(last.end, member);
}

}  // namespace thimble::host

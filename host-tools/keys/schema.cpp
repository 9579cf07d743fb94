#include "host-tools/keys/schema.h"

#include <cmath>
#include <cstdint>
#include <nlohmann/json.hpp>

namespace thimble::host {
namespace {

using Json = nlohmann::ordered_json;

// 10 rather than 10.0.
Json json_number(double value) {
  if (std::trunc(value) == value && std::abs(value) < 1.0e15) return static_cast<std::int64_t>(value);
  return value;
}

Json number_schema(const Range& range) {
  Json schema = {{"type", "number"}};
  schema[range.least_excluded ? "exclusiveMinimum" : "minimum"] = json_number(range.least);
  schema["maximum"] = json_number(range.most);
  return schema;
}

Json array_schema(const Json& items, double least, double most) {
  Json schema = {{"type", "array"}, {"minItems", json_number(least)}};
  if (most > 0) schema["maxItems"] = json_number(most);
  schema["items"] = items;
  return schema;
}

Json text_schema(const Range& length) {
  return {
      {"type", "string"}, {"minLength", json_number(length.least)}, {"maxLength", json_number(length.most)}};
}

Json kind_ref(std::string_view kind) { return {{"$ref", "#/$defs/" + std::string(kind)}}; }

Json quantity_schema(const Range& range) {
  return {{"type", "object"},
          {"required", Json::array({"value"})},
          {"additionalProperties", false},
          {"properties",
           {{"value", number_schema(range)},
            {"spread", {{"type", "number"}, {"minimum", 0}}},
            {"by", text_schema({1, 200})}}}};
}

Json rows_schema(const Range& range) { return array_schema(array_schema(number_schema(range), 2, 0), 2, 0); }

Json curve_schema(const KeyValue& curve) {
  const Json point = {
      {"type", "array"},
      {"prefixItems", {number_schema(curve.range), number_schema({-curve.most_effort, curve.most_effort})}},
      {"minItems", 2},
      {"maxItems", 2}};
  return array_schema(point, curve.count.least, curve.count.most);
}

Json type_schema(const FileKey& key) {
  constexpr Range kPath{1, 4096};
  switch (key.type) {
    case KeyType::kVersion:
      return {{"const", 1}};
    case KeyType::kNumber:
      return number_schema(key.range);
    case KeyType::kNumbers:
      return array_schema(number_schema(key.range), key.count.least, key.count.most);
    case KeyType::kQuantity:
      return {{"oneOf", Json::array({number_schema(key.range), quantity_schema(key.range)})}};
    case KeyType::kPair:
      return array_schema(number_schema(key.range), 2, 2);
    case KeyType::kVector:
    case KeyType::kDirection:
      return array_schema(number_schema(key.range), 3, 3);
    case KeyType::kText:
      return text_schema(key.range);
    case KeyType::kWord:
      return {{"enum", key.words}};
    case KeyType::kFlag:
      return {{"type", "boolean"}};
    case KeyType::kPart: {
      if (key.words.size() == 1) return kind_ref(key.words.front());
      Json parts = Json::array();
      for (const std::string_view kind : key.words) parts.push_back(kind_ref(kind));
      return {{"oneOf", parts}};
    }
    case KeyType::kList:
      return array_schema(kind_ref(key.words.front()), key.range.least, key.range.most);
    case KeyType::kNamedParts:
      return {{"type", "object"}, {"additionalProperties", kind_ref(key.words.front())}};
    case KeyType::kPartOrName:
      return {
          {"oneOf", Json::array({Json{{"type", "string"}, {"minLength", 1}}, kind_ref(key.words.front())})}};
    case KeyType::kRows:
      return rows_schema(key.range);
    case KeyType::kRowsOrFile:
      return {{"oneOf", Json::array({rows_schema(key.range), text_schema(kPath)})}};
    case KeyType::kCurve:
      return curve_schema(key);
  }
  return {};
}

Json key_schema(const FileKey& key) {
  Json schema = type_schema(key);
  std::string text(key.text);
  if (*key.range.unit != '\0') text += (text.empty() ? "In " : " In ") + std::string(key.range.unit) + ".";
  if (!text.empty()) schema["description"] = text;
  if (!key.default_word.empty()) schema["default"] = key.default_word;
  if (key.default_numbers.size() == 1)
    schema["default"] =
        key.type == KeyType::kFlag ? Json(key.default_numbers[0] != 0) : json_number(key.default_numbers[0]);
  if (key.default_numbers.size() > 1) {
    schema["default"] = Json::array();
    for (const double value : key.default_numbers) schema["default"].push_back(json_number(value));
  }
  return schema;
}

Json kind_schema(const FileKind& kind) {
  Json schema = {{"type", "object"}};
  if (!kind.text.empty()) schema["description"] = kind.text;
  Json required = Json::array();
  for (const FileKey& key : kind.keys)
    if (key.required) required.push_back(key.name);
  if (!required.empty()) schema["required"] = required;
  if (kind.exactly_one) {
    schema["minProperties"] = 1;
    schema["maxProperties"] = 1;
  }
  schema["additionalProperties"] = false;
  schema["properties"] = Json::object();
  for (const FileKey& key : kind.keys) schema["properties"][std::string(key.name)] = key_schema(key);
  return schema;
}

// On one line where it fits.
void print(const Json& tree, std::size_t indent, std::size_t used, std::string& out) {
  constexpr std::size_t kWidth = 140;
  const std::string flat = tree.dump(-1, ' ', false);
  if (!tree.is_structured() || tree.empty() || used + flat.size() + flat.size() / 12 <= kWidth) {
    bool in_string = false;
    for (std::size_t i = 0; i < flat.size(); ++i) {  // "a":1,"b":2 with a blank behind ':' and ','
      out += flat[i];
      if (flat[i] == '"' && (i == 0 || flat[i - 1] != '\\')) in_string = !in_string;
      if (!in_string && (flat[i] == ',' || flat[i] == ':')) out += ' ';
    }
    return;
  }
  out += tree.is_object() ? '{' : '[';
  const std::string lead(indent + 2, ' ');
  bool first = true;
  for (const auto& [key, value] : tree.items()) {
    out += (first ? "\n" : ",\n") + lead;
    const std::string label = tree.is_object() ? "\"" + key + "\": " : "";
    out += label;
    print(value, indent + 2, indent + 2 + label.size(), out);
    first = false;
  }
  out += "\n" + std::string(indent, ' ') + (tree.is_object() ? '}' : ']');
}

}  // namespace

std::string schema_text(const std::string& title, const std::string& comment, const std::string& root,
                        const KeyTable& table) {
  Json schema = {
      {"$schema", "https://json-schema.org/draft/2020-12/schema"}, {"title", title}, {"$comment", comment}};
  schema.update(kind_ref(root));
  schema["$defs"] = Json::object();
  for (const FileKind& kind : table) schema["$defs"][std::string(kind.name)] = kind_schema(kind);
  std::string text;
  print(schema, 0, 0, text);
  return text + "\n";
}

}  // namespace thimble::host

// param list, get, set and save.
#include <fmt/format.h>

#include <charconv>
#include <cmath>

#include "firmware/params.h"
#include "host-tools/cli/open_remote.h"
#include "host-tools/cli/output.h"
#include "host-tools/cli/verbs.h"
#include "host-tools/client/device.h"

namespace thimble::host {
namespace {

using firmware::kParamTable;
using firmware::ParamRow;
using firmware::ParamType;

const ParamRow& param_named(const std::string& name) {
  const ParamRow* row = firmware::find_param(std::string_view(name));
  if (row == nullptr) {
    throw Error(ExitCode::kUsage, "unknown-parameter", "there is no parameter '" + name + "'",
                "`thimble param list` names them");
  }
  return *row;
}

const char* access_name(const ParamRow& row) {
  return row.access == firmware::Access::kAlways ? "always" : "at rest";
}

Json to_json(const ParamRow& row, double value) {
  Json json;
  json["name"] = row.name;
  json["value"] = row.type == ParamType::kUnsigned ? Json(static_cast<std::uint64_t>(value))
                                                   : Json(tidy(static_cast<float>(value)));
  json["unit"] = row.unit;
  json["default"] = tidy(row.initial);
  json["min"] = tidy(row.min);
  json["max"] = tidy(row.max);
  json["writable"] = access_name(row);
  json["text"] = row.text;
  return json;
}

std::string shown(const ParamRow& row, double value) {
  return row.type == ParamType::kUnsigned ? fmt::format("{}", static_cast<std::uint64_t>(value))
                                          : fmt::format("{}", static_cast<float>(value));
}

}  // namespace

void param_list(const Common& common, const Remote& remote) {
  Device device = open_device(common, remote);
  Json json = document("param");
  json["params"] = Json::array();
  for (const ParamRow& row : kParamTable) {
    const double value = device.read_param(row);
    if (common.json) {
      json["params"].push_back(to_json(row, value));
    } else {
      say("{:<22} {:>10} {:<6} {} to {}, {}: {}\n", row.name, shown(row, value), row.unit, row.min, row.max,
          access_name(row), row.text);
    }
  }
  if (common.json) print(json);
}

void param_get(const Common& common, const Remote& remote, const std::string& name) {
  const ParamRow& row = param_named(name);
  const double value = open_device(common, remote).read_param(row);
  if (common.json) {
    Json json = document("param");
    json.update(to_json(row, value));
    print(json);
  } else {
    say("{}\n", shown(row, value));
  }
}

void param_set(const Common& common, const Remote& remote, const std::string& name,
               const std::string& value) {
  const ParamRow& row = param_named(name);
  double number = 0;
  const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), number);
  const bool whole = row.type == ParamType::kFloat || std::trunc(number) == number;
  if (error != std::errc() || end != value.data() + value.size() || !whole ||
      !(number >= static_cast<double>(row.min)) || !(number <= static_cast<double>(row.max))) {
    throw Error(
        ExitCode::kUsage, "bad-value",
        fmt::format("'{}' is not a value of {}: a {} from {} to {} {}", value, name,
                    row.type == ParamType::kFloat ? "number" : "whole number", row.min, row.max, row.unit),
        "choose a value in that range");
  }
  Device device = open_device(common, remote);
  device.write_param(row, number);
  const double now = device.read_param(row);
  if (common.json) {
    Json json = document("param");
    json.update(to_json(row, now));
    print(json);
  } else {
    say("{}\n", shown(row, now));
  }
}

void param_save(const Common& common, const Remote& remote) {
  Device device = open_device(common, remote);
  device.save_params();
  if (common.json) {
    Json json = document("param");
    json["saved"] = true;
    print(json);
  } else {
    say("saved\n");
  }
}

}  // namespace thimble::host

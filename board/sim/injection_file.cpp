#include "board/sim/injection_file.h"

#include <algorithm>
#include <array>
#include <string>

#include "board/files/json_value.h"
#include "board/files/text_file.h"

namespace thimble::board {
namespace {

constexpr Range kInjectedTime{0, 1e6, "s"};
constexpr Range kAnyValue{-1e9, 1e9};
constexpr Range kPush{-100, 100, "N"};
constexpr std::size_t kMostFaults = 1000;
constexpr std::array<std::string_view, 3> kInjectedTimes = {"start", "armed",
                                                            "contact"};  // in the order of InjectionTime

PlannedFault read_fault(const JsonValue& value, std::size_t axes) {
  value.object("a fault", {"fault", "arm", "joint", "value", "force_N", "at_s", "for_s", "after"});
  std::vector<std::string_view> names;
  for (const InjectionRow& row : injections()) names.push_back(row.name);
  const InjectionRow& row = injections()[value.at("fault").word(names)];
  PlannedFault fault{.kind = row.kind};
  if (value.has("arm")) fault.arm = static_cast<std::size_t>(value.at("arm").integer(0, 1));
  if (row.of == InjectionOf::kJoint && value.has("joint"))
    fault.joint = static_cast<std::size_t>(value.at("joint").integer(0, static_cast<int>(axes) - 1));
  if (!row.unit.empty()) fault.value = value.at("value").number(kAnyValue);
  if (row.kind == Injection::kHandPushes) fault.force_N = value.at("force_N").vector(kPush);
  fault.at_s = value.number_or("at_s", kInjectedTime, 0);
  if (value.has("for_s")) fault.for_s = value.at("for_s").number(kInjectedTime);
  if (value.has("after")) fault.from = static_cast<InjectionTime>(value.at("after").word(kInjectedTimes));
  return fault;
}

std::vector<PlannedFault> read_all(const JsonValue& root, std::size_t axes) {
  root.object("a file of faults", {"thimble_faults", "description", "faults"});
  (void)root.at("thimble_faults").integer(1, 1);
  const JsonValue list = root.at("faults");
  std::vector<PlannedFault> faults;
  for (std::size_t i = 0; i < list.size(0, kMostFaults); ++i) faults.push_back(read_fault(list.at(i), axes));
  return faults;
}

}  // namespace

std::vector<PlannedFault> read_injections(const std::filesystem::path& file, std::size_t axes) {
  try {
    const JsonDocument document(read_text(file), file.string(), "the file of faults");
    return read_all(JsonValue(document), axes);
  } catch (const FileError& error) {
    throw InjectionError(error.what());
  } catch (const JsonError& error) {
    throw InjectionError(error.what());
  }
}

}  // namespace thimble::board

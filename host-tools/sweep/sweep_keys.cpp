#include "host-tools/sweep/sweep_keys.h"

#include "host-tools/keys/key_values.h"
#include "host-tools/sweep/measures.h"

namespace thimble::host {
namespace keys {
namespace {

constexpr std::size_t kWhat = 256;  // bytes of a pointer
constexpr std::size_t kMostValues = 100'000;

KeyTable make_kinds() {
  KeyTable kinds;
  const auto add = [&kinds](std::string_view name, const char* what) -> FileKind& {
    return kinds.emplace_back(FileKind{name, what});
  };
  add("sweep", "a sweep plan")
      .required("thimble_sweep", version(), "Version of the format.")
      .required("name", text(64), "For people, and the title of the table.")
      .optional("description", text(4096), "For people, and below the title of the table.")
      .optional("scene", text(4096), "The scene file that is simulated. Paths are relative to the plan.")
      .optional("path", text(4096), "The hand's path in that scene (CSV), as `thimble simulate` takes it.")
      .optional("wall", flag().by_default(0), "Instead of scene and path: a hand presses a wall.")
      .optional("ideal", flag().by_default(0), "As `--ideal` of `thimble simulate`.")
      .optional("steady_s", number(above(0, 1e6, "s")),
                "The last seconds of the path, in which the hand rests: there the tip's swing is measured.")
      .optional("swing_along", direction(),
                "Swings are measured along this direction; without it along x, y and z.")
      .optional("still_m", number(above(0, 1, "m")).by_default(kTwoCounts_m),
                "A run is stable if the tip swings by no more.")
      .optional("set", KeyValue{KeyType::kNamedParts, {}, {"number", "text", "hand"}},
                "Values that all runs share, by name.")
      .required("vary", list("axis", 1, 8), "Every combination is a run; the last axis varies fastest.")
      .optional("largest_stable", part("search"), "A run is a search for the largest stable value.")
      .optional("table", part("table"), "What `--table` writes.");
  add("axis", "an axis")
      .required("what", text(kWhat), "Name of the value, or its JSON pointer in the scene file.")
      .optional("values", KeyValue{KeyType::kList, from(1, kMostValues), {"number", "text", "hand"}},
                "One by one.")
      .optional("from", number(from(-1e12, 1e12)), "Instead of values: the first of a series of numbers.")
      .optional("to", number(from(-1e12, 1e12)), "The last.")
      .optional("count", number(from(2, kMostValues)), "How many.")
      .optional("spacing", one_of({"step", "ratio"}).by_default("step"),
                "What is the same between neighbours.")
      .optional("label", text(64), "Of the axis in the table.")
      .optional("unit", text(32), "Behind the values in the table.");
  add("hand", "a hand")
      .optional("name", text(64), "In the results and the table.")
      .optional("mass_kg", number(from(0, 10, "kg")).by_default(board::Hand{}.mass_kg),
                "It moves with the tip.")
      .optional("stiffness_N_m", number(above(0, 1e6, "N/m")).by_default(board::Hand{}.stiffness_N_m),
                "Of the spring that pulls it to the path.")
      .optional("damping_N_s_m", number(from(0, 1e4, "N s/m")).by_default(board::Hand{}.damping_N_s_m),
                "Of the damper beside the spring.");
  add("search", "a search")
      .required("what", text(kWhat), "A number: a name or a pointer as in an axis.")
      .required("from", number(above(0, 1e12)), "The first value.")
      .required("to", number(above(0, 1e12)), "The last.")
      .required("ratio", number(above(1, 100)), "Of a value to the one before it.");
  add("table", "a table")
      .required("rows", text(kWhat), "The axis of the rows.")
      .required("columns", text(kWhat),
                "The axis of the columns. A combination of the others has a table of its own.")
      .required("value", text(32), "A column of the results.")
      .optional("digits", number(from(1, 9)).by_default(3), "Further digits are cut off.");
  return kinds;
}

}  // namespace
}  // namespace keys

const KeyTable& sweep_kinds() {
  static const KeyTable kinds = keys::make_kinds();
  return kinds;
}

const FileKind& sweep_kind(std::string_view name) { return kind_of(sweep_kinds(), name); }

}  // namespace thimble::host

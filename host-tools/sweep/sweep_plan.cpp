#include "host-tools/sweep/sweep_plan.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <span>
#include <utility>

#include "board/sim/hand_path_file.h"
#include "firmware/link/crc32.h"
#include "host-tools/arms/arm_folder.h"
#include "host-tools/compiler/scene_errors.h"
#include "host-tools/files/input_file.h"
#include "host-tools/keys/check.h"
#include "host-tools/sweep/measures.h"
#include "host-tools/sweep/sweep_keys.h"

namespace thimble::host {
namespace {

using board::JsonError;

constexpr std::string_view kLargest = "largest_stable";
// Of a longer series about so many values are compiled before the first run, evenly spread. Meshes and fields that do not change are not
// computed again; where they do change, each run computes them too, so that the check costs less than the sweep.
constexpr std::size_t kMostProbes = 1000;

bool needs_steady_part(std::string_view column) {
  return column == kStable || std::ranges::any_of(measure_columns(), [&](const MeasureColumn& each) {
           return each.name == column && each.is_steady;
         });
}

// Reads what it can, and collects what is wrong on the way.
class PlanReader {
 public:
  PlanReader(const std::filesystem::path& file, const Value& root, SceneIssues& issues)
      : file_(file), root_(root), issues_(issues) {}

  SweepPlan read(const std::string& text) {
    const FilePart part(root_, sweep_kind("sweep"));
    attempt([&] { plan_.name = part.text("name"); });
    attempt([&] { plan_.description = part.has("description") ? part.text("description") : ""; });
    attempt([&] { plan_.ideal = part.flag("ideal"); });
    attempt([&] { plan_.still_m = part.number("still_m"); });
    attempt([&] {
      if (part.has("swing_along")) plan_.along = part.direction("swing_along");
    });
    bool wall = false;
    attempt([&] { wall = part.flag("wall"); });
    attempt([&] { read_scene(part, wall); });
    add(text);
    // Another version may give other figures.
    add(THIMBLE_VERSION);
    if (!wall && plan_.scene == nullptr) return std::move(plan_);  // what could values be checked with?
    const SweepValues values(plan_.scene.get());
    attempt([&] { read_settings(values, part); });
    attempt([&] { read_axes(values, part); });
    if (part.has(kLargest))
      attempt([&] { read_search(values, FilePart(part.at(kLargest), sweep_kind("search"))); });
    if (part.has("table")) attempt([&] { read_table(FilePart(part.at("table"), sweep_kind("table"))); });
    plan_.crc = crc_;
    return std::move(plan_);
  }
  // Of the scene file.
  [[nodiscard]] const std::optional<SceneErrors>& scene_errors() const { return scene_errors_; }

 private:
  template <typename Read>
  void attempt(Read&& read) {
    try {
      read();
    } catch (const JsonError& error) {
      issues_.add(to_error(error));
    } catch (const SceneErrors& errors) {
      scene_errors_ = errors;
    } catch (const Error& error) {
      issues_.add(error);
    }
  }
  // Files beside the plan.
  [[nodiscard]] std::filesystem::path beside(const std::string& path) const {
    return file_.parent_path() / path;
  }
  void add(const std::string& text) {
    crc_ = firmware::link::crc32(std::as_bytes(std::span(text)), crc_);
    crc_ = firmware::link::crc32(std::as_bytes(std::span("", 1)), crc_);
  }

  void add_files(const std::vector<std::filesystem::path>& files) {
    for (const std::filesystem::path& file : files) {
      if (std::ranges::find(plan_.files, file) != plan_.files.end()) continue;
      add(read_input(file));
      plan_.files.push_back(file);
    }
  }

  void read_scene(const FilePart& part, bool wall) {
    for (const char* key : {"scene", "path", "steady_s", "ideal", "swing_along"})
      if (wall && part.has(key))
        part.at(key).fail("bad-value", "has no place in a plan of a wall",
                          "leave it out, or leave out \"wall\"");
    if (wall) return;
    if (!part.has("scene"))
      root_.fail("missing-key", "has neither \"scene\" nor \"wall\"",
                 "give the scene file and the path of the hand, or \"wall\": true");
    const std::filesystem::path path = beside(part.text("path"));
    const std::string rows = read_input(path);
    try {
      plan_.path = board::read_hand_path(path);
    } catch (const board::HandPathError& error) {
      throw Error(ExitCode::kBadInput, "bad-path", error.what(),
                  "correct the path file: time_s,x_m,y_m,z_m[,arm]");
    }
    add(rows);
    plan_.files = {path, beside(part.text("scene"))};
    plan_.scene = std::make_shared<const SweepScene>(beside(part.text("scene")));
    add(plan_.scene->text());
    add_files(plan_.scene->files());
    if (!part.has("steady_s")) return;
    plan_.steady_s = part.number("steady_s");
    const auto [first, last] = std::ranges::minmax(plan_.path, {}, &board::PathPoint::time_s);
    if (plan_.steady_s > last.time_s - first.time_s)
      part.at("steady_s").wrong("up to the " + board::number(last.time_s - first.time_s) + " s of the path");
  }

  void read_settings(const SweepValues& values, const FilePart& part) {
    if (!part.has("set")) return;
    const Value all = part.at("set");
    if (!all.raw().is_object()) all.wrong("an object of values by name");
    for (const auto& each : all.raw().items()) attempt([&] { read_setting(values, all, each.key()); });
    // All together: one alone may be good only with another. Refused, they would spoil the probes of the axes.
    const std::map<std::string, std::string> scene = std::exchange(plan_.base.scene, {});
    if (!scene.empty()) compile(scene, "these values", all);
    plan_.base.scene = scene;
  }
  void read_axes(const SweepValues& values, const FilePart& part) {
    const Value axes = part.list("vary", "too-many-axes", "axes", "vary fewer values");
    for (std::size_t i = 0; i < axes.raw().size(); ++i)
      attempt([&] { read_axis(values, FilePart(axes.at(i), sweep_kind("axis"))); });
    if (plan_.runs() > SweepPlan::kMostRuns)
      axes.fail("too-many-runs",
                "makes more than " + std::to_string(SweepPlan::kMostRuns) + " runs, which are the most",
                "vary fewer values");
  }

  void read_setting(const SweepValues& values, const Value& all, const std::string& key) {
    const board::JsonDocument name(nlohmann::json(key).dump(), file_.string(), "the name");
    try {
      static_cast<void>(values.known(Value(name)));
    } catch (const JsonError&) {
      all.at(key).fail("unknown-value", "is no value that a sweep can set", "docs/sweep.md has the names");
    }
    const SweepValue value = values.read(key, all.at(key));
    value.set(plan_.base);
    if (key.starts_with("hand_")) plan_.hand_numbers.push_back(value);
    add_arm(key, value);
  }

  void read_axis(const SweepValues& values, const FilePart& part) {
    SweepAxis axis;
    axis.what = values.known(part.at("what"));
    if (std::ranges::find(plan_.axes, axis.what, &SweepAxis::what) != plan_.axes.end())
      part.at("what").fail("repeated-axis", "is \"" + axis.what + "\", which varies already",
                           "leave one of them out");
    if (part.has("label")) axis.label = part.text("label");
    if (part.has("unit")) axis.unit = part.text("unit");
    if (part.has("values"))
      read_values(values, part, axis);
    else
      read_series(values, part, axis);
    plan_.axes.push_back(std::move(axis));
  }

  void read_values(const SweepValues& values, const FilePart& part, SweepAxis& axis) {
    for (const char* key : {"from", "to", "count"})
      if (part.has(key))
        part.at(key).fail("bad-value", "stands beside \"values\"", "give values, or from, to and count");
    const Value given = part.list("values", "too-many-values", "values", "vary fewer values");
    for (std::size_t i = 0; i < given.raw().size(); ++i) {
      attempt([&] {
        SweepValue value = values.read(axis.what, given.at(i));
        if (std::ranges::find(axis.values, value.text, &SweepValue::text) != axis.values.end())
          given.at(i).fail("repeated-value", "is \"" + value.text + "\" again", "leave one of them out");
        add_arm(axis.what, value);
        probe(value, given.at(i));
        axis.values.push_back(std::move(value));
      });
    }
  }

  void read_series(const SweepValues& values, const FilePart& part, SweepAxis& axis) {
    const double from = part.number("from"), to = part.number("to"), count = part.number("count");
    if (count != std::floor(count)) part.at("count").wrong("a whole number");
    const bool by_ratio = part.word("spacing") == 1;
    if (by_ratio && !(from > 0 && to > 0)) part.at("spacing").wrong("\"step\" where a number is not above 0");
    if (from == to) part.at("to").wrong("another number than \"from\"");
    for (double i = 0; i < count; ++i) {
      const double number = i == 0           ? from
                            : i == count - 1 ? to
                            : by_ratio       ? from * std::pow(to / from, i / (count - 1))
                                             : from + (to - from) * i / (count - 1);
      axis.values.push_back(values.number(axis.what, number, part.value()));
    }
    probe(axis.values, part.value());
  }

  void read_search(const SweepValues& values, const FilePart& part) {
    SweepSearch search;
    search.what = values.known(part.at("what"));
    for (const SweepAxis& axis : plan_.axes)
      if (axis.what == search.what)
        part.at("what").fail("repeated-axis", "is \"" + search.what + "\", which varies already",
                             "search for another value, or do not vary it");
    if (plan_.scene != nullptr && !(plan_.steady_s > 0))
      part.value().fail("no-steady-part", "asks what is stable, and the plan has no \"steady_s\"",
                        "say for how long at the end of its path the hand rests");
    // As floats, which the values of a scene are.
    const auto from = static_cast<float>(part.number("from")), to = static_cast<float>(part.number("to"));
    const auto ratio = static_cast<float>(part.number("ratio"));
    if (to < from) part.at("to").wrong("at least \"from\"");
    for (float number = from; number <= to; number *= ratio) {
      if (search.values.size() == kMostTries)
        part.at("ratio").fail("too-many-values", "makes more than " + std::to_string(kMostTries) + " values",
                              "choose a larger ratio");
      search.values.push_back(values.number(search.what, number, part.value()));
    }
    probe(search.values, part.value());
    plan_.search = std::move(search);
  }

  void read_table(const FilePart& part) {
    SweepTable table;
    const auto axis = [&](const char* key) {
      const std::string what = part.text(key);
      std::vector<std::string_view> names;
      for (const SweepAxis& each : plan_.axes) names.push_back(each.what);
      const auto found = std::ranges::find(names, what);
      if (found == names.end())
        part.at(key).fail("unknown-value",
                          "is \"" + what + "\", which does not vary; " + suggestion(what, names),
                          "name an axis of \"vary\"");
      return static_cast<std::size_t>(found - names.begin());
    };
    table.rows = axis("rows");
    table.columns = axis("columns");
    if (table.rows == table.columns) part.at("columns").wrong("another axis than \"rows\"");
    std::vector<std::string_view> columns;
    if (root_.has(kLargest))
      columns.push_back(kLargest);
    else
      for (const MeasureColumn& column : measure_columns()) columns.push_back(column.name);
    if (!root_.has(kLargest)) columns.push_back(kStable);
    table.value = part.text("value");
    static_cast<void>(part.at("value").word(columns));
    if (plan_.scene != nullptr && !root_.has("steady_s") && needs_steady_part(table.value))
      part.at("value").fail("no-steady-part", "is \"" + table.value + "\", and the plan has no \"steady_s\"",
                            "say for how long at the end of its path the hand rests");
    table.digits = static_cast<int>(part.number("digits"));
    plan_.table = std::move(table);
  }

  // The scene with this value and those of "set": what the compiler refuses is told before the first run.
  void probe(const SweepValue& value, const Value& place) {
    SweepSettings settings = plan_.base;
    value.set(settings);
    if (settings.scene != plan_.base.scene) compile(settings.scene, value.text, place);
  }
  void probe(const std::vector<SweepValue>& series, const Value& place) {
    const std::size_t step = (series.size() + kMostProbes - 1) / kMostProbes;
    for (std::size_t i = 0; i < series.size(); i += step) probe(series[i], place);
    if ((series.size() - 1) % step != 0) probe(series.back(), place);
  }
  // Only to see whether it can be, and with what files.
  void compile(const std::map<std::string, std::string>& values, const std::string& what,
               const Value& place) {
    try {
      add_files(plan_.scene->compile(values).report.files);
    } catch (const Error& error) {
      place.fail(error.name, "makes a scene that is refused, with " + what + ": " + error.cause,
                 error.remedy);
    }
  }
  // An arm file is part of the plan.
  void add_arm(const std::string& what, const SweepValue& value) {
    if (what != "arm") return;
    if (const std::filesystem::path path = arm_path(value.text); std::filesystem::is_regular_file(path))
      add_files({path});
  }

  static constexpr std::size_t kMostTries = 1000;

  std::filesystem::path file_;
  const Value& root_;
  SceneIssues& issues_;
  SweepPlan plan_;
  std::optional<SceneErrors> scene_errors_;
  std::uint32_t crc_ = 0;
};

void erase_unknown(nlohmann::json& object, std::string_view kind) {
  if (!object.is_object()) return;
  const std::vector<std::string_view>& known = sweep_kind(kind).key_names;
  const nlohmann::json all = object;
  for (const auto& each : all.items())
    if (std::ranges::find(known, std::string_view(each.key())) == known.end()) object.erase(each.key());
}

// So that the other values are read all the same.
nlohmann::json without_unknown_keys(nlohmann::json plan) {
  erase_unknown(plan, "sweep");
  for (const auto& [key, kind] : {std::pair(std::string(kLargest), "search"), {"table", "table"}})
    if (plan.contains(key)) erase_unknown(plan[key], kind);
  if (plan.contains("vary") && plan["vary"].is_array())
    for (nlohmann::json& axis : plan["vary"]) erase_unknown(axis, "axis");
  return plan;
}

}  // namespace

std::size_t SweepPlan::runs() const {
  std::size_t runs = 1;
  for (const SweepAxis& axis : axes) {
    runs *= std::max<std::size_t>(axis.values.size(), 1);
    if (runs > 1000 * kMostRuns) return runs;  // it could overflow
  }
  return runs;
}

std::vector<std::size_t> SweepPlan::place(std::size_t run) const {
  std::vector<std::size_t> place(axes.size());
  for (std::size_t i = axes.size(); i-- > 0; run /= axes[i].values.size())
    place[i] = run % axes[i].values.size();
  return place;
}

SweepPlan read_sweep_plan(const std::filesystem::path& file) {
  return read_sweep_plan_text(read_input(file), file);
}

SweepPlan read_sweep_plan_text(const std::string& text, const std::filesystem::path& file) {
  const std::string name = file.string();
  SceneIssues issues(text, name);
  SweepPlan plan;
  try {
    const board::JsonDocument document = parse_commented(text, name, "the plan");
    const Value root(document);
    if (root.raw().is_object() && root.at("thimble_sweep").raw() != 1)
      root.at("thimble_sweep")
          .fail("wrong-version",
                "is " + root.at("thimble_sweep").raw().dump() + ", this program reads version 1",
                "use \"thimble_sweep\": 1, or a newer program");
    check_keys(root, sweep_kind("sweep"), sweep_kinds(),
               [&issues](const JsonError& error) { issues.add(to_error(error)); });
    if (root.raw().is_object()) {
      const nlohmann::json known = without_unknown_keys(root.raw());
      const Value all(document, known, "");
      PlanReader reader(file, all, issues);
      plan = reader.read(text);
      if (issues.empty() && reader.scene_errors()) throw SceneErrors(*reader.scene_errors());
    }
  } catch (const JsonError& error) {
    issues.add(to_error(error));
  } catch (const SceneIssues::Full&) {  // enough to correct
  }
  if (!issues.empty()) issues.raise();
  return plan;
}

}  // namespace thimble::host

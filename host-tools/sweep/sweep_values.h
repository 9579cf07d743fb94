// The values that a sweep may set: by a name (arm, rate_Hz, seed ...), or by a JSON pointer into the text of its scene file.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "host-tools/compiler/compile.h"
#include "host-tools/compiler/scene_text.h"
#include "host-tools/keys/part.h"
#include "host-tools/sweep/wall_press.h"

namespace thimble::host {

// Of one run.
struct SweepSettings {
  WallPress press{.damping_N_s_m = 0, .hold_s = 3};  // of a scene: its arm, rate, hand and seed
  std::uint8_t trial = 0;
  std::map<std::string, std::string> scene;  // values as JSON, by pointer
};

// A scene file whose values can be replaced.
class SweepScene {
 public:
  // SceneErrors: of the file as it is.
  explicit SweepScene(const std::filesystem::path& file);

  [[nodiscard]] bool has(const std::string& pointer) const;  // a number, a text, true or false
  [[nodiscard]] CompiledScene compile(const std::map<std::string, std::string>& values) const;
  [[nodiscard]] const std::string& text() const { return text_; }
  [[nodiscard]] const std::vector<std::filesystem::path>& files() const { return files_; }  // that it names

 private:
  std::filesystem::path file_;
  std::string text_;
  std::string plain_;  // without comments
  ValueRanges ranges_;
  std::vector<std::filesystem::path> files_;
  std::shared_ptr<const CompiledParts> parts_;
};

struct SweepValue {
  std::string text;  // in the results
  std::function<void(SweepSettings&)> set;
};

// scene: null for a wall.
class SweepValues {
 public:
  explicit SweepValues(const SweepScene* scene) : scene_(scene) {}

  // Throws JsonError at `what`, which holds it, if there is no such value.
  [[nodiscard]] std::string known(const Value& what) const;
  // JsonError, or Error of an arm: not a value that `what` may have.
  [[nodiscard]] SweepValue read(const std::string& what, const Value& given) const;
  // A number that is computed; place: what it is computed from.
  [[nodiscard]] SweepValue number(const std::string& what, double number, const Value& place) const;
  [[nodiscard]] SweepValue number(const std::string& what, float number, const Value& place) const;

 private:
  [[nodiscard]] std::vector<std::string_view> names() const;
  [[nodiscard]] SweepValue number(const std::string& what, double number, std::string text,
                                  const Value& place) const;

  const SweepScene* scene_;
};

// The names of values, for people: those of walls among them.
struct SweepName {
  std::string_view name;
  std::string_view text;
  bool of_walls;
};
[[nodiscard]] std::vector<SweepName> sweep_names();

}  // namespace thimble::host

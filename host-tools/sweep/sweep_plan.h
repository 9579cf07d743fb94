// What a sweep runs, and what is made of the results: the plan file of `thimble sweep`, JSON like a scene file (docs/sweep.md has the keys).
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "board/sim/hand_path.h"
#include "host-tools/sweep/sweep_values.h"

namespace thimble::host {

struct SweepAxis {
  std::string what;
  std::string label, unit;  // in the table
  std::vector<SweepValue> values;
};

// Values from the first to the last; each is the one before it times ratio.
struct SweepSearch {
  std::string what;
  std::vector<SweepValue> values;
};

struct SweepTable {
  std::size_t rows = 0, columns = 0;  // axes
  std::string value;
  int digits = 3;
};

struct SweepPlan {
  std::string name, description;
  std::shared_ptr<const SweepScene> scene;  // null: a wall
  std::vector<board::PathPoint> path;
  bool ideal = false;
  double steady_s = 0;  // 0: no steady part; of a wall, half of its hold_s
  std::optional<Eigen::Vector3d> along;
  double still_m = kTwoCounts_m;
  SweepSettings base;
  std::vector<SweepValue> hand_numbers;  // of "set": what it says of the hand holds for each hand of an axis
  std::vector<SweepAxis> axes;
  std::optional<SweepSearch> search;
  std::optional<SweepTable> table;
  std::vector<std::filesystem::path> files;  // that it names: scene, meshes, path, arms
  std::uint32_t crc =
      0;  // of this version of Thimble, the plan and all files that it depends on: results belong to one plan

  static constexpr std::size_t kMostRuns = 1'000'000;
  [[nodiscard]] std::size_t runs() const;
  // Of a run, the index of the value of each axis. The last axis varies fastest.
  [[nodiscard]] std::vector<std::size_t> place(std::size_t run) const;
};

// SceneErrors (kBadInput): everything that is wrong in the plan, each with file, line, JSON pointer, the value and what is allowed; or all that is
// wrong in its scene file. Error kBadInput, kPermission of other files.
[[nodiscard]] SweepPlan read_sweep_plan(const std::filesystem::path& file);
// The same for text that is not in a file yet: `file` stands in messages, and paths are relative to its folder.
[[nodiscard]] SweepPlan read_sweep_plan_text(const std::string& text, const std::filesystem::path& file);

}  // namespace thimble::host

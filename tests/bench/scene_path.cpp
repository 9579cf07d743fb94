#include "tests/bench/scene_path.h"

#include <algorithm>
#include <string>
#include <string_view>

#include "board/sim/hand_path.h"
#include "board/sim/hand_path_file.h"
#include "host-tools/compiler/compile.h"
#include "tests/support/ideal_run.h"

namespace thimble::test {

ScenePath scene_path(const std::filesystem::path& file) {
  ScenePath scene{SceneImage(host::compile_scene(file).image), 1, {}};
  std::array<std::vector<board::PathPoint>, control::kMaxArms> points;
  const std::string file_name = file.filename().string();
  const std::filesystem::path own =
      file.parent_path() / (file_name.substr(0, file_name.find('.')) + ".stroke.csv");
  for (const board::PathPoint& point :
       board::read_hand_path(std::filesystem::exists(own) ? own : file.parent_path() / "stroke.csv")) {
    points.at(static_cast<std::size_t>(point.arm)).push_back(point);
  }
  std::vector<board::HandPath> hands;
  for (const auto& of_arm : points) {
    if (!of_arm.empty()) hands.emplace_back(of_arm);
  }
  scene.arms = hands.size();
  double end_s = 0;
  for (const board::HandPath& hand : hands) end_s = std::max(end_s, hand.end_s());
  for (double t = hands.front().start_s(); t <= end_s; t += 1.0 / kRate_Hz) {
    std::array<control::Tip, control::kMaxArms> tips;
    for (std::size_t arm = 0; arm < hands.size(); ++arm) {
      const board::HandPath::Sample at = hands[arm].at(t);
      tips[arm].position_m = at.position_m.cast<float>();
      tips[arm].velocity_m_s = at.velocity_m_s.cast<float>();
    }
    scene.tips.push_back(tips);
  }
  return scene;
}

std::map<std::string, std::filesystem::path> demonstrations() {
  constexpr std::string_view kEnding = ".scene.json";
  std::map<std::string, std::filesystem::path> files;
  const std::filesystem::path scenes = std::filesystem::path(THIMBLE_SOURCE_DIR) / "scenes";
  for (const auto& entry : std::filesystem::recursive_directory_iterator(scenes)) {
    std::string name = entry.path().filename().string();
    if (!name.ends_with(kEnding)) continue;
    name.resize(name.size() - kEnding.size());
    const std::string folder = entry.path().parent_path().filename().string();
    if (name != folder) name.insert(0, folder + '/');
    files.emplace(name, entry.path());
  }
  return files;
}

}  // namespace thimble::test

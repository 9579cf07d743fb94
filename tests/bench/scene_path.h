// A scene of the repository and the tip positions of its stroke, tick by tick.
#pragma once

#include <array>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "control/renderer_types.h"
#include "control/scene/limits.h"
#include "tests/support/scene.h"

namespace thimble::test {

struct ScenePath {
  SceneImage image;
  std::size_t arms = 1;
  std::vector<std::array<control::Tip, control::kMaxArms>> tips;  // the hand's whole way at kRate_Hz
};

// `file`: NAME.scene.json with NAME.stroke.csv or stroke.csv beside it.
[[nodiscard]] ScenePath scene_path(const std::filesystem::path& file);

// The files of scenes/ by FOLDER, or FOLDER/NAME.
[[nodiscard]] std::map<std::string, std::filesystem::path> demonstrations();

}  // namespace thimble::test

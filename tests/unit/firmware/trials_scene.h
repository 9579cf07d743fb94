// A scene for tests of the parameter `trial`: a constant force for each of three trials, and one that always acts.
#pragma once

#include <flatbuffers/flatbuffers.h>

#include <cstddef>
#include <span>
#include <utility>
#include <vector>

#include "thimble_scene_schema/scene_generated.h"

namespace thimble::test {

inline std::vector<std::byte> trials_image() {
  flatbuffers::FlatBufferBuilder builder;
  const scene::Vec3 none(0, 0, 0), everywhere(10, 10, 10);
  const scene::Pose pose(none, scene::Quat(1, 0, 0, 0));
  const scene::Material material(1, 0, 0, 0, scene::FrictionMode::StickSlip);
  std::vector<flatbuffers::Offset<scene::Object>> all;
  for (const auto& [force_N, trial] : {std::pair(scene::Vec3(0, 0, 1), 0U),
                                       {scene::Vec3(2, 0, 0), 1U},
                                       {scene::Vec3(0, -2, 0), 2U},
                                       {scene::Vec3(0, 0, 5), 3U}}) {
    const scene::ForceField field(force_N, none, none, none, everywhere, 0, 0, 0, trial);
    const auto shape = builder.CreateStruct(field).Union();
    all.push_back(scene::CreateObject(builder, builder.CreateString("field"), scene::Shape::ForceField, shape,
                                      &pose, &material));
  }
  const auto objects = builder.CreateVector(all);
  scene::FinishSceneBuffer(builder, scene::CreateScene(builder, builder.CreateString("trials"), objects));
  const auto bytes = std::as_bytes(std::span(builder.GetBufferPointer(), builder.GetSize()));
  return {bytes.begin(), bytes.end()};
}

}  // namespace thimble::test

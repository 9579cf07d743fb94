#include "tests/unit/firmware/bench.h"

#include "thimble_scene_schema/scene_generated.h"

namespace thimble::test {

std::vector<std::byte> plane_image(float stiffness_N_m, float height_m, float damping_N_s_m,
                                   const std::string& name, std::size_t planes, float friction) {
  flatbuffers::FlatBufferBuilder builder;
  const scene::Plane plane(scene::Vec3(0, 0, 1), height_m);
  const scene::Pose pose(scene::Vec3(0, 0, 0), scene::Quat(1, 0, 0, 0));
  const scene::Material material(stiffness_N_m, damping_N_s_m, friction, friction,
                                 scene::FrictionMode::StickSlip);
  std::vector<flatbuffers::Offset<scene::Object>> all;
  for (std::size_t i = 0; i < planes; ++i) {
    // Before the name, so that the image ends in the shape and not in padding: cut anywhere, it is refused.
    const auto shape = builder.CreateStruct(plane).Union();
    const auto object = builder.CreateString("plane");
    all.push_back(scene::CreateObject(builder, object, scene::Shape::Plane, shape, &pose, &material));
  }
  const auto objects = builder.CreateVector(all);
  scene::FinishSceneBuffer(builder, scene::CreateScene(builder, builder.CreateString(name), objects));
  const auto bytes = std::as_bytes(std::span(builder.GetBufferPointer(), builder.GetSize()));
  return {bytes.begin(), bytes.end()};
}

}  // namespace thimble::test

// The parameter `trial`: the force fields of the scene switch in the next tick, while the arm is armed.
#include <gtest/gtest.h>

#include <bit>

#include "tests/unit/firmware/bench.h"
#include "thimble_scene_schema/scene_generated.h"

namespace thimble::test {
namespace {

// A constant force for each of three trials, and one that always acts.
std::vector<std::byte> trials_image() {
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

void set_param(Bench& bench, const char* name, std::uint32_t bits) {
  ASSERT_EQ(bench.controller->write_param(firmware::find_param(name)->id, bits), firmware::ParamStatus::kOk)
      << name;
}

TEST(Trial, ChangesTheForceInTheNextTickWhileArmed) {
  Bench bench;
  ASSERT_EQ(bench.controller->load_scene(trials_image()), firmware::StoreStatus::kOk);
  bench.home();
  set_param(bench, "allow_uncommissioned", 1);
  bench.arm();
  bench.ticks(8000);  // the ramp
  const auto force_after_a_tick = [&](std::uint32_t trial) {
    set_param(bench, "trial", trial);
    bench.tick();
    return bench.shown().arm[0].force_N;
  };
  constexpr float kExact = 1e-5F;
  for (int round = 0; round < 50; ++round) {
    EXPECT_TRUE(force_after_a_tick(1).isApprox(Vec3(2, 0, 1), kExact))
        << bench.shown().arm[0].force_N.transpose();
    EXPECT_TRUE(force_after_a_tick(0).isApprox(Vec3(0, 0, 1), kExact));
    EXPECT_TRUE(force_after_a_tick(2).isApprox(Vec3(0, -2, 1), kExact));
    EXPECT_TRUE(force_after_a_tick(200).isApprox(Vec3(0, 0, 1), kExact));
  }
  // A step of 5 N is more than force_slew lets through in a tick by default, and less than it can be set to.
  EXPECT_FALSE(force_after_a_tick(3).isApprox(Vec3(0, 0, 6), kExact));
  bench.tick();
  EXPECT_TRUE(force_after_a_tick(3).isApprox(Vec3(0, 0, 6), kExact));
  EXPECT_TRUE(force_after_a_tick(0).isApprox(Vec3(0, 0, 1), kExact));
  set_param(bench, "force_slew", std::bit_cast<std::uint32_t>(firmware::find_param("force_slew")->max));
  EXPECT_TRUE(force_after_a_tick(3).isApprox(Vec3(0, 0, 6), kExact));
  EXPECT_EQ(bench.mode(), Mode::kArmed);
}

}  // namespace
}  // namespace thimble::test

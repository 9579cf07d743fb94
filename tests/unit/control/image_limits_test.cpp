// The board's own check of an image that holds too much of something: the figure and the limit are told.
#include <gtest/gtest.h>

#include <array>
#include <cstring>
#include <functional>
#include <string>
#include <vector>

#include "control/scene/limits.h"
#include "control/scene/scene_view.h"
#include "tests/support/scene.h"
#include "thimble_scene_schema/scene_generated.h"

namespace thimble::test {
namespace {

using flatbuffers::FlatBufferBuilder;
using scene::Shape;

const scene::Vec3 kZero(0.0F, 0.0F, 0.0F);

struct Made {
  Shape kind;
  flatbuffers::Offset<void> shape;
  flatbuffers::Offset<scene::Body> body = 0;
};

// As many objects as asked for, each made by `make`, and what the check says of them.
std::string verdict_on(std::size_t objects, const std::function<Made(FlatBufferBuilder&)>& make) {
  FlatBufferBuilder builder;
  std::vector<flatbuffers::Offset<scene::Object>> made;
  const scene::Pose pose(kZero, scene::Quat(1.0F, 0.0F, 0.0F, 0.0F));
  const scene::Material material(500.0F, 0.0F, 0.0F, 0.0F, scene::FrictionMode::StickSlip);
  for (std::size_t i = 0; i < objects; ++i) {
    const Made one = make(builder);
    const auto name = builder.CreateString(std::to_string(i));
    made.push_back(scene::CreateObject(builder, name, one.kind, one.shape, &pose, &material, 0, one.body));
  }
  scene::FinishSceneBuffer(
      builder, scene::CreateScene(builder, builder.CreateString("x"), builder.CreateVector(made)));
  std::vector<std::uint64_t> aligned((builder.GetSize() + 7) / 8);
  std::memcpy(aligned.data(), builder.GetBufferPointer(), builder.GetSize());
  control::SceneView view;
  const control::ImageVerdict verdict =
      control::SceneView::check(std::as_bytes(std::span(aligned)).first(builder.GetSize()), view);
  std::array<char, 100> text{};
  control::write_text(verdict, text);
  return text.data();
}

Made ball(FlatBufferBuilder& builder) {
  return {Shape::Sphere, builder.CreateStruct(scene::Sphere(0.01F)).Union()};
}

Made moving_ball(FlatBufferBuilder& builder) {
  Made made = ball(builder);
  const scene::Vec3 inertia(1e-5F, 1e-5F, 1e-5F), axis(0.0F, 0.0F, 1.0F);
  made.body = scene::CreateBody(builder, scene::Motion::Free, 0.1F, &inertia, 0.0F, &kZero, &kZero, 0.0F,
                                0.0F, 0.0F, &axis, &kZero);
  return made;
}

Made needle(FlatBufferBuilder& builder, std::size_t layers) {
  const std::vector<scene::Layer> all(layers, scene::Layer(0.001F, 500.0F, 1.0F, 0.1F, 1.0F));
  return {Shape::Needle, scene::CreateNeedle(builder, builder.CreateVectorOfStructs(all)).Union()};
}

Made mesh(FlatBufferBuilder& builder, std::size_t triangles) {
  const std::vector<scene::Vertex> vertices(3);
  const std::vector<scene::Triangle> faces(triangles);
  const std::vector<scene::BvhNode> nodes(1);
  const auto v = builder.CreateVectorOfStructs(vertices);
  const auto t = builder.CreateVectorOfStructs(faces);
  const auto n = builder.CreateVectorOfStructs(nodes);
  const auto f = builder.CreateVector(std::vector<std::uint8_t>(triangles));
  return {Shape::Mesh, scene::CreateMesh(builder, v, t, f, 0, n).Union()};
}

TEST(ImageLimits, EachIsToldWithTheFigure) {
  EXPECT_EQ(verdict_on(control::kMaxObjects, ball), "ok");
  EXPECT_EQ(verdict_on(control::kMaxObjects + 1, ball), "too_many_objects: 65 objects, at most 64");
  EXPECT_EQ(verdict_on(control::kMaxBodies, moving_ball), "ok");
  EXPECT_EQ(verdict_on(control::kMaxBodies + 1, moving_ball),
            "too_many_bodies: 17 objects that move, at most 16");
  const auto one_layer = [](FlatBufferBuilder& builder) { return needle(builder, 1); };
  EXPECT_EQ(verdict_on(control::kMaxVolumes, one_layer), "ok");
  EXPECT_EQ(verdict_on(control::kMaxVolumes + 1, one_layer), "too_many_objects: 17 volumes, at most 16");
  const auto layers = [](FlatBufferBuilder& builder) { return needle(builder, control::kMaxLayers + 1); };
  EXPECT_EQ(verdict_on(1, layers), "too_many_samples: " + std::to_string(control::kMaxLayers + 1) +
                                       " layers, at most " + std::to_string(control::kMaxLayers));
  const auto triangles = [](FlatBufferBuilder& builder) { return mesh(builder, control::kMaxTriangles + 1); };
  EXPECT_EQ(verdict_on(1, triangles), "too_many_triangles: 1048577 triangles, at most 1048576");
}

TEST(ImageLimits, ATextThatDoesNotFitIsCut) {
  const control::ImageVerdict verdict(control::ImageStatus::kTooManyObjects, "objects", 65, 64);
  std::array<char, 22> text{};
  control::write_text(verdict, text);
  EXPECT_STREQ(text.data(), "too_many_objects: 65 ");
  control::write_text(verdict, {});
}

}  // namespace
}  // namespace thimble::test

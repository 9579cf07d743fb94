// The check of an image that exceeds a limit reports the figure and the limit.
#include <gtest/gtest.h>

#include <array>
#include <cstring>
#include <functional>
#include <limits>
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

const scene::Vec3 kZero(0.0F, 0.0F, 0.0F), kUp(0.0F, 0.0F, 1.0F);

struct Made {
  Shape kind;
  flatbuffers::Offset<void> shape;
  flatbuffers::Offset<scene::Body> body = 0;
  flatbuffers::Offset<scene::Surface> surface = 0;
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
    made.push_back(
        scene::CreateObject(builder, name, one.kind, one.shape, &pose, &material, one.surface, one.body));
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

Made moving_ball(FlatBufferBuilder& builder, flatbuffers::Offset<scene::Control> control = 0) {
  Made made = ball(builder);
  const scene::Vec3 inertia(1e-5F, 1e-5F, 1e-5F);
  made.body = scene::CreateBody(builder, control.IsNull() ? scene::Motion::Free : scene::Motion::Slide, 0.1F,
                                &inertia, 0.0F, &kZero, &kZero, 0.0F, 0.0F, 0.0F, &kUp, &kZero, control);
  return made;
}

Made control_of_points(FlatBufferBuilder& builder, std::size_t points) {
  std::vector<scene::CurvePoint> curve;
  for (std::size_t i = 0; i < points; ++i) curve.emplace_back(1e-3F * static_cast<float>(i), 0.0F);
  const auto made = builder.CreateVectorOfStructs(curve);
  scene::ControlBuilder control(builder);
  control.add_low(-0.1F);
  control.add_high(0.1F);
  control.add_curve(made);
  return moving_ball(builder, control.Finish());
}

Made vector_field(FlatBufferBuilder& builder, std::size_t subvolumes, std::size_t sides) {
  const scene::HalfSpace half(kUp, 0.0F);
  std::vector<flatbuffers::Offset<scene::Subvolume>> all;
  for (std::size_t i = 0; i < subvolumes; ++i) {
    const auto those = builder.CreateVectorOfStructs(std::vector<scene::HalfSpace>(sides, half));
    all.push_back(scene::CreateSubvolume(builder, those, &half, &kZero, 0.0F));
  }
  const auto made = builder.CreateVector(all);
  return {Shape::VectorField, scene::CreateVectorField(builder, made, &kZero, &kZero).Union()};
}

Made potential_field(FlatBufferBuilder& builder, std::uint16_t side) {
  const auto count = builder.CreateVector(std::vector<std::uint16_t>{side, side, 128});
  const auto coefficients = builder.CreateVector(std::vector<float>(std::size_t{128} * side * side));
  return {Shape::PotentialField, scene::CreatePotentialField(builder, count, &kZero, 1e-3F,
                                                             scene::PotentialLaw::Spring, coefficients)
                                     .Union()};
}

Made textured(FlatBufferBuilder& builder, std::uint16_t rows) {
  Made made = ball(builder);
  const auto heights = builder.CreateVector(std::vector<float>(std::size_t{256} * rows));
  const auto texture =
      scene::CreateTexture(builder, scene::TextureKind::Lateral, 256, rows, 1.0F, 1.0F, heights);
  made.surface = scene::CreateSurface(builder, nullptr, 0.0F, texture);
  return made;
}

Made mapped(FlatBufferBuilder& builder, std::uint16_t rows) {
  Made made = ball(builder);
  const scene::Vec3 u(1.0F, 0.0F, 0.0F);
  const auto stiffness = builder.CreateVector(std::vector<float>(std::size_t{256} * rows, 100.0F));
  const auto map = scene::CreateStiffnessMap(builder, 256, rows, 1e-3F, &kZero, &u, &kUp, stiffness);
  made.surface = scene::CreateSurface(builder, nullptr, 0.0F, 0, map);
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

TEST(ImageLimits, AConeIsASolidOfFiniteSizeThatCanMove) {
  const auto cone = [](float radius_m, float height_m) {
    return [=](FlatBufferBuilder& builder) {
      Made made = moving_ball(builder);
      made.kind = Shape::Cone;
      made.shape = builder.CreateStruct(scene::Cone(radius_m, height_m)).Union();
      return made;
    };
  };
  EXPECT_EQ(verdict_on(1, cone(0.01F, 0.02F)), "ok");
  EXPECT_EQ(verdict_on(1, cone(0.0F, 0.02F)), "bad_number");
  EXPECT_EQ(verdict_on(1, cone(0.01F, -0.02F)), "bad_number");
  EXPECT_EQ(verdict_on(1, cone(std::numeric_limits<float>::quiet_NaN(), 0.02F)), "bad_number");
  EXPECT_EQ(verdict_on(1, cone(0.01F, 2.0F * control::kMaxCoordinate_m)), "bad_number");
  // Not one of the volumes, though the union names it after them.
  const auto still = [](FlatBufferBuilder& builder) {
    return Made{Shape::Cone, builder.CreateStruct(scene::Cone(0.01F, 0.02F)).Union()};
  };
  EXPECT_EQ(verdict_on(control::kMaxVolumes + 1, still), "ok");
}

TEST(ImageLimits, AShapeOfALaterUnionIsRefused) {
  const auto later = [](FlatBufferBuilder& builder) {
    return Made{static_cast<Shape>(static_cast<int>(Shape::MAX) + 1),
                builder.CreateStruct(scene::Cone(0.01F, 0.02F)).Union()};
  };
  EXPECT_EQ(verdict_on(1, later), "no_shape");
}

TEST(ImageLimits, ObjectsAreToldWithTheFigure) {
  EXPECT_EQ(verdict_on(control::kMaxObjects, ball), "ok");
  EXPECT_EQ(verdict_on(control::kMaxObjects + 1, ball), "too_many_objects: 65 objects, at most 64");
  const auto moving = [](FlatBufferBuilder& builder) { return moving_ball(builder); };
  EXPECT_EQ(verdict_on(control::kMaxBodies, moving), "ok");
  EXPECT_EQ(verdict_on(control::kMaxBodies + 1, moving), "too_many_bodies: 17 objects that move, at most 16");
  const auto one_layer = [](FlatBufferBuilder& builder) { return needle(builder, 1); };
  EXPECT_EQ(verdict_on(control::kMaxVolumes, one_layer), "ok");
  EXPECT_EQ(verdict_on(control::kMaxVolumes + 1, one_layer), "too_many_objects: 17 volumes, at most 16");
}

// One object with the most of what it may have, and with more.
TEST(ImageLimits, WhatOneObjectHasIsToldWithTheFigure) {
  using Builder = FlatBufferBuilder;
  struct Case {
    std::function<Made(Builder&)> full, over;
    const char* verdict;
  };
  constexpr std::size_t kTile = 256, kSide = 128;
  static_assert(control::kMaxTextureSamples == kTile * kTile && control::kMaxMapSamples == kTile * kTile);
  static_assert(control::kMaxFieldSamples == kSide * kSide * kSide);
  for (const auto& [full, over, verdict] : std::initializer_list<Case>{
           {[](Builder& b) { return needle(b, control::kMaxLayers); },
            [](Builder& b) { return needle(b, control::kMaxLayers + 1); },
            "too_many_samples: 33 layers, at most 32"},
           {[](Builder& b) { return control_of_points(b, control::kMaxCurvePoints); },
            [](Builder& b) { return control_of_points(b, control::kMaxCurvePoints + 1); },
            "too_many_samples: 33 points of a curve, at most 32"},
           {[](Builder& b) { return vector_field(b, control::kMaxSubvolumes, 1); },
            [](Builder& b) { return vector_field(b, control::kMaxSubvolumes + 1, 1); },
            "too_many_samples: 65 subvolumes, at most 64"},
           {[](Builder& b) { return vector_field(b, 1, control::kMaxSubvolumeSides); },
            [](Builder& b) { return vector_field(b, 1, control::kMaxSubvolumeSides + 1); },
            "too_many_samples: 17 sides of a subvolume, at most 16"},
           {[](Builder& b) { return potential_field(b, 128); },
            [](Builder& b) { return potential_field(b, 129); },
            "too_many_samples: 2130048 points of a field, at most 2097152"},
           {[](Builder& b) { return textured(b, 256); }, [](Builder& b) { return textured(b, 257); },
            "too_many_samples: 65792 points of a texture, at most 65536"},
           {[](Builder& b) { return mapped(b, 256); }, [](Builder& b) { return mapped(b, 257); },
            "too_many_samples: 65792 points of a map, at most 65536"}}) {
    EXPECT_EQ(verdict_on(1, full), "ok") << verdict;
    EXPECT_EQ(verdict_on(1, over), verdict);
  }
  const auto triangles = [](Builder& builder) { return mesh(builder, control::kMaxTriangles + 1); };
  EXPECT_EQ(verdict_on(1, triangles), "too_many_triangles: 1064961 triangles, at most 1064960");
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

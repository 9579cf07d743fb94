#include "host-tools/compiler/scene_tissue.h"

#include <cmath>

#include "control/scene/limits.h"

namespace thimble::host {
namespace {

constexpr Range kForce{0.0, static_cast<double>(control::kMaxTear_N), false, "N"};
constexpr Range kLayerStiffness{0.0, static_cast<double>(control::kMaxStiffness_N_m), false, "N/m"};

scene::Layer read_layer(const Value& value) {
  value.object("a layer of a needle's way", kLayerKeys);
  if (value.has("name"))
    static_cast<void>(value.at("name").as_text(64));  // for people: the image numbers them
  const double thickness_m = value.at("thickness_m").as_number(kLength);
  const double stiffness_N_m = value.at("stiffness_N_m").as_number(kLayerStiffness);
  const double tear_N = value.at("tear_N").as_number(kForce);
  if (stiffness_N_m == 0.0 && tear_N > 0.0)
    value.at("tear_N").wrong("0, for without stiffness no force comes about");
  constexpr Range kViscosity{0.0, static_cast<double>(control::kMaxViscosity_N_s_m2), false, "N s/m^2"};
  return {static_cast<float>(thickness_m), static_cast<float>(stiffness_N_m), static_cast<float>(tear_N),
          static_cast<float>(value.number_or("friction_N", kForce, 0.0)),
          static_cast<float>(value.number_or("viscosity_N_s_m2", kViscosity, 0.0))};
}

}  // namespace

NeedleShape read_needle(const Value& value) {
  value.object("a needle", kNeedleKeys);
  const Value layers = value.at("layers");
  if (!layers.raw().is_array() || layers.raw().empty()) layers.wrong("an array of at least one layer");
  if (layers.raw().size() > control::kMaxLayers) {
    layers.fail("too-many-layers",
                "has " + std::to_string(layers.raw().size()) + " layers, at most " +
                    std::to_string(control::kMaxLayers) + " are allowed",
                "merge thin layers");
  }
  NeedleShape needle;
  for (std::size_t i = 0; i < layers.raw().size(); ++i) needle.layers.push_back(read_layer(layers.at(i)));
  return needle;
}

TissueShape read_tissue(const Value& value) {
  value.object("a tissue", kTissueKeys);
  const Value size = value.at("size_m");
  if (!size.raw().is_array() || size.raw().size() != 2) size.wrong("an array of two numbers [x, y]");
  const auto number = [](double each) { return static_cast<float>(each); };
  return {scene::Tissue(
      number(size.at(std::size_t{0}).as_number(kLength) / 2.0),
      number(size.at(std::size_t{1}).as_number(kLength) / 2.0),
      number(value.at("contact_radius_m").as_number(kLength)),
      number(value.at("relaxed_stiffness_N_m")
                 .as_number({0.0, static_cast<double>(control::kMaxStiffness_N_m), true, "N/m"})),
      number(value.at("recovery_s")
                 .as_number({static_cast<double>(control::kMinRecovery_s),
                             static_cast<double>(control::kMaxRecovery_s), false, "s"})))};
}

void check_against_material(const TissueShape& tissue, const Value& value, double stiffness_N_m) {
  const auto relaxed = static_cast<double>(tissue.image.relaxed_stiffness_n_per_m());
  // To the six digits that people read: the share is a float.
  const double least =
      std::round(1.0e6 * static_cast<double>(control::kMinRelaxedShare)) * 1.0e-6 * stiffness_N_m;
  if (relaxed < least || relaxed > static_cast<double>(static_cast<float>(stiffness_N_m))) {
    value.at("relaxed_stiffness_N_m")
        .wrong(describe({least, stiffness_N_m, false, "N/m"}) + " (the material's stiffness is " +
               number(stiffness_N_m) + ")");
  }
}

std::pair<scene::Shape, flatbuffers::Offset<void>> write_shape(flatbuffers::FlatBufferBuilder& builder,
                                                               const NeedleShape& needle) {
  const auto layers = builder.CreateVectorOfStructs(needle.layers);
  return {scene::Shape::Needle, scene::CreateNeedle(builder, layers).Union()};
}

std::pair<scene::Shape, flatbuffers::Offset<void>> write_shape(flatbuffers::FlatBufferBuilder& builder,
                                                               const TissueShape& tissue) {
  return {scene::Shape::Tissue, builder.CreateStruct(tissue.image).Union()};
}

}  // namespace thimble::host

#include "host-tools/compiler/scene_tissue.h"

#include <cmath>

#include "control/scene/limits.h"

namespace thimble::host {
namespace {

scene::Layer read_layer(const Value& value) {
  const ScenePart part(value, "layer");
  if (part.has("name")) static_cast<void>(part.text("name"));  // for people; the image numbers the layers
  const double stiffness_N_m = part.number("stiffness_N_m");
  const double tear_N = part.number("tear_N");
  if (stiffness_N_m == 0.0 && tear_N > 0.0)
    part.at("tear_N").wrong("0, because without stiffness there is no force");
  const auto number = [&part](std::string_view key) { return static_cast<float>(part.number(key)); };
  return {number("thickness_m"), static_cast<float>(stiffness_N_m), static_cast<float>(tear_N),
          number("friction_N"), number("viscosity_N_s_m2")};
}

}  // namespace

NeedleShape read_needle(const Value& value) {
  const Value layers =
      ScenePart(value, "needle").list("layers", "too-many-layers", "layers", "merge thin layers");
  NeedleShape needle;
  for (std::size_t i = 0; i < layers.raw().size(); ++i) needle.layers.push_back(read_layer(layers.at(i)));
  return needle;
}

TissueShape read_tissue(const Value& value) {
  const ScenePart part(value, "tissue");
  const std::array<double, 2> size_m = part.pair("size_m");
  const auto number = [](double each) { return static_cast<float>(each); };
  return {scene::Tissue(number(size_m[0] / 2.0), number(size_m[1] / 2.0),
                        number(part.number("contact_radius_m")), number(part.number("relaxed_stiffness_N_m")),
                        number(part.number("recovery_s")))};
}

void check_against_material(const TissueShape& tissue, const Value& value, double stiffness_N_m) {
  const auto relaxed = static_cast<double>(tissue.image.relaxed_stiffness_n_per_m());
  // To the six digits that people read: the share is a float.
  const double least =
      std::round(1.0e6 * static_cast<double>(control::kMinRelaxedShare)) * 1.0e-6 * stiffness_N_m;
  if (relaxed < least || relaxed > static_cast<double>(static_cast<float>(stiffness_N_m))) {
    value.at("relaxed_stiffness_N_m")
        .wrong(describe({least, stiffness_N_m, "N/m"}) + " (the material's stiffness is " +
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

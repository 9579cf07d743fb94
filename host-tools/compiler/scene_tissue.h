// Needle layers and soft tissue of a scene file (paper, section 6): read, checked, written into the image.
#pragma once

#include <array>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "host-tools/compiler/scene_value.h"
#include "thimble_scene_schema/scene_generated.h"

namespace thimble::host {

struct NeedleShape {
  std::vector<scene::Layer> layers;
};
struct TissueShape {
  scene::Tissue image;
};

// Throw Error (kBadInput) with the place. stiffness_N_m: of the object's material.
[[nodiscard]] NeedleShape read_needle(const Value& value);
[[nodiscard]] TissueShape read_tissue(const Value& value);
void check_against_material(const TissueShape& tissue, const Value& value, double stiffness_N_m);

[[nodiscard]] std::pair<scene::Shape, flatbuffers::Offset<void>> write_shape(
    flatbuffers::FlatBufferBuilder& builder, const NeedleShape& needle);
[[nodiscard]] std::pair<scene::Shape, flatbuffers::Offset<void>> write_shape(
    flatbuffers::FlatBufferBuilder& builder, const TissueShape& tissue);

}  // namespace thimble::host

// The shapes of a scene file: one row each, with its word, its reader and what it is in the image. Used by read_scene_file and by the
// table of keys. Movable, textured and volume are said by control/scene/shape_table.h.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "host-tools/compiler/mesh.h"
#include "host-tools/compiler/scene_field.h"
#include "host-tools/compiler/scene_height_field.h"
#include "host-tools/compiler/scene_keys.h"
#include "host-tools/compiler/scene_tissue.h"
#include "host-tools/compiler/scene_value.h"
#include "thimble_scene_schema/scene_generated.h"

namespace thimble::host {

// A shape of a few numbers, which is a struct in the image.
struct PrimitiveShape {
  std::function<flatbuffers::Offset<void>(flatbuffers::FlatBufferBuilder&)> write;
  Eigen::Vector3d unit_inertia_m2 = Eigen::Vector3d::Zero();  // principal moments about the axes, for 1 kg
  double unrolled_radius_m = 0;  // of a side round which a texture is wrapped; 0: there is none
};

struct MeshShape {
  std::string file;  // relative to the scene file
  double scale_m;
  MeshOptions options;
  std::string place;  // "file:line: /pointer" for messages
};

using SceneShape = std::variant<PrimitiveShape, MeshShape, HeightFieldShape, VectorFieldShape,
                                PotentialFieldShape, NeedleShape, TissueShape>;

struct SceneShapeRow {
  std::string_view word;  // the key of "shape"
  scene::Shape kind;      // in the image
  bool may_move;          // as a body
  SceneShape (*read)(const Value& value);
  std::optional<FileKind> keys = {};  // of a primitive shape; scene_keys.cpp has those of the others
};

[[nodiscard]] std::span<const SceneShapeRow> scene_shapes();
// The words of the shapes, of all or of those that can be bodies.
[[nodiscard]] std::vector<std::string_view> shape_words();
[[nodiscard]] std::vector<std::string_view> movable_shape_words();

}  // namespace thimble::host

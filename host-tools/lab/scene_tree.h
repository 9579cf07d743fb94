// The objects of a scene as its author knows them: what they are, how large, where, how they feel and how they move (`thimble show`).
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include "host-tools/compiler/compile.h"

namespace thimble::host {

struct SceneTreeObject {
  std::string name;
  std::string shape;               // the scene file's word
  std::array<double, 3> size_m{};  // of its box, in its own frame; infinite: without end
  std::array<double, 3>
      position_m{};  // of its frame, in the world; of a plane the point that is nearest to the frame's origin
  std::size_t triangles = 0;  // of a mesh or a height field
  std::size_t bytes = 0;      // in the image, of what is large: meshes, fields, textures, maps
  double stiffness_N_m = 0;   // of its material; 0: a force field, which needs none
  double damping_N_s_m = 0;
  double static_friction = 0;
  double dynamic_friction = 0;
  std::vector<std::string>
      effects;  // of its surface: "click", "brake", "texture", "stiffness map"; of a force field: "constant", "curl" ...
  std::string motion;  // the scene file's word; "": it stays where it is
  double mass_kg = 0;
  std::vector<std::string>
      control;  // of a control element: "spring", "friction", "detents", "curve", "switch"
};

[[nodiscard]] std::vector<SceneTreeObject> scene_tree(const CompiledScene& scene);

}  // namespace thimble::host

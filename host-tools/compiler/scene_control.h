// The part of the scene file about controls of one degree of freedom: `control` of a body that slides or turns.
// docs/scene-format.md, "Control elements".
#pragma once

#include <array>
#include <numbers>
#include <string>
#include <string_view>
#include <vector>

#include "host-tools/compiler/scene_value.h"
#include "thimble_scene_schema/scene_generated.h"

namespace thimble::host {

// In m and N for a slide, in rad and N m for a turn.
struct SceneControlElement {
  double stiffness = 0;
  double rest = 0;
  double damping = 0;
  double friction = 0;
  double low = 0;
  double high = 0;
  double detent_pitch = 0;
  double detent_phase = 0;
  double detent_effort = 0;
  std::vector<scene::CurvePoint> curve;
  bool has_switch = false;
  double on_at = 0;
  double off_at = 0;
  std::string place;  // "file:line: /pointer" for messages
};

[[nodiscard]] SceneControlElement read_control(const Value& value, bool turns);

// inertia: kg, or kg m2 about the axis. Throws Error (kBadInput) when the control is too stiff for it to be integrated.
[[nodiscard]] flatbuffers::Offset<scene::Control> write_control(flatbuffers::FlatBufferBuilder& builder,
                                                                const SceneControlElement& control,
                                                                double inertia);

}  // namespace thimble::host

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

// Lengths in m for a slide, angles in degrees for a turn.
inline constexpr std::array<std::string_view, 9> kSlideControlKeys{
    "stiffness_N_m", "rest_m",  "damping_N_s_m", "friction_N", "low_m",
    "high_m",        "detents", "curve_m_N",     "switch"};
inline constexpr std::array<std::string_view, 9> kTurnControlKeys{
    "stiffness_N_m_rad", "rest_deg", "damping_N_m_s_rad", "friction_N_m", "low_deg",
    "high_deg",          "detents",  "curve_deg_N_m",     "switch"};
inline constexpr std::array<std::string_view, 3> kSlideDetentKeys{"pitch_m", "phase_m", "force_N"};
inline constexpr std::array<std::string_view, 3> kTurnDetentKeys{"pitch_deg", "phase_deg", "torque_N_m"};
inline constexpr std::array<std::string_view, 2> kSlideSwitchKeys{"on_at_m", "off_at_m"};
inline constexpr std::array<std::string_view, 2> kTurnSwitchKeys{"on_at_deg", "off_at_deg"};

// In m and N, or rad and N m.
struct SceneControl {
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

[[nodiscard]] SceneControl read_control(const Value& value, bool turns);

// inertia: kg, or kg m2 about the axis. Throws Error (kBadInput) when the control is too stiff for it to be integrated.
[[nodiscard]] flatbuffers::Offset<scene::Control> write_control(flatbuffers::FlatBufferBuilder& builder,
                                                                const SceneControl& control, double inertia);

}  // namespace thimble::host

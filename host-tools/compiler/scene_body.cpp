#include "host-tools/compiler/scene_body.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "control/scene/limits.h"
#include "host-tools/compiler/to_scene.h"
#include "host-tools/error.h"

namespace thimble::host {
namespace {

constexpr double limit(float value) { return static_cast<double>(value); }

// As the controller computes it from the image.
float stiffest_allowed_N_m(double mass_kg) {
  return control::kMaxStiffnessPerMass_1_s2 * static_cast<float>(mass_kg);
}

bool is_guided(scene::Motion motion) {  // along or about an axis, as a control element
  return motion == scene::Motion::Slide || motion == scene::Motion::Turn;
}

// A key that does not apply to the body's motion is an error.
void refuse_senseless_keys(const ScenePart& part, scene::Motion motion) {
  const std::string word(key_of(part.kind(), "motion").words.at(static_cast<std::size_t>(motion)));
  const auto only = [&](std::string_view key, bool sensible) {
    if (part.has(key) && !sensible) {
      part.at(key).fail("senseless-key", "has no meaning, for motion is \"" + word + "\"", "leave it out");
    }
  };
  for (const std::string_view key : {"centre_m", "inertia_kg_m2", "spin_rad_s", "angular_damping_N_m_s"})
    only(key, rotates(motion));
  only("axis", is_guided(motion) || motion == scene::Motion::Plane);
  for (const std::string_view key : {"velocity_m_s", "spring_N_m", "damping_N_s_m"})
    only(key, motion != scene::Motion::Turn);
  only("pivot_m", motion == scene::Motion::Turn);
  only("control", is_guided(motion));
  if (!part.has("control")) return;
  for (const std::string_view key : {"spring_N_m", "damping_N_s_m", "angular_damping_N_m_s"}) {
    if (part.has(key))
      part.at(key).fail("senseless-key", "stands beside a control", "give it in the control");
  }
}

}  // namespace

bool rotates(scene::Motion motion) { return motion == scene::Motion::Free || motion == scene::Motion::Turn; }

SceneBody read_body(const Value& value) {
  const ScenePart part(value, "body");
  SceneBody body;
  const std::size_t motion = part.word("motion");
  body.motion = static_cast<scene::Motion>(motion);
  refuse_senseless_keys(part, body.motion);

  body.place = value.place();
  body.mass_kg = part.number("mass_kg");
  if (part.has("centre_m")) body.centre_m = part.vector("centre_m");
  if (part.has("inertia_kg_m2")) body.inertia_kg_m2 = part.vector("inertia_kg_m2");
  body.restitution = part.number("restitution");
  body.velocity_m_s = part.vector("velocity_m_s");
  body.spin_rad_s = part.vector("spin_rad_s");
  body.spring_N_m = part.number("spring_N_m");
  if (part.has("spring_N_m")) {
    Range spring = part.range("spring_N_m");
    spring.most = std::min(spring.most, board::as_written(stiffest_allowed_N_m(body.mass_kg)));
    body.spring_N_m = part.at("spring_N_m").number(spring);
  }
  body.damping_N_s_m = part.number("damping_N_s_m");
  body.angular_damping_N_m_s = part.number("angular_damping_N_m_s");
  const bool needs_axis = is_guided(body.motion);
  body.axis = needs_axis ? part.at("axis").direction() : part.direction("axis");
  if (part.has("pivot_m")) body.pivot_m = part.vector("pivot_m");
  if (part.has("control"))
    body.control = read_control(part.at("control"), body.motion == scene::Motion::Turn);
  return body;
}

namespace {

// The least moments of inertia are those of the homogeneous body with the least mass that the surface allows: with smaller ones it
// would yield at its side like a lighter body.
void refuse_too_light(const SceneBody& body, const Eigen::Vector3d& unit_inertia, double stiffest_N_m) {
  constexpr double kRounding = 1.0 - 1.0e-5;  // the controller compares floats
  const double least_kg = stiffest_N_m / limit(control::kMaxStiffnessPerMass_1_s2);
  const std::string surface = "; its surface is up to " + number(stiffest_N_m) + " N/m stiff";
  const char* const remedy = "make it heavier or its surface softer";
  if (static_cast<float>(stiffest_N_m) > stiffest_allowed_N_m(body.mass_kg)) {
    throw Error(ExitCode::kBadInput, "body-too-light",
                body.place + " has a mass of " + number(body.mass_kg) + " kg, at least " + number(least_kg) +
                    " kg are needed" + surface,
                remedy);
  }
  if (!body.inertia_kg_m2) return;
  const Eigen::Vector3d& moments = *body.inertia_kg_m2;
  const Eigen::Vector3d least_kg_m2 = least_kg * unit_inertia;
  for (int axis = 0; axis < 3; ++axis) {
    if (moments[axis] >= least_kg_m2[axis] * kRounding) continue;
    throw Error(ExitCode::kBadInput, "body-too-light",
                body.place + "/inertia_kg_m2/" + std::to_string(axis) + " is " + number(moments[axis]) +
                    ", at least " + number(least_kg_m2[axis]) + " kg m2 are needed" + surface,
                remedy);
  }
}

// The inertia in the image. `unit_inertia` is that of the shape about the centre of mass.
PrincipalInertia inertia_of(const SceneBody& body, const Eigen::Matrix3d& unit_inertia) {
  if (body.inertia_kg_m2) return {*body.inertia_kg_m2};
  PrincipalInertia inertia = principal_inertia(body.mass_kg * unit_inertia);
  inertia.moments = inertia.moments.cwiseMax(limit(control::kMinInertia_kg_m2));
  if (inertia.moments.maxCoeff() > limit(control::kMaxInertia_kg_m2)) {
    throw Error(ExitCode::kBadInput, "bad-value",
                body.place + " has a moment of inertia of " + number(inertia.moments.maxCoeff()) +
                    ", at most " + number(limit(control::kMaxInertia_kg_m2)) + " kg m2 are allowed",
                "make it lighter, or move its \"centre_m\" nearer to the shape");
  }
  return inertia;
}

}  // namespace

flatbuffers::Offset<scene::Body> write_body(flatbuffers::FlatBufferBuilder& builder, const SceneBody& body,
                                            const ShapeMass& mass, double stiffest_N_m,
                                            const Eigen::Vector3d& position_m,
                                            const Eigen::Quaterniond& rotation) {
  const auto cast = [](double value) { return static_cast<float>(value); };
  const Eigen::Vector3d centre_m = body.centre_m.value_or(mass.centre_m);
  const Eigen::Matrix3d unit_inertia = inertia_about(mass, centre_m);
  refuse_too_light(body, unit_inertia.diagonal(), stiffest_N_m);
  const PrincipalInertia inertia = inertia_of(body, unit_inertia);
  const Eigen::Vector3d pivot_m = body.pivot_m.value_or(position_m);
  flatbuffers::Offset<scene::Control> control = 0;
  if (body.control) {
    const Eigen::Vector3d own_axis = (rotation * inertia.axes).conjugate() * body.axis;
    const Eigen::Vector3d arm_m = position_m + rotation * centre_m - pivot_m;
    const double about_axis =
        own_axis.cwiseAbs2().dot(inertia.moments) + body.mass_kg * body.axis.cross(arm_m).squaredNorm();
    control =
        write_control(builder, *body.control, body.motion == scene::Motion::Turn ? about_axis : body.mass_kg);
  }
  const scene::Vec3 moments = to_scene(inertia.moments);
  const scene::Vec3 centre = to_scene(centre_m);
  const Eigen::Quaternionf q = inertia.axes.cast<float>();
  const scene::Quat axes(q.w(), q.x(), q.y(), q.z());
  const bool off_origin = rotates(body.motion) && !centre_m.isZero(0.0);
  const bool skewed = rotates(body.motion) && !inertia.axes.vec().isZero(0.0);
  const scene::Vec3 velocity = to_scene(body.velocity_m_s);
  const scene::Vec3 spin = to_scene(body.spin_rad_s);
  const scene::Vec3 axis = to_scene(body.axis);
  const scene::Vec3 pivot = to_scene(pivot_m);
  return scene::CreateBody(builder, body.motion, cast(body.mass_kg), &moments, cast(body.restitution),
                           &velocity, &spin, cast(body.spring_N_m), cast(body.damping_N_s_m),
                           cast(body.angular_damping_N_m_s), &axis, &pivot, control,
                           off_origin ? &centre : nullptr, skewed ? &axes : nullptr);
}

}  // namespace thimble::host

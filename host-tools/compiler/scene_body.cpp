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

}  // namespace

SceneBody read_body(const Value& value) {
  using control::kMaxStiffnessPerMass_1_s2;
  value.object("a body", kBodyKeys);
  constexpr std::array<std::string_view, 5> kMotions{"free", "translate", "plane", "slide", "turn"};
  SceneBody body;
  body.motion = static_cast<scene::Motion>(value.at("motion").as_word(kMotions));
  const bool turns = body.motion == scene::Motion::Free || body.motion == scene::Motion::Turn;
  const bool along_axis = body.motion >= scene::Motion::Plane;
  const std::string motion =
      "motion is \"" + std::string(kMotions.at(static_cast<std::size_t>(body.motion))) + "\"";
  const auto only = [&](std::string_view key, bool sensible) {
    if (value.has(key) && !sensible) {
      value.at(key).fail("senseless-key", "has no meaning, for " + motion, "leave it out");
    }
  };
  only("inertia_kg_m2", turns);
  only("spin_rad_s", turns);
  only("angular_damping_N_m_s", turns);
  only("axis", along_axis);
  for (const std::string_view key : {"velocity_m_s", "spring_N_m", "damping_N_s_m"}) {
    only(key, body.motion != scene::Motion::Turn);
  }
  only("pivot_m", body.motion == scene::Motion::Turn);
  only("control", body.motion >= scene::Motion::Slide);
  if (value.has("control")) {
    for (const std::string_view key : {"spring_N_m", "damping_N_s_m", "angular_damping_N_m_s"}) {
      if (value.has(key))
        value.at(key).fail("senseless-key", "stands beside a control", "give it in the control");
    }
  }

  body.place = value.place();
  body.mass_kg =
      value.at("mass_kg").as_number({limit(control::kMinMass_kg), limit(control::kMaxMass_kg), false, "kg"});
  const double stiffest = limit(kMaxStiffnessPerMass_1_s2) * body.mass_kg;
  if (value.has("inertia_kg_m2")) {
    body.inertia_kg_m2 = value.at("inertia_kg_m2")
                             .as_vector({limit(control::kMinInertia_kg_m2), limit(control::kMaxInertia_kg_m2),
                                         false, "kg m2"});
  }
  body.restitution = value.number_or("restitution", {0.0, 1.0}, 0.0);
  const double speed = limit(control::kMaxBodySpeed_m_s);
  const double spin = limit(control::kMaxBodySpin_rad_s);
  if (value.has("velocity_m_s")) {
    body.velocity_m_s = value.at("velocity_m_s").as_vector({-speed, speed, false, "m/s"});
  }
  if (value.has("spin_rad_s"))
    body.spin_rad_s = value.at("spin_rad_s").as_vector({-spin, spin, false, "rad/s"});
  body.spring_N_m = value.number_or(
      "spring_N_m", {0.0, std::min(stiffest, limit(control::kMaxStiffness_N_m)), false, "N/m"}, 0.0);
  body.damping_N_s_m =
      value.number_or("damping_N_s_m", {0.0, limit(control::kMaxDamping_N_s_m), false, "N s/m"}, 0.0);
  body.angular_damping_N_m_s = value.number_or(
      "angular_damping_N_m_s", {0.0, limit(control::kMaxAngularDamping_N_m_s), false, "N m s"}, 0.0);
  if (body.motion >= scene::Motion::Slide || value.has("axis")) {
    const Value axis = value.at("axis");
    body.axis = axis.as_vector({-1.0e9, 1.0e9});
    if (body.axis.norm() < 1.0e-6) axis.wrong("a direction, of any length but zero");
    body.axis.normalize();
  }
  if (value.has("pivot_m")) body.pivot_m = value.at("pivot_m").as_vector(kCoordinate);
  if (value.has("control"))
    body.control = read_control(value.at("control"), body.motion == scene::Motion::Turn);
  return body;
}

Eigen::Vector3d box_inertia(const Eigen::Vector3d& size_m) {
  const Eigen::Vector3d s = size_m.cwiseAbs2();
  return Eigen::Vector3d(s.y() + s.z(), s.z() + s.x(), s.x() + s.y()) / 12.0;
}

Eigen::Vector3d sphere_inertia(double radius_m) {
  return Eigen::Vector3d::Constant(.4 * radius_m * radius_m);
}

Eigen::Vector3d cylinder_inertia(double radius_m, double height_m) {
  const double r2 = radius_m * radius_m;
  const double across = r2 / 4.0 + height_m * height_m / 12.0;
  return {across, across, r2 / 2.0};
}

Eigen::Vector3d capsule_inertia(double radius_m, double height_m) {
  const double r = radius_m;
  const double h = height_m;
  const double cylinder = h / (h + 4.0 / 3.0 * r);  // shares of the mass
  const double ball = 1.0 - cylinder;
  const Eigen::Vector3d middle = cylinder_inertia(r, h);
  // Two half balls, their centres of mass 3 r / 8 beyond the cylinder's ends: 83/320 r^2 about those.
  const double arm = h / 2.0 + 3.0 / 8.0 * r;
  const double across = cylinder * middle.x() + ball * (83.0 / 320.0 * r * r + arm * arm);
  return {across, across, cylinder * middle.z() + ball * .4 * r * r};
}

std::optional<MeshMass> mesh_mass(const CompiledMesh& mesh) {
  // Sums over the tetrahedra from the origin to each triangle (Tonon 2004).
  double volume = 0.0;
  double extent = 0.0;
  Eigen::Vector3d first = Eigen::Vector3d::Zero();
  Eigen::Vector3d second = Eigen::Vector3d::Zero();
  for (const scene::Triangle& triangle : mesh.triangles) {
    std::array<Eigen::Vector3d, 3> p;
    for (std::uint16_t i = 0; i < 3; ++i) {
      const scene::Vec3& v = mesh.vertices[(*triangle.vertex())[i]].position_m();
      p.at(i) = Eigen::Vector3f(v.x(), v.y(), v.z()).cast<double>();
      extent = std::max(extent, p.at(i).norm());
    }
    const double six = p[0].dot(p[1].cross(p[2]));
    volume += six / 6.0;
    first += six / 24.0 * (p[0] + p[1] + p[2]);
    second += six / 60.0 *
              (p[0].cwiseAbs2() + p[1].cwiseAbs2() + p[2].cwiseAbs2() + p[0].cwiseProduct(p[1]) +
               p[1].cwiseProduct(p[2]) + p[2].cwiseProduct(p[0]));
  }
  constexpr double kThin = 1.0e-6;
  const bool open = mesh.report.open_edges > 0;
  if (open || !(std::abs(volume) > kThin * extent * extent * extent)) return std::nullopt;
  const Eigen::Vector3d s = second / volume;
  return MeshMass{first / volume, {s.y() + s.z(), s.z() + s.x(), s.x() + s.y()}};
}

namespace {

// An evenly filled body of the least mass that the surface allows has the least moments too: a smaller one gives way to a fingertip
// at its side as a lighter body does.
void refuse_too_light(const SceneBody& body, const Eigen::Vector3d& unit_inertia,
                      const Eigen::Vector3d& moments, double stiffest_N_m) {
  constexpr double kRounding = 1.0 - 1.0e-5;  // the controller compares the numbers as rounded to float
  const double least_kg = stiffest_N_m / limit(control::kMaxStiffnessPerMass_1_s2);
  const std::string surface = "; its surface is up to " + number(stiffest_N_m) + " N/m stiff";
  const char* const remedy = "make it heavier or its surface softer";
  if (body.mass_kg < least_kg * kRounding) {
    throw Error(ExitCode::kBadInput, "body-too-light",
                body.place + " has a mass of " + number(body.mass_kg) + " kg, at least " + number(least_kg) +
                    " kg are needed" + surface,
                remedy);
  }
  if (body.motion != scene::Motion::Free && body.motion != scene::Motion::Turn) return;
  const Eigen::Vector3d least_kg_m2 = least_kg * unit_inertia;
  for (int axis = 0; axis < 3; ++axis) {
    if (moments[axis] >= least_kg_m2[axis] * kRounding) continue;
    throw Error(ExitCode::kBadInput, "body-too-light",
                body.place + "/inertia_kg_m2/" + std::to_string(axis) + " is " + number(moments[axis]) +
                    ", at least " + number(least_kg_m2[axis]) + " kg m2 are needed" + surface,
                remedy);
  }
}

}  // namespace

flatbuffers::Offset<scene::Body> write_body(flatbuffers::FlatBufferBuilder& builder, const SceneBody& body,
                                            const Eigen::Vector3d& unit_inertia, double stiffest_N_m,
                                            const Eigen::Vector3d& position_m,
                                            const Eigen::Quaterniond& rotation) {
  const auto cast = [](double value) { return static_cast<float>(value); };
  const Eigen::Vector3d least = Eigen::Vector3d::Constant(limit(control::kMinInertia_kg_m2));
  const Eigen::Vector3d moments =
      body.inertia_kg_m2.value_or(Eigen::Vector3d((body.mass_kg * unit_inertia).cwiseMax(least)));
  refuse_too_light(body, unit_inertia, moments, stiffest_N_m);
  const Eigen::Vector3d pivot_m = body.pivot_m.value_or(position_m);
  flatbuffers::Offset<scene::Control> control = 0;
  if (body.control) {
    const Eigen::Vector3d own_axis = rotation.conjugate() * body.axis;
    const double about_axis = own_axis.cwiseAbs2().dot(moments) +
                              body.mass_kg * body.axis.cross(position_m - pivot_m).squaredNorm();
    control =
        write_control(builder, *body.control, body.motion == scene::Motion::Turn ? about_axis : body.mass_kg);
  }
  const scene::Vec3 inertia = to_scene(moments);
  const scene::Vec3 velocity = to_scene(body.velocity_m_s);
  const scene::Vec3 spin = to_scene(body.spin_rad_s);
  const scene::Vec3 axis = to_scene(body.axis);
  const scene::Vec3 pivot = to_scene(pivot_m);
  return scene::CreateBody(builder, body.motion, cast(body.mass_kg), &inertia, cast(body.restitution),
                           &velocity, &spin, cast(body.spring_N_m), cast(body.damping_N_s_m),
                           cast(body.angular_damping_N_m_s), &axis, &pivot, control);
}

}  // namespace thimble::host

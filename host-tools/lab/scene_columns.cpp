#include "host-tools/lab/scene_columns.h"

#include <algorithm>
#include <cstring>
#include <set>
#include <utility>

#include "control/scene/scene_view.h"
#include "thimble_scene_schema/scene_generated.h"

namespace thimble::host {
namespace {

using Values = std::vector<double>;

void put(Values& out, const Eigen::Vector3f& v) {
  for (const float component : v) out.push_back(static_cast<double>(component));
}

// The name of an object, as the beginning of a column's name: without what a CSV file or a program would stumble over, and once only.
std::string label_of(const scene::Object& object, std::set<std::string>& taken) {
  std::string base = object.name()->str();
  for (char& c : base) {
    const bool plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-';
    if (!plain) c = '_';
  }
  std::string label = base;
  for (int n = 2; !taken.insert(label).second; ++n) label = base + "_" + std::to_string(n);
  return label;
}

// The coordinate of a control element with its unit; empty: the object has several.
std::string coordinate_of(const scene::Body& body) {
  switch (body.motion()) {
    case scene::Motion::Slide:
      return "q_m";
    case scene::Motion::Turn:
      return "q_rad";
    case scene::Motion::Free:
    case scene::Motion::Translate:
    case scene::Motion::Plane:
      break;
  }
  return "";
}

Eigen::Vector3d to_vector(const scene::Vec3& v) {
  return Eigen::Vector3f(v.x(), v.y(), v.z()).cast<double>();
}

// What the kinetic energy of a body depends on besides its motion.
struct Inertia {
  double mass_kg;
  Eigen::Vector3d principal_kg_m2;
  Eigen::Quaterniond principal_axes = Eigen::Quaterniond::Identity();  // in the object's frame, as centre_m
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();

  explicit Inertia(const scene::Body& body)
      : mass_kg(static_cast<double>(body.mass_kg())), principal_kg_m2(to_vector(*body.inertia_kg_m2())) {
    if (const scene::Vec3* centre = body.centre_m(); centre != nullptr) centre_m = to_vector(*centre);
    if (const scene::Quat* axes = body.principal_axes(); axes != nullptr)
      principal_axes = Eigen::Quaternionf(axes->w(), axes->x(), axes->y(), axes->z()).cast<double>();
  }

  [[nodiscard]] double kinetic_J(const control::BodyState& state) const {
    const Eigen::Quaterniond rotation = state.rotation.cast<double>();
    const Eigen::Vector3d spin = state.spin_rad_s.cast<double>();
    const Eigen::Vector3d centre_velocity =
        state.velocity_m_s.cast<double>() + spin.cross(rotation * centre_m);
    const Eigen::Vector3d principal_spin = (rotation * principal_axes).conjugate() * spin;
    return (mass_kg * centre_velocity.squaredNorm() +
            principal_kg_m2.dot(principal_spin.cwiseProduct(principal_spin))) /
           2;
  }
};

}  // namespace

SceneColumns::SceneColumns(std::span<const std::byte> image) {
  std::vector<std::uint64_t> aligned((image.size() + 7) / 8);
  if (!image.empty()) std::memcpy(aligned.data(), image.data(), image.size());
  control::SceneView view;
  if (control::SceneView::check(std::as_bytes(std::span(aligned)).first(image.size()), view) !=
      control::ImageStatus::kOk)
    return;
  add_bounds();
  std::set<std::string> taken;
  std::uint8_t index = 0;
  for (const scene::Object* object : *view.scene()->objects()) {
    const std::string label = label_of(*object, taken);
    if (object->body() != nullptr) add_body(label, index, *object->body());
    const scene::Shape shape = object->shape_type();
    if (shape == scene::Shape::Needle || shape == scene::Shape::Tissue) add_tissue(label, index);
    ++index;
  }
}

std::span<const double> SceneColumns::values(const board::LogRow& row) const {
  values_.clear();
  for (const auto& write : write_) write(row, values_);
  return values_;
}

void SceneColumns::add(std::string name, std::vector<std::string> columns) {
  fields_.push_back({std::move(name), std::move(columns)});
}

void SceneColumns::add_bounds() {
  for (const char* name : {"sweep_bound", "slide_bound", "contact_bound", "put_off"}) add(name, {name});
  write_.emplace_back([](const board::LogRow& row, Values& out) {
    const control::RenderCounters& bounds = row.scene.bounds;
    for (const std::uint32_t count :
         {bounds.sweep_bound, bounds.slide_bound, bounds.contact_bound, bounds.put_off})
      out.push_back(count);
  });
}

void SceneColumns::add_body(const std::string& label, std::uint8_t object, const scene::Body& body) {
  const auto columns = [&](std::initializer_list<const char*> names) {
    std::vector<std::string> all;
    for (const char* name : names) all.push_back(label + "." + name);
    return all;
  };
  add(label + ".position_m", columns({"x_m", "y_m", "z_m"}));
  add(label + ".rotation", columns({"qw", "qx", "qy", "qz"}));
  add(label + ".velocity_m_s", columns({"vx_m_s", "vy_m_s", "vz_m_s"}));
  add(label + ".spin_rad_s", columns({"wx_rad_s", "wy_rad_s", "wz_rad_s"}));
  add(label + ".kinetic_J", {label + ".kinetic_J"});
  const std::string coordinate = coordinate_of(body);
  const bool controlled = !coordinate.empty();
  if (controlled) {
    add(label + "." + coordinate, {label + "." + coordinate});
    add(label + ".on", {label + ".on"});
  }
  write_.emplace_back([object, controlled, inertia = Inertia(body)](const board::LogRow& row, Values& out) {
    const auto moved = std::ranges::find(row.scene.bodies, object, &control::BodyState::object);
    const control::BodyState state = moved == row.scene.bodies.end() ? control::BodyState{} : *moved;
    put(out, state.position_m);
    out.push_back(static_cast<double>(state.rotation.w()));
    put(out, state.rotation.vec());
    put(out, state.velocity_m_s);
    put(out, state.spin_rad_s);
    out.push_back(inertia.kinetic_J(state));
    if (!controlled) return;
    out.push_back(static_cast<double>(state.q));
    out.push_back(state.on ? 1.0 : 0.0);
  });
}

void SceneColumns::add_tissue(const std::string& label, std::uint8_t object) {
  for (const char* name : {"inside", "depth_m", "x_m", "y_m", "torn"})
    add(label + "." + name, {label + "." + name});
  write_.emplace_back([object](const board::LogRow& row, Values& out) {
    const auto tissue = std::ranges::find_if(row.scene.tissues, [&](const control::TissueView& view) {
      return view.object == object && view.arm == row.arm;
    });
    const control::TissueView view = tissue == row.scene.tissues.end() ? control::TissueView{} : *tissue;
    out.push_back(view.inside ? 1.0 : 0.0);
    for (const float value : {view.depth_m, view.x_m, view.y_m}) out.push_back(static_cast<double>(value));
    out.push_back(view.torn);
  });
}

}  // namespace thimble::host

#include "control/bodies/collide.h"

#include <algorithm>
#include <cmath>

#include "thimble_scene_schema/scene_generated.h"

namespace thimble::control {
namespace {

using scene::Shape;

// Axes nearer than this to parallel are: 0.6 degrees.
constexpr float kParallel = 0.99995F;

// The nearest place of a solid's surface to a point of its frame: its outward normal there, and how far the point is outside.
struct Nearest {
  Vec3 normal = Vec3::UnitZ();
  float outside_m = 0.0F;
};

Nearest nearest_to_point(const Vec3& p, float radius) {
  const float distance = p.norm();
  return {distance > 0.0F ? Vec3(p / distance) : Vec3(Vec3::UnitZ()), distance - radius};
}

Nearest nearest_on_box(const Vec3& half, const Vec3& p) {
  const Vec3 beyond = p.cwiseAbs() - half;
  const Vec3 outside = beyond.cwiseMax(0.0F);
  const float distance = outside.norm();
  if (distance > 0.0F) {
    Vec3 normal = outside / distance;
    for (int i = 0; i < 3; ++i) normal[i] = std::copysign(normal[i], p[i]);
    return {normal, distance};
  }
  Eigen::Index axis = 0;
  const float depth = beyond.maxCoeff(&axis);
  Vec3 normal = Vec3::Zero();
  normal[axis] = p[axis] < 0.0F ? -1.0F : 1.0F;
  return {normal, depth};
}

Nearest nearest_on_cylinder(float radius, float half_height, const Vec3& p) {
  const float across = planar_length(p.x(), p.y());
  const Vec3 out = across > 0.0F ? Vec3(p.x() / across, p.y() / across, 0.0F) : Vec3(Vec3::UnitX());
  const Vec3 up(0.0F, 0.0F, p.z() < 0.0F ? -1.0F : 1.0F);
  const float side = across - radius;
  const float cap = std::abs(p.z()) - half_height;
  if (side > 0.0F && cap > 0.0F) {
    const float distance = planar_length(side, cap);
    return {(side * out + cap * up) / distance, distance};
  }
  return side > cap ? Nearest{out, side} : Nearest{up, cap};
}

Nearest nearest(Shape kind, const ShapeData& shape, const Vec3& p) {
  switch (kind) {
    case Shape::Plane:
      return {shape.vector, shape.vector.dot(p) - shape.radius_m};
    case Shape::Sphere:
      return nearest_to_point(p, shape.radius_m);
    case Shape::Box:
      return nearest_on_box(shape.vector, p);
    case Shape::Cylinder:
      return nearest_on_cylinder(shape.radius_m, shape.half_height_m, p);
    case Shape::Capsule:
      return nearest_to_point(p - Vec3(0, 0, std::clamp(p.z(), -shape.half_height_m, shape.half_height_m)),
                              shape.radius_m);
    case Shape::NONE:
    case Shape::Mesh:
    case Shape::VectorField:
    case Shape::PotentialField:
    case Shape::Needle:
    case Shape::Tissue:
      break;
  }
  return {Vec3::UnitZ(), 1.0F};
}

void meet_ball(const Vec3& centre, float radius, Shape kind, const PlacedObject& b, float margin,
               Manifold& out) {
  const Nearest place = nearest(kind, b.shape, b.to_local(centre));
  const float depth = radius - place.outside_m;
  if (depth < -margin) return;
  const Vec3 normal = b.turn(place.normal);
  out.add({centre - (radius - 0.5F * depth) * normal, normal, depth});
}

// The balls at a capsule's ends, and the one of its axis that is nearest to the other solid.
void meet_capsule(const PlacedObject& a, Shape kind, const PlacedObject& b, float margin, Manifold& out) {
  const float half = a.shape.half_height_m;
  const float radius = a.shape.radius_m;
  meet_ball(a.to_world({0, 0, half}), radius, kind, b, margin, out);
  meet_ball(a.to_world({0, 0, -half}), radius, kind, b, margin, out);
  if (kind == Shape::Plane) return;
  // By the thirds: outside_m is convex along the axis.
  constexpr int kThirds = 12;
  float lo = -half;
  float hi = half;
  const auto outside = [&](float z) {
    return nearest(kind, b.shape, b.to_local(a.to_world({0, 0, z}))).outside_m;
  };
  for (int i = 0; i < kThirds; ++i) {
    const float third = (hi - lo) / 3.0F;
    if (outside(lo + third) < outside(hi - third)) {
      hi -= third;
    } else {
      lo += third;
    }
  }
  const float z = 0.5F * (lo + hi);
  if (std::abs(z) < 0.9F * half) meet_ball(a.to_world({0, 0, z}), radius, kind, b, margin, out);
}

void meet_plane(const PlacedObject& plane, const Vec3& point, float margin, Manifold& out) {
  const Vec3 normal = plane.turn(plane.shape.vector);
  const float depth = plane.shape.radius_m - plane.shape.vector.dot(plane.to_local(point));
  if (depth >= -margin) out.add({point + 0.5F * depth * normal, normal, depth});
}

void box_on_plane(const PlacedObject& a, const PlacedObject& plane, float margin, Manifold& out) {
  const Vec3& half = a.shape.vector;
  for (unsigned corner = 0; corner < 8; ++corner) {
    const Vec3 local((corner & 1U) != 0 ? half.x() : -half.x(), (corner & 2U) != 0 ? half.y() : -half.y(),
                     (corner & 4U) != 0 ? half.z() : -half.z());
    meet_plane(plane, a.to_world(local), margin, out);
  }
}

// Four points of each rim, the lowest one among them.
void cylinder_on_plane(const PlacedObject& a, const PlacedObject& plane, float margin, Manifold& out) {
  const Vec3 down = a.turn_back(-plane.turn(plane.shape.vector));
  const float across = planar_length(down.x(), down.y());
  constexpr float kUpright = 0.01F;
  const Vec3 lowest =
      across > kUpright ? Vec3(down.x() / across, down.y() / across, 0.0F) : Vec3(Vec3::UnitX());
  const Vec3 beside(-lowest.y(), lowest.x(), 0.0F);
  for (const float z : {-a.shape.half_height_m, a.shape.half_height_m}) {
    const Vec3 middle(0.0F, 0.0F, z);
    for (const Vec3& way : {lowest, beside, Vec3(-lowest), Vec3(-beside)})
      meet_plane(plane, a.to_world(middle + a.shape.radius_m * way), margin, out);
  }
}

// Seen along a puck's axis: its circle and the other's circle or rectangle, in the frame of the other with z along the axis.
struct Outline {
  bool circle = true;
  float radius_m = 0.0F;
  float half_x_m = 0.0F;
  float half_y_m = 0.0F;
  float half_z_m = 0.0F;
  Mat3 axes = Mat3::Identity();  // its x, y and z in the world

  [[nodiscard]] Nearest across(const Vec3& p) const {
    const Vec3 flat(p.x(), p.y(), 0.0F);
    if (circle) {
      const float distance = flat.norm();
      return {distance > 0.0F ? Vec3(flat / distance) : Vec3(Vec3::UnitX()), distance - radius_m};
    }
    // A box without end along z.
    constexpr float kEndless = 1.0e6F;
    return nearest_on_box({half_x_m, half_y_m, kEndless}, flat);
  }
};

void meet_puck(const PlacedObject& a, const PlacedObject& b, const Outline& outline, float margin,
               Manifold& out) {
  const Vec3 centre =
      outline.axes.transpose() * (a.position_m - b.position_m);  // of the puck, from the other's
  const float radius = a.shape.radius_m;
  const Nearest side = outline.across(centre);
  const float side_depth = radius - side.outside_m;
  const float cap_depth = a.shape.half_height_m + outline.half_z_m - std::abs(centre.z());
  if (side_depth < -margin || cap_depth < -margin) return;
  const auto world = [&](const Vec3& p) { return Vec3(outline.axes * p + b.position_m); };
  if (side_depth <= cap_depth) {
    const float top = std::min(centre.z() + a.shape.half_height_m, outline.half_z_m);
    const float bottom = std::max(centre.z() - a.shape.half_height_m, -outline.half_z_m);
    const Vec3 at = Vec3(centre.x(), centre.y(), 0.0F) - (radius - 0.5F * side_depth) * side.normal;
    const Vec3 normal = outline.axes * side.normal;
    out.add({world(at + Vec3(0, 0, top)), normal, side_depth});
    out.add({world(at + Vec3(0, 0, bottom)), normal, side_depth});
    return;
  }
  // One on the other: points of either outline that are within the other.
  const float up = centre.z() < 0.0F ? -1.0F : 1.0F;
  const Vec3 normal = outline.axes * Vec3(0, 0, up);
  const float z = up * (outline.half_z_m - 0.5F * cap_depth);
  for (const auto& [x, y] :
       {std::pair(1.0F, 0.0F), std::pair(0.0F, 1.0F), std::pair(-1.0F, 0.0F), std::pair(0.0F, -1.0F)}) {
    const Vec3 of_a(centre.x() + radius * x, centre.y() + radius * y, z);
    if (outline.across(of_a).outside_m <= 0.0F) out.add({world(of_a), normal, cap_depth});
    const Vec3 of_b = outline.circle ? Vec3(outline.radius_m * x, outline.radius_m * y, z)
                                     : Vec3(outline.half_x_m * (x + y), outline.half_y_m * (x - y), z);
    if ((of_b - centre).head<2>().norm() < radius) out.add({world(of_b), normal, cap_depth});
  }
}

OrientedBox box_about(Shape kind, const PlacedObject& o) {
  const ShapeData& s = o.shape;
  return {o.position_m, o.rotation,
          kind == Shape::Box ? s.vector : Vec3(s.radius_m, s.radius_m, s.half_height_m)};
}

// a is a cylinder, b a cylinder or a box.
bool meet_parallel(const PlacedObject& a, Shape kind, const PlacedObject& b, float margin, Manifold& out) {
  const Vec3 axis = b.rotation.transpose() * a.rotation.col(2);
  for (int i = kind == Shape::Box ? 0 : 2; i < 3; ++i) {
    if (std::abs(axis[i]) < kParallel) continue;
    Outline outline;
    const int x = (i + 1) % 3;
    const int y = (i + 2) % 3;
    outline.axes << b.rotation.col(x), b.rotation.col(y), b.rotation.col(i);
    outline.circle = kind == Shape::Cylinder;
    outline.radius_m = b.shape.radius_m;
    outline.half_x_m = b.shape.vector[x];
    outline.half_y_m = b.shape.vector[y];
    outline.half_z_m = kind == Shape::Box ? b.shape.vector[i] : b.shape.half_height_m;
    meet_puck(a, b, outline, margin, out);
    return true;
  }
  return false;
}

void turn_round(Manifold& manifold) {
  for (std::size_t i = 0; i < manifold.count; ++i) manifold.points[i].normal = -manifold.points[i].normal;
}

bool is_round(Shape kind) { return kind == Shape::Sphere || kind == Shape::Capsule; }

// Where a can be the one that is written for.
bool collide_as(Shape kind_a, const PlacedObject& a, Shape kind_b, const PlacedObject& b, float margin,
                Manifold& out) {
  if (kind_a == Shape::Sphere) {
    meet_ball(a.position_m, a.shape.radius_m, kind_b, b, margin, out);
    return true;
  }
  if (kind_a == Shape::Capsule && kind_b != Shape::Sphere) {
    meet_capsule(a, kind_b, b, margin, out);
    return true;
  }
  if (is_round(kind_b)) return false;
  if (kind_b == Shape::Plane) {
    if (kind_a == Shape::Box) {
      box_on_plane(a, b, margin, out);
    } else {
      cylinder_on_plane(a, b, margin, out);
    }
    return true;
  }
  return kind_a == Shape::Cylinder && meet_parallel(a, kind_b, b, margin, out);
}

}  // namespace

void Manifold::add(const Meeting& meeting) noexcept {
  if (count < kMaxManifold) {
    points[count++] = meeting;
    return;
  }
  std::size_t least = 0;
  for (std::size_t i = 1; i < count; ++i) {
    if (points[i].depth_m < points[least].depth_m) least = i;
  }
  if (points[least].depth_m < meeting.depth_m) points[least] = meeting;
}

void collide(Shape kind_a, const PlacedObject& a, Shape kind_b, const PlacedObject& b, float margin_m,
             Manifold& out) noexcept {
  out.count = 0;
  if (collide_as(kind_a, a, kind_b, b, margin_m, out)) return;
  if (collide_as(kind_b, b, kind_a, a, margin_m, out)) {
    turn_round(out);
    return;
  }
  collide_boxes(box_about(kind_a, a), box_about(kind_b, b), margin_m, out);
}

}  // namespace thimble::control

#include "control/bodies/collide.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "thimble_scene_schema/scene_generated.h"

namespace thimble::control {

void collide_point_with_plane(const PlacedObject& plane, const Vec3& point, float margin,
                              Manifold& out) noexcept {
  const Vec3& normal = plane.normal;
  const float depth = plane.offset_m - normal.dot(point);
  if (depth >= -margin) out.add({point + 0.5F * depth * normal, normal, depth});
}

void flip_normals(Manifold& manifold) noexcept {
  for (std::size_t i = 0; i < manifold.count; ++i) manifold.points[i].normal = -manifold.points[i].normal;
}

namespace {

// Cosine of the largest angle between axes that count as parallel: 0.6 degrees.
constexpr float kParallel = 0.99995F;

CollisionForm form(const PlacedObject& object) { return object.row->collision->form; }

NearestPlace nearest(const PlacedObject& object, const Vec3& p) {
  return object.row->collision->nearest(object.shape, p);
}

void collide_ball(const Vec3& centre, float radius, const PlacedObject& b, float margin, Manifold& out) {
  const NearestPlace place = nearest(b, b.to_local(centre));
  const float depth = radius - place.outside_m;
  if (depth < -margin) return;
  const Vec3 normal = b.turn(place.normal);
  out.add({centre - (radius - 0.5F * depth) * normal, normal, depth});
}

// Three balls of the capsule: at both ends, and at the point of its axis that is nearest to the other solid.
void collide_capsule(const PlacedObject& a, const PlacedObject& b, float margin, Manifold& out) {
  const float half = a.shape.half_height_m;
  const float radius = a.shape.radius_m;
  collide_ball(a.to_world({0, 0, half}), radius, b, margin, out);
  collide_ball(a.to_world({0, 0, -half}), radius, b, margin, out);
  if (form(b) == CollisionForm::kHalfSpace) return;
  // Ternary search: outside_m is convex along the axis.
  constexpr int kThirds = 12;
  float lo = -half;
  float hi = half;
  const auto outside = [&](float z) { return nearest(b, b.to_local(a.to_world({0, 0, z}))).outside_m; };
  for (int i = 0; i < kThirds; ++i) {
    const float third = (hi - lo) / 3.0F;
    if (outside(lo + third) < outside(hi - third)) {
      hi -= third;
    } else {
      lo += third;
    }
  }
  const float z = 0.5F * (lo + hi);
  if (std::abs(z) < 0.9F * half) collide_ball(a.to_world({0, 0, z}), radius, b, margin, out);
}

void collide_points_with_plane(const PlacedObject& a, const PlacedObject& plane, float margin,
                               Manifold& out) {
  const Vec3 down = a.turn_back(-plane.normal);
  const float height_m = plane.normal.dot(a.position_m) - plane.offset_m;
  LowestPoints points;
  const std::size_t count = a.row->collision->lowest(a.shape, down, points);
  for (std::size_t i = 0; i < count; ++i) {
    const float depth = down.dot(points[i]) - height_m;
    if (depth >= -margin) out.add({a.to_world(points[i]) + 0.5F * depth * plane.normal, plane.normal, depth});
  }
}

// A cylinder or box seen along an axis that it shares with a cylinder: a circle or a rectangle, in its own
// frame with z along that axis.
struct Profile {
  bool circle = true;
  float radius_m = 0.0F;
  float half_x_m = 0.0F;
  float half_y_m = 0.0F;
  float half_z_m = 0.0F;
  Mat3 axes = Mat3::Identity();  // its x, y and z in the world

  [[nodiscard]] NearestPlace across(const Vec3& p) const {
    const Vec3 flat(p.x(), p.y(), 0.0F);
    if (circle) {
      const float distance = flat.norm();
      return {distance > 0.0F ? Vec3(flat / distance) : Vec3(Vec3::UnitX()), distance - radius_m};
    }
    // A box that is infinite along z.
    constexpr float kEndless = 1.0e6F;
    return nearest_on_box({half_x_m, half_y_m, kEndless}, flat);
  }
};

void collide_outlines(const PlacedObject& a, const PlacedObject& b, const Profile& outline, float margin,
                      Manifold& out) {
  const Vec3 centre = outline.axes.transpose() *
                      (a.position_m - b.position_m);  // of the cylinder, relative to the other solid
  const float radius = a.shape.radius_m;
  const NearestPlace side = outline.across(centre);
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
  // Stacked: the points of each outline that lie within the other one.
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

OrientedBox box_about(const PlacedObject& o) {
  const BoxAbout box = o.row->collision->box_about(o.shape);
  return {o.to_world(box.centre_m), o.rotation, box.half_m};
}

// a is a cylinder, b a cylinder or a box.
bool collide_parallel(const PlacedObject& a, const PlacedObject& b, float margin, Manifold& out) {
  const bool is_box = form(b) == CollisionForm::kBox;
  const Vec3 axis = b.rotation.transpose() * a.rotation.col(2);
  for (int i = is_box ? 0 : 2; i < 3; ++i) {
    if (std::abs(axis[i]) < kParallel) continue;
    Profile outline;
    const int x = (i + 1) % 3;
    const int y = (i + 2) % 3;
    outline.axes << b.rotation.col(x), b.rotation.col(y), b.rotation.col(i);
    outline.circle = !is_box;
    outline.radius_m = b.shape.radius_m;
    outline.half_x_m = b.shape.vector[x];
    outline.half_y_m = b.shape.vector[y];
    outline.half_z_m = is_box ? b.shape.vector[i] : b.shape.half_height_m;
    collide_outlines(a, b, outline, margin, out);
    return true;
  }
  return false;
}

bool is_round(CollisionForm form) { return form == CollisionForm::kBall || form == CollisionForm::kCapsule; }

// Whether there is an exact collision with a in the first place; it is in `out` then.
bool collide_as(const PlacedObject& a, const PlacedObject& b, float margin, Manifold& out) {
  const CollisionForm form_a = form(a);
  const CollisionForm form_b = form(b);
  if (form_a == CollisionForm::kBall) {
    collide_ball(a.position_m, a.shape.radius_m, b, margin, out);
    return true;
  }
  if (form_a == CollisionForm::kCapsule && form_b != CollisionForm::kBall) {
    collide_capsule(a, b, margin, out);
    return true;
  }
  if (is_round(form_b)) return false;
  if (form_b == CollisionForm::kHalfSpace) {
    collide_points_with_plane(a, b, margin, out);
    return true;
  }
  const bool has_outline = form_b == CollisionForm::kCylinder || form_b == CollisionForm::kBox;
  return form_a == CollisionForm::kCylinder && has_outline && collide_parallel(a, b, margin, out);
}

}  // namespace

void Manifold::add(const ContactPoint& point) noexcept {
  constexpr std::uint32_t kFullWork = 12;  // pairs of points
  if (work != nullptr) work->charge(count < kMaxManifold ? 1 : kFullWork);
  if (count < kMaxManifold) {
    points[count++] = point;
    return;
  }
  // Among these and the new one, whose index is kMaxManifold. Of two that are level the first one stays.
  const auto at = [&](std::size_t i) -> const ContactPoint& { return i == kMaxManifold ? point : points[i]; };
  float nearest = std::numeric_limits<float>::infinity();
  std::size_t dropped = kMaxManifold;
  for (std::size_t i = 0; i < kMaxManifold; ++i) {
    for (std::size_t j = i + 1; j <= kMaxManifold; ++j) {
      // Points with unlike normals count as far apart.
      constexpr float kTurn_m = 0.02F;  // per radian
      const float distance2 = (at(i).point_m - at(j).point_m).squaredNorm() +
                              kTurn_m * kTurn_m * (at(i).normal - at(j).normal).squaredNorm();
      if (distance2 >= nearest) continue;
      nearest = distance2;
      constexpr float kLevel_m = 1.0e-6F;
      dropped = at(i).depth_m < at(j).depth_m - kLevel_m ? i : j;
    }
  }
  if (dropped < kMaxManifold) points[dropped] = point;
}

void Manifold::add_distinct(const ContactPoint& point) noexcept {
  constexpr float kSamePlace_m = 5.0e-5F;
  constexpr float kSameNormal = 0.9999F;
  for (std::size_t i = 0; i < count; ++i) {
    if ((points[i].point_m - point.point_m).squaredNorm() > kSamePlace_m * kSamePlace_m ||
        points[i].normal.dot(point.normal) < kSameNormal)
      continue;
    if (points[i].depth_m < point.depth_m) points[i] = point;
    return;
  }
  add(point);
}

NearestPlace nearest_on_ball(float radius_m, const Vec3& from_centre) noexcept {
  const float distance = from_centre.norm();
  return {distance > 0.0F ? Vec3(from_centre / distance) : Vec3(Vec3::UnitZ()), distance - radius_m};
}

NearestPlace nearest_on_box(const Vec3& half, const Vec3& p) noexcept {
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

std::array<Vec3, 4> rim_directions(const Vec3& down) noexcept {
  const float across = planar_length(down.x(), down.y());
  constexpr float kUpright = 0.01F;
  const Vec3 lowest =
      across > kUpright ? Vec3(down.x() / across, down.y() / across, 0.0F) : Vec3(Vec3::UnitX());
  const Vec3 beside(-lowest.y(), lowest.x(), 0.0F);
  return {lowest, beside, -lowest, -beside};
}

bool collide_in_closed_form(const PlacedObject& a, const PlacedObject& b, float margin_m,
                            Manifold& out) noexcept {
  if (collide_as(a, b, margin_m, out)) return true;
  if (collide_as(b, a, margin_m, out)) {
    flip_normals(out);
    return true;
  }
  if (form(a) != CollisionForm::kBox || form(b) != CollisionForm::kBox) return false;
  collide_boxes(box_about(a), box_about(b), margin_m, out);
  return true;
}

}  // namespace thimble::control

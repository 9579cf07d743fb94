#include "control/contact/separations.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "control/bodies/collide.h"

namespace thimble::control {
namespace {

// False when the ball began inside, or when the solid does not matter.
bool separate_convex(const PlacedObject& object, const BallQuery& ball, Separation& out) {
  const auto nearest = object.row->collision->nearest;
  const NearestPlace here = nearest(object.shape, ball.centre_m);
  if (here.outside_m < -ball.radius_m) return false;
  out.apart_m = here.outside_m;
  out.feature = {};
  PlaneChoice choice(ball, out);
  choice.offer_direct(here.normal);
  if (!choice.matters()) return false;
  const NearestPlace there = nearest(object.shape, ball.target_m);
  choice.offer(there.normal, there.outside_m - there.normal.dot(ball.target_m - ball.centre_m));
  if (object.ops->faces != nullptr) {
    std::array<NearestPlace, 3> faces;
    const std::size_t count = object.ops->faces(object.shape, ball.centre_m, faces);
    for (std::size_t i = 0; i < count; ++i) choice.offer_face(faces[i].normal, faces[i].outside_m);
  }
  return choice.matters();
}

}  // namespace

bool Separations::look(const World& world, const Nearby& nearby, const BallQuery& ball,
                       const Held& held) noexcept {
  count = 0;
  free_m = std::numeric_limits<float>::infinity();
  for (const std::uint8_t index : nearby.objects()) {
    ball.work.at(index);
    if (!ball.work.spend(kSolidWork)) return false;
    const PlacedObject& placed = world.objects[index];
    BallQuery local = ball;
    local.triangles = nearby.triangles();
    local.centre_m = placed.to_local(ball.centre_m);
    local.aim_m = placed.to_local(ball.aim_m);
    local.target_m = placed.to_local(ball.target_m);
    for (std::size_t i = 0; i < ball.held_count; ++i) local.held_by[i] = placed.turn_back(ball.held_by[i]);
    for (std::size_t i = 0; i < held.count; ++i)
      if (held.object[i] == index) local.held_features[local.held_feature_count++] = held.feature[i];
    const std::span<Separation> room = std::span(of).subspan(count);
    std::size_t found = 0;
    if (placed.ops->separate != nullptr) {
      found = placed.ops->separate(placed.shape, local, room, free_m);
    } else if (room.empty()) {
      found = 1;
    } else if (separate_convex(placed, local, room[0])) {
      if (placed.ops->feature != nullptr) room[0].feature = placed.ops->feature(placed.shape, room[0].normal);
      found = 1;
    }
    if (found > room.size()) return false;
    for (std::size_t end = count + found; count < end; ++count) {
      of[count].normal = placed.turn(of[count].normal);
      of[count].direct = placed.turn(of[count].direct);
      object[count] = index;
      planes[count] = {of[count].normal, ball.radius_m - of[count].height_m};
    }
  }
  for (std::size_t i = 0; i < count; ++i) {
    if (!of[i].ledge || goes_on(i)) continue;
    of[i].normal = of[i].direct;
    of[i].height_m = of[i].apart_m;
    planes[i] = {of[i].normal, ball.radius_m - of[i].height_m};
  }
  return true;
}

bool Separations::goes_on(std::size_t face) const {
  constexpr float kSame = 0.9999F;
  for (std::size_t i = 0; i < count; ++i) {
    const Separation& other = of[i];
    if (i != face && other.normal.dot(of[face].normal) > kSame &&
        std::abs(other.height_m - of[face].height_m) <= kTouchGap_m &&
        (other.apart_m - other.height_m) * (other.apart_m + other.height_m) <= kFaceMargin_m * kFaceMargin_m)
      return true;
  }
  return false;
}

NearestInside Separations::nearest(const Vec3& way, Work& work) noexcept {
  NearestInside out = nearest_inside(all(), way, work);
  if (out.found) return out;
  for (HalfSpace& plane : std::span(planes).first(count)) plane.offset_m = std::min(plane.offset_m, 0.0F);
  return nearest_inside(all(), way, work);
}

}  // namespace thimble::control

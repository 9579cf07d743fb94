#include "control/contact/tip_ball.h"

#include "control/solids/near_triangles.h"

namespace thimble::control {
namespace {

// Whether the ball, after it has moved, touches all that holds it with the normals of the planes. Then it would not move
// on: nothing else is as near.
bool stands_on(const World& world, const Vec3& centre, const NearestInside& there, const Separations& near,
               float radius_m) {
  for (std::size_t i = 0; i < there.count; ++i) {
    const std::size_t at = there.holding[i];
    const PlacedObject& object = world.objects[near.object[at]];
    if (object.ops->touches == nullptr ||
        !object.ops->touches(object.shape, near.of[at].feature, object.to_local(centre), radius_m,
                             object.turn_back(near.of[at].normal)))
      return false;
  }
  return true;
}

void set_tip_contacts(GodObject& god, const NearestInside& there, const Separations& near) {
  god.position_m = god.centre_m;
  god.count = there.count;
  for (std::size_t i = 0; i < there.count; ++i) {
    const std::size_t at = there.holding[i];
    god.contacts[i] = {near.object[at], near.of[at].feature};
    god.normals[i] = near.of[at].normal;
  }
}

}  // namespace

NearestInside with_plane(const NearestInside& there, std::size_t plane) noexcept {
  NearestInside out = there;
  for (std::size_t i = 0; i < out.count; ++i)
    if (out.holding[i] == plane) return out;
  if (out.count < out.holding.size()) out.holding[out.count++] = plane;
  return out;
}

bool stop_on(const World& world, GodObject& god, const NearestInside& there,
             const Separations& near) noexcept {
  if (there.count == 0 || !stands_on(world, god.centre_m, there, near, world.tip_radius_m)) return false;
  set_tip_contacts(god, there, near);
  return true;
}

void set_tip_contacts(GodObject& god, Separations& near, const Vec3& target, bool hold,
                      float radius_m) noexcept {
  god.position_m = god.centre_m;
  god.count = 0;
  Vec3 way = target - god.centre_m;
  if (hold) {
    way.setZero();
    for (std::size_t i = 0; i < near.count; ++i)
      if (near.touches(i, radius_m)) way -= near.of[i].normal;
    way *= radius_m;
  }
  Work work(kHoldWork);
  const NearestInside there = near.nearest(way, work);
  if (!there.found) return;
  set_tip_contacts(god, there, near);
}

bool is_clear(const World& world, const Nearby& nearby, Work& work, const Vec3& centre,
              const Vec3& target) noexcept {
  if (nearby.triangles() == nullptr || nearby.several()) return false;
  const PlacedObject& object = world.objects[nearby.objects()[0]];
  return nearby.triangles()->is_clear(object.shape, work, object.to_local(centre), world.tip_radius_m,
                                      (target - centre).norm() + kTouchGap_m);
}

bool roll(const World& world, const Nearby& nearby, Work& work, GodObject& god, const Vec3& target,
          bool hold) noexcept {
  if (world.tip_radius_m <= 0.0F || god.count != 1 || nearby.several()) return false;
  const PlacedObject& object = world.objects[god.contacts[0].object];
  if (object.ops->roll == nullptr) return false;
  BallRoll ball{work,
                object.to_local(god.centre_m),
                object.to_local(target),
                world.tip_radius_m,
                hold,
                god.contacts[0].feature,
                {},
                nearby.triangles()};
  if (!object.ops->roll(object.shape, ball)) return false;
  god.centre_m = object.to_world(ball.centre_m);
  god.position_m = god.centre_m;
  god.contacts[0].feature = ball.feature;
  god.normals[0] = object.turn(ball.normal);
  return true;
}

}  // namespace thimble::control

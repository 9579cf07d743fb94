#include "control/contact/find_contact.h"

#include <algorithm>
#include <cstdint>

#include "control/contact/friction.h"
#include "control/contact/planes.h"

namespace thimble::control {
namespace {

// Nothing holds the god object any more. One that flies for longer than a tick, round an edge, has not come to the tip yet: the
// account of its contact goes on.
void let_go(Finger& finger, const Vec3& tip_m) {
  if (finger.rest.position_m == tip_m) {
    finger.account.close();
    finger.shaded.end();
  } else {
    finger.account.tick(kNoBody, tip_m, (finger.rest.position_m - tip_m).norm(), 0.0F, Vec3::Zero(),
                        finger.shaded.took_part(), 0.0F);
  }
  finger.potential.end();
}

// Whether its contacts keep the god object from the tip. Where the work is spent it stays behind, and must not draw the tip back to a
// surface that it has left.
[[gnu::noinline]] bool is_pushed(const World& world, Resting& resting, const GodObject& god,
                                 const Vec3& tip_m) {
  resting.planes_at(world, god);
  return resting.project(tip_m - god.position_m).count != 0;
}

// Whether the stiction point surely stays where it is: several planes of one material hold at least what one would.
bool surely_sticks(const World& world, const Finger& finger, const Vec3& tip_m) {
  const GodObject& rest = finger.rest;
  const std::uint8_t object = finger.god.contacts[0].object;
  const float limit = world.objects[object].material.static_friction;
  return on_one_object(rest, object) && !finger.friction.sliding() &&
         (finger.god.position_m - rest.position_m).squaredNorm() <=
             limit * limit * (rest.position_m - tip_m).squaredNorm();
}

// Moves the place without friction. On a mesh it continues from the previous tick, unless that would be farther from the tip than the
// stiction point: from there the way can be many faces long. Where a point may slip, it begins at the stiction point, so that there is a way
// from there; but not while that takes more than the work of a tick.
void move_rest(const World& world, const Nearby& nearby, Finger& finger, const Vec3& tip_m, bool bodies,
               Effort& effort) {
  const GodObject& god = finger.god;
  GodObject& rest = finger.rest;
  const PlacedObject& object = world.objects[god.contacts[0].object];
  const bool is_point = world.tip_radius_m <= 0.0F;
  if (!world.any_shaded && !bodies && shares_object(rest, god) && object.ops->walks &&
      (!is_point || object.plain)) {
    move(world, nearby, rest, tip_m, false, effort);
    if (shares_object(rest, god) && !is_farther(rest.position_m, god.position_m, tip_m) &&
        (!is_point || finger.stuck > 0 || surely_sticks(world, finger, tip_m)))
      return;
  }
  rest = god;
  move(world, nearby, rest, tip_m, false, effort);
}

// Where the work is spent before the first step of the way is proven free, a shorter way often takes less of it.
constexpr float kShorter = 0.125F;

const Vec3& middle(const GodObject& god) { return god.is_ball ? god.centre_m : god.position_m; }

Vec3 shorter(const GodObject& from, const Vec3& tip_m) {
  return middle(from) + kShorter * (tip_m - middle(from));
}

void fly_towards(const World& world, const Nearby& nearby, GodObject& god, const Vec3& tip_m,
                 Effort& effort) {
  const GodObject before = god;
  fly(world, nearby, god, tip_m, effort);
  if (!effort.work.is_spent() || god.count != 0 || god.position_m != before.position_m) return;
  effort.work.open_reserve();
  god = before;
  fly(world, nearby, god, shorter(before, tip_m), effort);
}

// The same for the place without friction, which moves towards `target_m`, on the way to the tip. Until it is proven free it keeps its contacts.
void move_rest_towards(const World& world, const Nearby& nearby, Finger& finger, const Vec3& target_m,
                       const Vec3& tip_m, bool bodies, Effort& effort) {
  const GodObject& god = finger.god;
  GodObject& rest = finger.rest;
  const GodObject last = rest;
  move_rest(world, nearby, finger, target_m, bodies, effort);
  const bool is_short = target_m != tip_m;
  if (!effort.work.is_spent() && !is_short) return;
  const bool from_last = shares_object(last, god) && !is_farther(last.position_m, god.position_m, tip_m);
  const GodObject& before = from_last ? last : god;
  if (effort.work.is_spent() && rest.position_m == before.position_m) {
    effort.work.open_reserve();
    rest = before;
    move(world, nearby, rest, shorter(before, target_m), false, effort);
  }
  const Vec3& from_m = middle(before);
  const Vec3& to_m = middle(rest);
  if (world.tip_radius_m > 0.0F) {
    // One that has left the surface goes on in the air.
    if (rest.count == 0 && (to_m == from_m || is_farther(to_m, from_m, target_m))) rest = before;
  } else if (rest.count == 0 || (is_short && is_farther(to_m, from_m, tip_m))) {
    rest = before;
  }
}

// A god object looks for what is near its way before it goes. Where that takes more than the work of a tick it would look at the same again in
// each tick, and never go. So it goes a part of the way that gets shorter until the work suffices, and then longer again. A point that comes
// nearer all the same needs no shorter way.
struct Leash {
  static constexpr float kLeast_m = 2.0e-5F;

  Vec3 target_m;
  Vec3 from_m;
  float way_m = 0.0F;

  // is_ball: it may move as one (contact/ball.h).
  Leash(const Finger& finger, const Vec3& tip_m, bool is_ball, Work& work)
      : target_m(tip_m), from_m(leader(finger).position_m) {
    if (!is_ball) return;
    const Vec3 way = tip_m - from_m;
    way_m = way.norm();
    if (way_m > finger.leash_m) target_m = from_m + finger.leash_m / way_m * way;
    if (finger.leash_m <= kLeast_m) work.open_reserve();  // nothing less is left to try
  }
  void fit(Finger& finger, bool is_tip, Work& work) const {
    constexpr float kLess = 0.25F;
    if (way_m == 0.0F) return;
    const bool is_short = way_m > finger.leash_m;
    if (!work.was_spent()) {
      finger.leash_m *= 2.0F;
    } else if (is_tip || leader(finger).position_m == from_m) {
      finger.leash_m = std::max(kLess * std::min(finger.leash_m, way_m), kLeast_m);
    }
    if (is_short) work.exhaust();  // the rest of the way is put off
  }

 private:
  static const GodObject& leader(const Finger& finger) {
    return finger.god.count == 0 ? finger.god : finger.rest;
  }
};

}  // namespace

bool shares_object(const GodObject& a, const GodObject& b) noexcept {
  for (std::size_t i = 0; i < a.count; ++i) {
    for (std::size_t j = 0; j < b.count; ++j) {
      if (a.contacts[i].object == b.contacts[j].object) return true;
    }
  }
  return false;
}

bool find_contact(const World& world, const Nearby& nearby, Finger& finger, const Vec3& tip_m, bool bodies,
                  Effort& effort) noexcept {
  GodObject& god = finger.god;
  GodObject& rest = finger.rest;
  const bool is_tip = world.tip_radius_m > 0.0F;
  const Leash leash(finger, tip_m, is_tip || nearby.several(), effort.work);
  // A new contact: the stiction point is the place where the flight hit the surface (paper, section 3.6).
  if (god.count == 0) fly_towards(world, nearby, god, leash.target_m, effort);
  if (god.count == 0) {
    rest = god;
  } else {
    move_rest_towards(world, nearby, finger, leash.target_m, tip_m, bodies, effort);
  }
  leash.fit(finger, is_tip, effort.work);
  if (effort.work.was_spent() && rest.count != 0 && !is_pushed(world, finger.resting, rest, tip_m)) {
    finger.click.release();
    return false;
  }
  if (rest.count != 0) return true;
  if (god.count != 0) god = rest;
  finger.friction.reset();
  let_go(finger, tip_m);
  finger.click.release();
  return false;
}

}  // namespace thimble::control

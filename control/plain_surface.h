// The fast path of the renderer, for the most common tick: one plain surface holds the god object, and nothing else is near.
#pragma once

#include <cstddef>
#include <optional>

#include "control/contact/damping.h"
#include "control/contact/finger.h"
#include "control/contact/friction.h"
#include "control/contact/nearby.h"
#include "control/contact/passive.h"
#include "control/contact/world.h"
#include "control/renderer_types.h"
#include "control/solids/near_triangles.h"
#include "control/solids/solid.h"
#include "kinematics/vector.h"

namespace thimble::control {

// The scale of the force of one plain surface. pull_m, force_N: in the object's frame.
[[gnu::noinline]] inline float plain_scale(const World& world, Finger& finger, const PlacedObject& object,
                                           const Vec3& tip_m, const Vec3& pull_m, const Vec3& force_N) {
  const float stiffness_N_m = object.material.stiffness_N_m;
  const Vec3 spring_N = stiffness_N_m * (finger.god.position_m - tip_m);
  if (world.any_shaded) finger.shaded.follow(object, tip_m, spring_N, stiffness_N_m, stiffness_N_m, false);
  return passive_scale(finger, kNoBody, tip_m, {pull_m, spring_N, stored_J(force_N, pull_m)}, true);
}

// Looks at all objects: not needed while the tip stays within what was clear.
[[gnu::noinline]] inline bool look_round(const World& world, Finger& finger, std::size_t object,
                                         const Vec3& tip_m, float radius_m) {
  const Clearance now = clearance(world, object, tip_m);
  finger.clearance = world.any_bodies ? Clearance{} : now;
  return now.free_m >= radius_m;
}

// Whether nothing but this object counts in this tick, and shading does not bind its force.
inline bool alone_in_reach(const World& world, Finger& finger, std::size_t object, const Vec3& tip_m) {
  if (finger.inside != 0 || (world.any_shaded && finger.shaded.binds())) return false;
  const float radius_m =
      Reach(finger.god.position_m, finger.rest.position_m, tip_m, world.margin_m).radius_m();
  return finger.clearance.holds(object, tip_m, radius_m) ||
         look_round(world, finger, object, tip_m, radius_m);
}

// The way over one surface from a place in the object's frame: of a point, or of a tip with a radius as a ball (contact/tip_ball.h).
// is_held: false where more can be in the way, or where the surface lets go of it.
struct PointWay {
  static constexpr bool kBall = false;
  Slide slide;

  [[gnu::always_inline]] PointWay(const World& /*world*/, const PlacedObject& object, Feature& feature,
                                  const Vec3& from_m, const Vec3& to_m, bool hold, const GodObject& god,
                                  TriangleCache* triangles, Work& work)
      : slide(object.ops->slide(object.shape, feature,
                                {work, from_m, to_m, hold, false, true,
                                 beside_on(god, god.contacts[0].object), triangles, true})) {}
  [[nodiscard]] bool is_held(const Feature& feature) const {
    return slide.end == SlideEnd::kHeld && slide.swept && feature.kind == 0;
  }
  [[nodiscard]] const Vec3& to_m() const { return slide.to; }
  static bool is_allowed(const PlacedObject& object) { return object.plain; }
  void put(GodObject& god, const PlacedObject& /*object*/) const {
    god.is_ball = false;
  }  // of a mesh with seams
};

struct BallWay {
  static constexpr bool kBall = true;
  BallRoll ball;
  bool rolls;

  // Out of line on every board: one rule of tests/hardware/cortex/firmware.limits is about it.
  [[gnu::noinline]] BallWay(const World& world, const PlacedObject& object, Feature& feature,
                            const Vec3& from_m, const Vec3& to_m, bool hold, const GodObject& /*god*/,
                            TriangleCache* triangles, Work& work)
      : ball{work, from_m, to_m, world.tip_radius_m, hold, feature, {}, triangles},
        rolls(object.ops->roll(object.shape, ball)) {
    feature = ball.feature;
  }
  [[nodiscard]] bool is_held(const Feature& /*feature*/) const { return rolls; }
  [[nodiscard]] const Vec3& to_m() const { return ball.centre_m; }
  static bool is_allowed(const PlacedObject& object) { return object.rolls; }
  void put(GodObject& god, const PlacedObject& object) const {
    god.is_ball = true;
    god.centre_m = god.position_m;
    god.normals[0] = object.turn(ball.normal);
  }
};

// The fast path. It gives the forces of Renderer::touch() (tests/property/control/renderer_paths_test.cpp),
// except that on a mesh rest continues from its place in the previous tick while the tip sticks. In every
// other case it returns false and changes nothing.
template <typename Way>
[[gnu::always_inline]] inline bool touch_one_plain_surface(const World& world, Finger& finger, const Tip& tip,
                                                           float period_s, TriangleCache* triangles,
                                                           Work& work, Touch& touch) {
  GodObject& god = finger.god;
  if (god.count != 1 || finger.rest.count != 1) return false;
  Contact& contact = god.contacts[0];
  if (finger.rest.contacts[0].object != contact.object) return false;
  const PlacedObject& object = world.objects[contact.object];
  if (!Way::is_allowed(object)) return false;
  if (world.count > 1) {
    if (!alone_in_reach(world, finger, contact.object, tip.position_m)) return false;
    if constexpr (!Way::kBall)
      if (!object.shape.mesh.seams) god.is_ball = finger.rest.is_ball = false;
  }
  const Vec3 x = object.to_local(tip.position_m);
  const Vec3 stuck = object.to_local(god.position_m);
  const Material& m = object.material;
  // On a mesh, rest continues from its place in the previous tick: the path from the stiction point can be
  // many faces long.
  const bool walks = object.ops->walks;
  Feature feature = walks ? finger.rest.contacts[0].feature : contact.feature;
  std::optional<Way> rest(std::in_place, world, object, feature,
                          walks ? object.to_local(finger.rest.position_m) : stuck, x, false, finger.rest,
                          triangles, work);
  if (!rest->is_held(feature)) return false;
  Vec3 at = stuck;
  if (m.static_friction > 0.0F) {
    // A test on squares, without a root: most ticks stick.
    const float limit2 = m.static_friction * m.static_friction;
    if (finger.friction.sliding() ||
        (stuck - rest->to_m()).squaredNorm() > limit2 * (rest->to_m() - x).squaredNorm() ||
        (walks && is_farther(rest->to_m(), stuck, x))) {
      // It may slip: then rest is the end of a slide that starts at the stiction point.
      if (walks) {
        feature = contact.feature;
        rest.emplace(world, object, feature, stuck, x, false, god, triangles, work);
        if (!rest->is_held(feature)) return false;
      }
      Friction friction = finger.friction;
      const Slip slip =
          friction.tick(friction_limits(m, (rest->to_m() - x).norm()), stuck - rest->to_m(), period_s);
      if (slip.slips) {
        Feature slipped_feature = contact.feature;
        const Way slipped(world, object, slipped_feature, stuck, rest->to_m() + slip.offset_m, true, god,
                          triangles, work);
        if (!slipped.is_held(slipped_feature) || !loosens(slipped.to_m(), stuck, rest->to_m(), x))
          return false;
        contact.feature = slipped_feature;
        at = slipped.to_m();
        god.position_m = object.to_world(at);
        if constexpr (Way::kBall) slipped.put(god, object);
      }
      finger.friction = friction;
    }
  } else {
    at = rest->to_m();
    contact.feature = feature;
    god.position_m = object.to_world(at);
    if constexpr (Way::kBall) rest->put(god, object);
  }
  if (walks) {
    if constexpr (!Way::kBall) rest->put(god, object);
    finger.rest.position_m = object.to_world(rest->to_m());
    finger.rest.contacts[0].feature = feature;
    rest->put(finger.rest, object);
  }
  Vec3 force = m.stiffness_N_m * (at - x);
  if (!world.one_potential) force *= plain_scale(world, finger, object, tip.position_m, at - x, force);
  const Vec3 pull = rest->to_m() - x;
  if (const float depth = pull.norm(); m.damping_N_s_m > 0.0F && depth > 0.0F) {
    const Vec3 normal = pull / depth;
    const float speed = object.turn_back(tip.velocity_m_s).dot(normal);
    force += damping_force_N(m.stiffness_N_m * depth, m.damping_N_s_m, speed) * normal;
  }
  touch.force_N = object.turn(force);
  touch.god_object_m = god.position_m;
  touch.contacts = 1;
  return true;
}

// The same for a tip with a radius. It is in a file of its own, so that the point's copy is inlined alone, and a board of little code memory
// can have this one small.
[[nodiscard]] bool roll_on_one_plain_surface(const World& world, Finger& finger, const Tip& tip,
                                             float period_s, TriangleCache* triangles, Work& work,
                                             Touch& touch) noexcept;

}  // namespace thimble::control

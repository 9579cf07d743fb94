#include "control/renderer.h"

#include <algorithm>
#include <cmath>

#include "control/contact/damping.h"
#include "control/surfaces/surfaces.h"

namespace thimble::control {
namespace {

// Force shading in two passes (Ruspini et al. 1997): the plane with the interpolated normal, then the true
// surface. The error of the god object against the shaded surface falls in each round by the ratio of depth
// to radius of curvature.
constexpr int kShadingRounds = 3;

// The interpolated normal at the god object, when exactly one solid holds it, if by several facets, and that one is
// shaded.
bool shaded_normal(const World& world, const GodObject& god, Vec3& normal) {
  if (god.count == 0) return false;
  const PlacedObject& object = world.objects[god.contacts[0].object];
  for (std::size_t i = 1; i < god.count; ++i)
    if (god.contacts[i].object != god.contacts[0].object) return false;
  if (!object.shaded) return false;
  if (!object.ops->shaded_normal(object.shape, god.contacts[0].feature, object.to_local(god.position_m),
                                 normal))
    return false;
  normal = object.turn(normal);
  return true;
}

// Moves the frictionless god object to its place on the shaded surface. False where nothing is shaded.
bool shade(const World& world, const Nearby& nearby, GodObject& god, const Vec3& tip,
           RenderCounters& counters, Vec3& normal) {
  for (int round = 0; round < kShadingRounds; ++round) {
    if (!shaded_normal(world, god, normal)) return false;
    const Vec3 on_plane = tip - normal * (tip - god.position_m).dot(normal);
    move(world, nearby, god, on_plane, true, counters);
  }
  return shaded_normal(world, god, normal);
}

// F = sum K lambda n, with each object's own K.
Vec3 spring_force(const Constraints& held) {
  Vec3 force = Vec3::Zero();
  for (std::size_t i = 0; i < held.count; ++i) {
    force += (held.list[i].material.stiffness_N_m * held.list[i].lambda_m) * held.list[i].normal;
  }
  return force;
}

// The velocity of the tip relative to the object's material at the god object.
Vec3 relative_velocity(const PlacedObject& object, const Bodies& bodies, const Vec3& at,
                       const Vec3& velocity) {
  return object.body == kNoBody ? velocity : Vec3(velocity - bodies.velocity_at(object.body, at));
}

Vec3 damping_force(const World& world, const Bodies& bodies, const Constraint& c, const Vec3& at,
                   const Vec3& velocity) {
  const Material& m = c.material;
  const float speed = relative_velocity(world.objects[c.object], bodies, at, velocity).dot(c.normal);
  return damping_force_N(m.stiffness_N_m * c.lambda_m, m.damping_N_s_m, speed) * c.normal;
}

// Applies to every moving object in contact the opposite of its force on the finger: spring and damping along
// its own normal, and its share of the rest (friction, effects of surfaces), in proportion to its static
// friction limit.
void push_back(const World& world, Bodies& bodies, const Constraints& held, const Vec3& at,
               const Vec3& velocity, const Vec3& force) {
  std::array<Vec3, kMaxContacts> own;
  std::array<float, kMaxContacts> holds;
  Vec3 rest = force;
  float all = 0.0F;
  for (std::size_t i = 0; i < held.count; ++i) {
    const Constraint& c = held.list[i];
    const Material& m = c.material;
    const float push = m.stiffness_N_m * c.lambda_m;
    own[i] = push * c.normal + damping_force(world, bodies, c, at, velocity);
    rest -= own[i];
    holds[i] = m.static_friction * push;
    all += holds[i];
  }
  for (std::size_t i = 0; i < held.count; ++i) {
    const PlacedObject& object = world.objects[held.list[i].object];
    if (object.body == kNoBody) continue;
    const float share = all > 0.0F ? holds[i] / all : 1.0F / static_cast<float>(held.count);
    bodies.push(object.body, at, held.count == 1 ? Vec3(-force) : Vec3(-own[i] - share * rest));
  }
}

// The object in whose frame the energy account counts the work. Work on a moving object is counted relative to
// that object. Null between objects that move differently: there is no such frame.
const PlacedObject* account_frame(const World& world, const Constraints& held) {
  if (held.count == 0) return nullptr;
  const PlacedObject& first = world.objects[held.list[0].object];
  for (std::size_t i = 1; i < held.count; ++i) {
    if (world.objects[held.list[i].object].body != first.body) return nullptr;
  }
  return &first;
}

// What the spring of a contact does: the force without damping, and the energy that it returns when it is let go.
struct Spring {
  Vec3 pull_m;  // from the tip to what pulls it
  Vec3 force_N;
  float stored_J;
};

// The scale of the spring force, 0 to 1, with which no closed path of the tip gains energy. All is in the frame of
// `body`. gradient: the force is that of the potential that holds the tip since the contact began.
[[gnu::always_inline]] inline float passive_scale(Finger& finger, std::uint8_t body, const Vec3& tip_m,
                                                  const Spring& spring, bool gradient) {
  if (!gradient || !finger.account.exact(body))
    return finger.account.tick(body, tip_m, spring.pull_m.norm(), spring.stored_J, spring.force_N);
  finger.account.follow(body, tip_m, spring.stored_J, spring.force_N);
  return 1.0F;
}

// gradient: each contact's force is the gradient of a potential.
float passive_scale(const World& world, Finger& finger, const Constraints& held, const Vec3& tip_m,
                    const Spring& spring, bool gradient) {
  const PlacedObject* frame = account_frame(world, held);
  if (frame == nullptr) {
    finger.account.close();
    finger.potential.end();
    return 1.0F;
  }
  const bool moves = frame->body != kNoBody;
  const Vec3 at = moves ? frame->to_local(tip_m) : tip_m;
  const bool goes_on =
      finger.potential.stays(held) || finger.potential.goes_on(held, finger.account.step_m(frame->body, at));
  if (!moves) return passive_scale(finger, kNoBody, at, spring, gradient && goes_on);
  return passive_scale(finger, frame->body, at,
                       {spring.pull_m, frame->turn_back(spring.force_N), spring.stored_J},
                       gradient && goes_on);
}

// Of one spring: force times stretch, halved. A shaded normal can turn it against the pull.
float stored_J(const Vec3& force_N, const Vec3& pull_m) { return 0.5F * std::max(force_N.dot(pull_m), 0.0F); }

// Nothing holds the god object any more. One that flies for longer than a tick, round an edge, has not come to the tip yet: the
// account of its contact goes on.
void let_go(Finger& finger, const Vec3& tip_m) {
  if (finger.rest.position_m == tip_m) {
    finger.account.close();
  } else {
    finger.account.tick(kNoBody, tip_m, (finger.rest.position_m - tip_m).norm(), 0.0F, Vec3::Zero());
  }
  finger.potential.end();
}

bool unlike_stiffness(const Constraints& held) {
  for (std::size_t i = 1; i < held.count; ++i)
    if (held.list[i].material.stiffness_N_m != held.list[0].material.stiffness_N_m) return true;
  return false;
}

bool any_surfaced(const World& world, const Constraints& held) {
  for (std::size_t i = 0; i < held.count; ++i) {
    if (world.objects[held.list[i].object].surfaced) return true;
  }
  return false;
}

bool shares_object(const GodObject& a, const GodObject& b) {
  for (std::size_t i = 0; i < a.count; ++i) {
    for (std::size_t j = 0; j < b.count; ++j) {
      if (a.contacts[i].object == b.contacts[j].object) return true;
    }
  }
  return false;
}

// Friction can only increase the distance to the tip. A rest position farther from the tip than the stiction
// point does not belong to this contact.
bool is_farther(const Vec3& rest, const Vec3& stuck, const Vec3& tip) {
  constexpr float kRounding2 = 1.0F + 2.0e-5F;
  return (rest - tip).squaredNorm() > kRounding2 * (stuck - tip).squaredNorm();
}

// The fast path for the most common tick: one plain surface holds the god object, and no other object is
// within reach. It gives the forces of Renderer::touch() (tests/property/control/renderer_paths_test.cpp),
// except that on a mesh rest continues from its place in the previous tick while the tip sticks. In every
// other case it returns false and changes nothing.
[[gnu::always_inline]] inline bool touch_one_plain_surface(const World& world, Finger& finger, const Tip& tip,
                                                           float period_s, Touch& touch) {
  GodObject& god = finger.god;
  if (god.count != 1 || finger.rest.count != 1) return false;
  Contact& contact = god.contacts[0];
  if (finger.rest.contacts[0].object != contact.object) return false;
  const PlacedObject& object = world.objects[contact.object];
  if (!object.plain) return false;
  if (world.count > 1) {
    const Reach reach(god, finger.rest, tip.position_m);
    for (std::size_t i = 0; i < world.count; ++i) {
      if (i != contact.object && reach.meets(world.objects[i])) return false;
    }
    god.is_ball = finger.rest.is_ball = false;
  }
  const Vec3 x = object.to_local(tip.position_m);
  const Vec3 stuck = object.to_local(god.position_m);
  const Material& m = object.material;
  // On a mesh, rest continues from its place in the previous tick: the path from the stiction point can be
  // many faces long.
  const bool walks = object.ops->walks;
  Feature feature = walks ? finger.rest.contacts[0].feature : contact.feature;
  Slide rest = object.ops->slide(object.shape, feature,
                                 walks ? object.to_local(finger.rest.position_m) : stuck, x, {});
  if (rest.end != SlideEnd::kHeld || !rest.swept || feature.kind != 0) return false;
  Vec3 at = rest.to;
  if (m.static_friction > 0.0F) {
    at = stuck;
    // A test on squares, without a root: most ticks stick.
    const float limit2 = m.static_friction * m.static_friction;
    if (finger.friction.sliding() || (stuck - rest.to).squaredNorm() > limit2 * (rest.to - x).squaredNorm() ||
        (walks && is_farther(rest.to, stuck, x))) {
      // It may slip: then rest is the end of a slide that starts at the stiction point.
      feature = contact.feature;
      rest = object.ops->slide(object.shape, feature, stuck, x, {});
      if (rest.end != SlideEnd::kHeld || !rest.swept || feature.kind != 0) return false;
      Friction friction = finger.friction;
      const Slip slip = friction.tick(friction_limits(m, (rest.to - x).norm()), stuck - rest.to, period_s);
      if (slip.slips) {
        Feature slipped_feature = contact.feature;
        const Slide slipped =
            object.ops->slide(object.shape, slipped_feature, stuck, rest.to + slip.offset_m, {.hold = true});
        if (slipped.end != SlideEnd::kHeld || !slipped.swept || !loosens(slipped.to, stuck, rest.to, x))
          return false;
        contact.feature = slipped_feature;
        at = slipped.to;
        god.position_m = object.to_world(at);
      }
      finger.friction = friction;
    }
  } else {
    contact.feature = feature;
    god.position_m = object.to_world(at);
  }
  if (walks) {
    finger.rest.position_m = object.to_world(rest.to);
    finger.rest.contacts[0].feature = feature;
  }
  const Vec3 pull = rest.to - x;
  Vec3 force = m.stiffness_N_m * (at - x);
  if (!world.one_potential) {
    const Vec3 spring_N = m.stiffness_N_m * (god.position_m - tip.position_m);
    force *=
        passive_scale(finger, kNoBody, tip.position_m, {at - x, spring_N, stored_J(force, at - x)}, true);
  }
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

}  // namespace

void Renderer::bind(const SceneView& scene, Binding binding) noexcept {
  if (binding == Binding::kKeepState) {
    world_.apply_materials(scene);
    fields_.apply_materials(scene);
    bodies_.apply_materials(scene);
    // The energy stored with the old stiffness is not what the new one returns.
    for (Finger& finger : fingers_) finger.account.close();
    return;
  }
  world_.bind(scene);
  fields_.bind(scene);
  bodies_.bind(scene, world_);
  counters_ = {};
  reset();
}

void Renderer::reset() noexcept {
  fingers_ = {};
  fields_.reset();
}

void Renderer::use_general_path_only() noexcept {
  for (PlacedObject& object : world_.objects) object.plain = false;
}

void Renderer::tick(std::span<const Tip> tips, float period_s, std::span<Touch> touches) noexcept {
  const std::size_t count = std::min(tips.size(), kMaxArms);
  for (std::size_t i = 0; i < count; ++i) {
    if (!touch_one_plain_surface(world_, fingers_[i], tips[i], period_s, touches[i]))
      touch(fingers_[i], tips[i], period_s, touches[i]);
    if (fields_.count() != 0) fields_.tick(i, tips[i], period_s, touches[i]);
  }
  if (!bodies_.empty()) bodies_.step(world_, std::span(fingers_).first(count), period_s, counters_);
}

void Renderer::touch(Finger& finger, const Tip& tip, float period_s, Touch& touch) noexcept {
  const Vec3& x = tip.position_m;
  GodObject& god = finger.god;
  GodObject& rest = finger.rest;
  if (!finger.started) {
    finger.started = true;
    god.position_m = x;
    rest = god;
  }
  const Nearby nearby(world_, Reach(god, rest, x));

  // A new contact: the stiction point is the place where the flight hit the surface (paper, section 3.6).
  if (god.count == 0) fly(world_, nearby, god, x, counters_);
  // The place of the god object without friction, and its contact constraints there.
  rest = god;
  if (god.count != 0) move(world_, nearby, rest, x, false, counters_);
  if (rest.count == 0) {
    if (god.count != 0) god = rest;
    finger.friction.reset();
    let_go(finger, x);
    finger.click.release();
    touch = {Vec3::Zero(), god.position_m, 0};
    return;
  }
  Constraints held = constraints(world_, rest, x);
  Vec3 normal;
  const bool shaded = shade(world_, nearby, rest, x, counters_, normal);
  if (shaded) {
    held.count = 1;
    const std::uint8_t object = rest.contacts[0].object;
    held.list[0] = {object, normal, std::max((rest.position_m - x).dot(normal), 0.0F),
                    world_.objects[object].material};
  }
  const bool surfaced = any_surfaced(world_, held);
  SurfaceTouch surface;
  if (surfaced) surface = apply_surfaces(world_, rest, x, held);

  if (!shares_object(rest, god)) god = rest;  // on another surface there is no stiction point yet
  const FrictionLimits limits = friction_limits(held);
  Vec3 force = spring_force(held) + surface.along_N;
  Vec3 friction_N = Vec3::Zero();
  if (limits.static_m > 0.0F) {
    const Slip slip = finger.friction.tick(limits, god.position_m - rest.position_m, period_s);
    if (slip.slips) {
      const Vec3 stuck_m = god.position_m;
      const bool one = shaded || rest.count == 1;
      move(world_, nearby, god, (one ? rest.position_m : x) + slip.offset_m, one, counters_);
      // A shaded rest position is not the point nearest to the tip; the energy account below covers what such
      // a slip could give.
      const Vec3& nearest_to_m = shaded ? rest.position_m : x;
      if (god.count == 0 || !loosens(god.position_m, stuck_m, rest.position_m, nearest_to_m)) god = rest;
    }
    friction_N = limits.stiffness_N_m * (god.position_m - rest.position_m);
    force += friction_N;
  } else {
    god = rest;
  }

  if (!world_.one_potential) {
    const Vec3 pull = god.position_m - surface.sunk_m - x;
    const float energy_J = unlike_stiffness(held) ? spring_energy_J(held) +
                                                        stored_J(friction_N, god.position_m - rest.position_m)
                                                  : stored_J(force, pull);
    force *= passive_scale(world_, finger, held, x, {pull, force, energy_J}, !shaded && surface.potential);
  }
  Vec3 damping = Vec3::Zero();
  for (std::size_t i = 0; i < held.count; ++i)
    damping += damping_force(world_, bodies_, held.list[i], god.position_m, tip.velocity_m_s);
  force += damping;
  if (surfaced && held.count > 0) {
    const PlacedObject& met = world_.objects[held.list[0].object];
    const Vec3 velocity = relative_velocity(met, bodies_, god.position_m, tip.velocity_m_s);
    force += finger.click.tick(world_, held, {x, velocity}, damping, period_s);
  } else {
    finger.click.release();
  }
  if (!bodies_.empty()) push_back(world_, bodies_, held, god.position_m, tip.velocity_m_s, force);
  touch = {force, god.position_m, static_cast<std::uint8_t>(held.count)};
}

}  // namespace thimble::control

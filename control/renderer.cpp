#include "control/renderer.h"

#include <algorithm>
#include <cmath>

#include "control/contact/damping.h"
#include "control/contact/reaction.h"
#include "control/contact/shading.h"
#include "control/surfaces/surfaces.h"

namespace thimble::control {
namespace {

// F = sum K lambda n, with each object's own K.
Vec3 spring_force(const Constraints& held) {
  Vec3 force = Vec3::Zero();
  for (std::size_t i = 0; i < held.count; ++i) {
    force += (held.list[i].material.stiffness_N_m * held.list[i].lambda_m) * held.list[i].normal;
  }
  return force;
}

// The object in whose frame the energy account counts the work. Work on a moving object is counted relative to
// that object. Null between objects that move differently: there is no such frame. rest: the god object, in contact; above a
// relief nothing holds it back, and the contact goes on.
const PlacedObject* account_frame(const World& world, const GodObject& rest, const Constraints& held) {
  const PlacedObject& first = world.objects[held.count == 0 ? rest.contacts[0].object : held.list[0].object];
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
  float falls = 0.0F;  // EnergyAccount::tick()
};

// The scale of the spring force, 0 to 1, with which no closed path of the tip gains energy. All is in the frame of
// `body`. gradient: the force is that of the potential that holds the tip since the contact began.
[[gnu::always_inline]] inline float passive_scale(Finger& finger, std::uint8_t body, const Vec3& tip_m,
                                                  const Spring& spring, bool gradient) {
  if (!gradient || !finger.account.exact(body))
    return finger.account.tick(body, tip_m, spring.pull_m.norm(), spring.stored_J, spring.force_N,
                               finger.shaded.took_part(), spring.falls);
  finger.account.follow(body, tip_m, spring.stored_J, spring.force_N);
  return 1.0F;
}

// gradient: each contact's force is the gradient of a potential.
float passive_scale(const World& world, Finger& finger, const Constraints& held, const Vec3& tip_m,
                    const Spring& spring, bool gradient) {
  const PlacedObject* frame = account_frame(world, finger.rest, held);
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
                       {spring.pull_m, frame->turn_back(spring.force_N), spring.stored_J, spring.falls},
                       gradient && goes_on);
}

// Of one spring: force times stretch, halved. A shaded normal can turn it against the pull.
float stored_J(const Vec3& force_N, const Vec3& pull_m) { return 0.5F * std::max(force_N.dot(pull_m), 0.0F); }

// The springs of a contact in a scene with shaded meshes, before the effects of surfaces.
struct ShadedSprings {
  const PlacedObject* frame = nullptr;
  Vec3 felt_N = Vec3::Zero();
  Vec3 late_N = Vec3::Zero();  // the part of it that is not the force of the springs as they stand
  float stiffness_N_m = 1.0F;  // felt_N over this is the pull
};

// facets_m: where the god object would be without shading. Shading that has given the hand much energy is faded out, as far
// as the account holds its force back: the facets themselves give none.
ShadedSprings shaded_springs(const World& world, Finger& finger, const Constraints& held, const Vec3& tip_m,
                             const Vec3& facets_m, bool shaded) {
  const FrictionLimits limits = friction_limits(held);
  const bool sticks = limits.static_m > 0.0F;
  const float mean_N_m =
      limits.stiffness_N_m > 0.0F ? limits.stiffness_N_m : held.list[0].material.stiffness_N_m;
  Vec3 springs_N = spring_force(held);
  if (sticks) springs_N += limits.stiffness_N_m * (finger.god.position_m - finger.rest.position_m);
  const PlacedObject* frame = account_frame(world, finger.rest, held);
  if (frame == nullptr) {
    finger.shaded.end();
    return {nullptr, springs_N, Vec3::Zero(), mean_N_m};
  }
  float stiffest_N_m = 0.0F;
  bool on_shaded = false;  // also where two solids hold the god object, and neither is shaded there
  for (std::size_t i = 0; i < held.count; ++i) {
    stiffest_N_m = std::max(stiffest_N_m, held.list[i].material.stiffness_N_m);
    on_shaded = on_shaded || world.objects[held.list[i].object].shaded;
  }
  Vec3 wanted_N = springs_N;
  if (shaded) {
    constexpr float kFacets = 0.15F;
    constexpr float kShaded = 0.4F;
    const float part = std::clamp((finger.account.scale() - kFacets) / (kShaded - kFacets), 0.0F, 1.0F);
    const Vec3 facets_N = stiffest_N_m * ((sticks ? finger.god.position_m : facets_m) - tip_m);
    wanted_N = facets_N + part * (springs_N - facets_N);
  }
  const Vec3 felt_N = finger.shaded.follow(*frame, tip_m, wanted_N, stiffest_N_m, mean_N_m, on_shaded);
  return {frame, felt_N, felt_N - springs_N, finger.shaded.mean_N_m()};
}

// The stiction point has slipped. Returns what the felt force lacks of the springs' change.
Vec3 slip_shaded(Finger& finger, ShadedSprings& springs, const Constraints& held,
                 const FrictionLimits& limits, const Vec3& slipped_m) {
  const Vec3 by_N = limits.stiffness_N_m * slipped_m;
  const float felt_N = springs.felt_N.norm();
  const float normal_N = std::max(spring_force(held).norm(), felt_N);
  const float breaks = limits.stiffness_N_m * (limits.static_m - limits.dynamic_m) / normal_N;
  const Vec3 change_N = finger.shaded.slip(*springs.frame, by_N, breaks * felt_N);
  springs.felt_N += change_N;
  return change_N - by_N;
}

bool unlike_stiffness(const Constraints& held) {
  for (std::size_t i = 1; i < held.count; ++i)
    if (held.list[i].material.stiffness_N_m != held.list[0].material.stiffness_N_m) return true;
  return false;
}

struct StaticForce {
  Vec3 tip_m;
  Vec3 force_N;
  Vec3 friction_N;  // the part of it that is friction
  const SurfaceTouch& surface;
  bool surfaced;
};

Spring spring_of(const Finger& finger, const Constraints& held, const ShadedSprings& springs,
                 const StaticForce& felt) {
  // With shading from the force, which is continuous there.
  const bool continuous = finger.shaded.took_part();
  const Vec3& sunk_m = felt.surface.sunk_m;
  const Vec3 pull = continuous ? Vec3(springs.felt_N / springs.stiffness_N_m - sunk_m)
                               : Vec3(finger.god.position_m - sunk_m - felt.tip_m);
  const float energy_J =
      unlike_stiffness(held) && !continuous
          ? spring_energy_J(held) + stored_J(felt.friction_N, finger.god.position_m - finger.rest.position_m)
          : stored_J(felt.force_N - felt.surface.along_N, pull);
  // With effects of surfaces U is less smooth.
  const float falls = !finger.shaded.bound() ? 0.0F : felt.surfaced ? 3.0F : 1.0F;
  return {pull, felt.force_N, energy_J, falls};
}

void begin(const World& world, Finger& finger, const Vec3& tip_m, RenderCounters& counters) {
  finger.started = true;
  finger.god.position_m = tip_m;
  finger.rest = finger.god;
  finger.inside = solids_around(world, ~SolidSet{0}, tip_m, counters);
}

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

// A solid is felt again when neither the tip nor the god object is in it. While another solid holds the god object, it can
// be in there for longer than the tip.
[[gnu::noinline]] void update_inside(const World& world, Finger& finger, const Vec3& tip_m,
                                     RenderCounters& counters) {
  SolidSet still = solids_around(world, finger.inside, tip_m, counters);
  for (const Vec3& at : {finger.god.position_m, finger.rest.position_m})
    still |= solids_around(world, finger.inside & ~still, at, counters);
  finger.inside = still;
}

// Moves the place without friction. That of a sphere on a mesh continues from the previous tick, unless that would be
// farther from the tip than the stiction point: from there the way can be many faces long.
void move_rest(const World& world, const Nearby& nearby, Finger& finger, const Vec3& tip_m, bool bodies,
               RenderCounters& counters) {
  const GodObject& god = finger.god;
  GodObject& rest = finger.rest;
  if (world.tip_radius_m > 0.0F && !world.any_shaded && !bodies && shares_object(rest, god) &&
      world.objects[god.contacts[0].object].ops->walks) {
    move(world, nearby, rest, tip_m, false, counters);
    if (shares_object(rest, god) && !is_farther(rest.position_m, god.position_m, tip_m)) return;
  }
  rest = god;
  move(world, nearby, rest, tip_m, false, counters);
}

// The scale of the force of one plain surface. pull_m, force_N: in the object's frame.
[[gnu::noinline]] float plain_scale(const World& world, Finger& finger, const PlacedObject& object,
                                    const Vec3& tip_m, const Vec3& pull_m, const Vec3& force_N) {
  const float stiffness_N_m = object.material.stiffness_N_m;
  const Vec3 spring_N = stiffness_N_m * (finger.god.position_m - tip_m);
  if (world.any_shaded) finger.shaded.follow(object, tip_m, spring_N, stiffness_N_m, stiffness_N_m, false);
  return passive_scale(finger, kNoBody, tip_m, {pull_m, spring_N, stored_J(force_N, pull_m)}, true);
}

// Whether nothing but this object counts in this tick, and shading does not bind its force.
[[gnu::noinline]] bool alone_in_reach(const World& world, Finger& finger, std::size_t object,
                                      const Vec3& tip_m) {
  if (finger.inside != 0 || (world.any_shaded && finger.shaded.binds())) return false;
  GodObject& god = finger.god;
  const Reach reach(god.position_m, finger.rest.position_m, tip_m, world.margin_m);
  for (std::size_t i = 0; i < world.count; ++i)
    if (i != object && reach.meets(world.objects[i])) return false;
  if (!world.objects[object].shape.mesh.seams) god.is_ball = finger.rest.is_ball = false;
  return true;
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
  if (world.count > 1 && !alone_in_reach(world, finger, contact.object, tip.position_m)) return false;
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
    god.is_ball = finger.rest.is_ball = false;  // of a mesh with seams
    finger.rest.position_m = object.to_world(rest.to);
    finger.rest.contacts[0].feature = feature;
  }
  const Vec3 pull = rest.to - x;
  Vec3 force = m.stiffness_N_m * (at - x);
  if (!world.one_potential) force *= plain_scale(world, finger, object, tip.position_m, at - x, force);
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
    for (Finger& finger : fingers_) {
      finger.account.close();
      finger.shaded.end();
    }
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
  for (TriangleCache& triangles : triangles_) triangles.clear();
  fields_.reset();
}

std::uint64_t Renderer::inside_in_image(SolidSet inside) const noexcept {
  std::uint64_t in_image = 0;
  for (std::size_t i = 0; i < world_.count; ++i)
    if ((inside & only(i)) != 0) in_image |= std::uint64_t{1} << world_.objects[i].in_image;
  return in_image;
}

void Renderer::use_general_path_only() noexcept {
  for (PlacedObject& object : world_.objects) object.plain = false;
}

void Renderer::tick(std::span<const Tip> tips, float period_s, std::span<Touch> touches) noexcept {
  const std::size_t count = std::min(tips.size(), kMaxArms);
  for (std::size_t i = 0; i < count; ++i) {
    Finger& finger = fingers_[i];
    if (!touch_one_plain_surface(world_, finger, tips[i], period_s, touches[i])) {
      touch(finger, tips[i], period_s, touches[i]);
      if (finger.inside != 0) update_inside(world_, finger, tips[i].position_m, counters_);
    }
    if (fields_.count() != 0) fields_.tick(i, tips[i], period_s, touches[i]);
  }
  if (bodies_.empty()) return;
  if (fields_.count() != 0) fields_.press(world_, period_s, bodies_);
  bodies_.step(world_, std::span(fingers_).first(count), period_s, counters_);
}

void Renderer::touch(Finger& finger, const Tip& tip, float period_s, Touch& touch) noexcept {
  const Vec3& x = tip.position_m;
  GodObject& god = finger.god;
  GodObject& rest = finger.rest;
  if (!finger.started) begin(world_, finger, x, counters_);
  const Nearby nearby(world_, Reach(god.position_m, rest.position_m, x, world_.margin_m), finger.inside,
                      lists_ ? &triangles_[static_cast<std::size_t>(&finger - fingers_.data())] : nullptr);

  // A new contact: the stiction point is the place where the flight hit the surface (paper, section 3.6).
  if (god.count == 0) fly(world_, nearby, god, x, counters_);
  // The place of the god object without friction, and its contact constraints there.
  if (god.count == 0) {
    rest = god;
  } else {
    move_rest(world_, nearby, finger, x, !bodies_.empty(), counters_);
  }
  if (rest.count == 0) {
    if (god.count != 0) god = rest;
    finger.friction.reset();
    let_go(finger, x);
    finger.click.release();
    touch = {Vec3::Zero(), god.position_m, 0};
    return;
  }
  Constraints held = constraints(world_, rest, x);
  const Vec3 facets_m = rest.position_m;
  const bool shaded = shade(world_, nearby, rest, x, held, counters_);
  if (!shares_object(rest, god)) god = rest;  // on another surface there is no stiction point yet
  ShadedSprings springs;
  if (world_.any_shaded) springs = shaded_springs(world_, finger, held, x, facets_m, shaded);
  const bool surfaced = any_surfaced(world_, held);
  const bool effects = springs.frame != nullptr && (surfaced || finger.shaded.has_effect());
  const Vec3 plain_N = effects ? spring_force(held) : Vec3(Vec3::Zero());
  const SurfaceTouch surface = surfaced ? apply_surfaces(world_, rest, x, held) : SurfaceTouch{};

  const FrictionLimits limits = friction_limits(held);
  Vec3 force = spring_force(held) + surface.along_N;
  if (effects) force += finger.shaded.effect(*springs.frame, force - plain_N);
  force += springs.late_N;
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
      if (springs.frame != nullptr)
        force += slip_shaded(finger, springs, held, limits, god.position_m - stuck_m);
    }
    friction_N = limits.stiffness_N_m * (god.position_m - rest.position_m);
    force += friction_N;
  } else {
    god = rest;
  }

  if (!world_.one_potential) {
    const Spring spring = spring_of(finger, held, springs, {x, force, friction_N, surface, surfaced});
    force *= passive_scale(world_, finger, held, x, spring, !shaded && surface.potential);
  }
  const Vec3 damping = damping_force(world_, bodies_, held, god.position_m, tip.velocity_m_s);
  force +=
      damping + damping_along(world_, bodies_, finger, held, tip.velocity_m_s, friction_N, limits, period_s);
  if (surfaced && held.count > 0) {
    const PlacedObject& met = world_.objects[held.list[0].object];
    const Vec3 velocity =
        relative_velocity(met, bodies_, god.position_m + held.list[0].to_place_m, tip.velocity_m_s);
    force += finger.click.tick(world_, held, {x, velocity}, damping, period_s);
  } else {
    finger.click.release();
  }
  const auto index = static_cast<std::uint8_t>(&finger - fingers_.data());
  if (!bodies_.empty()) push_back(world_, bodies_, index, held, god.position_m, tip.velocity_m_s, force);
  touch = {force, god.position_m, static_cast<std::uint8_t>(held.count)};
}

}  // namespace thimble::control

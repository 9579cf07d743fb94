#include "control/renderer.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "control/contact/find_contact.h"
#include "control/contact/free_flight.h"
#include "control/contact/passive.h"
#include "control/contact/reaction.h"
#include "control/contact/shading.h"
#include "control/plain_surface.h"
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

// The springs of a contact in a scene with shaded meshes, before the effects of surfaces.
struct ShadedSprings {
  const PlacedObject* frame = nullptr;
  Vec3 felt_N = Vec3::Zero();
  Vec3 late_N = Vec3::Zero();  // the part of it that is not the force of the springs as they stand
  float stiffness_N_m = 1.0F;  // felt_N over this is the pull
};

// facets_m: where the god object would be without shading. Shading that has given the hand much energy is faded out, as far
// as the account holds its force back: the facets themselves give none.
ShadedSprings shaded_springs(const World& world, Finger& finger, const Constraints& held,
                             const FrictionLimits& limits, Vec3 springs_N, const Vec3& tip_m,
                             const Vec3& facets_m, bool shaded) {
  const bool sticks = limits.static_m > 0.0F;
  const float mean_N_m =
      limits.stiffness_N_m > 0.0F ? limits.stiffness_N_m : held.list[0].material.stiffness_N_m;
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

// Where the way from the stiction point to the place without friction takes all the work of each tick, the place that is reached can be within
// the friction for ever, while the tip goes on. After so many ticks the stiction point goes to it.
constexpr std::uint8_t kMostStuck = 2;

void count_stuck(Finger& finger, const Work& work, const Vec3& before_m) {
  const bool stuck = work.was_spent() && finger.stuck < kMostStuck && finger.god.position_m == before_m;
  finger.stuck = stuck ? static_cast<std::uint8_t>(finger.stuck + 1) : std::uint8_t{0};
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
  const float falls = !finger.shaded.bound() ? 0.0F : felt.surfaced ? 2.0F : 1.0F;
  return {pull, felt.force_N, energy_J, falls};
}

// Farther from the surface that it was on than rounding, so that it is not in it.
Vec3 off_the_surface(const Vec3& god_m, const Vec3& tip_m) {
  constexpr float kOff_m = 50e-6F;
  const Vec3 out = god_m - tip_m;
  const float deep_m = out.norm();
  return deep_m > 1e-6F ? Vec3(god_m + out * (kOff_m / deep_m)) : tip_m;
}

[[gnu::cold, gnu::noinline]] void begin(const World& world, Finger& finger, const Vec3& tip_m,
                                        Effort& effort) {
  finger.started = true;
  effort.work.open_reserve();
  finger.god.position_m = finger.starts_at_god ? off_the_surface(finger.god.position_m, tip_m) : tip_m;
  finger.rest = finger.god;
  finger.inside = solids_around(world, ~SolidSet{0}, finger.god.position_m, effort);
}

bool any_surfaced(const World& world, const Constraints& held) {
  for (std::size_t i = 0; i < held.count; ++i) {
    if (world.objects[held.list[i].object].surfaced) return true;
  }
  return false;
}

// A solid is felt again when neither the tip nor the god object is in it. While another solid holds the god object, it can
// be in there for longer than the tip. Where the work is spent, the next tick begins with what is left of them.
[[gnu::noinline]] void update_inside(const World& world, Finger& finger, const Vec3& tip_m, Effort& effort) {
  finger.look_inside_first = false;
  std::size_t object = finger.look_inside_from;
  for (std::size_t n = 0; n < world.count; ++n) {
    if (++object >= world.count) object = 0;
    if ((finger.inside & only(object)) == 0) continue;
    SolidSet still = 0;
    for (const Vec3& at : {tip_m, finger.god.position_m, finger.rest.position_m}) {
      if (still == 0) still = solids_around(world, only(object), at, effort);
    }
    if (effort.work.is_spent()) {
      finger.look_inside_from = static_cast<std::uint8_t>(object);
      finger.look_inside_first = true;
      return;
    }
    if (still == 0) finger.inside &= ~only(object);
  }
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
  fields_.bind(scene, binding);
  bodies_.bind(scene, binding, world_);
  bound_work(work_);
  effort_.counters = {};
  body_work_ = 0;
  std::array<Vec3, kMaxArms> places_m;
  std::array<bool, kMaxArms> held{};
  for (std::size_t i = 0; i < kMaxArms; ++i) {
    const GodObject& god = fingers_[i].god;
    held[i] = god.count != 0 && binding == Binding::kKeepPlaces;
    places_m[i] = god.is_ball ? god.centre_m : god.position_m;
  }
  reset_fingers();
  for (std::size_t i = 0; i < kMaxArms; ++i) {
    fingers_[i].starts_at_god = held[i];
    fingers_[i].god.position_m = places_m[i];
  }
}

// Bodies have half of it, and what the arms leave; the arms share the rest equally.
void Renderer::bound_work(std::uint32_t units) noexcept {
  static_assert(kMaxArms <= 2);  // so that all shares are whole
  work_ = units - units % 4;
  left_ = least_left_ = work_;
  most_over_ = 0;
  const std::uint32_t all = bodies_.empty() ? work_ : work_ / 2;
  for (std::size_t i = 0; i < kMaxArms; ++i) {
    const std::uint32_t share = all / static_cast<std::uint32_t>(i + 1);
    arm_work_[i] = Work(share, share / kReserve);
  }
}

void Renderer::reset_fingers() noexcept {
  fingers_ = {};
  for (TriangleCache& triangles : triangles_) triangles.clear();
}

void Renderer::reset() noexcept {
  reset_fingers();
  fields_.reset();
}

void Renderer::reset(std::size_t arm) noexcept {
  fingers_[arm] = {};
  triangles_[arm].clear();
  fields_.reset(arm);
}

std::uint64_t Renderer::inside_in_image(SolidSet inside) const noexcept {
  std::uint64_t in_image = 0;
  for (std::size_t i = 0; i < world_.count; ++i)
    if ((inside & only(i)) != 0) in_image |= std::uint64_t{1} << world_.objects[i].in_image;
  return in_image;
}

void Renderer::use_general_path_only() noexcept {
  for (PlacedObject& object : world_.objects) object.plain = object.rolls = false;
}

void Renderer::tick(std::span<const Tip> tips, float period_s, std::span<Touch> touches) noexcept {
  const std::size_t count = std::min(tips.size(), kMaxArms);
  std::uint32_t left = 0;  // by the arms
  put_off_ = false;
  for (std::size_t i = 0; i < count; ++i) {
    Finger& finger = fingers_[i];
    effort_.work = arm_work_[count - 1];
    const bool looks_first = finger.look_inside_first;
    if (looks_first) {
      effort_.work.open_reserve();
      update_inside(world_, finger, tips[i].position_m, effort_);
      finger.look_inside_first = false;  // what is nearby is the first again
    }
    TriangleCache* const triangles = keeps_ ? &triangles_[i] : nullptr;
    if (!fly_in_the_open(finger, tips[i].position_m, touches[i]) &&
        !touch_one_plain_surface<PointWay>(world_, finger, tips[i], period_s, triangles, effort_.work,
                                           touches[i])) {
      if (world_.tip_radius_m == 0.0F ||
          !roll_on_one_plain_surface(world_, finger, tips[i], period_s, triangles, effort_.work, touches[i]))
        touch(finger, tips[i], period_s, triangles, effort_, touches[i]);
      if (finger.inside != 0 && !looks_first) update_inside(world_, finger, tips[i].position_m, effort_);
    }
    if (fields_.count() != 0) fields_.tick(i, tips[i], period_s, touches[i]);
    left += effort_.work.left();
    if (effort_.work.was_spent()) count_put_off();
  }
  if (!bodies_.empty()) {
    if (count == 0) left = work_ / 2;
    body_work_ = work_ / 2 + left;
    effort_.work = Work(body_work_);
    const bool pressed = fields_.count() == 0 || fields_.press(world_, period_s, bodies_, effort_.work);
    bodies_.step(world_, std::span(fingers_).first(count), period_s, pressed, effort_);
    left = effort_.work.left();
    body_work_ -= left;
    most_over_ = std::max(most_over_, effort_.work.over());
    if (effort_.work.was_spent()) count_put_off();
  }
  left_ = left;
  if (left < least_left_) least_left_ = left;
}

void Renderer::count_put_off() noexcept {
  if (!put_off_) ++effort_.counters.put_off;
  put_off_ = true;
  effort_.counters.put_off_object = effort_.work.object();
}

RenderCounters Renderer::counters() const noexcept {
  RenderCounters all = effort_.counters;
  all.most_work = work_ - least_left_ + most_over_;
  if (all.put_off_object < world_.count) all.put_off_object = world_.objects[all.put_off_object].in_image;
  return all;
}

Renderer::Load Renderer::load() const noexcept {
  return {.finger_units = work_ - left_ - body_work_,
          .body_units = body_work_ + effort_.work.over(),
          .awake = static_cast<std::uint32_t>(bodies_.states().size()) -
                   static_cast<std::uint32_t>(std::popcount(bodies_.asleep())),
          .solids = world_.count,
          .volumes = fields_.count(),
          .shaded = world_.any_shaded};
}

void Renderer::touch(Finger& finger, const Tip& tip, float period_s, TriangleCache* triangles, Effort& effort,
                     Touch& touch) noexcept {
  const Vec3& x = tip.position_m;
  GodObject& god = finger.god;
  GodObject& rest = finger.rest;
  if (triangles == nullptr) finger.resting.forget();
  if (!finger.started) begin(world_, finger, x, effort);
  finger.open.free_m = 0.0F;
  const Nearby nearby(world_, Reach(god.position_m, rest.position_m, x, world_.margin_m), finger.inside,
                      triangles, finger.resting);
  if (!find_contact(world_, nearby, finger, x, !bodies_.empty(), effort)) {
    if (keeps_) find_the_open(world_, triangles, finger, x, effort.work);
    touch = {Vec3::Zero(), god.position_m, static_cast<std::uint8_t>(rest.count)};
    return;
  }
  Constraints held;
  const Vec3 facets_m = rest.position_m;
  const bool shaded = shade(world_, nearby, rest, x, held, effort);
  if (!shaded) find_constraints(world_, rest, x, finger.resting, held);
  // On another surface there is no stiction point yet.
  if (!shares_object(rest, god) ||
      (finger.stuck >= kMostStuck && !is_farther(rest.position_m, god.position_m, x)))
    god = rest;
  const Vec3 before_m = god.position_m;
  const bool surfaced = any_surfaced(world_, held);
  FrictionLimits limits;
  Vec3 force = Vec3::Zero();
  ShadedSprings springs;
  if (world_.any_shaded) {
    limits = friction_limits(held);
    force = spring_force(held);
    springs = shaded_springs(world_, finger, held, limits, force, x, facets_m, shaded);
  }
  const Vec3 plain_N = force;
  const bool effects = springs.frame != nullptr && (surfaced || finger.shaded.has_effect());
  const SurfaceTouch surface = surfaced ? apply_surfaces(world_, rest, x, held) : SurfaceTouch{};
  if (surfaced || !world_.any_shaded) {
    limits = friction_limits(held);
    force = spring_force(held) + surface.along_N;
  }
  if (effects) force += finger.shaded.effect(*springs.frame, force - plain_N);
  force += springs.late_N;
  Vec3 friction_N = Vec3::Zero();
  if (limits.static_m > 0.0F) {
    const Slip slip = finger.friction.tick(limits, god.position_m - rest.position_m, period_s);
    if (slip.slips) {
      const Vec3 stuck_m = god.position_m;
      const bool one = shaded || rest.count == 1;
      move(world_, nearby, god, (one ? rest.position_m : x) + slip.offset_m, one, effort);
      // A shaded rest position is not the nearest; the energy account covers what such a slip could give.
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
  count_stuck(finger, effort.work, before_m);
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

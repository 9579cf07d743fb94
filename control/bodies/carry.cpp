#include "control/bodies/carry.h"

#include <array>

#include "control/contact/ball.h"

namespace thimble::control {
namespace {

constexpr float kGap_m = 2.0F * kSurfaceTolerance_m;

struct Box {
  Vec3 lo_m;
  Vec3 hi_m;
};

bool reaches(const Box& box, const Vec3& p) {
  for (Eigen::Index i = 0; i < 3; ++i)
    if (p[i] < box.lo_m[i] - kGap_m || p[i] > box.hi_m[i] + kGap_m) return false;
  return true;
}

bool is_on(const GodObject& god, std::uint8_t object) {
  if (god.has_beside && god.beside.object == object) return true;
  for (std::size_t i = 0; i < god.count; ++i)
    if (god.contacts[i].object == object) return true;
  return false;
}

// The god object's contact with the object, and its plane, taken out of the list.
bool take_contact(GodObject& god, std::uint8_t object, Contact& contact, Vec3& normal) {
  std::size_t kept = 0;
  bool found = false;
  for (std::size_t i = 0; i < god.count; ++i) {
    if (god.contacts[i].object == object) {
      contact = god.contacts[i];
      normal = god.normals[i];
      found = true;
    } else {
      god.normals[kept] = god.normals[i];
      god.contacts[kept++] = god.contacts[i];
    }
  }
  god.count = kept;
  return found;
}

// The point of the surface nearest to `local`, which is on `feature` except for rounding.
[[gnu::noinline]] Vec3 onto_surface(const PlacedObject& object, Feature& feature, const Vec3& local,
                                    Work& of_tick) {
  Work work(kInPlaceWork);
  Vec3 to = object.ops->slide(object.shape, feature, {work, local, local, true}).to;
  of_tick.charge(kInPlaceWork - work.left());
  return to;
}

// The box about the old and the new pose holds the path of every point of the object, except for the curvature of its
// rotation. That is less than the motion of the box, so the box grows by the motion.
Box box_of_motion(const PlacedObject& before, const PlacedObject& now) {
  const Vec3 margin = (before.lo_m - now.lo_m).cwiseAbs().cwiseMax((before.hi_m - now.hi_m).cwiseAbs());
  return {now.lo_m.cwiseMin(before.lo_m) - margin, now.hi_m.cwiseMax(before.hi_m) + margin};
}

bool is_at(const Vec3& a, const Vec3& b, float within_m) {
  return (a - b).squaredNorm() <= within_m * within_m;
}

// What keeps a god object from its target.
Pin pin_of(const GodObject& god, const Vec3& target) {
  Pin pin;
  pin.point_m = god.position_m;
  const Vec3 denied = target - god.position_m;
  const float length = denied.norm();
  if (length > 0.0F) pin.direction = denied / length;
  for (std::size_t i = 0; i < god.count; ++i) {
    const std::uint8_t object = god.contacts[i].object;
    pin.object = i == 0 || pin.object == object ? object : kNoBody;
  }
  return pin;
}

// The same as carry() for a tip with a radius. Its path relative to the moving object is that of a sphere.
bool carry_sphere(const World& world, std::uint8_t moved, const PlacedObject& before, Finger& finger,
                  Pin& pin, Effort& effort) {
  const PlacedObject& now = world.objects[moved];
  const Nearby alone(moved);
  GodObject god = finger.god;
  Contact contact{.object = moved, .feature = {}};
  Vec3 normal;
  const bool touched = take_contact(god, moved, contact, normal);
  Vec3 local = before.to_local(god.position_m);
  if (touched) {
    normal = now.turn(before.turn_back(normal));
    const Anchor& anchor = finger.anchor;
    if (anchor.holds && anchor.object == moved && anchor.world_m == god.position_m) local = anchor.local_m;
  } else {
    Box both = box_of_motion(before, now);
    both.lo_m.array() -= world.margin_m;
    both.hi_m.array() += world.margin_m;
    if (!reaches(both, god.position_m)) return true;
    GodObject seen;  // as the object sees it
    seen.position_m = now.to_world(local);
    static_cast<void>(fly_ball(world, alone, seen, god.position_m, effort));
    if (seen.position_m == god.position_m) return true;
    if (seen.count == 0) return false;
    contact = seen.contacts[0];
    normal = seen.normals[0];
    local = now.to_local(seen.position_m);
  }

  // Move it there, around all other objects.
  const Vec3 target = now.to_world(local);
  const Nearby others(world, Reach(god.position_m, god.position_m, target, world.margin_m),
                      finger.inside | only(moved), nullptr, finger.resting);
  move(world, others, god, target, false, effort);
  const bool arrived = is_at(god.position_m, target, kTouchGap_m);
  if (!arrived) {
    pin = pin_of(god, target);
    // Another object is in the way. The sphere may have slid along the moving object, but must not be in it.
    GodObject seen;
    seen.position_m = target;
    static_cast<void>(move_ball(world, alone, seen, god.position_m, false, effort));
    if (!is_at(seen.position_m, god.position_m, kTouchGap_m)) return false;
  }
  if (god.count == kMaxContacts) --god.count;
  god.normals[god.count] = normal;
  god.contacts[god.count++] = contact;
  finger.god = god;
  finger.rest = god;
  finger.anchor = {moved, local, god.position_m, arrived};
  return true;
}

}  // namespace

bool carry(const World& world, std::uint8_t moved, const PlacedObject& before, Finger& finger, Pin& pin,
           Effort& effort) noexcept {
  if (world.tip_radius_m > 0.0F) return carry_sphere(world, moved, before, finger, pin, effort);
  const PlacedObject& now = world.objects[moved];
  if (!is_on(finger.god, moved) && !reaches(box_of_motion(before, now), finger.god.position_m)) return true;
  GodObject god = finger.god;
  Contact contact;
  Vec3 normal;  // of a ball
  const bool touched = take_contact(god, moved, contact, normal);
  const bool beside = god.has_beside && god.beside.object == moved;

  // The place on the object where the god object rests, or where the object hits it.
  Vec3 from = before.to_local(god.position_m);
  Vec3 local;
  std::array<Feature, 1> side{};
  if (touched) {
    const Anchor& anchor = finger.anchor;
    local = anchor.holds && anchor.object == moved && anchor.world_m == god.position_m
                ? anchor.local_m
                : onto_surface(now, contact.feature, from, effort.work);
    from = local;
    side[0] = contact.feature;
  } else {
    if (beside) side[0] = god.beside.feature;
    side[0].kind = kSideOnly;
    const Vec3 to = now.to_local(god.position_m);
    Hit hit;
    if (!now.ops->sweep(now.shape, {effort.work, from, to, {side.data(), beside ? 1U : 0U}}, hit)) {
      ++effort.counters.sweep_bound;
      return false;
    }
    if (hit.t > 1.0F) return true;
    local = from + hit.t * (to - from);
    contact = {moved, hit.feature};
  }

  // Move the god object there, around all other objects.
  const Vec3 target = now.to_world(local);
  const Nearby others(world, Reach(god.position_m, god.position_m, target, world.margin_m),
                      finger.inside | only(moved), nullptr, finger.resting);
  if (others.objects().empty()) {
    god.count = 0;
    god.position_m = target;
  } else {
    move(world, others, god, target, false, effort);
  }
  if ((god.position_m - target).squaredNorm() > kSurfaceTolerance_m * kSurfaceTolerance_m) {
    // Another object is in the way. The god object may have slid along the moving object, or stay behind it,
    // but it must not be inside.
    pin = pin_of(god, target);
    const Vec3 to = now.to_local(god.position_m);
    Hit hit;
    side[0].kind = kSideOnly;
    if (!now.ops->sweep(now.shape, {effort.work, from, to, {side.data(), touched || beside ? 1U : 0U}},
                        hit) ||
        hit.t <= 1.0F)
      return false;
    local = onto_surface(now, contact.feature, to, effort.work);
    if ((local - to).squaredNorm() > kGap_m * kGap_m) {
      god.beside = contact;
      god.has_beside = true;
      god.is_ball = false;
      finger.god = god;
      finger.rest = god;
      finger.anchor.holds = false;
      return true;
    }
  }
  if (god.count == kMaxContacts) --god.count;
  god.contacts[god.count++] = contact;
  if (beside) god.has_beside = false;
  god.is_ball = false;
  finger.god = god;
  finger.rest = god;
  finger.anchor = {moved, local, god.position_m, true};
  return true;
}

}  // namespace thimble::control

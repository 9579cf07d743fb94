#include "control/bodies/carry.h"

#include <array>

namespace thimble::control {
namespace {

constexpr float kGap_m = 2.0F * kSurfaceTolerance_m;

bool reaches(const PlacedObject& object, const Vec3& p) {
  return (p.array() >= object.lo_m.array() - kGap_m).all() &&
         (p.array() <= object.hi_m.array() + kGap_m).all();
}

// The god object's contact with the object, taken out of the list.
bool take_contact(GodObject& god, std::uint8_t object, Contact& contact) {
  std::size_t kept = 0;
  bool found = false;
  for (std::size_t i = 0; i < god.count; ++i) {
    if (god.contacts[i].object == object) {
      contact = god.contacts[i];
      found = true;
    } else {
      god.contacts[kept++] = god.contacts[i];
    }
  }
  god.count = kept;
  return found;
}

// The point of the surface nearest to `local`, which is on `feature` except for rounding.
Vec3 onto_surface(const PlacedObject& object, Feature& feature, const Vec3& local) {
  return object.ops->slide(object.shape, feature, local, local, {.hold = true}).to;
}

}  // namespace

bool carry(const World& world, std::uint8_t moved, const PlacedObject& before, Finger& finger,
           RenderCounters& counters) noexcept {
  const PlacedObject& now = world.objects[moved];
  GodObject god = finger.god;
  Contact contact;
  const bool touched = take_contact(god, moved, contact);
  const bool beside = god.has_beside && god.beside.object == moved;
  // The box about the old and the new pose holds the path of every point of the object, except for the
  // curvature of its rotation. That is less than the motion of the box, so the box grows by the motion.
  if (!touched && !beside) {
    const Vec3 margin = (before.lo_m - now.lo_m).cwiseAbs().cwiseMax((before.hi_m - now.hi_m).cwiseAbs());
    PlacedObject both = now;
    both.lo_m = now.lo_m.cwiseMin(before.lo_m) - margin;
    both.hi_m = now.hi_m.cwiseMax(before.hi_m) + margin;
    if (!reaches(both, god.position_m)) return true;
  }

  // The place on the object where the god object rests, or where the object hits it.
  Vec3 from = before.to_local(god.position_m);
  Vec3 local;
  std::array<Feature, 1> side{};
  if (touched) {
    const Anchor& anchor = finger.anchor;
    local = anchor.holds && anchor.object == moved && anchor.world_m == god.position_m
                ? anchor.local_m
                : onto_surface(now, contact.feature, from);
    from = local;
    side[0] = contact.feature;
  } else {
    if (beside) side[0] = god.beside.feature;
    side[0].kind = kSideOnly;
    const Vec3 to = now.to_local(god.position_m);
    Hit hit;
    if (!now.ops->sweep(now.shape, from, to, {side.data(), beside ? 1U : 0U}, hit)) {
      ++counters.sweep_bound;
      return false;
    }
    if (hit.t > 1.0F) return true;
    local = from + hit.t * (to - from);
    contact = {moved, hit.feature};
  }

  // Move the god object there, around all other objects.
  const Vec3 target = now.to_world(local);
  const Nearby others(world, Reach(god, god, target), moved);
  if (others.objects().empty()) {
    god.count = 0;
    god.position_m = target;
  } else {
    move(world, others, god, target, false, counters);
  }
  if ((god.position_m - target).squaredNorm() > kSurfaceTolerance_m * kSurfaceTolerance_m) {
    // Another object is in the way. The god object may have slid along the moving object, or stay behind it,
    // but it must not be inside.
    const Vec3 to = now.to_local(god.position_m);
    Hit hit;
    side[0].kind = kSideOnly;
    if (!now.ops->sweep(now.shape, from, to, {side.data(), touched || beside ? 1U : 0U}, hit) ||
        hit.t <= 1.0F)
      return false;
    local = onto_surface(now, contact.feature, to);
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

#include "control/contact/inside.h"

#include "control/bodies/collide.h"
#include "control/contact/separations.h"

namespace thimble::control {
namespace {

bool in_box(const PlacedObject& object, const Vec3& p) {
  return (p.array() >= object.lo_m.array()).all() && (p.array() <= object.hi_m.array()).all();
}

Containment contains(const PlacedObject& object, const Vec3& centre_m, Work& work) {
  if (!in_box(object, centre_m)) return Containment::kOutside;
  const Vec3 local = object.to_local(centre_m);
  if (object.ops->contains != nullptr) return object.ops->contains(object.shape, local, work);
  // The same tolerance as in the sweeps: a point that they would stop is outside.
  return object.row->collision->nearest(object.shape, local).outside_m < -kSurfaceTolerance_m
             ? Containment::kInside
             : Containment::kOutside;
}

// Whether a tip with a radius whose centre is outside of the solid is nearer to it than the radius.
[[gnu::noinline]] bool reaches_into(const World& world, std::uint8_t index, const Vec3& centre_m,
                                    Work& work) {
  const float radius_m = world.tip_radius_m;
  const PlacedObject& object = world.objects[index];
  if ((centre_m.array() < object.lo_m.array() - radius_m).any() ||
      (centre_m.array() > object.hi_m.array() + radius_m).any())
    return false;
  Separations near;
  if (!near.look(world, Nearby(index), {work, centre_m, centre_m, centre_m, radius_m, 0.0F, {}, 0, true}, {}))
    return true;
  for (std::size_t i = 0; i < near.count; ++i)
    if (near.of[i].apart_m < radius_m - kTouchGap_m) return true;
  return false;
}

}  // namespace

SolidSet solids_around(const World& world, SolidSet among, const Vec3& centre_m, Effort& effort) noexcept {
  SolidSet found = 0;
  for (std::size_t i = 0; i < world.count; ++i) {
    if ((among & only(i)) == 0) continue;
    effort.work.at(static_cast<std::uint8_t>(i));
    const Containment containment = contains(world.objects[i], centre_m, effort.work);
    if (containment == Containment::kOutside &&
        !(world.tip_radius_m > 0.0F &&
          reaches_into(world, static_cast<std::uint8_t>(i), centre_m, effort.work)))
      continue;
    if (containment == Containment::kUnknown) ++effort.counters.sweep_bound;
    found |= only(i);
  }
  return found;
}

}  // namespace thimble::control

#include "control/contact/inside.h"

#include "control/bodies/collide.h"

namespace thimble::control {
namespace {

bool in_box(const PlacedObject& object, const Vec3& p) {
  return (p.array() >= object.lo_m.array()).all() && (p.array() <= object.hi_m.array()).all();
}

Containment contains(const PlacedObject& object, const Vec3& centre_m) {
  if (!in_box(object, centre_m)) return Containment::kOutside;
  const Vec3 local = object.to_local(centre_m);
  if (object.ops->contains != nullptr) return object.ops->contains(object.shape, local);
  // The same tolerance as in the sweeps: a point that they would stop is outside.
  return object.row->collision->nearest(object.shape, local).outside_m < -kSurfaceTolerance_m
             ? Containment::kInside
             : Containment::kOutside;
}

}  // namespace

SolidSet solids_around(const World& world, SolidSet among, const Vec3& centre_m,
                       RenderCounters& counters) noexcept {
  SolidSet found = 0;
  for (std::size_t i = 0; i < world.count; ++i) {
    if ((among & only(i)) == 0) continue;
    const Containment containment = contains(world.objects[i], centre_m);
    if (containment == Containment::kOutside) continue;
    if (containment == Containment::kUnknown) ++counters.sweep_bound;
    found |= only(i);
  }
  return found;
}

}  // namespace thimble::control

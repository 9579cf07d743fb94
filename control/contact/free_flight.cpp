#include "control/contact/free_flight.h"

#include <algorithm>
#include <limits>

#include "control/bodies/collide.h"

namespace thimble::control {
namespace {

// How far a place is at least from an object; 0: not known.
float away_m(const PlacedObject& object, TriangleCache* triangles, const Vec3& place_m, Work& work) {
  const float from_box_m = (place_m - place_m.cwiseMax(object.lo_m).cwiseMin(object.hi_m)).norm();
  if (object.half_space) return object.normal.dot(place_m) - object.offset_m;
  if (object.ops->separate != nullptr)
    return std::max(from_box_m,
                    triangles != nullptr ? triangles->away_m(object.shape, object.to_local(place_m)) : 0.0F);
  if (from_box_m > 0.0F || !work.spend(kSolidWork)) return from_box_m;
  return object.row->collision->nearest(object.shape, object.to_local(place_m)).outside_m;
}

}  // namespace

void find_the_open(const World& world, TriangleCache* triangles, Finger& finger, const Vec3& tip_m,
                   Work& work) noexcept {
  // Bodies come nearer in the next tick.
  if (world.any_bodies || world.tip_radius_m > 0.0F || finger.inside != 0 || finger.god.count != 0 ||
      finger.god.position_m != tip_m || work.was_spent())
    return;
  float free_m = std::numeric_limits<float>::max();
  for (std::size_t i = 0; i < world.count && free_m > 0.0F; ++i)
    free_m = std::min(free_m, away_m(world.objects[i], triangles, tip_m, work) - world.margin_m);
  if (!(free_m > 0.0F)) return;
  finger.open = {kNoBody, tip_m, free_m};
  finger.god = GodObject{};
  finger.god.position_m = tip_m;
  finger.rest = finger.god;
}

}  // namespace thimble::control

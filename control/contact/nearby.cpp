#include "control/contact/nearby.h"

#include <algorithm>

#include "control/bodies/collide.h"

namespace thimble::control {

Nearby::Nearby(const World& world, const Reach& reach, SolidSet without, TriangleCache* triangles,
               Resting& resting) noexcept
    : triangles_(triangles), resting_(&resting) {
  for (std::size_t i = 0; i < world.count; ++i)
    if (reach.meets(world.objects[i])) list_[count_++] = static_cast<std::uint8_t>(i);
  if (without != 0) {
    const auto* const end = std::remove_if(list_.data(), list_.data() + count_,
                                           [without](std::uint8_t i) { return (without & only(i)) != 0; });
    count_ = static_cast<std::size_t>(end - list_.data());
  }
  point_ = world.tip_radius_m <= 0.0F;
  if (count_ > 1)
    keep(world, reach.tip_m, reach.radius_m());
  else
    one_mesh_ = count_ == 1 && world.objects[list_[0]].ops->separate != nullptr;
}

Nearby Nearby::within(const World& world, const Vec3& place_m, float distance_m) const noexcept {
  Nearby closer = *this;
  closer.keep(world, place_m, distance_m);
  return closer;
}

void Nearby::keep(const World& world, const Vec3& place_m, float distance_m) noexcept {
  std::size_t kept = 0;
  int meshes = 0;
  for (std::size_t i = 0; i < count_; ++i) {
    const PlacedObject& object = world.objects[list_[i]];
    const bool is_mesh = object.ops->separate != nullptr;
    const float outside_m =
        is_mesh ? (place_m - place_m.cwiseMax(object.lo_m).cwiseMin(object.hi_m)).norm()
                : object.row->collision->nearest(object.shape, object.to_local(place_m)).outside_m;
    if (outside_m > distance_m) continue;
    list_[kept++] = list_[i];
    if (is_mesh) ++meshes;
  }
  count_ = kept;
  one_mesh_ = meshes == 1;
}

}  // namespace thimble::control

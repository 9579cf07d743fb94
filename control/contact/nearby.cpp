#include "control/contact/nearby.h"

#include <algorithm>

#include "control/bodies/collide.h"

namespace thimble::control {

Nearby::Nearby(const World& world, const Reach& reach, SolidSet without, TriangleCache* triangles) noexcept {
  for (std::size_t i = 0; i < world.count; ++i)
    if (reach.meets(world.objects[i])) list_[count_++] = static_cast<std::uint8_t>(i);
  if (without != 0) {
    const auto* const end = std::remove_if(list_.begin(), list_.begin() + count_,
                                           [without](std::uint8_t i) { return (without & only(i)) != 0; });
    count_ = static_cast<std::size_t>(end - list_.begin());
  }
  if (world.tip_radius_m > 0.0F) {
    int meshes = 0;
    for (const std::uint8_t index : objects())
      if (world.objects[index].ops->separate != nullptr) ++meshes;
    if (meshes == 1) triangles_ = triangles;
  }
  if (count_ < 2) return;
  const float radius_m = reach.radius_m();
  std::size_t kept = 0;
  for (std::size_t i = 0; i < count_; ++i) {
    const PlacedObject& object = world.objects[list_[i]];
    if (object.ops->separate != nullptr ||
        object.row->collision->nearest(object.shape, object.to_local(reach.tip_m)).outside_m <= radius_m)
      list_[kept++] = list_[i];
  }
  count_ = kept;
}

}  // namespace thimble::control

#include "control/contact/passive.h"

namespace thimble::control {

const PlacedObject* account_frame(const World& world, const GodObject& rest,
                                  const Constraints& held) noexcept {
  const PlacedObject& first = world.objects[held.count == 0 ? rest.contacts[0].object : held.list[0].object];
  for (std::size_t i = 1; i < held.count; ++i) {
    if (world.objects[held.list[i].object].body != first.body) return nullptr;
  }
  return &first;
}

float passive_scale(const World& world, Finger& finger, const Constraints& held, const Vec3& tip_m,
                    const Spring& spring, bool gradient) noexcept {
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

}  // namespace thimble::control

#include "control/plain_surface.h"

namespace thimble::control {

bool roll_on_one_plain_surface(const World& world, Finger& finger, const Tip& tip, float period_s,
                               TriangleCache* triangles, Work& work, Touch& touch) noexcept {
  return touch_one_plain_surface<BallWay>(world, finger, tip, period_s, triangles, work, touch);
}

}  // namespace thimble::control

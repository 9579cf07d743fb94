// The result of a clamp: the value, and which limiter acted. Clamping is never silent.
#pragma once

namespace thimble::kinematics {

template <typename Value, typename Which>
struct Limited {
  Value value;
  Which which;
};

}  // namespace thimble::kinematics

// The result of a clamp: the value, and which limit acted.
#pragma once

namespace thimble::kinematics {

template <typename Value, typename Which>
struct Limited {
  Value value;
  Which which;
};

}  // namespace thimble::kinematics

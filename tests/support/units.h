// Units for test data; the code uses SI.
#pragma once

#include <numbers>

namespace thimble::test {

inline constexpr double kDegree = std::numbers::pi / 180.0;  // rad

}  // namespace thimble::test

#include "tests/support/random.h"

#include <bit>
#include <cmath>
#include <numbers>

namespace thimble::test {

Random::Random(std::uint64_t seed) {
  for (std::uint64_t& word : state_) {
    seed += 0x9E3779B97F4A7C15U;
    std::uint64_t z = seed;
    z = (z ^ (z >> 30U)) * 0xBF58476D1CE4E5B9U;
    z = (z ^ (z >> 27U)) * 0x94D049BB133111EBU;
    word = z ^ (z >> 31U);
  }
}

std::uint64_t Random::bits() {
  const std::uint64_t result = std::rotl(state_[1] * 5U, 7) * 9U;
  const std::uint64_t shifted = state_[1] << 17U;
  state_[2] ^= state_[0];
  state_[3] ^= state_[1];
  state_[1] ^= state_[2];
  state_[0] ^= state_[3];
  state_[2] ^= shifted;
  state_[3] = std::rotl(state_[3], 45);
  return result;
}

std::size_t Random::below(std::size_t bound) { return static_cast<std::size_t>(bits() % bound); }

double Random::uniform(double low, double high) {
  return low + (high - low) * static_cast<double>(bits() >> 11U) * 0x1.0p-53;
}

double Random::gaussian() {
  const double u = 1.0 - uniform(0.0, 1.0);
  return std::sqrt(-2.0 * std::log(u)) * std::cos(2.0 * std::numbers::pi * uniform(0.0, 1.0));
}

Eigen::Vector3d Random::direction() {
  const double z = uniform(-1.0, 1.0);
  const double angle = uniform(0.0, 2.0 * std::numbers::pi);
  const double r = std::sqrt(1.0 - z * z);
  return {r * std::cos(angle), r * std::sin(angle), z};
}

Eigen::Vector3d Random::in_box(const Eigen::Vector3d& half_size) {
  const double x = uniform(-1.0, 1.0);
  const double y = uniform(-1.0, 1.0);
  const double z = uniform(-1.0, 1.0);
  return half_size.cwiseProduct(Eigen::Vector3d(x, y, z));
}

}  // namespace thimble::test

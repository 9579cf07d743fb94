// Random numbers for tests: seeded, identical on every machine (xoshiro256**, Blackman and Vigna 2018, seeded
// by splitmix64).
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>

namespace thimble::test {

class Random {
 public:
  explicit Random(std::uint64_t seed);

  [[nodiscard]] std::uint64_t bits();
  [[nodiscard]] std::size_t below(std::size_t bound);     // 0 to bound - 1; bound > 0
  [[nodiscard]] double uniform(double low, double high);  // low <= result < high
  [[nodiscard]] double gaussian();                        // mean 0, variance 1
  [[nodiscard]] Eigen::Vector3d direction();              // a unit vector, uniform on the sphere
  [[nodiscard]] Eigen::Vector3d in_box(const Eigen::Vector3d& half_size);

 private:
  std::uint64_t state_[4];
};

}  // namespace thimble::test

// The work that a tick may do, counted in units: so a tick has a bound that no scene and no motion exceeds (docs/time.md).
//
// Whatever takes longer in one tick than in another spends units before it does so: a node of a mesh's tree, a triangle, a face that a slide
// goes over, a solid that a flight passes. The count depends on the scene and the motion alone, so a tick ends at the same place on every
// machine. Where it is spent, what is left is put off: a flight or a slide ends where it is proven free, and goes on in the next tick.
//
// A unit is about 100 instructions of a Cortex-M7 (tests/bench/tick_instructions prints both).
#pragma once

#include <cstdint>

namespace thimble::control {

// What each costs.
inline constexpr std::uint32_t kNodeWork = 1;          // a node of a mesh's tree
inline constexpr std::uint32_t kTriangleWork = 2;      // a triangle and a segment or ray
inline constexpr std::uint32_t kNearTriangleWork = 3;  // a triangle and a ball
inline constexpr std::uint32_t kFaceWork = 2;          // a face or an edge that a slide goes over
inline constexpr std::uint32_t kFanWork = 1;           // a triangle round a vertex
inline constexpr std::uint32_t kSolidWork = 2;  // a solid that a flight or a ball passes, a piece of a slide
// Of a slide to the place where it is already: rounding can make it go over some faces.
inline constexpr std::uint32_t kInPlaceWork = 32;

class Work {
 public:
  static constexpr std::uint32_t kNoBound = 0xFFFFFFFFU;

  constexpr explicit Work(std::uint32_t units = kNoBound) noexcept : left_(units) {}

  // False where fewer units are left: then none is left.
  [[nodiscard]] bool spend(std::uint32_t units) noexcept {
    if (units > left_) {
      left_ = 0;
      spent_ = true;
      return false;
    }
    left_ -= units;
    return true;
  }
  // For a step whose cost is known only when it is done: what it takes beyond what was left is counted.
  void charge(std::uint32_t units) noexcept {
    const std::uint32_t left = left_;
    if (!spend(units)) over_ += units - left;
  }
  // What charge() took when less was left: at most one step of each search that does so (control/bodies/bodies.h).
  [[nodiscard]] std::uint32_t over() const noexcept { return over_; }
  // Whether more was asked for than was left.
  [[nodiscard]] bool is_spent() const noexcept { return spent_; }
  [[nodiscard]] std::uint32_t left() const noexcept { return left_; }

 private:
  std::uint32_t left_;
  std::uint32_t over_ = 0;
  bool spent_ = false;
};

}  // namespace thimble::control

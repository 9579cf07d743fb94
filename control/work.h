// The work that a tick may do, counted in units: so a tick has a bound that no scene and no motion exceeds (docs/time.md).
//
// Whatever takes longer in one tick than in another spends units before it does so: a node of a mesh's tree, a triangle, a face that a slide
// goes over, a solid that a flight passes. The count depends on the scene and the motion alone, so a tick ends at the same place on every
// machine. Where it is spent, what is left is put off: a flight or a slide ends where it is proven free, and goes on in the next tick. Part of
// the work is a reserve for a shorter way where the whole one has taken all the rest.
//
// A unit is about 100 instructions of a Cortex-M7 (tests/bench/tick_instructions prints both).
#pragma once

#include <cstdint>

namespace thimble::control {

// What each costs.
inline constexpr std::uint32_t kNodeWork = 1;          // a node of a mesh's tree
inline constexpr std::uint32_t kTriangleWork = 2;      // a triangle and a segment or ray
inline constexpr std::uint32_t kNearTriangleWork = 3;  // a triangle and a ball
inline constexpr std::uint32_t kListWork = 1;          // a triangle for a list of those near a ball
inline constexpr std::uint32_t kFaceWork = 2;          // a face or an edge that a slide goes over
inline constexpr std::uint32_t kFanWork = 1;           // a triangle round a vertex
inline constexpr std::uint32_t kSolidWork = 2;  // a solid that a flight or a ball passes, a piece of a slide
inline constexpr std::uint32_t kMoveWork = 4;   // a slide, or a step along a corner
inline constexpr std::uint32_t kRoundWork = 3;  // a plane that is taken in, and kPlanesAUnit more a unit
inline constexpr std::uint32_t kPlanesAUnit = 8;
// What a tick does with the place where the god object is has a bound of its own each time, so that a spent tick keeps its contacts: a
// slide to where it is already, as rounding can make it go over some faces; the point that the planes at a place hold.
inline constexpr std::uint32_t kInPlaceWork = 32;
inline constexpr std::uint32_t kHoldWork = 128;

class Work {
 public:
  static constexpr std::uint32_t kNoBound = 0xFFFFFFFFU;

  constexpr Work() noexcept = default;
  // `reserve`: of the units, cannot be spent before open_reserve().
  constexpr explicit Work(std::uint32_t units, std::uint32_t reserve = 0) noexcept
      : left_(units - reserve), reserve_(reserve) {}

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
  // What is left is for nothing any more.
  void exhaust() noexcept {
    left_ = reserve_ = 0;
    spent_ = true;
  }
  // For a step whose cost is known only when it is done: what it takes beyond what was left is counted.
  void charge(std::uint32_t units) noexcept {
    const std::uint32_t left = left_;
    if (!spend(units)) over_ += units - left;
  }
  // What charge() took when less was left: at most one step of each search that does so (control/bodies/bodies.h).
  [[nodiscard]] std::uint32_t over() const noexcept { return over_; }
  // What is looked at from here on.
  void at(std::uint8_t object) noexcept { object_ = object; }
  [[nodiscard]] std::uint8_t object() const noexcept { return object_; }

  // What was held back is there to be spent.
  void open_reserve() noexcept {
    left_ += reserve_;
    reserve_ = 0;
    ran_out_ = was_spent();
    spent_ = false;
  }
  // Whether more was asked for than was left: since the reserve was opened, or at all.
  [[nodiscard]] bool is_spent() const noexcept { return spent_; }
  [[nodiscard]] bool was_spent() const noexcept { return spent_ || ran_out_; }
  [[nodiscard]] std::uint32_t left() const noexcept { return left_ + reserve_; }
  // Of these, what can be spent before open_reserve().
  [[nodiscard]] std::uint32_t at_hand() const noexcept { return left_; }

 private:
  std::uint32_t left_ = kNoBound;
  std::uint32_t reserve_ = 0;
  std::uint32_t over_ = 0;
  bool spent_ = false;
  bool ran_out_ = false;  // before the reserve was opened
  std::uint8_t object_ = 255;
};

}  // namespace thimble::control

// Quadrature decoding from edges, for a board without a counter in hardware: four counts a cycle, up while A leads B.
// Fed with each edge of the two lines in the order in which they happened; an edge that cannot be (the line was already at
// that level) proves that one before it was lost, and then the count is worthless until reset().
// Servo context. No heap, no OS; cannot fail.
#pragma once

#include <cstdint>

namespace thimble::board {

enum class QuadratureLine : std::uint8_t { kA, kB };

class Quadrature {
 public:
  // The levels now; the count goes on from where it is, and lost() is false again.
  void reset(bool a, bool b) noexcept {
    a_ = a;
    b_ = b;
    lost_ = false;
  }

  // level: of the line after its edge.
  void edge(QuadratureLine line, bool level) noexcept {
    bool& own = line == QuadratureLine::kA ? a_ : b_;
    if (own == level) {
      lost_ = true;
      return;
    }
    own = level;
    // After an edge of A the lines differ while A leads; after an edge of B they are equal.
    const bool up = line == QuadratureLine::kA ? a_ != b_ : a_ == b_;
    count_ += up ? 1U : ~0U;
  }

  [[nodiscard]] std::uint32_t count() const noexcept { return count_; }  // wraps, as a 32-bit counter does
  [[nodiscard]] bool lost() const noexcept { return lost_; }

 private:
  std::uint32_t count_ = 0;
  bool a_ = false;
  bool b_ = false;
  bool lost_ = false;
};

}  // namespace thimble::board

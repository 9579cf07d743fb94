// Quadrature decoding from edges, for a board without a hardware counter: four counts per cycle, up while A
// leads B. It takes the edges of both lines in order of time. An impossible edge (the line already had that
// level) shows that an earlier edge was lost; the count is then invalid until reset(). Servo context. No
// heap, no OS; cannot fail.
#pragma once

#include <cstdint>

namespace thimble::board {

enum class QuadratureLine : std::uint8_t { kA, kB };

class Quadrature {
 public:
  // a, b: the present levels. Keeps the count and clears lost().
  void reset(bool a, bool b) noexcept {
    a_ = a;
    b_ = b;
    lost_ = false;
  }

  // level: level of the line after the edge.
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

  [[nodiscard]] std::uint32_t count() const noexcept { return count_; }  // wraps at 32 bits
  [[nodiscard]] bool lost() const noexcept { return lost_; }

 private:
  std::uint32_t count_ = 0;
  bool a_ = false;
  bool b_ = false;
  bool lost_ = false;
};

}  // namespace thimble::board

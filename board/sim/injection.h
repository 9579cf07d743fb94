// Faults of the simulated hardware: what breaks, when, and for how long. SimBoard applies them between the plant and the controller, so
// the controller sees and does what it would with real hardware that broke. Never part of a real board's image.
//
//   board.inject({.kind = Injection::kEncoderDead, .arm = 0, .joint = 1});                       // now, for good
//   board.inject({.kind = Injection::kTickLost, .value = 3, .at_s = 0.5, .for_s = 0.1, .from = InjectionTime::kContact});
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string_view>

namespace thimble::board {

enum class Injection : std::uint8_t {
#define THIMBLE_INJECTION(identifier, name, of, value, text) identifier,
#include "board/sim/injection.def"
#undef THIMBLE_INJECTION
};

enum class InjectionOf : std::uint8_t { kJoint, kArm, kBoard };

struct InjectionRow {
  Injection kind;
  std::string_view name;
  InjectionOf of;
  std::string_view unit;  // of the value; empty: it has none
  std::string_view text;
};
[[nodiscard]] std::span<const InjectionRow> injections() noexcept;
[[nodiscard]] const InjectionRow* find_injection(std::string_view name) noexcept;  // null: unknown

// What a time counts from; each the first time after the board has started.
enum class InjectionTime : std::uint8_t { kStart, kArmed, kContact };

struct PlannedFault {
  Injection kind{};
  std::size_t arm = 0;
  std::optional<std::size_t> joint{};  // none: all of the arm
  double value = 0;
  Eigen::Vector3d force_N = Eigen::Vector3d::Zero();  // of kHandPushes
  double at_s = 0;
  double for_s = std::numeric_limits<double>::infinity();
  InjectionTime from = InjectionTime::kStart;
};

}  // namespace thimble::board

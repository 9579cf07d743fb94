// Lines of GPIO chips, found by name: inputs with level and edges, and single outputs. The servo reads and
// writes them. gpio_v1.cpp uses libgpiod 1.x (Debian 12), gpio_v2.cpp libgpiod 2.x; CMake selects the one for
// the installed version.
//
// Constructors throw GpioError with line and cause. No other function throws or waits.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <system_error>
#include <vector>

#include "board/linux/outputs.h"

namespace thimble::board {

class GpioError : public std::runtime_error {
 public:
  // error: an errno that tells whether the line is missing, in use or forbidden.
  GpioError(const std::string& line, const std::string& cause, int error)
      : std::runtime_error("GPIO line \"" + line + "\": " + cause), code(error, std::generic_category()) {}
  std::error_code code;
};

enum class GpioBias : std::uint8_t { kAsIs, kPullDown, kPullUp };

struct GpioLine {
  std::string name;
  bool active_low = false;
  GpioBias bias = GpioBias::kAsIs;

  bool operator==(const GpioLine&) const = default;
};

struct GpioEdge {
  std::uint64_t time_ns = 0;  // CLOCK_MONOTONIC
  std::uint8_t line = 0;      // its index among the inputs
  bool active = false;        // after the edge
};

[[nodiscard]] std::string gpio_library();  // "libgpiod 1.6.3", for people

// For the udev rule: whether the chip ("/dev/gpiochip0") has a line of this name; false if it cannot be read.
[[nodiscard]] bool gpio_chip_has_line(const std::string& chip, const std::string& name);

class GpioInputs {
 public:
  static constexpr std::size_t kMaxLines = 14;
  static constexpr std::size_t kEdgesPerLine = 16;  // kernel buffer between two calls
  struct Edges {
    std::span<const GpioEdge> edges;  // the oldest first
    bool lost = false;                // the kernel's buffer was full: edges may have been lost
  };

  explicit GpioInputs(std::span<const GpioLine> lines);
  GpioInputs(const GpioInputs&) = delete;
  GpioInputs& operator=(const GpioInputs&) = delete;
  ~GpioInputs();

  // Present levels, in the order of the lines. False: the chip is gone. One system call per line (v1) or per
  // chip (v2).
  [[nodiscard]] bool levels(std::span<bool> active) noexcept;
  // Edges since the last call. Empty: the chip is gone. One system call per line (v1) or per chip (v2).
  [[nodiscard]] std::optional<Edges> edges() noexcept;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
  std::array<GpioEdge, kMaxLines * kEdgesPerLine> edges_;
};

class GpioOutput final : public SwitchOutput {
 public:
  explicit GpioOutput(const GpioLine& line);  // not active
  GpioOutput(const GpioOutput&) = delete;
  GpioOutput& operator=(const GpioOutput&) = delete;
  ~GpioOutput() override;  // sets it to not active and returns the line to the kernel

  [[nodiscard]] bool set(bool active) noexcept override;  // false: the chip is gone. Any thread.

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace thimble::board

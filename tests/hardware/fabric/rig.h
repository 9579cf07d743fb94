// The verilated logic with what is at its pins: an AXI4-Lite master, two converters, and lines that a test sets. Time is in clocks, 10 MHz.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <random>
#include <string>

#include "tests/hardware/fabric/converter.h"
#include "tests/hardware/fabric/model.h"
#include "tests/hardware/fabric/trapped_page.h"

namespace thimble::tests {

inline constexpr std::uint64_t kClocks_us = 10;
inline constexpr std::uint32_t kArms = 2, kEncoders = 3 * kArms;

class Rig final : public RegisterBus {
 public:
  // Loads the shared object that the environment names (THIMBLE_FABRIC), and resets the logic. Throws std::runtime_error.
  explicit Rig(std::uint32_t seed = 1);
  Rig(const Rig&) = delete;
  Rig& operator=(const Rig&) = delete;
  ~Rig() override;

  void run(std::uint64_t clocks);
  void reset();  // for 8 clocks

  // A driver's accesses. The master delays address, data and the acceptance of the answer at random.
  std::uint32_t read(std::uint32_t offset) override;
  void write(std::uint32_t offset, std::uint32_t value) override {
    if (write(offset, value, 0xF) != 0) ++bus_errors;
  }
  std::uint32_t write(std::uint32_t offset, std::uint32_t value, std::uint8_t strobes);  // the response

  [[nodiscard]] std::uint32_t roll(std::uint32_t sides) {
    return static_cast<std::uint32_t>(random() % sides);
  }

  FabricIn in{};
  FabricOut out{};                 // at the last edge
  std::function<void()> on_clock;  // before each; it may set `in` and read `now`
  std::array<Converter, kArms> converter;
  std::uint64_t now = 0;
  std::uint64_t taken = 0;  // the clock in which the logic took the last write
  std::uint32_t reads = 0, writes = 0;
  std::uint32_t bus_errors =
      0;  // answers that are not OKAY, vanish, change or come unasked; accesses that nobody answers
  std::mt19937 random;

 private:
  void clock();
  std::uint32_t delay() { return roll(4); }

  void* library_;
  decltype(&fabric_new) new_;
  decltype(&fabric_delete) delete_;
  decltype(&fabric_clock) clock_;
  void* model_;
  FabricIn at_edge_{};  // what the last edge took
};

}  // namespace thimble::tests

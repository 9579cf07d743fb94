// An AD5754R as the logic sees it: takes frames and checks the timing of the pins (limits of the data sheet, in clocks of the shipped
// 100 MHz).
#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace thimble::tests {

class Converter {
 public:
  void clock(bool sync_n, bool sclk, bool sdin);

  std::array<std::int16_t, 4> output{};  // what the outputs show, if they have power
  std::uint32_t range = 0, power = 0;
  std::uint32_t loads = 0;
  std::vector<std::uint32_t> frames;  // all of them
  std::uint32_t violations = 0;       // of the timing, and frames that do not have 24 bits

 private:
  void take();

  std::array<std::int16_t, 4> input_{};
  bool sync_n_ = true, sclk_ = false, sdin_ = false;
  std::uint32_t bits_ = 0, frame_ = 0;
  std::uint32_t since_sync_ = 1000, since_sclk_ = 1000, since_sdin_ = 1000, since_power_ = 1000;  // clocks
};

}  // namespace thimble::tests

// Encoders decoded from GPIO edges, for a board without counters: slow, and limited by the kernel's latency.
// At most kEdgesPerLine edges per line between two ticks: at 1000 ticks per second 16 000 edges per second,
// 32 000 counts; use a quarter of that as a margin for late ticks. A lost edge is detected (by Quadrature, or
// by a full buffer). Then no sample is delivered for more ticks than encoder_stale_ticks can allow, so the
// controller raises a fault and the arm must be homed.
#pragma once

#include <array>
#include <memory>
#include <string>

#include "board/common/quadrature.h"
#include "board/linux/encoder_reader.h"
#include "board/linux/gpio.h"

namespace thimble::board {

class GpioEncoder final : public EncoderReader {
 public:
  // lines: A and B of each joint; joints without names are not read. Throws GpioError.
  explicit GpioEncoder(const std::array<std::array<std::string, 2>, kArmJoints>& lines);
  [[nodiscard]] std::optional<EncoderSample> read(std::uint64_t now_ns) noexcept override;

 private:
  static constexpr std::size_t kLines = 2 * kArmJoints;
  static constexpr unsigned kBlindTicks = 128;  // after a lost edge; encoder_stale_ticks is at most 100

  [[nodiscard]] bool follow() noexcept;
  [[nodiscard]] bool start_again() noexcept;

  GpioInputs inputs_;
  std::array<Quadrature, kArmJoints> joints_;
  std::array<std::size_t, kArmJoints> joint_of_{};  // of each pair of lines
  std::size_t pairs_ = 0;
  std::array<bool, kLines> levels_{};
  unsigned blind_ticks_ = 0;
};

}  // namespace thimble::board

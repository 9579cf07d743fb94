// Encoders decoded from GPIO edges, for a board without counters: slow, and only as good as the kernel is quick. At most
// kEdgesPerLine edges of a line between two ticks: with 1000 ticks a second 16 000 edges a second, 32 000 counts; a
// quarter of that leaves room for a late tick. A lost edge is noticed (Quadrature, and a list that was full) and costs the
// sample of more ticks than the parameter encoder_stale_ticks can allow: the controller trips, and the arm must be homed.
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
  // lines: A and B of each joint. Throws GpioError.
  explicit GpioEncoder(const std::array<std::array<std::string, 2>, 3>& lines);
  [[nodiscard]] std::optional<EncoderSample> read(std::uint64_t now_ns) noexcept override;

 private:
  static constexpr std::size_t kLines = 6;
  static constexpr unsigned kBlindTicks = 128;  // after a lost edge; encoder_stale_ticks is at most 100

  [[nodiscard]] bool follow() noexcept;
  [[nodiscard]] bool start_again() noexcept;

  GpioInputs inputs_;
  std::array<Quadrature, 3> joints_;
  std::array<bool, kLines> levels_{};
  unsigned blind_ticks_ = 0;
};

}  // namespace thimble::board

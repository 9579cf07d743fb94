// The currents that the drives of a board measure, for hosts (record MeasuredCurrents).
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "firmware/core/config.h"
#include "firmware/link/byte_writer.h"
#include "firmware/link/messages.h"

namespace thimble::board {

class MeasuredCurrents final : public firmware::BoardData {
 public:
  MeasuredCurrents() noexcept {
    for (std::atomic<float>& current_A : current_A_)
      current_A.store(std::numeric_limits<float>::quiet_NaN(), std::memory_order_relaxed);
  }
  // In the tick; read() may be in another thread, and then some values may be of the tick before.
  void take(const firmware::Inputs& in) noexcept {
    for (std::size_t arm = 0; arm < in.arm.size(); ++arm)
      for (std::size_t j = 0; j < firmware::kJoints; ++j)
        current_A_[arm * firmware::kJoints + j].store(in.arm[arm].evidence.current_A[j],
                                                      std::memory_order_relaxed);
    tick_.store(static_cast<std::uint32_t>(in.tick), std::memory_order_relaxed);
  }
  [[nodiscard]] bool read(std::uint16_t id, firmware::link::ByteWriter& out) const noexcept override {
    firmware::link::MeasuredCurrents measured;
    if (id != firmware::link::MeasuredCurrents::kId) return false;
    measured.tick = tick_.load(std::memory_order_relaxed);
    for (std::size_t i = 0; i < current_A_.size(); ++i)
      measured.current_A[i] = current_A_[i].load(std::memory_order_relaxed);
    out.put_record(measured);
    return true;
  }

 private:
  static_assert(firmware::link::kMaxJoints == firmware::kJoints &&
                firmware::link::kMaxLinkArms >= firmware::kMaxArms);
  std::atomic<std::uint32_t> tick_{0};
  std::array<std::atomic<float>, firmware::link::kMaxMotors> current_A_;
};

}  // namespace thimble::board

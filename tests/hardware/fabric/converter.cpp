#include "tests/hardware/fabric/converter.h"

namespace thimble::tests {
namespace {

constexpr std::uint32_t kSyncHigh = 10;  // 100 ns
constexpr std::uint32_t kHalf = 2;       // 13 ns, and a period of 33 ns is 4
constexpr std::uint32_t kSetup = 1;      // 7 ns
constexpr std::uint32_t kPowerUp = 100;  // 10 us at the 10 MHz of the model

}  // namespace

void Converter::clock(bool sync_n, bool sclk, bool sdin) {
  ++since_sync_, ++since_sclk_, ++since_sdin_, ++since_power_;
  if (sdin != sdin_) {
    since_sdin_ = 0;
    if (since_sclk_ < kSetup && !sclk_) ++violations;  // held after the falling edge
  }
  if (sync_n != sync_n_) {
    if (!sync_n && since_sync_ < kSyncHigh) ++violations;
    if (sync_n && since_sclk_ < kHalf) ++violations;
    if (sync_n) take();
    since_sync_ = 0;
    bits_ = 0;
  }
  if (sclk != sclk_) {
    if (since_sclk_ < kHalf || sync_n) ++violations;
    if (!sclk) {
      if (since_sdin_ < kSetup || since_sync_ < kHalf) ++violations;
      frame_ = frame_ << 1U | (sdin ? 1U : 0U);
      ++bits_;
    }
    since_sclk_ = 0;
  }
  sync_n_ = sync_n, sclk_ = sclk, sdin_ = sdin;
}

void Converter::take() {
  frame_ &= 0xFFFFFFU;
  if (bits_ != 24) {
    ++violations;
    return;
  }
  frames.push_back(frame_);
  const std::uint32_t address = frame_ >> 16U & 7U;
  switch (frame_ >> 19U & 7U) {
    case 0:
      if (address < 4) input_[address] = static_cast<std::int16_t>(frame_ & 0xFFFFU);
      break;
    case 1:
      range = frame_ & 7U;
      break;
    case 2:
      if ((power ^ frame_) & 0x1FU) since_power_ = 0;
      power = frame_ & 0x1FU;
      break;
    case 3:
      if (address != 5 || since_power_ < kPowerUp) ++violations;
      output = input_;
      ++loads;
      break;
    default:
      ++violations;
  }
}

}  // namespace thimble::tests

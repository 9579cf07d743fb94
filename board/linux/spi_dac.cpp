#include "board/linux/spi_dac.h"

#include <sys/ioctl.h>

namespace thimble::board {

SpiDac::SpiDac(const std::string& device, std::uint32_t speed_Hz,
               const std::array<Ad5754::Channel, kArmJoints>& channels)
    : device_(open_file(device, O_RDWR)), channels_(channels) {
  std::uint8_t mode = SPI_MODE_1, bits = 8;
  if (ioctl(device_.get(), SPI_IOC_WR_MODE, &mode) != 0 ||
      ioctl(device_.get(), SPI_IOC_WR_BITS_PER_WORD, &bits) != 0 ||
      ioctl(device_.get(), SPI_IOC_WR_MAX_SPEED_HZ, &speed_Hz) != 0)
    throw std::system_error(errno, std::generic_category(), device + ": set SPI mode and speed");
  for (std::size_t i = 0; i < kFrames; ++i) {
    transfers_[i].tx_buf = reinterpret_cast<std::uintptr_t>(frames_[i].data());
    transfers_[i].len = static_cast<std::uint32_t>(frames_[i].size());
    transfers_[i].cs_change = 1;  // each frame is accepted at the end of its chip select
  }
  transfers_[kFrames - 1].cs_change = 0;
  // Set the range while the outputs are powered down, then zero current, then power up.
  if (!command(Ad5754::set_range()) || !zero() || !command(Ad5754::power_up()) || !zero())
    throw std::system_error(errno, std::generic_category(), device + ": write to the converter");
}

bool SpiDac::write(const std::array<float, kArmJoints>& current_A) noexcept {
  for (std::size_t i = 0; i < channels_.size(); ++i)
    frames_[i] =
        Ad5754::voltage(static_cast<std::uint8_t>(i), Ad5754::word(channels_[i], current_A[i]).value);
  frames_[kFrames - 1] = Ad5754::load();
  return ioctl(device_.get(), SPI_IOC_MESSAGE(kFrames), transfers_.data()) >= 0;
}

bool SpiDac::command(const Ad5754::Frame& frame) noexcept {
  frames_[kFrames - 1] = frame;
  return ioctl(device_.get(), SPI_IOC_MESSAGE(1), &transfers_[kFrames - 1]) >= 0;
}

}  // namespace thimble::board

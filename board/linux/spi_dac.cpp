#include "board/linux/spi_dac.h"

#include <sys/ioctl.h>

namespace thimble::board {

SpiDac::SpiDac(const std::string& device, std::uint32_t speed_Hz,
               const std::array<std::optional<Ad5754::Channel>, Ad5754::kOutputs>& channels)
    : device_(open_file(device, O_RDWR)) {
  for (std::size_t j = 0; j < channels.size(); ++j)
    if (channels[j]) outputs_[count_++] = {*channels[j], static_cast<std::uint8_t>(j)};
  std::uint8_t mode = SPI_MODE_1, bits = 8;
  if (ioctl(device_.get(), SPI_IOC_WR_MODE, &mode) != 0 ||
      ioctl(device_.get(), SPI_IOC_WR_BITS_PER_WORD, &bits) != 0 ||
      ioctl(device_.get(), SPI_IOC_WR_MAX_SPEED_HZ, &speed_Hz) != 0)
    throw std::system_error(errno, std::generic_category(), device + ": set SPI mode and speed");
  for (std::size_t i = 0; i <= count_; ++i) {
    transfers_[i].tx_buf = reinterpret_cast<std::uintptr_t>(frames_[i].data());
    transfers_[i].len = static_cast<std::uint32_t>(frames_[i].size());
    transfers_[i].cs_change = 1;  // each frame is accepted at the end of its chip select
  }
  transfers_[count_].cs_change = 0;
  // Set the range while the outputs are powered down, then zero current, then power up.
  if (!command(Ad5754::set_range()) || !zero() || !command(Ad5754::power_up()) || !zero())
    throw std::system_error(errno, std::generic_category(), device + ": write to the converter");
}

bool SpiDac::write(const std::array<float, kArmJoints>& current_A) noexcept {
  for (std::size_t i = 0; i < count_; ++i) {
    const auto& [channel, joint] = outputs_[i];
    frames_[i] = Ad5754::voltage(joint, Ad5754::word(channel, current_A[joint]).value);
  }
  frames_[count_] = Ad5754::load();
  // The number of transfers is a part of the request.
  const unsigned long request = _IOC(_IOC_WRITE, SPI_IOC_MAGIC, 0, (count_ + 1) * sizeof(spi_ioc_transfer));
  return ioctl(device_.get(), request, transfers_.data()) >= 0;
}

bool SpiDac::command(const Ad5754::Frame& frame) noexcept {
  frames_[count_] = frame;
  return ioctl(device_.get(), SPI_IOC_MESSAGE(1), &transfers_[count_]) >= 0;
}

}  // namespace thimble::board

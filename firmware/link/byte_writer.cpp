#include "firmware/link/byte_writer.h"

#include <algorithm>

namespace thimble::firmware::link {

void ByteWriter::put(std::uint8_t value) noexcept { put(std::span<const std::uint8_t>(&value, 1)); }

void ByteWriter::put_u16(std::uint16_t value) noexcept {
  put(static_cast<std::uint8_t>(value >> 8U));
  put(static_cast<std::uint8_t>(value));
}

void ByteWriter::put_u32(std::uint32_t value) noexcept {
  put_u16(static_cast<std::uint16_t>(value >> 16U));
  put_u16(static_cast<std::uint16_t>(value));
}

void ByteWriter::put(std::span<const std::uint8_t> bytes) noexcept {
  if (bytes.size() > out_.size() - size_) {
    overflowed_ = true;
    return;
  }
  std::ranges::copy(bytes, out_.begin() + static_cast<std::ptrdiff_t>(size_));
  size_ += bytes.size();
}

void ByteWriter::put_text(const char* text) noexcept {
  if (text == nullptr) return;
  while (*text != '\0' && !overflowed_) put(static_cast<std::uint8_t>(*text++));
}

void ByteWriter::advance(std::size_t bytes) noexcept {
  if (bytes > out_.size() - size_) {
    overflowed_ = true;
    return;
  }
  size_ += bytes;
}

void ByteWriter::cut_to(std::size_t size) noexcept { size_ = std::min(size, size_); }

}  // namespace thimble::firmware::link

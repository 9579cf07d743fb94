// Writes an answer of the services into a buffer: big-endian numbers, texts, records of messages.def. It never writes past
// the end; it remembers that something did not fit.
//
// Who calls it: the handlers of firmware/services/.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "firmware/link/messages.h"

namespace thimble::firmware::link {

class ByteWriter {
 public:
  explicit ByteWriter(std::span<std::uint8_t> out) noexcept : out_(out) {}
  void put(std::uint8_t value) noexcept;
  void put_u16(std::uint16_t value) noexcept;  // big-endian, as ISO 14229 has it
  void put_u32(std::uint32_t value) noexcept;  // big-endian
  void put(std::span<const std::uint8_t> bytes) noexcept;
  void put_text(const char* text) noexcept;  // without its end; null counts as empty
  template <class Message>
  void put_record(const Message& message) noexcept;  // a record of messages.def

  [[nodiscard]] std::size_t size() const noexcept { return size_; }
  [[nodiscard]] bool overflowed() const noexcept { return overflowed_; }
  [[nodiscard]] std::span<std::uint8_t> free_space() noexcept { return out_.subspan(size_); }
  void advance(std::size_t bytes) noexcept;  // after writing into free_space()
  void cut_to(std::size_t size) noexcept;    // forgets what was appended behind; size is at most size()

 private:
  std::span<std::uint8_t> out_;
  std::size_t size_ = 0;
  bool overflowed_ = false;
};

template <class Message>
void ByteWriter::put_record(const Message& message) noexcept {
  const std::size_t bytes = encode(message, free_space());
  if (bytes == 0) overflowed_ = true;
  size_ += bytes;
}

}  // namespace thimble::firmware::link

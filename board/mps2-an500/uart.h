// UART 0, driven by interrupts (a product would use USB CDC). Bytes are queued in two rings; bytes that do
// not fit are dropped and counted.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>

namespace thimble::board::uart {

void start() noexcept;

// --- background context
[[nodiscard]] bool take(char& byte) noexcept;             // false: no byte received
[[nodiscard]] std::size_t room() noexcept;                // bytes that put() accepts now
[[nodiscard]] bool put(std::string_view bytes) noexcept;  // all bytes, or none: false
void forget() noexcept;                                   // discards the bytes to be sent
[[nodiscard]] bool sent() noexcept;                       // all bytes have been sent
[[nodiscard]] std::uint32_t dropped() noexcept;           // received bytes that did not fit, since start

}  // namespace thimble::board::uart

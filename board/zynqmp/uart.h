// UART 1 (Cadence), polled from the background: the second link, as SLCAN, after some lines of text at start.
// Bytes to be sent are queued in a ring, received ones in the UART's FIFO of 64 bytes (0.7 ms at 921600
// baud). An overrun of that FIFO is counted.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>

namespace thimble::board::uart {

void start(std::uint32_t clock_Hz, std::uint32_t baud) noexcept;

[[nodiscard]] bool take(char& byte) noexcept;             // false: no byte received
[[nodiscard]] std::size_t room() noexcept;                // bytes that put() accepts now
[[nodiscard]] bool put(std::string_view bytes) noexcept;  // all bytes, or none: false
void feed() noexcept;                                     // fills the transmit FIFO; called in every cycle
void forget() noexcept;                                   // discards the bytes to be sent
[[nodiscard]] bool sent() noexcept;                       // all bytes have been sent
[[nodiscard]] std::uint32_t overruns() noexcept;          // of the receive FIFO, since start

}  // namespace thimble::board::uart

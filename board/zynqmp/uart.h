// UART 1 (Cadence), polled from the background: the second link, as SLCAN, after a few lines of text at start. Bytes to be sent wait in a
// ring, received ones in the UART's FIFO of 64 bytes: 0.7 ms at 921600 baud. A byte that found no room there is lost, and counted.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>

namespace thimble::board::uart {

void start(std::uint32_t clock_Hz, std::uint32_t baud) noexcept;

[[nodiscard]] bool take(char& byte) noexcept;             // false: nothing has come
[[nodiscard]] std::size_t room() noexcept;                // bytes that put() takes now
[[nodiscard]] bool put(std::string_view bytes) noexcept;  // whole, or not at all: false
void feed() noexcept;                                     // gives the FIFO what fits; every round
void forget() noexcept;                                   // what waits to be sent
[[nodiscard]] bool sent() noexcept;                       // nothing waits
[[nodiscard]] std::uint32_t overruns() noexcept;          // of the receiver's FIFO, since start

}  // namespace thimble::board::uart

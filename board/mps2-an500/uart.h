// UART 0, driven by interrupts: what a sold board has as USB CDC. Bytes wait in two rings; one that finds no room is dropped and
// counted.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>

namespace thimble::board::uart {

void start() noexcept;

// --- background context
[[nodiscard]] bool take(char& byte) noexcept;             // false: nothing has come
[[nodiscard]] std::size_t room() noexcept;                // bytes that put() takes now
[[nodiscard]] bool put(std::string_view bytes) noexcept;  // whole, or not at all: false
void forget() noexcept;                                   // what waits to be sent
[[nodiscard]] bool sent() noexcept;                       // nothing waits
[[nodiscard]] std::uint32_t dropped() noexcept;           // received bytes without room, since start

}  // namespace thimble::board::uart

// Text of devices and files for a terminal.
#pragma once

#include <string>
#include <string_view>

namespace thimble::host {

// Control characters, which could command the terminal, as "\x1b"; also those of UTF-8 (U+0080 to U+009F). Line feed and tab stay.
[[nodiscard]] std::string printable(std::string_view text);

}  // namespace thimble::host

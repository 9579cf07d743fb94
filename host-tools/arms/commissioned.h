// Whether an arm file is as it was when it passed a commissioning: the key `commissioned`, which `thimble commission` writes.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

namespace thimble::host {

inline constexpr const char* kCommissionedKey = "commissioned";

// The CRC-32 of all that a board works by, 8 hexadecimal digits: not of `$schema`, `description`, `source` and `commissioned`, nor of the order
// of the keys.
[[nodiscard]] std::string commissioned_crc(nlohmann::json arm);

}  // namespace thimble::host

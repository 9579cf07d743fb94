// What to do about a refusal that the device gives a reason for.
#pragma once

#include <string>

namespace thimble::host {

// `reasons` are the names that the device gives, "not_homed,no_scene"; one may be followed by details. Never empty.
[[nodiscard]] std::string remedy_of(const std::string& reasons);

// A reason that a latched fault does not explain.
[[nodiscard]] bool is_of_its_own(const std::string& reason);

}  // namespace thimble::host

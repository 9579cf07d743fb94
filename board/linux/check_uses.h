// What the board's configuration may name once only: a GPIO line with one purpose, a count of one joint, an interface of one link.
#pragma once

#include "board/files/json_value.h"

namespace thimble::board {

// root: the configuration, whose values have been read without an error. Throws JsonError at the second use. Allowed: two arms share an
// input (their drive faults, or their indices) with the same level.
void check_uses(const JsonValue& root);

}  // namespace thimble::board

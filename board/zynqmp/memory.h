// What the processor may do where: its memory protection unit, and the caches.
#pragma once

namespace thimble::board {

// Called by the start-up code, before the runtime starts. Anything outside crashes: a null pointer's neighbourhood is code, which cannot
// be written.
void protect_memory() noexcept;

}  // namespace thimble::board

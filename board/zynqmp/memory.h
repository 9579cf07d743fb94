// Configuration of the memory protection unit and the caches.
#pragma once

namespace thimble::board {

// Called by the start-up code before the runtime is initialised. Access outside the regions is a crash.
// Addresses near a null pointer are code and cannot be written.
void protect_memory() noexcept;

// Code and constants that no tick uses, in DDR. Unless permitted, access to them is a crash: the tests' image
// forbids it during a tick.
void permit_outside(bool permitted) noexcept;

}  // namespace thimble::board

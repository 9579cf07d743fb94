// FlatBuffers' assertion without stdio: the standard one drags malloc and printf into the controller's image.
#pragma once

inline void thimble_flatbuffers_assert(bool sound) {
  if (!sound) __builtin_trap();
}

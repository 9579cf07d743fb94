/* What wasi-libc lacks; assimp then takes a path as it is. */
#pragma once
static inline char *realpath(const char *path, char *resolved) {
  return (void)path, (void)resolved, (char *)0;
}

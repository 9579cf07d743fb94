// Included by one source of each test program that reads models which Assimp refuses.
#pragma once

// Assimp leaks a few bytes when it refuses a file; the leak check is about our own code.
extern "C" const char* __lsan_default_suppressions();  // NOLINT(bugprone-reserved-identifier)
extern "C" const char* __lsan_default_suppressions() {
  return "leak:libassimp\n";
}  // NOLINT(bugprone-reserved-identifier)

// Prints a figure that a test asserts, with its limit.
#pragma once

#include <cstdio>
#include <string>

namespace thimble::test {

inline double figure(const std::string& what, double value, const std::string& limit) {
  std::printf("[ figure   ] %-72s %12.6g   (%s)\n", what.c_str(), value, limit.c_str());
  return value;
}

}  // namespace thimble::test

// What a board needs and does not have: a device, a privilege. It then runs all the same and answers over the link, but
// does not arm (firmware::Config::lacks); `thimble-board --check` prints the list.
#pragma once

#include <cerrno>
#include <string>

namespace thimble::board {

struct Missing {
  std::string name;  // short, for the host: "no_encoders"
  std::string what;  // with its cause: "/dev/spidev0.0: Permission denied"
  std::string remedy;
  int error = 0;  // errno

  [[nodiscard]] bool forbidden() const noexcept { return error == EACCES || error == EPERM; }
};

}  // namespace thimble::board

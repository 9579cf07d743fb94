// A device or privilege that the board needs and does not have. The board still runs and answers over the
// link, but refuses to arm (firmware::Config::lacks); `thimble-board --check` prints the list.
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

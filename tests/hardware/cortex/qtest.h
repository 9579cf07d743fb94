// A connection to QEMU's test socket (-qtest): reads and writes of the emulated machine's memory and registers, from outside. Many commands
// go out at once, and their answers come back in order. Throws std::runtime_error when QEMU has ended or refuses.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "board/posix/descriptor.h"

namespace thimble::tests {

class Qtest {
 public:
  explicit Qtest(const std::string& socket);

  struct Access {
    std::uint32_t address = 0;
    bool write = false;
    std::uint32_t value = 0;  // to be written; what was read
  };
  void run(std::span<Access> accesses);

  [[nodiscard]] std::uint32_t read(std::uint32_t address) {
    Access access{address};
    run({&access, 1});
    return access.value;
  }
  void write(std::uint32_t address, std::uint32_t value) {
    Access access{address, true, value};
    run({&access, 1});
  }

 private:
  [[nodiscard]] std::string line();

  board::Descriptor socket_;
  std::string received_;
};

}  // namespace thimble::tests

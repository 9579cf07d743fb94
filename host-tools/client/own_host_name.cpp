#include <errno.h>
#include <unistd.h>

#include <array>
#include <cstdlib>

#include "host-tools/client/host_name.h"

namespace thimble::host {

std::string host_name(const std::string& program) {
  std::array<char, 256> machine{};
  if (gethostname(machine.data(), machine.size() - 1) != 0) machine = {};
  const char* const user = std::getenv("USER");
  return host_name(user != nullptr ? user : "uid" + std::to_string(geteuid()), machine.data(),
                   program.empty() ? program_invocation_short_name : program);
}

}  // namespace thimble::host

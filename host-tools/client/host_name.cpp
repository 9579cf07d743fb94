#include "host-tools/client/host_name.h"

#include <errno.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdlib>

#include "firmware/link/messages.h"

namespace thimble::host {
namespace {

constexpr std::size_t kMostBytes = firmware::link::kHostNameBytes;
constexpr std::size_t kLeastOfUser = 8;  // with the machine, however long the program's name is

}  // namespace

std::string host_name(const std::string& user, const std::string& machine, const std::string& program) {
  std::string who = user + "@" + machine.substr(0, machine.find('.'));
  const std::size_t left = kMostBytes - std::min(kMostBytes, program.size() + 1);
  who.resize(std::min(who.size(), std::max(left, kLeastOfUser)));
  std::string name = (who + " " + program).substr(0, kMostBytes);
  for (char& letter : name)
    if (letter < 0x20 || letter > 0x7E) letter = '?';
  return name;
}

std::string host_name(const std::string& program) {
  std::array<char, 256> machine{};
  if (gethostname(machine.data(), machine.size() - 1) != 0) machine = {};
  const char* const user = std::getenv("USER");
  return host_name(user != nullptr ? user : "uid" + std::to_string(geteuid()), machine.data(),
                   program.empty() ? program_invocation_short_name : program);
}

}  // namespace thimble::host

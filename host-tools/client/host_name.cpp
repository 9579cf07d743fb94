#include "host-tools/client/host_name.h"

#include <algorithm>

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

}  // namespace thimble::host

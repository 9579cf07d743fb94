#include "host-tools/files/removed_on_signal.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <climits>
#include <csignal>
#include <cstring>
#include <string>

namespace thimble::host {
namespace {

// No heap, which a signal handler must not use. An empty path: the place is free.
std::array<std::array<char, PATH_MAX>, 8> paths{};

void remove_and_end(int signal) {
  for (auto path = paths.rbegin(); path != paths.rend(); ++path) {
    if ((*path)[0] != '\0' && unlink(path->data()) != 0) rmdir(path->data());
  }
  std::signal(signal, SIG_DFL);
  std::raise(signal);
}

}  // namespace

RemovedOnSignal::RemovedOnSignal(const std::filesystem::path& path) : place_(paths.size()) {
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    struct sigaction now {};
    if (sigaction(signal, nullptr, &now) == 0 && now.sa_handler == SIG_DFL)
      std::signal(signal, remove_and_end);
  }
  const std::string name = std::filesystem::absolute(path).string();
  const auto free = std::ranges::find_if(paths, [](const auto& one) { return one[0] == '\0'; });
  if (free == paths.end() || name.size() >= free->size()) return;
  place_ = static_cast<std::size_t>(free - paths.begin());
  // The first character last: a signal in between finds a whole path or none.
  std::strcpy(free->data() + 1, name.c_str() + 1);
  std::atomic_signal_fence(std::memory_order_seq_cst);
  (*free)[0] = name[0];
}

void RemovedOnSignal::forget() {
  if (place_ < paths.size()) paths[place_][0] = '\0';
  place_ = paths.size();
}

}  // namespace thimble::host

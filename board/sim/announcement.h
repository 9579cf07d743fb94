// Announcement of a running simulator: a small file in the runtime directory, $XDG_RUNTIME_DIR/thimble or
// /tmp/thimble-<uid>, which the simulator keeps locked while it runs. thimble-sim writes it, the host's
// discovery reads it.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace thimble::board {

struct Announcement {
  std::string name;
  std::string arm;
  std::vector<std::string> uris;  // the preferred one first
};

// The announcement exists as long as the object. If the process is killed, its file stays but is no longer
// locked: it is not listed, and the next simulator removes it.
class Announced {
 public:
  // Throws std::runtime_error if the directory is not writable or the name is in use.
  explicit Announced(const Announcement& announcement);
  Announced(const Announced&) = delete;
  Announced& operator=(const Announced&) = delete;
  ~Announced();

 private:
  std::filesystem::path file_;
  int fd_;
};

[[nodiscard]] std::vector<Announcement> announcements();  // of the running simulators, sorted by name

}  // namespace thimble::board

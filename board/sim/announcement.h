// Announcement of a running simulator: a small file in the runtime directory, $XDG_RUNTIME_DIR/thimble or
// /tmp/thimble-<uid>, which the simulator keeps locked while it runs. thimble-sim writes it, the host's
// discovery reads it.
//
// The directory must be this user's, with mode 0700, and no symbolic link: anybody can make one of that name in /tmp.
#pragma once

#include <string>
#include <vector>

#include "board/posix/descriptor.h"

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
  // Throws std::runtime_error if the directory is not safe or not writable, or the name is in use.
  explicit Announced(const Announcement& announcement);
  Announced(const Announced&) = delete;
  Announced& operator=(const Announced&) = delete;
  ~Announced();

 private:
  Descriptor folder_;
  std::string file_;  // its name in the folder
  Descriptor fd_;
};

struct Announcements {
  std::vector<Announcement> found;  // of the running simulators, sorted by name
  std::string
      trouble;  // why there are none to be trusted, as a sentence without full stop; empty: no trouble
};
// Without the addresses that belong to another user.
[[nodiscard]] Announcements announcements();

}  // namespace thimble::board

// How a running simulator is found: it keeps one small file in the runtime directory,
// $XDG_RUNTIME_DIR/thimble or /tmp/thimble-<uid>, locked for as long as it lives. thimble-sim writes it, the
// host's discovery reads it.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace thimble::board {

struct Announcement {
  std::string name;
  std::string arm;
  std::vector<std::string> uris;  // the best first
};

// There while the object lives, and gone with the process however that ends: what is left of a killed one is
// not locked, so nobody lists it and the next simulator removes it.
class Announced {
 public:
  // Throws std::runtime_error when the directory cannot be written, or the name is in use.
  explicit Announced(const Announcement& announcement);
  Announced(const Announced&) = delete;
  Announced& operator=(const Announced&) = delete;
  ~Announced();

 private:
  std::filesystem::path file_;
  int fd_;
};

[[nodiscard]] std::vector<Announcement> announcements();  // of the simulators that live, by name

}  // namespace thimble::board

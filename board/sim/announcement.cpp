#include "board/sim/announcement.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <stdexcept>
#include <string_view>
#include <system_error>

namespace thimble::board {
namespace {

namespace fs = std::filesystem;

fs::path runtime_directory() {
  const char* runtime = std::getenv("XDG_RUNTIME_DIR");
  if (runtime != nullptr && *runtime != '\0') return fs::path(runtime) / "thimble";
  return "/tmp/thimble-" + std::to_string(getuid());
}

bool is_announcement(const fs::path& file) { return file.extension() == ".sim"; }

// Opens the file and reports whether a running simulator has locked it.
bool is_alive(const fs::path& file) {
  const int fd = open(file.c_str(), O_RDONLY | O_CLOEXEC);
  if (fd < 0) return false;
  const bool alive = flock(fd, LOCK_SH | LOCK_NB) != 0;
  close(fd);
  return alive;
}

}  // namespace

Announced::Announced(const Announcement& announcement) {
  const fs::path directory = runtime_directory();
  std::error_code failed;
  fs::create_directories(directory, failed);
  for (const auto& entry : fs::directory_iterator(directory, failed)) {
    if (is_announcement(entry.path()) && !is_alive(entry.path())) fs::remove(entry.path(), failed);
  }
  file_ = directory / (announcement.name + ".sim");
  fd_ = open(file_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600);
  if (fd_ < 0) throw std::runtime_error("cannot write " + file_.string() + ": " + std::strerror(errno));
  if (flock(fd_, LOCK_EX | LOCK_NB) != 0) {
    close(fd_);
    throw std::runtime_error("another simulator is named '" + announcement.name + "'");
  }
  std::string text = "arm=" + announcement.arm + "\n";
  for (const std::string& uri : announcement.uris) text += "uri=" + uri + "\n";
  if (ftruncate(fd_, 0) != 0 || write(fd_, text.data(), text.size()) != static_cast<ssize_t>(text.size())) {
    close(fd_);
    throw std::runtime_error("cannot write " + file_.string());
  }
}

Announced::~Announced() {
  std::error_code ignored;
  fs::remove(file_, ignored);
  fs::remove(file_.parent_path(), ignored);  // succeeds if this was the last file
  close(fd_);
}

std::vector<Announcement> announcements() {
  std::vector<Announcement> found;
  std::error_code none;
  for (const auto& entry : fs::directory_iterator(runtime_directory(), none)) {
    if (!is_announcement(entry.path()) || !is_alive(entry.path())) continue;
    Announcement announcement;
    announcement.name = entry.path().stem().string();
    std::ifstream file(entry.path());
    for (std::string line; std::getline(file, line);) {
      const std::string_view text(line);
      if (text.starts_with("arm=")) announcement.arm = text.substr(4);
      if (text.starts_with("uri=")) announcement.uris.emplace_back(text.substr(4));
    }
    if (!announcement.uris.empty()) found.push_back(announcement);
  }
  std::ranges::sort(found, {}, &Announcement::name);
  return found;
}

}  // namespace thimble::board

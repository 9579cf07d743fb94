#include "board/sim/announcement.h"

#include <arpa/inet.h>
#include <dirent.h>
#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <memory>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <string_view>
#include <system_error>
#include <utility>

#include "board/posix/socket_owner.h"

namespace thimble::board {
namespace {

constexpr std::string_view kSuffix = ".sim";
constexpr std::size_t kMostBytes = 4096;  // of an announcement

[[noreturn]] void fail(const std::string& what) { throw std::runtime_error(what); }

std::string runtime_path() {
  const char* runtime = std::getenv("XDG_RUNTIME_DIR");
  if (runtime != nullptr && *runtime != '\0') return std::string(runtime) + "/thimble";
  return "/tmp/thimble-" + std::to_string(geteuid());
}

// Everything below the folder is reached through this descriptor, so nobody can exchange the folder after the check. Not open: there is
// none.
Descriptor open_folder(const std::string& path) {
  const std::string remedy = ": remove it, or set XDG_RUNTIME_DIR to a folder of yours";
  Descriptor folder(open(path.c_str(), O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC));
  if (!folder.is_open()) {
    if (errno == ENOENT) return folder;
    if (errno == ENOTDIR || errno == ELOOP) fail(path + " is not a folder, or is a symbolic link" + remedy);
    fail("cannot open " + path + ": " + std::strerror(errno) + remedy);
  }
  struct stat about {};
  if (fstat(folder.get(), &about) != 0) fail("cannot open " + path + ": " + std::strerror(errno));
  if (about.st_uid != geteuid())
    fail(path + " belongs to the user " + std::to_string(about.st_uid) + ", not to you" + remedy);
  if ((about.st_mode & 077U) != 0) fail(path + " is open to other users (chmod 700 closes it)" + remedy);
  return folder;
}

// An announcement, and never what a link, a pipe or another user has put there.
Descriptor open_announcement(const Descriptor& folder, const std::string& name, int flags) {
  Descriptor file(openat(folder.get(), name.c_str(), flags | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC, 0600));
  struct stat about {};
  if (file.is_open() && (fstat(file.get(), &about) != 0 || !S_ISREG(about.st_mode) ||
                         about.st_uid != geteuid() || about.st_nlink > 1)) {
    errno = EPERM;
    return {};
  }
  return file;
}

std::vector<std::string> names_in(const Descriptor& folder) {
  std::vector<std::string> names;
  const std::unique_ptr<DIR, int (*)(DIR*)> entries(
      fdopendir(openat(folder.get(), ".", O_RDONLY | O_DIRECTORY | O_CLOEXEC)), closedir);
  while (const dirent* entry = entries ? readdir(entries.get()) : nullptr) {
    const std::string_view name(static_cast<const char*>(entry->d_name));
    if (name.ends_with(kSuffix)) names.emplace_back(name);
  }
  std::ranges::sort(names);
  return names;
}

// A running simulator has locked it.
bool is_alive(const Descriptor& file) { return file.is_open() && flock(file.get(), LOCK_SH | LOCK_NB) != 0; }

// False only where it is known whose it is.
bool may_be_own(const std::string& uri) {
  constexpr std::string_view kSlcan = "slcan:";
  constexpr std::string_view kTcp = "tcp:127.0.0.1:";
  if (uri.starts_with(kSlcan)) {
    struct stat about {};
    return stat(uri.c_str() + kSlcan.size(), &about) != 0 || about.st_uid == geteuid();
  }
  if (uri.starts_with(kTcp)) {
    sockaddr_in listener{};
    listener.sin_family = AF_INET;
    std::uint16_t port = 0;
    std::from_chars(uri.data() + kTcp.size(), uri.data() + uri.size(), port);
    listener.sin_port = htons(port);
    listener.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    const std::optional<uid_t> owner = socket_owner(listener, {});
    return !owner || *owner == geteuid();
  }
  return true;
}

}  // namespace

Announced::Announced(const Announcement& announcement) : file_(announcement.name + std::string(kSuffix)) {
  const std::string path = runtime_path();
  std::error_code ignored;
  std::filesystem::create_directories(std::filesystem::path(path).parent_path(), ignored);
  if (mkdir(path.c_str(), 0700) != 0 && errno != EEXIST)
    fail("cannot make " + path + ": " + std::strerror(errno));
  folder_ = open_folder(path);
  if (!folder_.is_open()) fail("cannot make " + path);
  for (const std::string& name : names_in(folder_)) {
    if (!is_alive(open_announcement(folder_, name, O_RDONLY))) unlinkat(folder_.get(), name.c_str(), 0);
  }
  fd_ = open_announcement(folder_, file_, O_RDWR | O_CREAT);
  if (!fd_.is_open()) fail("cannot write " + path + "/" + file_ + ": " + std::strerror(errno));
  if (flock(fd_.get(), LOCK_EX | LOCK_NB) != 0)
    fail("another simulator is named '" + announcement.name + "'");
  std::string text = "arm=" + announcement.arm + "\n";
  for (const std::string& uri : announcement.uris) text += "uri=" + uri + "\n";
  if (ftruncate(fd_.get(), 0) != 0 ||
      write(fd_.get(), text.data(), text.size()) != static_cast<ssize_t>(text.size()))
    fail("cannot write " + path + "/" + file_);
}

Announced::~Announced() {
  unlinkat(folder_.get(), file_.c_str(), 0);
  rmdir(runtime_path().c_str());  // succeeds if this was the last file
}

Announcements announcements() {
  Announcements all;
  Descriptor folder;
  try {
    folder = open_folder(runtime_path());
  } catch (const std::runtime_error& error) {
    all.trouble = error.what();
  }
  if (!folder.is_open()) return all;
  for (const std::string& name : names_in(folder)) {
    const Descriptor file = open_announcement(folder, name, O_RDONLY);
    if (!is_alive(file)) continue;
    std::array<char, kMostBytes> bytes{};
    const ssize_t size = read(file.get(), bytes.data(), bytes.size());
    if (size <= 0) continue;
    Announcement announcement;
    announcement.name = name.substr(0, name.size() - kSuffix.size());
    std::istringstream lines(std::string(bytes.data(), static_cast<std::size_t>(size)));
    for (std::string line; std::getline(lines, line);) {
      const std::string_view text(line);
      if (text.starts_with("arm=")) announcement.arm = text.substr(4);
      if (text.starts_with("uri=") && may_be_own(line.substr(4)))
        announcement.uris.emplace_back(text.substr(4));
    }
    if (!announcement.uris.empty()) all.found.push_back(std::move(announcement));
  }
  return all;
}

}  // namespace thimble::board

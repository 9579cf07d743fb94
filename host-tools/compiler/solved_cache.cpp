#include "host-tools/compiler/solved_cache.h"

#include <dirent.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "firmware/link/crc32.h"

namespace thimble::host {
namespace {

constexpr std::string_view kMark = "thimble cache 1\n";
constexpr std::size_t kMostEntryBytes = std::size_t{64} << 20U;

class OpenFile {
 public:
  explicit OpenFile(int fd) : fd_(fd) {}
  OpenFile(const OpenFile&) = delete;
  OpenFile& operator=(const OpenFile&) = delete;
  ~OpenFile() {
    if (fd_ >= 0) close(fd_);
  }
  [[nodiscard]] int get() const { return fd_; }
  // Whether it is open, of this type (S_IFDIR, S_IFREG), and this user's own.
  [[nodiscard]] bool is_own(mode_t type, struct stat& about) const {
    return fd_ >= 0 && fstat(fd_, &about) == 0 && (about.st_mode & S_IFMT) == type &&
           about.st_uid == geteuid();
  }

 private:
  int fd_;
};

// Everything below is reached through this descriptor, so nobody can exchange the folder after the check. -1: not to be used.
int open_folder(const std::filesystem::path& path) {
  const int folder = open(path.c_str(), O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC);
  struct stat about {};
  if (folder < 0 || (fstat(folder, &about) == 0 && about.st_uid == geteuid() && (about.st_mode & 077U) == 0))
    return folder;
  close(folder);
  return -1;
}

void append_size(std::string& to, std::size_t size) {
  for (unsigned shift = 0; shift < 32; shift += 8) to += static_cast<char>(size >> shift & 0xFFU);
}

// The whole entry but its value and checksum.
std::string head_of(std::string_view key) {
  std::string head(kMark);
  append_size(head, key.size());
  return head.append(key);
}

std::uint32_t checksum(std::string_view bytes) {
  return firmware::link::crc32(std::as_bytes(std::span(bytes)));
}

std::string name_of(std::string_view key) {
  std::uint64_t hash = 0xCBF29CE484222325ULL;  // FNV-1a
  for (const char c : key) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001B3ULL;
  std::array<char, 24> name{};
  static_cast<void>(
      std::snprintf(name.data(), name.size(), "%016llx", static_cast<unsigned long long>(hash)));
  return name.data();
}

bool read_whole(int fd, std::string& bytes) {
  std::size_t got = 0;
  while (got < bytes.size()) {
    const ssize_t count = read(fd, bytes.data() + got, bytes.size() - got);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return false;
    got += static_cast<std::size_t>(count);
  }
  return true;
}

bool write_whole(int fd, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t count = write(fd, bytes.data(), bytes.size());
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return false;
    bytes.remove_prefix(static_cast<std::size_t>(count));
  }
  return true;
}

// Removes the files that were used longest ago, drafts of programs that were killed among them.
void shrink(int folder, std::uintmax_t most_bytes) {
  struct Entry {
    std::pair<time_t, long> used;
    std::uintmax_t bytes;
    std::string name;
  };
  std::vector<Entry> entries;
  std::uintmax_t sum = 0;
  const std::unique_ptr<DIR, int (*)(DIR*)> listing(
      fdopendir(openat(folder, ".", O_RDONLY | O_DIRECTORY | O_CLOEXEC)), closedir);
  while (const dirent* entry = listing ? readdir(listing.get()) : nullptr) {
    struct stat about {};
    const char* const name = static_cast<const char*>(entry->d_name);
    if (fstatat(folder, name, &about, AT_SYMLINK_NOFOLLOW) != 0 || !S_ISREG(about.st_mode)) continue;
    const auto bytes = static_cast<std::uintmax_t>(about.st_size);
    entries.push_back({{about.st_mtim.tv_sec, about.st_mtim.tv_nsec}, bytes, name});
    sum += bytes;
  }
  std::ranges::sort(entries, {}, &Entry::used);
  for (const Entry& entry : entries) {
    if (sum <= most_bytes) return;
    if (unlinkat(folder, entry.name.c_str(), 0) == 0) sum -= entry.bytes;
  }
}

}  // namespace

std::filesystem::path SolvedCache::user_folder() {
  const char* const cache = std::getenv("XDG_CACHE_HOME");
  if (cache != nullptr && *cache == '/') return std::filesystem::path(cache) / "thimble";
  const char* const home = std::getenv("HOME");
  if (home != nullptr && *home == '/') return std::filesystem::path(home) / ".cache" / "thimble";
  return {};
}

std::optional<std::string> SolvedCache::find(std::string_view key) const {
  const OpenFile folder(open_folder(folder_));
  if (folder.get() < 0) return std::nullopt;
  const OpenFile file(
      openat(folder.get(), name_of(key).c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC));
  struct stat about {};
  if (!file.is_own(S_IFREG, about)) return std::nullopt;
  const std::string head = head_of(key);
  const auto size = static_cast<std::size_t>(about.st_size);
  if (size < head.size() + 4 || size > kMostEntryBytes) return std::nullopt;
  std::string bytes(size, '\0');
  if (!read_whole(file.get(), bytes) || !bytes.starts_with(head)) return std::nullopt;
  std::string sum;
  append_size(sum, checksum(std::string_view(bytes).substr(0, size - 4)));
  if (!bytes.ends_with(sum)) return std::nullopt;
  static_cast<void>(futimens(file.get(), nullptr));  // used now
  return bytes.substr(head.size(), size - 4 - head.size());
}

void SolvedCache::keep(std::string_view key, std::string_view value) const {
  if (folder_.empty()) return;
  std::string bytes = head_of(key).append(value);
  append_size(bytes, checksum(bytes));
  if (bytes.size() > std::min<std::uintmax_t>(kMostEntryBytes, most_bytes_)) return;
  std::error_code ignored;
  std::filesystem::create_directories(folder_.parent_path(), ignored);
  static_cast<void>(mkdir(folder_.c_str(), 0700));
  const OpenFile folder(open_folder(folder_));
  if (folder.get() < 0) return;
  static std::atomic<unsigned> drafts{0};
  const std::string name = name_of(key);
  const std::string draft = name + ".part-" + std::to_string(getpid()) + "-" + std::to_string(++drafts);
  const OpenFile file(
      openat(folder.get(), draft.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0600));
  if (file.get() < 0) return;
  if (!write_whole(file.get(), bytes) ||
      renameat(folder.get(), draft.c_str(), folder.get(), name.c_str()) != 0) {
    static_cast<void>(unlinkat(folder.get(), draft.c_str(), 0));
    return;
  }
  shrink(folder.get(), most_bytes_);
}

}  // namespace thimble::host

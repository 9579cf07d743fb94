#include "board/files/text_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <span>

namespace thimble::board {
namespace {

// An open file. By the system's own calls, which a page has too: there are no file streams.
class InputFile {
 public:
  explicit InputFile(const std::filesystem::path& file) : fd_(open(file.c_str(), O_RDONLY | O_CLOEXEC)) {}
  InputFile(const InputFile&) = delete;
  InputFile& operator=(const InputFile&) = delete;
  ~InputFile() {
    if (fd_ >= 0) close(fd_);
  }
  [[nodiscard]] bool is_open() const { return fd_ >= 0; }
  // Bytes that were read; 0 at the end; below 0: errno.
  [[nodiscard]] ssize_t read(std::span<char> to) const { return ::read(fd_, to.data(), to.size()); }

 private:
  int fd_;
};

}  // namespace

const char* unreadable_kind(const std::filesystem::path& file) {
  struct stat status {};
  if (stat(file.c_str(), &status) != 0) return nullptr;
  if (S_ISDIR(status.st_mode)) return "Is a directory";
  return S_ISCHR(status.st_mode) || S_ISBLK(status.st_mode) ? "Is a device, not a file" : nullptr;
}

std::optional<std::uintmax_t> size_of_file(const std::filesystem::path& file) {
  struct stat status {};
  if (stat(file.c_str(), &status) != 0 || !S_ISREG(status.st_mode)) return std::nullopt;
  return static_cast<std::uintmax_t>(status.st_size);
}

std::optional<std::string> read_bounded(std::istream& in, std::size_t most) {
  std::string bytes;
  std::array<char, 65536> part{};
  while (in.read(part.data(), part.size()) || in.gcount() != 0) {
    bytes.append(part.data(), static_cast<std::size_t>(in.gcount()));
    if (bytes.size() > most) return std::nullopt;
  }
  return bytes;
}

std::string read_head(const std::filesystem::path& file, std::size_t most) {
  const auto fail = [&file](const char* why) { throw FileError(file.string() + ": " + why); };
  if (const char* why = unreadable_kind(file)) fail(why);
  const InputFile in(file);
  if (!in.is_open()) fail(std::strerror(errno));
  std::string text;
  std::array<char, 65536> part{};
  while (text.size() < most) {
    const ssize_t size = in.read(std::span(part).first(std::min(part.size(), most - text.size())));
    if (size < 0 && errno != EINTR) fail(std::strerror(errno));
    if (size == 0) break;
    text.append(part.data(), static_cast<std::size_t>(std::max(size, ssize_t{0})));
  }
  return text;
}

std::string read_text(const std::filesystem::path& file) {
  std::string text = read_head(file, kMostTextBytes + 1);
  if (text.size() > kMostTextBytes) throw FileError(file.string() + ": " + std::strerror(EFBIG));
  return text;
}

}  // namespace thimble::board

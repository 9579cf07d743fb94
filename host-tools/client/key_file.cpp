#include "host-tools/client/key_file.h"

#include <fcntl.h>
#include <sys/random.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <utility>

#include "host-tools/client/descriptor.h"
#include "host-tools/error.h"

namespace thimble::host {
namespace {

constexpr std::size_t kDigits = 2 * link::kKeyBytes;
constexpr mode_t kOthers = S_IRWXG | S_IRWXO;

[[noreturn]] void cannot(ExitCode code, const std::string& what, const std::filesystem::path& file,
                         int error) {
  throw Error(code, "key-file", what + " the key file " + file.string() + ": " + std::strerror(error),
              "name another file with --key, or mend this one");
}

}  // namespace

std::filesystem::path default_key_file() {
  if (const char* config = std::getenv("XDG_CONFIG_HOME"); config != nullptr && *config != '\0')
    return std::filesystem::path(config) / "thimble" / "key";
  const char* home = std::getenv("HOME");
  return std::filesystem::path(home == nullptr ? "." : home) / ".config" / "thimble" / "key";
}

link::Key read_key(const std::filesystem::path& file) {
  const Descriptor descriptor(open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
  if (descriptor.get() < 0) cannot(ExitCode::kPermission, "cannot open", file, errno);
  struct stat status {};
  if (fstat(descriptor.get(), &status) != 0) cannot(ExitCode::kPermission, "cannot open", file, errno);
  if ((status.st_mode & kOthers) != 0) {
    throw Error(ExitCode::kPermission, "key-not-private",
                "other users may read the key file " + file.string(),
                "chmod 600 " + file.string() +
                    "; if others may have read it, give the board another key (`thimble key set FILE`)");
  }
  std::array<char, kDigits + 2> text{};
  const ssize_t got = read(descriptor.get(), text.data(), text.size());
  link::Key key{};
  bool good = got == static_cast<ssize_t>(kDigits) ||
              (got == static_cast<ssize_t>(kDigits + 1) && text[kDigits] == '\n');
  for (std::size_t i = 0; good && i < key.size(); ++i) {
    const char* digits = text.data() + 2 * i;
    good = std::from_chars(digits, digits + 2, key[i], 16).ptr == digits + 2;
  }
  if (!good) {
    throw Error(ExitCode::kBadInput, "not-a-key",
                file.string() + " is no key: it must be 64 hexadecimal digits",
                "name the right file with --key");
  }
  return key;
}

link::Key make_key(const std::filesystem::path& file) {
  std::error_code ignored;
  if (file.has_parent_path()) std::filesystem::create_directories(file.parent_path(), ignored);
  link::Key key;
  if (getrandom(key.data(), key.size(), 0) != static_cast<ssize_t>(key.size()))
    cannot(ExitCode::kRefused, "no random numbers for", file, errno);
  std::string text;
  for (const std::uint8_t byte : key) {
    constexpr const char* kHex = "0123456789abcdef";
    text += {kHex[byte >> 4U], kHex[byte & 0xFU]};
  }
  text += '\n';
  const Descriptor descriptor(open(file.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, S_IRUSR | S_IWUSR));
  if (descriptor.get() < 0) {
    if (errno == EEXIST) {
      throw Error(ExitCode::kRefused, "file-exists", "there is already a file " + file.string(),
                  "name another file, or remove this one if no board has its key");
    }
    cannot(errno == EACCES ? ExitCode::kPermission : ExitCode::kRefused, "cannot make", file, errno);
  }
  if (write(descriptor.get(), text.data(), text.size()) != static_cast<ssize_t>(text.size()) ||
      fsync(descriptor.get()) != 0)
    cannot(ExitCode::kRefused, "cannot write", file, errno);
  return key;
}

Prover prove_with(std::filesystem::path file) {
  return [file = std::move(file)](std::uint8_t node, std::uint8_t address, const link::Challenge& challenge) {
    std::error_code ignored;
    if (!std::filesystem::exists(file, ignored)) {
      throw Error(
          ExitCode::kPermission, "no-key",
          "the device takes commands only from who has its key, and there is no file " + file.string(),
          "copy the key file from where the key was set (`thimble key set`), or name it with --key");
    }
    return link::proof_of(read_key(file), node, address, challenge);
  };
}

}  // namespace thimble::host

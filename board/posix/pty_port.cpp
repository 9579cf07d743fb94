#include "board/posix/pty_port.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <termios.h>

#include <array>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <stdexcept>
#include <system_error>
#include <utility>

namespace thimble::board {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail_pty(const std::string& what) {
  throw std::runtime_error(what + ": " + std::strerror(errno));
}

}  // namespace

PtyPort::PtyPort(const std::string& link) {
  Descriptor master(posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC | O_NONBLOCK));
  std::array<char, 128> name{};
  if (!master.is_open() || grantpt(master.get()) != 0 || unlockpt(master.get()) != 0 ||
      ptsname_r(master.get(), name.data(), name.size()) != 0) {
    fail_pty("cannot open a pty");
  }
  stream_.emplace(std::move(master));
  slave_ = Descriptor(open(name.data(), O_RDWR | O_NOCTTY | O_CLOEXEC));
  termios settings{};
  if (!slave_.is_open() || tcgetattr(slave_.get(), &settings) != 0)
    fail_pty(std::string("cannot open ") + name.data());
  cfmakeraw(&settings);
  tcsetattr(slave_.get(), TCSANOW, &settings);
  fchmod(slave_.get(), S_IRUSR | S_IWUSR);  // the kernel lets the group tty write

  std::string path = name.data();
  if (!link.empty()) {
    std::error_code failed;
    if (fs::is_symlink(link, failed)) fs::remove(link, failed);  // left behind by a killed simulator
    fs::create_symlink(path, link, failed);
    if (failed) throw std::runtime_error("cannot make the link " + link + ": " + failed.message());
    link_ = link;
    path = fs::absolute(link).string();
  }
  uri_ = "slcan:" + path;
}

PtyPort::~PtyPort() {
  std::error_code ignored;
  if (!link_.empty()) fs::remove(link_, ignored);
}

}  // namespace thimble::board

// Supervision of the board: a watchdog (here a pipe) and a service manager (here a socket).
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <string>
#include <system_error>

#include "board/linux/open_file.h"
#include "board/linux/service_manager.h"
#include "board/linux/watchdog.h"
#include "tests/support/temporary_folder.h"

namespace thimble::test {
namespace {

using board::Descriptor;
using board::ServiceManager;
using board::Watchdog;

TEST(Watchdog, FeedsWithAnyByteAndDisarmsWithV) {
  std::array<int, 2> ends{};
  ASSERT_EQ(pipe2(ends.data(), O_CLOEXEC | O_NONBLOCK), 0);
  const Descriptor reading(ends[0]);
  {
    Watchdog watchdog{Descriptor(ends[1])};
    EXPECT_TRUE(watchdog.feed());
    EXPECT_TRUE(watchdog.feed());
    std::array<char, 16> bytes{};
    EXPECT_EQ(read(reading.get(), bytes.data(), bytes.size()), 2);
    EXPECT_EQ(std::string(bytes.data(), 2).find('V'), std::string::npos);
    EXPECT_TRUE(watchdog.disarm());
    EXPECT_EQ(read(reading.get(), bytes.data(), bytes.size()), 1);
    EXPECT_EQ(bytes[0], 'V');
  }
  char byte = 0;
  EXPECT_EQ(read(reading.get(), &byte, 1), 0);  // closed, and nothing more was said
}

TEST(Watchdog, RefusesWhatIsNone) {
  const TemporaryFolder folder;
  const auto file = folder.path() / "watchdog";
  EXPECT_THROW(Watchdog(file, 2), std::system_error);
  (void)board::open_file(file, O_WRONLY | O_CREAT);
  try {
    const Watchdog watchdog(file, 2);
    FAIL() << "a plain file was taken for a watchdog";
  } catch (const std::system_error& error) {
    // ENOSYS: qemu-user, which does not pass the watchdog's calls on.
    EXPECT_TRUE(error.code().value() == ENOTTY || error.code().value() == ENOSYS) << error.what();
    EXPECT_NE(std::string(error.what()).find(file.string()), std::string::npos);
  }
}

// A service manager's end of NOTIFY_SOCKET.
class Manager {
 public:
  explicit Manager(const std::string& path) : socket_(socket(AF_UNIX, SOCK_DGRAM | SOCK_NONBLOCK, 0)) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::memcpy(address.sun_path, path.data(), path.size());
    if (path[0] == '@') address.sun_path[0] = '\0';
    const auto size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + path.size());
    if (bind(socket_.get(), reinterpret_cast<const sockaddr*>(&address), size) != 0)
      throw std::system_error(errno, std::generic_category(), path);
    setenv("NOTIFY_SOCKET", path.c_str(), 1);
  }
  ~Manager() {
    for (const char* variable : {"NOTIFY_SOCKET", "WATCHDOG_USEC", "WATCHDOG_PID"}) unsetenv(variable);
  }
  std::string heard() const {
    std::array<char, 256> text{};
    const ssize_t size = recv(socket_.get(), text.data(), text.size(), 0);
    return size < 0 ? "nothing" : std::string(text.data(), static_cast<std::size_t>(size));
  }

 private:
  Descriptor socket_;
};

TEST(ServiceManager, HearsStates) {
  const TemporaryFolder folder;
  for (const std::string& path :
       {(folder.path() / "notify").string(), "@thimble-test-" + std::to_string(getpid())}) {
    const Manager there(path);
    setenv("WATCHDOG_USEC", "3000000", 1);
    ServiceManager manager;
    EXPECT_EQ(manager.watchdog_us(), 3'000'000U);
    manager.tell("READY=1");
    EXPECT_EQ(there.heard(), "READY=1");
    EXPECT_EQ(there.heard(), "nothing");
  }
}

TEST(ServiceManager, AnotherProcessIsWatched) {
  const TemporaryFolder folder;
  const Manager there((folder.path() / "notify").string());
  setenv("WATCHDOG_USEC", "3000000", 1);
  setenv("WATCHDOG_PID", "1", 1);
  EXPECT_EQ(ServiceManager().watchdog_us(), 0U);
}

TEST(ServiceManager, WithoutOneNothingHappens) {
  unsetenv("NOTIFY_SOCKET");
  ServiceManager manager;
  manager.tell("READY=1");
  EXPECT_EQ(manager.watchdog_us(), 0U);
  setenv("NOTIFY_SOCKET", "/nobody/listens", 1);
  EXPECT_THROW(ServiceManager(), std::system_error);
  unsetenv("NOTIFY_SOCKET");
}

}  // namespace
}  // namespace thimble::test

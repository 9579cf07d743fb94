#include "host-tools/can_tools/doctor_facts.h"

#include <grp.h>
#include <linux/can.h>
#include <pwd.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <system_error>

#include "host-tools/error.h"

namespace thimble::host {
namespace {

bool matches(const std::string& name, const std::string& prefix) {
  return name.size() > prefix.size() && name.starts_with(prefix) && name[prefix.size()] >= '0' &&
         name[prefix.size()] <= '9';
}

// A capability of this process, by its number in linux/capability.h.
bool capable(unsigned number) {
  std::ifstream status("/proc/self/status");
  for (std::string word; status >> word;) {
    if (word != "CapEff:") continue;
    std::uint64_t bits = 0;
    status >> std::hex >> bits;
    return (bits >> number & 1U) != 0;
  }
  return false;
}
constexpr unsigned kIpcLock = 14;
constexpr unsigned kSysNice = 23;

}  // namespace

std::vector<CanInterface> read_can_interfaces() {
  try {
    return board::read_can_interfaces();
  } catch (const std::system_error& error) {
    throw Error(ExitCode::kRefused, "no-netlink",
                std::string("the kernel does not tell its network interfaces: ") + error.code().message(),
                "run it outside of a sandbox that forbids AF_NETLINK");
  }
}

DeviceFile read_device(DeviceKind kind, const std::string& path) {
  DeviceFile device{kind, path, true, access(path.c_str(), R_OK | W_OK) == 0, "", false};
  struct stat status {};
  if (stat(path.c_str(), &status) != 0) {
    device.exists = errno != ENOENT && errno != ENOTDIR;
    return device;
  }
  constexpr mode_t kGroupMay = S_IRGRP | S_IWGRP;
  const group* owner = getgrgid(status.st_gid);
  if ((status.st_mode & kGroupMay) != kGroupMay || owner == nullptr || status.st_gid == 0) return device;
  device.group = owner->gr_name;
  const passwd* user = getpwuid(getuid());
  for (char** member = owner->gr_mem; user != nullptr && *member != nullptr; ++member)
    device.member_by_now = device.member_by_now || std::strcmp(*member, user->pw_name) == 0;
  return device;
}

std::vector<DeviceFile> read_devices(bool board) {
  std::vector<DeviceFile> found;
  std::error_code none;
  for (const auto& entry : std::filesystem::directory_iterator("/dev", none)) {
    const std::string name = entry.path().filename().string();
    const auto add = [&](DeviceKind kind) { found.push_back(read_device(kind, entry.path().string())); };
    if (matches(name, "ttyACM") || matches(name, "ttyUSB")) add(DeviceKind::kSerial);
    if (!board) continue;
    if (matches(name, "ttyGS")) add(DeviceKind::kSerial);
    if (matches(name, "gpiochip")) add(DeviceKind::kGpio);
    if (matches(name, "spidev")) add(DeviceKind::kSpi);
    if (matches(name, "counter")) add(DeviceKind::kCounter);
  }
  std::ranges::sort(found, {}, &DeviceFile::path);
  return found;
}

Privileges read_privileges() {
  Privileges privileges;
  rlimit limit{};
  if (capable(kSysNice)) {
    privileges.priority = 99;
  } else if (getrlimit(RLIMIT_RTPRIO, &limit) == 0) {
    privileges.priority = std::min<rlim_t>(limit.rlim_cur, 99);
  }
  if (!capable(kIpcLock) && getrlimit(RLIMIT_MEMLOCK, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY)
    privileges.locked_bytes = limit.rlim_cur;
  return privileges;
}

bool kernel_has_can_sockets() {
  const int can = socket(PF_CAN, SOCK_RAW | SOCK_CLOEXEC, CAN_RAW);
  if (can >= 0) close(can);
  return can >= 0 || errno == EPERM || errno == EACCES;
}

}  // namespace thimble::host

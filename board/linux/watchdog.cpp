#include "board/linux/watchdog.h"

#include <linux/watchdog.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>
#include <utility>

#include "board/linux/open_file.h"

namespace thimble::board {
namespace {

bool write_byte(const Descriptor& device, char byte) noexcept { return ::write(device.get(), &byte, 1) == 1; }

}  // namespace

Watchdog::Watchdog(const std::filesystem::path& device, int timeout_s)
    : device_(open_file(device, O_WRONLY)) {
  if (ioctl(device_.get(), WDIOC_SETTIMEOUT, &timeout_s) == 0) return;
  const int error = errno;
  (void)disarm();
  throw std::system_error(error, std::generic_category(), device.string() + ": set the timeout");
}

Watchdog::Watchdog(Descriptor device) noexcept : device_(std::move(device)) {}

bool Watchdog::restarted_machine() const noexcept {
  int status = 0;
  return ioctl(device_.get(), WDIOC_GETBOOTSTATUS, &status) == 0 && (status & WDIOF_CARDRESET) != 0;
}

bool Watchdog::feed() noexcept { return write_byte(device_, '\0'); }
bool Watchdog::disarm() noexcept { return write_byte(device_, 'V'); }

}  // namespace thimble::board

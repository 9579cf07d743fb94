#include "host-tools/client/transport.h"

#include <poll.h>
#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <cstdint>
#include <string_view>

#include "host-tools/client/descriptor.h"
#include "host-tools/client/slcan_transport.h"
#include "host-tools/client/socketcan_transport.h"
#include "host-tools/error.h"

namespace thimble::host {

using link::Micros;

Descriptor::~Descriptor() {
  if (fd_ >= 0) close(fd_);
}

bool wait_for(int fd, short events, Micros deadline_us) {
  while (true) {
    const Micros now = now_us();
    const Micros left_us = deadline_us > now ? deadline_us - now : 0;
    pollfd entry{fd, events, 0};
    const int ready = poll(&entry, 1, static_cast<int>((left_us + 999) / 1000));
    if (ready > 0) return true;
    if (ready == 0) return false;
    if (errno != EINTR) return false;
  }
}

// getaddrinfo() takes 99999 for 34463.
static bool is_port(std::string_view text) {
  std::uint16_t port = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), port);
  return error == std::errc() && end == text.data() + text.size() && port != 0;
}

std::unique_ptr<Transport> open_transport(const std::string& uri) {
  if (uri.starts_with("slcan:") && uri.size() > 6) return open_serial(uri.substr(6), uri);
  if (uri.starts_with("can:") && uri.size() > 4) return open_socketcan(uri.substr(4), false);
  if (uri.starts_with("canfd:") && uri.size() > 6) return open_socketcan(uri.substr(6), true);
  if (uri.starts_with("tcp:")) {
    const std::size_t colon = uri.rfind(':');
    if (colon > 4 && is_port(std::string_view(uri).substr(colon + 1)))
      return open_tcp(uri.substr(4, colon - 4), uri.substr(colon + 1), uri);
  }
  throw Error(ExitCode::kUsage, "bad-uri", "'" + uri + "' is not the address of a device",
              "write slcan:/dev/ttyACM0, can:can0, canfd:can0 or tcp:127.0.0.1:29536; `thimble list` shows "
              "what is there");
}

}  // namespace thimble::host

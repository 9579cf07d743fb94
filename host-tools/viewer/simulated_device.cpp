#include "host-tools/viewer/simulated_device.h"

#include <fcntl.h>
#include <sys/socket.h>

#include <array>
#include <cerrno>
#include <system_error>

#include "host-tools/client/slcan_transport.h"

namespace thimble::host {
namespace {

board::LiveOptions with_socket(board::LiveOptions options, Descriptor& host_end) {
  std::array<int, 2> ends{};
  if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0, ends.data()) != 0)
    throw std::system_error(errno, std::generic_category(), "socketpair");
  host_end = Descriptor(ends[0]);
  options.host_socket = ends[1];
  return options;
}

}  // namespace

SimulatedDevice::SimulatedDevice(const board::LiveOptions& options)
    : live_(with_socket(options, host_end_)), hands_(live_.board()), uri_(live_.uris().front()) {
  thread_ = std::thread([this] {
    live_.run([this] { return stopping_.load(); },
              [this](const board::LiveLoop::Round& round) { hands_.move(round); });
  });
}

SimulatedDevice::~SimulatedDevice() {
  stopping_ = true;
  thread_.join();
}

std::unique_ptr<Transport> SimulatedDevice::connect() const {
  return open_socket(Descriptor(fcntl(host_end_.get(), F_DUPFD_CLOEXEC, 0)), uri_);
}

}  // namespace thimble::host

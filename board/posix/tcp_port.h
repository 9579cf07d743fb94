// SLCAN on TCP, loopback only: up to 32 hosts at once, each a node on the same bus. For one more, the connection of the host that was
// silent for the longest is closed. A connection of another user is closed at once, and told on stderr, unless everyone may connect.
#pragma once

#include <netinet/in.h>

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "board/posix/port.h"
#include "board/posix/slcan_stream.h"

namespace thimble::board {

class TcpPort final : public Port {
 public:
  enum class Hosts : std::uint8_t { kOwnUser, kEveryone };
  // Listens on 127.0.0.1; 0: any free port. Throws std::runtime_error with a remedy.
  explicit TcpPort(std::uint16_t port, Hosts hosts = Hosts::kOwnUser);

  [[nodiscard]] std::vector<std::string> uris() const override { return {uri_}; }
  void add_to(std::vector<pollfd>& polled) const override;
  void read() override;
  [[nodiscard]] std::optional<firmware::link::CanFrame> receive() override;
  void send(const firmware::link::CanFrame& frame) override;
  void flush() override;
  [[nodiscard]] bool waiting() const override;
  [[nodiscard]] std::uint64_t dropped() const override;

 private:
  [[nodiscard]] bool accept_host();  // false: nobody waits
  void tell_refused(uid_t owner);

  Descriptor listener_;
  sockaddr_in address_{};
  Hosts may_connect_;
  std::chrono::steady_clock::time_point tell_again_{};  // of a refused connection
  std::vector<std::unique_ptr<SlcanStream>> hosts_;
  std::vector<std::unique_ptr<SlcanStream>>
      ended_;  // nobody's: kept until what they have sent by now is handled
  std::string uri_;
  std::uint64_t dropped_ = 0;  // of closed connections
};

}  // namespace thimble::board

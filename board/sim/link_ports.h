// The simulated board's bus: SLCAN on a pty and on TCP loopback, any number of clients, each a node on the
// same bus. Used by thimble-sim, one thread. Telemetry that a client does not fetch is dropped, never queued
// for long.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "firmware/link/can_frame.h"
#include "firmware/link/slcan.h"

namespace thimble::board {

class LinkPorts {
 public:
  // Both throw std::runtime_error with what to do.
  void open_pty(const std::string& link);  // also as a symbolic link of that name, unless empty
  void open_tcp(std::uint16_t port);       // on 127.0.0.1; 0: any free port
  LinkPorts() = default;
  LinkPorts(const LinkPorts&) = delete;
  LinkPorts& operator=(const LinkPorts&) = delete;
  ~LinkPorts();

  [[nodiscard]] const std::vector<std::string>& uris() const { return uris_; }

  // Waits for something to read, at most so long, and reads it.
  void wait(std::uint64_t timeout_us);
  // The next frame that a client sent.
  [[nodiscard]] std::optional<firmware::link::CanFrame> receive();
  void send(const firmware::link::CanFrame& frame);  // to every client that opened the channel
  void flush();

  [[nodiscard]] std::uint64_t dropped() const { return dropped_; }

 private:
  struct Client {
    int fd = -1;
    bool pty = false;
    bool open = false;  // after the O command
    bool dead = false;
    firmware::link::SlcanParser parser;
    std::string in;
    std::size_t in_at = 0;
    std::string out;
  };
  void read_from(Client& client);
  void command(Client& client);
  void accept_clients();

  std::vector<std::unique_ptr<Client>> clients_;
  std::vector<std::string> uris_;
  int pty_slave_ = -1;  // held open: without it a client that leaves would end the pty
  int listener_ = -1;
  std::string link_;
  std::uint64_t dropped_ = 0;
};

}  // namespace thimble::board

// The simulated board in real time with its link: the loop of thimble-sim, which `thimble view --scene` runs
// in a thread.
//
//   LiveBoard live(options);            // opens the ports, announces itself
//   live.run([] { return stopping; });  // until told to stop
//
// One thread. `news` is called with the transmit problem of the ports each time it changes.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "board/sim/live_loop.h"

namespace thimble::board {

class Announced;
class FileStorage;

struct LiveOptions {
  std::string arm = "premium-1.5";
  std::optional<kinematics::ArmData> arm_data{};  // another arm in its place
  double rate_Hz = 4000;
  std::uint64_t seed = 1;
  std::uint8_t arm_count = 1;  // minimum; a path with a second arm makes it two
  std::optional<std::uint16_t> tcp_port;
  bool open = false;  // the TCP port takes connections of other users too
  int host_socket =
      -1;  // one end of a connected pair, which the board closes; a host in this process has the other
  bool pty = true;
  std::string link;      // a symbolic link to the pty
  std::string can;       // an interface
  std::string tty;       // a serial port
  std::string hand;      // file with the path of the hand
  bool loop = false;     // repeat the path
  std::string specimen;  // file of an object to scan; replaces the hand
  std::string inject;    // file of faults of its hardware
  Sensors sensors{};     // what the hardware measures besides the counts
  std::string store;     // a file that keeps the scenes
  std::string name;      // in `thimble list`
};

class LiveBoard {
 public:
  // Throws std::exception for a port in use, an unknown arm or an error in a file.
  explicit LiveBoard(const LiveOptions& options);
  LiveBoard(const LiveBoard&) = delete;
  LiveBoard& operator=(const LiveBoard&) = delete;
  ~LiveBoard();

  [[nodiscard]] std::vector<std::string> uris() const;  // the preferred one first

  // Runs cycles of about half a millisecond until stopping() returns true. `each` may be empty.
  void run(const std::function<bool()>& stopping,
           const std::function<void(const LiveLoop::Round&)>& each = {},
           const std::function<void(const std::string&)>& news = {});

  [[nodiscard]] SimBoard& board() noexcept { return loop_->board(); }
  [[nodiscard]] double skipped_s() const noexcept { return loop_->skipped_s(); }
  [[nodiscard]] std::uint64_t dropped() const;  // frames

 private:
  class Ports;
  [[nodiscard]] std::unique_ptr<SimBoard> start(const char* reset_reason);

  LiveOptions options_;
  std::unique_ptr<Ports> ports_;
  std::unique_ptr<FileStorage> file_;
  std::unique_ptr<MemoryStorage> memory_;
  std::unique_ptr<LiveLoop> loop_;
  std::unique_ptr<Announced> announced_;
};

}  // namespace thimble::board

// arm_peer MEMORY RATE [QTEST]: what an emulated board with RATE ticks a second needs around it. The simulated arm in the register block,
// which is the last page of the file MEMORY (the machine's RAM); and where QEMU's test socket QTEST is given, the second node on its bus,
// as SLCAN on TCP.
//
// Prints "arm" once the block is there. Takes commands, one a line, and answers each with one line:
//   bus                 QEMU runs: joins the bus; its address
//   hand X Y Z          the hand wants to be here, in metres; the first one takes the arm out of its cradle
//   line NAME 0|1       e_stop (1: pressed), dead_man (1: held), drives (1: good)
//   state               tip, force on the hand, steps, enable
//   read A, write A V   a word of the machine, numbers in hex
// Ends with its input. Exit codes: 0, 1 failed, 2 usage.
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <exception>
#include <filesystem>
#include <iostream>
#include <memory>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <string>
#include <utility>

#include "board/posix/link_ports.h"
#include "board/posix/tcp_port.h"
#include "tests/hardware/cortex/fabric_plant.h"
#include "tests/hardware/cortex/qtest.h"
#include "tests/hardware/cortex/qtest_can.h"

namespace thimble::tests {
namespace {

constexpr std::size_t kPage = 4096;
constexpr std::uint64_t kWait_us = 500;
// QEMU's bus has no bit rate, and its model of the receive FIFO ends QEMU when a frame comes while 63 wait and one is half read out. So
// this end keeps to the bit rate, in the board's time: 1 Mbit/s carries 8000 frames of 8 bytes a second.
constexpr double kFrames_s = 8000, kMostAtOnce = 16;

class Peer {
 public:
  Peer(const std::filesystem::path& memory, double rate_Hz, std::string qtest)
      : frames_per_tick_(kFrames_s / rate_Hz),
        plant_(memory, std::filesystem::file_size(memory) - kPage, rate_Hz),
        qtest_name_(std::move(qtest)) {}

  // Until the input ends.
  void run() {
    for (;;) {
      if (can_) {
        ports_.wait(kWait_us);
        send();
        relay();
        ports_.flush();
      }
      pollfd input{STDIN_FILENO, POLLIN, 0};
      if (poll(&input, 1, can_ ? 0 : 100) > 0 && !take_input()) return;
    }
  }

 private:
  void send() {
    const std::uint64_t steps = plant_.state().steps;
    may_send_ =
        std::min(may_send_ + frames_per_tick_ * static_cast<double>(steps - steps_seen_), kMostAtOnce);
    steps_seen_ = steps;
    for (; may_send_ >= 1; --may_send_) {
      const std::optional<firmware::link::CanFrame> frame = ports_.receive();
      if (!frame) return;
      can_->send(*frame);
      relay();
    }
  }

  void relay() {
    for (const firmware::link::CanFrame& frame : can_->receive()) ports_.send(frame);
  }

  bool take_input() {
    std::array<char, 256> bytes{};
    const ssize_t count = read(STDIN_FILENO, bytes.data(), bytes.size());
    if (count <= 0) return false;
    input_.append(bytes.data(), static_cast<std::size_t>(count));
    for (std::size_t end = 0; (end = input_.find('\n')) != std::string::npos; input_.erase(0, end + 1))
      std::cout << obey(input_.substr(0, end)) << std::endl;
    return true;
  }

  std::string obey(const std::string& command) {
    std::istringstream words(command);
    std::string verb;
    words >> verb;
    if (verb == "bus") {
      qtest_.emplace(qtest_name_);
      can_.emplace(*qtest_);
      if (ports_.empty()) ports_.add(std::make_unique<board::TcpPort>(0));
      return ports_.uris().front();
    }
    if (verb == "hand") {
      board::Vector3d at = board::Vector3d::Zero();
      words >> at.x() >> at.y() >> at.z();
      plant_.hold(at);
    } else if (verb == "line") {
      std::string name;
      bool on = false;
      words >> name >> on;
      if (name == "drives") {
        plant_.set_drives_good(on);
      } else {
        const std::uint32_t bit = name == "e_stop" ? board::kLineEStopReleased : board::kLineDeadManHeld;
        const bool set = on != (name == "e_stop");
        plant_.set_lines(set ? plant_.lines() | bit : plant_.lines() & ~bit);
      }
    } else if (verb == "state") {
      const FabricPlant::State state = plant_.state();
      std::ostringstream text;
      for (const board::Vector3d& vector : {state.tip_m, state.hand_force_N})
        for (int axis = 0; axis < 3; ++axis) text << vector[axis] << ' ';
      text << state.steps << ' ' << state.enabled;
      return text.str();
    } else if (qtest_ && (verb == "read" || verb == "write")) {
      std::uint32_t address = 0, value = 0;
      words >> std::hex >> address >> value;
      std::ostringstream text;
      if (verb == "write") qtest_->write(address, value);
      text << std::hex << (verb == "read" ? qtest_->read(address) : value);
      return text.str();
    } else {
      throw std::runtime_error("no such command: " + command);
    }
    return "ok";
  }

  double frames_per_tick_;
  FabricPlant plant_;
  std::string qtest_name_;
  std::optional<Qtest> qtest_;
  std::optional<QtestCan> can_;
  board::LinkPorts ports_;
  double may_send_ = 0;
  std::uint64_t steps_seen_ = 0;
  std::string input_;
};

}  // namespace
}  // namespace thimble::tests

int main(int argc, char** argv) {
  if (argc < 3 || argc > 4) {
    std::cerr << "arm_peer MEMORY RATE [QTEST]\n";
    return 2;
  }
  try {
    thimble::tests::Peer peer(argv[1], std::stod(argv[2]), argc == 4 ? argv[3] : "");
    std::cout << "arm" << std::endl;
    peer.run();
    return 0;
  } catch (const std::exception& error) {
    std::cerr << "arm_peer: " << error.what() << '\n';
    return 1;
  }
}

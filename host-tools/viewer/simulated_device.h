// The simulated controller that `thimble view --scene` starts: in this process, in a thread of its own, in real time, with a hand that
// follows the position that a page gives. Its link is a pair of sockets in this process; other programs of this user can open its pty. All
// public functions may be called from any thread.
#pragma once

#include <array>
#include <cstdint>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "board/sim/live_board.h"
#include "host-tools/client/descriptor.h"
#include "host-tools/client/transport.h"

namespace thimble::host {

class SimulatedDevice {
 public:
  // Throws what LiveBoard throws.
  explicit SimulatedDevice(const board::LiveOptions& options);
  SimulatedDevice(const SimulatedDevice&) = delete;
  SimulatedDevice& operator=(const SimulatedDevice&) = delete;
  ~SimulatedDevice();  // ends the thread

  [[nodiscard]] const std::string& uri() const { return uri_; }  // for other programs
  [[nodiscard]] std::unique_ptr<Transport> connect() const;      // for this one, once at a time
  [[nodiscard]] std::size_t arms() const { return arms_; }

  // The hand goes there, or as far as the arm's workspace reaches, at a hand's speed.
  void want(std::size_t arm, const std::array<double, 3>& position_m);
  [[nodiscard]] std::array<double, 3> hand_m(std::size_t arm) const;
  // Every hand goes where its arm is homed, and stays there while this lives, whatever pages want meanwhile.
  class LedHome {
   public:
    explicit LedHome(SimulatedDevice& device) : device_(device) { device_.lead_home(true); }
    LedHome(const LedHome&) = delete;
    LedHome& operator=(const LedHome&) = delete;
    ~LedHome() { device_.lead_home(false); }
    [[nodiscard]] bool there() const;

   private:
    SimulatedDevice& device_;
  };

  // Of the record with this sequence number: the newest tick in it, and when the round of ticks that it is of began, on the
  // machine's steady clock: what is measured from there on errs by up to a round to the long side.
  struct Stamp {
    std::uint64_t tick = 0;
    std::uint64_t since_us = 0;
  };
  [[nodiscard]] Stamp stamp(std::uint8_t sequence) const;

 private:
  using Vector = std::array<double, 3>;
  struct Hand {
    std::optional<Vector> wanted_m;
    bool fresh = false;  // not brought into the workspace yet
    Vector goal_m{}, at_m{}, home_m{};
  };
  void each(const board::LiveLoop::Round& round);
  void lead_home(bool yes);

  mutable std::mutex mutex_;
  std::array<Hand, 2> hands_;
  std::array<Stamp, 256> stamps_{};
  std::uint64_t last_us_ = 0;
  bool led_home_ = false;
  bool stopping_ = false;
  std::string uri_;
  std::size_t arms_ = 1;
  Descriptor host_end_{-1};
  board::LiveBoard live_;
  std::thread thread_;
};

}  // namespace thimble::host

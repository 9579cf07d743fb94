// A device on the link, as a program on the PC uses it: everything the services offer, with deadlines and
// retries.
//
//   Device device(open_transport("tcp:127.0.0.1:29536"));
//   device.upload(image, {}, [](auto p) { ... });
//   device.home(); device.arm();
//
// Who uses it: the command `thimble`, tests, host programs. One thread. Every failure is an Error with its
// exit code: kLinkLost when no answer came in time, kRefused when the device said no (with its reason),
// kVersion, kVerification, kFaulted.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "firmware/link/crc32.h"
#include "firmware/link/messages.h"
#include "firmware/params.h"
#include "host-tools/client/service_client.h"
#include "host-tools/client/transport.h"
#include "host-tools/client/upload.h"

namespace thimble::host {

// A fingertip in one tick, as the link tells it (Pose and Force). World frame.
struct TipReading {
  std::array<double, 3> position_m{};
  std::array<double, 3> force_N{};  // that the device exerts on the hand, after all limits
  std::uint8_t limiters = 0;        // Limiter bits of firmware/observe/telemetry.h: which of them acted
  std::uint8_t sequence = 0;        // counts readings: a gap are those that came meanwhile, or were lost
  link::Micros heard_us = 0;        // by now_us(): the reading is as old as that, and the link's delay
};

class Device {
 public:
  // Asks for LinkInfo: Error kVersion when the device speaks another version.
  explicit Device(std::unique_ptr<Transport> transport, const DeviceOptions& options = {});

  [[nodiscard]] const link::LinkInfo& info() const { return info_; }
  [[nodiscard]] link::DeviceState state();
  [[nodiscard]] link::Lateness lateness();
  [[nodiscard]] std::string text(std::uint16_t did);

  [[nodiscard]] double read_param(const firmware::ParamRow& row);
  void write_param(const firmware::ParamRow& row, double value);
  void save_params();  // as they are, over power-off

  [[nodiscard]] std::vector<std::uint8_t> faults();  // numbers, since the last clear
  [[nodiscard]] std::vector<link::FreezeFrame> freeze_frames(std::uint8_t fault);
  void clear_faults();

  // Each waits until the mode shows it, at most `wait_us`.
  // home(): once stopping() says so it lets the arm go and returns without.
  void home(link::Micros wait_us = 30'000'000, const std::function<bool()>& stopping = {});
  void arm(link::Micros wait_us = 2'000'000);
  void disarm(link::Micros wait_us = 5'000'000);

  // Disarms it, and starts it again. It answers before it does.
  void restart();

  // A guarded move: starts it; tells how far it is; what it measured once it holds; ends it. The device needs a sign of
  // life every link::kMoveHostTimeout_s meanwhile: asking move_state() is one.
  void start_move(const link::MoveOrder& order);
  [[nodiscard]] link::MoveState move_state();
  [[nodiscard]] std::vector<link::MoveSample> move_samples();
  void end_move();

  // A trace (firmware/observe/recorder.h); its frames come as telemetry(). How it began: a TraceStart, and a TraceArm for each arm.
  void start_trace();
  void end_trace();
  [[nodiscard]] link::TraceState trace_state();
  [[nodiscard]] std::pair<link::TraceStart, std::vector<link::TraceArm>> trace_start();
  [[nodiscard]] std::uint32_t param_bits(const firmware::ParamRow& row);

  // The program gives the forces (docs/host-rendering.md):
  //
  //   device.home();
  //   device.take_over();                                          // arms; no scene is felt from here on
  //   while (const auto tip = device.next_tip(now_us() + 100'000)) device.order_force(wall(tip->position_m));
  //   device.hand_back();                                          // disarms
  //
  // An order is felt for 20 ms at most, then the tip is damped until the next; after link_timeout without any the
  // device has the fault host_lost. Once the device is not armed any more next_tip() throws kFaulted or kRefused.
  //
  // Sets host_forces and telemetry_decimation (readings_per_s, at most one a tick) and arms. The device is homed and at rest.
  void take_over(double readings_per_s = 1000);
  // The newest reading that was not given before; nothing: none came until the deadline.
  [[nodiscard]] std::optional<TipReading> next_tip(link::Micros deadline_us, unsigned arm = 0);
  // Sends and does not wait. At most 32 N along an axis travel; the device's own limits are lower. Error kUsage: not a
  // number, or no such arm.
  void order_force(const std::array<double, 3>& force_N, unsigned arm = 0);
  // Disarms; the two parameters are as they were.
  void hand_back();
  [[nodiscard]] link::HostOrders orders();  // how many the device took, passed over, and missed

  UploadResult upload(std::span<const std::byte> image, const UploadOptions& options,
                      const UploadListener& progress);

  // A tester-present that asks for no answer: it feeds host supervision.
  void keep_alive();
  // Every real-time frame of the device, also those that come in while an answer is waited for. It must not call the device.
  void set_listener(std::function<void(const link::CanFrame&)> heard);
  // The next real-time frame of the device; nothing once the deadline has passed.
  [[nodiscard]] std::optional<link::CanFrame> telemetry(link::Micros deadline_us);

 private:
  // False: stopping() said so first.
  bool wait_for_mode(link::Mode wanted, link::Micros wait_us, const std::string& what,
                     const std::function<bool()>& stopping = {});
  void take_reading(const link::CanFrame& frame);
  void release_forces();

  ServiceClient services_;
  link::LinkInfo info_;
  // While the program gives the forces.
  struct Rendered {
    link::Pose pose;
    std::optional<TipReading> newest;  // not given yet
    std::uint8_t sequence = 0;         // of the last order
  };
  std::array<Rendered, 2> rendered_;
  std::optional<double> decimation_before_;  // while it has taken over
};

using link::crc32;

}  // namespace thimble::host

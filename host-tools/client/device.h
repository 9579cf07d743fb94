// A device on the link, as a program on the PC uses it: all services of the controller, with deadlines and
// repeats.
//
//   Device device(open_transport("tcp:127.0.0.1:29536"));
//   device.upload(image, {}, [](auto p) { ... });
//   device.home(); device.arm();
//
// Used by the command `thimble`, by tests and by programs. One thread. Every function that talks to the device throws Error:
// kLinkLost if no answer comes in time, kRefused with the device's reason, kFaulted if a fault is the reason, kVersion if a
// record does not fit this version. Further errors stand at the function. Units: SI. Frame of all vectors: the world, +x to
// the user's right, +y away from the user, +z up, origin at the tip's home. A force is what the device exerts on the hand.
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
#include "host-tools/client/stop.h"
#include "host-tools/client/transport.h"
#include "host-tools/client/upload.h"

namespace thimble::host {

// A fingertip in one tick, from the messages Pose and Force. World frame.
struct TipReading {
  std::array<double, 3> position_m{};
  std::array<double, 3> force_N{};  // on the hand, after all limits
  std::uint8_t limiters = 0;        // Limiter bits of firmware/observe/telemetry.h: which of them acted
  std::uint8_t sequence = 0;        // counts readings; a gap: readings were skipped or lost
  link::Micros heard_us = 0;        // arrival by now_us(); the reading is older by the delay of the link
};

class Device {
 public:
  // Reads LinkInfo. Error kVersion if the device speaks another version of the protocol or of the scene image.
  explicit Device(std::unique_ptr<Transport> transport, const DeviceOptions& options = {});

  [[nodiscard]] const link::LinkInfo& info() const { return info_; }
  [[nodiscard]] link::DeviceState state();
  [[nodiscard]] link::Lateness lateness();
  [[nodiscard]] std::string text(std::uint16_t did);
  // The solids that tips are still inside of; none if the firmware does not tell.
  struct Inside {
    unsigned arm = 0;
    unsigned object = 0;  // its place in the scene
    std::string name;
  };
  [[nodiscard]] std::vector<Inside> inside();

  [[nodiscard]] double read_param(const firmware::ParamRow& row);
  void write_param(const firmware::ParamRow& row, double value);
  // Writes `event` or `trial` (firmware/core/marks.h), and tells the tick that has taken it. A frame that is lost on the way marks no second
  // tick. write_param() of one of them is the same.
  link::Marked mark(const firmware::ParamRow& row, std::uint16_t value);
  void save_params();  // stores the present values; they survive power-off

  [[nodiscard]] std::vector<std::uint8_t> faults();  // numbers of the faults since the last clear
  [[nodiscard]] std::vector<link::FreezeFrame> freeze_frames(std::uint8_t fault);
  // outdated: asked last before the request leaves; true: it is not sent. Error kRefused.
  void clear_faults(const std::function<bool()>& outdated = {});

  // The audit record, the oldest entry first: what was done, when and by which host (firmware/store/audit_log.h). Hosts name themselves.
  [[nodiscard]] std::vector<link::AuditRecord> audit();

  // Each waits until the mode has changed, at most `wait_us`, or as long as for an answer if that is longer; then Error kRefused
  // `not-in-time`.
  // home(): when stopping() returns true, it disarms and returns before the arm is homed.
  void home(link::Micros wait_us = 30'000'000, const std::function<bool()>& stopping = {});
  void arm(link::Micros wait_us = 2'000'000);
  // disarm(): also when the device has given the place of this program to another one, and has no place left.
  void disarm(link::Micros wait_us = 5'000'000);

  // The e-stop frame (stop.h): every node on the bus stops. Error kNotStopped: the device has not confirmed it.
  Stopped stop(link::Micros wait_us = kStop_us);
  void send_stop();  // one such frame; may be called by a listener

  // Takes the lease before the first command, so that none of them has to wait for another program (docs/link.md). Error kCommanded.
  void take_command();

  // The key that programs need to command the device from now on (key_file.h); remove_key(): none. While the motors are off. Needs the key
  // that is there.
  void set_key(const link::Key& key);
  void remove_key();

  // Which arm images are used and stored.
  [[nodiscard]] link::ArmImages arm_images();

  // What its motor drives measure; nothing: this board cannot tell.
  [[nodiscard]] std::optional<link::MeasuredCurrents> measured_currents();

  // Disarms and restarts the controller. The answer comes before the restart.
  void restart();

  // A guarded move: start, progress, the samples once the arm holds, end. During the move the device needs a request every
  // link::kMoveHostTimeout_s, for example move_state(); without one it has the fault host_lost.
  void start_move(const link::MoveOrder& order);
  [[nodiscard]] link::MoveState move_state();
  [[nodiscard]] std::vector<link::MoveSample> move_samples();
  void end_move();

  // An order for the axes of an arm (firmware/sources/axis_drive.h). The device must be armed, and allow_moves be 1. While it runs, the device
  // needs a request every link::kMoveHostTimeout_s; without one it has the fault host_lost.
  void start_axes(const link::AxisOrder& order);
  [[nodiscard]] link::AxisState axis_state();

  // Homes an arm where this program says that it is.
  void home_at(const link::HomePlace& place);

  // Breaks the hardware of a simulated board. Error "not-simulated": it is a real one. "refused": no such fault or arm.
  void inject(const link::InjectedFault& fault);

  // A recording (firmware/observe/recorder.h); its frames come as telemetry(). How it began: a RecordingStart, and a RecordingArm for each arm.
  // counts_only: it goes on where the counts do not determine the forces (routine 0211).
  void start_recording(bool counts_only = false);
  void end_recording();
  [[nodiscard]] link::RecordingState recording_state();
  [[nodiscard]] std::pair<link::RecordingStart, std::vector<link::RecordingArm>> recording_start();
  [[nodiscard]] std::uint32_t param_bits(const firmware::ParamRow& row);

  // Forces from this program instead of the scene (docs/host-rendering.md):
  //
  //   device.home();
  //   device.take_over();                                          // arms; from here on the scene gives no force
  //   while (const auto tip = device.next_tip(now_us() + 100'000)) device.order_force(wall(tip->position_m));
  //   device.hand_back();                                          // disarms
  //
  // A force acts for at most 20 ms; then the tip is damped until the next one. After link_timeout without a force the device
  // has the fault host_lost. When the device is no longer armed, next_tip() throws kFaulted or kRefused.
  //
  // Sets host_forces and telemetry_decimation (readings_per_s, at most one a tick) and arms. The device must be homed and at rest.
  void take_over(double readings_per_s = 1000);
  // The newest reading that has not been returned yet; nothing if none came before the deadline.
  [[nodiscard]] std::optional<TipReading> next_tip(link::Micros deadline_us, unsigned arm = 0);
  // Sends the force on the hand and does not wait. The message carries at most 32 N along an axis; the device's limits are
  // lower. Error kUsage: a value is not finite, or the device has no such arm.
  void order_force(const std::array<double, 3>& force_N, unsigned arm = 0);
  // Disarms and restores the two parameters.
  void hand_back();
  [[nodiscard]] link::HostOrders orders();  // counts of forces that were applied, skipped and missing

  UploadResult upload(std::span<const std::byte> image, const UploadOptions& options,
                      const UploadListener& progress);

  // A tester-present without an answer: it feeds host supervision.
  void keep_alive();
  // Called with every real-time frame of the device, also while an answer is awaited. It must not call the device.
  void set_listener(std::function<void(const link::CanFrame&)> heard);
  // The next real-time frame of the device; nothing once the deadline has passed.
  [[nodiscard]] std::optional<link::CanFrame> telemetry(link::Micros deadline_us);

 private:
  // False: stopping() returned true first.
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
    std::uint8_t readings = 0;         // counts them, whose numbers have 4 bits on the link
  };
  std::array<Rendered, 2> rendered_;
  std::optional<double> decimation_before_;  // while it has taken over
};

using link::crc32;

// Disarms the device, also one that serves as many hosts as it can, or that is of another version. Returns the mode that follows.
// Errors as of Device::disarm().
link::Mode disarm(std::unique_ptr<Transport> transport, DeviceOptions options = {},
                  link::Micros wait_us = 5'000'000);

}  // namespace thimble::host

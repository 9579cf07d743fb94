// The controller: everything a board has to call. Sans-I/O: state changes only in answer to a call, and
// nothing here touches hardware, allocates, throws or waits.
//
// There are two contexts:
//   tick        tick(), telemetry(). One thread or interrupt, at the fixed period of the Config.
//   background  everything else: one thread or interrupt level at a time. Tick and background may interrupt each other at
//               any instruction; they share only what firmware/exchange/ hands over, so neither ever waits for the other.
// A program with one thread may call both in turn.
//
//   board: every period   out = controller.tick(in);                         // then write `out` to the drives
//   board: otherwise      controller.on_frame(f, now); controller.poll(now); // now: us of the board's clock
//                         while (controller.next_frame(f, now)) send(f);
//
// tick() is bounded; on_frame() and next_frame() are short; on_frame() and poll() are O(scene image) once an upload has ended.
//
// What the services do is in firmware/services/, what the real-time frames hold in firmware/observe/.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "control/scene/scene_view.h"
#include "firmware/core/core.h"
#include "firmware/core/faults.h"
#include "firmware/link/can_frame.h"
#include "firmware/observe/picture_frames.h"
#include "firmware/observe/recording_frames.h"
#include "firmware/observe/status_frames.h"
#include "firmware/observe/telemetry.h"
#include "firmware/observe/telemetry_frames.h"
#include "firmware/params.h"
#include "firmware/services/audit.h"
#include "firmware/services/force_orders.h"
#include "firmware/services/router.h"
#include "firmware/services/services.h"
#include "firmware/store/arm_store.h"
#include "firmware/store/key_store.h"
#include "firmware/store/param_store.h"
#include "firmware/store/persistent_state.h"
#include "firmware/store/scene_store.h"
#include "firmware/store/storage.h"

namespace thimble::firmware {

class Controller {
 public:
  // Opens the store and posts its newest scene to the tick: O(image). `storage` must outlive the controller.
  // A Config that cannot work (unknown arm model, arm count, period, node) gives a controller that stays
  // faulted with bad_config.
  Controller(const Config& config, Storage& storage) noexcept;
  Controller(const Controller&) = delete;
  Controller& operator=(const Controller&) = delete;

  // --- tick
  [[nodiscard]] Outputs tick(const Inputs& inputs) noexcept { return core_.tick(inputs); }
  [[nodiscard]] const Telemetry& telemetry() const noexcept { return core_.telemetry(); }  // of the last tick
  // The scene as the next tick will find it: moving objects, tissues, bounds.
  [[nodiscard]] const control::Renderer& renderer() const noexcept { return core_.renderer(); }

  // --- background: the link
  void on_frame(const link::CanFrame& frame, link::Micros now) noexcept;
  void poll(link::Micros now) noexcept;
  [[nodiscard]] bool next_frame(link::CanFrame& frame,
                                link::Micros now) noexcept;  // false: nothing to send now
  // Tells the host what the board's link has lost since start (DeviceState, link_losses).
  void tell_link_losses(std::uint32_t frames_or_bytes) noexcept { link_.link_losses = frames_or_bytes; }
  // A restart that a host has asked for, once the host has its answer, the motors are off and the audit record has what waited for it
  // (AuditLog::kInterval_s at most): the board stops calling the controller, and restarts. Returned once.
  [[nodiscard]] std::optional<link::Reset> take_reset() noexcept;

  // --- background: what the services do, for a program that holds the controller
  // Returns the unmet conditions (Condition bits); 0: accepted, the next tick executes it.
  [[nodiscard]] Conditions request(Command command) noexcept { return core_.commands().request(command); }
  // A guarded move (firmware/sources/guarded_move.h): returns the unmet conditions; 0: accepted, the next tick starts it.
  // The order's values must pass move_in_range().
  [[nodiscard]] bool move_in_range(const MoveOrder& order) const noexcept {
    return core_.commands().move_in_range(order);
  }
  [[nodiscard]] Conditions request_move(const MoveOrder& order) noexcept {
    return core_.commands().request_move(order);
  }
  [[nodiscard]] link::MoveState move_state() const noexcept;
  // What the move that ran last measured; empty while one is under way.
  [[nodiscard]] const MoveResults* move_results() const noexcept { return core_.sources().move.results(); }
  // The same of an order for the axes (firmware/sources/axis_drive.h).
  [[nodiscard]] bool axes_in_range(const link::AxisOrder& order) const noexcept {
    return core_.commands().axes_in_range(order);
  }
  [[nodiscard]] Conditions request_axes(const link::AxisOrder& order) noexcept {
    return core_.commands().request_axes(order);
  }
  [[nodiscard]] link::AxisState axis_state() const noexcept { return core_.sources().axes.state(); }
  // A recording (firmware/observe/recorder.h); the link sends its ticks. A program that holds the controller may start one with
  // request(Command::kRecord); the start record then has no scene_crc, because the service fills that in.
  [[nodiscard]] link::RecordingState recording_state() const noexcept {
    return core_.observers().recorder.state();
  }
  // For a replay, before the first tick: Core::resume(). Config, parameters and scene must be those of the recording.
  // trial: the parameter of that name.
  void resume(const RecordingStart& start, std::uint8_t trial = 0) noexcept { core_.resume(start, trial); }
  void replay(Command command) noexcept { core_.commands().replay(command); }
  void keep_alive() noexcept {
    core_.commands().keep_alive();
  }  // a valid command came; arming does not count as one
  // A host's clock: seconds since 1970.
  void tell_time(std::uint32_t utc_s, link::Micros now) noexcept { persistent_.tell_time(utc_s, now); }
  [[nodiscard]] Mode mode() const noexcept { return core_.status().mode(); }
  [[nodiscard]] Fault fault() const noexcept { return core_.status().fault(); }
  [[nodiscard]] Conditions unmet() const noexcept { return core_.status().unmet(); }  // against arming, now
  // A write with access kAtRest is refused while the motors are on. A recording ends before a parameter that has an effect on
  // the forces is written (column `recorded` of params.def). kBusy: no tick has taken the last mark yet (firmware/core/marks.h).
  [[nodiscard]] ParamStatus read_param(std::uint16_t id, std::uint32_t& bits) const noexcept;
  [[nodiscard]] ParamStatus write_param(std::uint16_t id, std::uint32_t bits) noexcept;
  // Keeps them over power-off, with the motors off (kBusy: they are on).
  [[nodiscard]] StoreStatus save_params() noexcept;

  // A whole upload at once: copies an image into the store, verifies it and posts it; the tick switches to it
  // with the force ramped. kRefused: store().image_verdict() says why, and the running scene stays.
  [[nodiscard]] StoreStatus load_scene(std::span<const std::byte> image) noexcept;
  [[nodiscard]] const SceneStore& store() const noexcept { return store_; }

  // The ticks up to the fault, 0 the oldest, until it is cleared. False: there is no such tick.
  [[nodiscard]] bool freeze_tick(std::size_t index, FrozenTick& tick) const noexcept {
    return core_.observers().freeze.tick(index, tick);
  }

 private:
  void fetch_records() noexcept;
  [[nodiscard]] PersistentState::InStore in_store() const noexcept;

  ArmStore arms_;  // before config_, which names its images
  Config config_;
  Params params_;
  Core core_;
  SceneStore store_;
  control::SceneView running_;  // the scene posted last
  ParamStore param_store_;
  KeyStore keys_;
  PersistentState persistent_;
  Audit audit_;
  // The real-time frames (firmware/observe/).
  TelemetryFrames telemetry_;
  StatusFrames status_;
  RecordingFrames recording_;
  PictureFrames picture_;
  // The hosts' requests (firmware/services/).
  LinkCounts link_;
  ForceOrders orders_;
  Services services_;
  Router router_;
};

}  // namespace thimble::firmware

#include "firmware/observe/status_frames.h"

#include "firmware/link/messages.h"
#include "firmware/link/services.h"

namespace thimble::firmware {
bool StatusFrames::next_frame(link::CanFrame& frame, link::Micros now) noexcept {
  const Fault fault = core_.status().fault();
  if (fault != reported_) {
    reported_ = fault;
    frame = emergency_frame(fault);
    return true;
  }
  if (now >= heartbeat_due_) {
    heartbeat_due_ = now + kHeartbeatPeriod_us;
    frame = heartbeat_frame(fault);
    return true;
  }
  if (now >= status_due_) {
    status_due_ = now + kStatusPeriod_us;
    frame = status_frame(fault);
    return true;
  }
  if (put_off_due_) {
    put_off_due_ = false;
    const control::RenderCounters& bounds = telemetry_.record().bounds;
    link::PutOff put_off;
    put_off.object = bounds.put_off_object;
    put_off.ticks = bounds.put_off;
    frame = link::to_frame(put_off, node_);
    return true;
  }
  return false;
}

link::CanFrame StatusFrames::emergency_frame(Fault fault) const noexcept {
  link::Emergency emergency;
  if (const FaultRow* row = find_fault(fault); row != nullptr) {
    emergency.code = row->emergency_code;
    emergency.error_register = 1;
    emergency.fault = static_cast<std::uint8_t>(fault);
    emergency.tick = core_.status().fault_tick();
  }
  return link::to_frame(emergency, node_);
}

link::CanFrame StatusFrames::heartbeat_frame(Fault fault) const noexcept {
  link::Heartbeat heartbeat;
  heartbeat.state = fault != Fault::kNone                   ? link::NodeState::kFaulted
                    : core_.status().mode() == Mode::kArmed ? link::NodeState::kArmed
                                                            : link::NodeState::kNotArmed;
  return link::to_frame(heartbeat, node_);
}

link::CanFrame StatusFrames::status_frame(Fault fault) noexcept {
  link::Status status;
  status.mode = core_.status().mode();
  status.fault = static_cast<std::uint8_t>(fault);
  status.flags = flags();
  status.limiters = telemetry_.take_limiters();
  put_off_due_ = (status.limiters & kLimitWork) != 0;
  status.worst_tick_s = telemetry_.take_worst_tick_us() * 1e-6F;
  status.tick_rate_Hz = telemetry_.rate_Hz();
  return link::to_frame(status, node_);
}

link::StatusFlags StatusFrames::flags() const noexcept {
  const Conditions unmet = core_.status().unmet();
  link::StatusFlags flags;
  flags.homed = (unmet & kNotHomed) == 0;
  flags.dead_man = (unmet & kDeadManOpen) == 0;
  flags.host_renders = params_.on(Param::host_forces);
  // Where the host renders, no scene is a condition for arming: unmet() does not tell whether there is one.
  flags.scene = flags.host_renders ? store_.image_bytes() != 0 : (unmet & kNoScene) == 0;
  flags.supervised = flags.host_renders || params_.on(Param::host_supervision);
  flags.uploading = store_.downloading();
  flags.moves_itself = core_.sources().guest_leads();
  return flags;
}

}  // namespace thimble::firmware

#include "firmware/controller.h"

#include <algorithm>
#include <bit>
#include <cstring>

#include "thimble_scene_schema/scene_generated.h"

namespace thimble::firmware {
namespace {

using link::Nrc;

// After each record's poses, forces and god objects: at 100 records a second 400 frames, a twentieth of a classic bus at 1 Mbit/s.
constexpr std::uint8_t kPictureFrames = 4;
// Then the services have one: on a bus that a trace fills it could not be stopped.
constexpr std::uint8_t kTraceFrames = 8;
constexpr link::Micros kStatusPeriod_us = 100'000;
constexpr link::Micros kHeartbeatPeriod_us = 500'000;
constexpr std::uint64_t kRateWindow_us = 500'000;
constexpr std::size_t kParamBytes = 4;
constexpr std::uint8_t kStateArmed =
    0x05;  // of the heartbeat, as CiA 301: operational, pre-operational, stopped
constexpr std::uint8_t kStateNotArmed = 0x7F;
constexpr std::uint8_t kStateFaulted = 0x04;

// The n-th set bit's number; n counts from 0.
unsigned nth_bit(std::uint32_t bits, std::size_t n) noexcept {
  for (; n > 0; --n) bits &= bits - 1;
  return static_cast<unsigned>(std::countr_zero(bits));
}
static_assert(std::all_of(std::begin(kFaultTable), std::end(kFaultTable),
                          [](const FaultRow& row) { return static_cast<unsigned>(row.fault) < 32; }),
              "faults_seen() has 32 bits");

Nrc to_nrc(StoreStatus status) noexcept {
  switch (status) {
    case StoreStatus::kOk:
      return Nrc::kOk;
    case StoreStatus::kTooLarge:
      return Nrc::kDownloadNotAccepted;
    case StoreStatus::kNoDownload:
    case StoreStatus::kWrongOffset:
    case StoreStatus::kIncomplete:
      return Nrc::kRequestSequenceError;
    case StoreStatus::kWrongCrc:
    case StoreStatus::kRefused:
    case StoreStatus::kStorage:
      return Nrc::kProgrammingFailure;
    case StoreStatus::kBusy:
      return Nrc::kBusyRepeatRequest;
  }
  return Nrc::kGeneralReject;
}

}  // namespace

Controller::Controller(const Config& config, Storage& storage) noexcept
    : config_(config),
      servo_(config, params_),
      store_(storage, config.pause),
      param_store_(storage),
      server_(*this, config.node_id, {}, config.block_bytes) {
  if (config_.arm_count > kMaxArms)
    config_.arm_count = kMaxArms;  // such a controller is faulted; its answers stay in bounds
  param_store_.load(params_);
  if (store_.open(running_) == StoreStatus::kOk) (void)servo_.post_scene(running_, store_.sequence());
}

// ------------------------------------------------------------------------------------------------ the link

void Controller::on_frame(const link::CanFrame& frame, link::Micros now) noexcept {
  ++frames_received_;
  if (!frame.extended && frame.id == link::EmergencyStop::kId) {  // with or without data, remote or not
    (void)servo_.request(Command::kStop);
    return;
  }
  if (!frame.extended && frame.id == std::uint32_t{link::ForceOrder::kId} + config_.node_id) {
    take_order(frame, now);
    return;
  }
  (void)server_.on_frame(frame, now);
}

// A force from a host that renders. Nobody else is asked for one: without the parameter, or not armed, it is as if none had come.
void Controller::take_order(const link::CanFrame& frame, link::Micros now) noexcept {
  if (!params_.on(Param::host_forces) || mode() != Mode::kArmed) return;
  link::ForceOrder order;
  if (!link::from_frame(frame, config_.node_id, order) || order.arm >= config_.arm_count) {
    ++orders_.wrong;
  } else if (!servo_.order_force(order, now)) {
    ++orders_.old;
  } else {
    ++orders_.taken;
    servo_.keep_alive();
  }
}

void Controller::poll(link::Micros now) noexcept {
  fetch_records();
  server_.poll(now);
}

// The real-time frames first; of the telemetry only the newest, whatever the link takes.
bool Controller::next_frame(link::CanFrame& frame, link::Micros now) noexcept {
  const Fault fault = servo_.fault();
  if (fault != reported_) {
    const FaultRow* row = find_fault(fault);
    reported_ = fault;
    link::Emergency emergency;
    if (row != nullptr) {
      emergency.code = row->emergency_code;
      emergency.error_register = 1;
      emergency.fault = static_cast<std::uint8_t>(fault);
      emergency.tick = servo_.fault_tick();
    }
    frame = link::to_frame(emergency, config_.node_id);
    return true;
  }
  if (now >= heartbeat_due_) {
    heartbeat_due_ = now + kHeartbeatPeriod_us;
    link::Heartbeat heartbeat;
    heartbeat.state = fault != Fault::kNone    ? kStateFaulted
                      : mode() == Mode::kArmed ? kStateArmed
                                               : kStateNotArmed;
    frame = link::to_frame(heartbeat, config_.node_id);
    return true;
  }
  if (now >= status_due_) {
    status_due_ = now + kStatusPeriod_us;
    link::Status status;
    status.mode = static_cast<std::uint8_t>(mode());
    status.fault = static_cast<std::uint8_t>(fault);
    status.flags = status_flags();
    status.limiter = limiters_;
    status.worst_tick_s = worst_tick_us_ * 1e-6F;
    status.tick_rate_Hz = rate_Hz_;
    limiters_ = 0;
    worst_tick_us_ = 0;
    frame = link::to_frame(status, config_.node_id);
    return true;
  }
  fetch_records();
  if (frames_left_ > 0) {
    frame = frames_left_ % 2 == 0 ? pose_frame() : force_frame();
    --frames_left_;
    return true;
  }
  if (trace_burst_ >= kTraceFrames) {
    trace_burst_ = 0;
    if (server_.next_frame(frame, now)) return true;
  }
  if (next_trace_frame(frame)) {
    ++trace_burst_;
    return true;
  }
  if (next_god_object_frame(frame)) return true;
  if (picture_frames_left_ > 0 && next_picture_frame(frame)) {
    --picture_frames_left_;
    return true;
  }
  return server_.next_frame(frame, now);
}

std::optional<link::Reset> Controller::take_reset() noexcept {
  if (!reset_ || !motors_off()) return std::nullopt;  // first the tip is braked
  const std::optional<link::Reset> kind = reset_;
  reset_.reset();
  return kind;
}

void Controller::fetch_records() noexcept {
  for (std::size_t i = 0; i < Servo::kRecords && servo_.next_record(record_); ++i) {
    ++record_count_;
    for (std::size_t arm = 0; arm < record_.arm_count; ++arm) limiters_ |= record_.arm[arm].limiters;
    worst_tick_us_ = std::max(worst_tick_us_, record_.tick_us);
    const std::uint64_t time_us = record_.time_us - rate_time_us_;
    if (rate_time_us_ == 0 || time_us >= kRateWindow_us) {
      if (rate_time_us_ != 0)
        rate_Hz_ = static_cast<float>(record_.tick - rate_tick_) * 1e6F / static_cast<float>(time_us);
      rate_tick_ = record_.tick;
      rate_time_us_ = record_.time_us;
    }
    frames_dropped_ += frames_left_;
    frames_left_ = static_cast<std::uint8_t>(2 * record_.arm_count);
    god_object_arm_ = 0;
    picture_frames_left_ = kPictureFrames;
  }
}

// Of the arm whose turn it is: frames_left_ counts down from a pose and a force for each arm.
link::CanFrame Controller::pose_frame() const noexcept {
  const std::size_t arm = record_.arm_count - static_cast<std::size_t>((frames_left_ + 1) / 2);
  link::Pose pose;
  pose.x_m = record_.arm[arm].tip_m.x();
  pose.y_m = record_.arm[arm].tip_m.y();
  pose.z_m = record_.arm[arm].tip_m.z();
  pose.arm = static_cast<std::uint8_t>(arm);
  pose.sequence = record_count_;
  return link::to_frame(pose, config_.node_id);
}

link::CanFrame Controller::force_frame() const noexcept {
  const std::size_t arm = record_.arm_count - static_cast<std::size_t>((frames_left_ + 1) / 2);
  const ArmTelemetry& shown = record_.arm[arm];
  link::Force force;
  force.x_N = shown.force_N.x();
  force.y_N = shown.force_N.y();
  force.z_N = shown.force_N.z();
  force.arm_contacts =
      static_cast<std::uint8_t>((shown.contacts & 3U) | (shown.limiters & 0xFU) << 2U | arm << 6U);
  force.sequence = record_count_;
  return link::to_frame(force, config_.node_id);
}

// Of the arms whose god object is not the tip.
bool Controller::next_god_object_frame(link::CanFrame& frame) noexcept {
  while (god_object_arm_ < record_.arm_count) {
    const std::uint8_t arm = god_object_arm_++;
    const ArmTelemetry& shown = record_.arm[arm];
    if (shown.contacts == 0 && !record_.moves_itself) continue;
    const link::GodObject god{shown.god_object_m.x(), shown.god_object_m.y(), shown.god_object_m.z(), arm,
                              record_count_};
    frame = link::to_frame(god, config_.node_id);
    return true;
  }
  return false;
}

// A tick after the other: the counts of each arm, then the check.
bool Controller::next_trace_frame(link::CanFrame& frame) noexcept {
  if (trace_arm_ >= config_.arm_count && !trace_entry_.checked) {
    if (!servo_.trace().next(trace_entry_)) return false;
    trace_arm_ = trace_entry_.counted ? std::uint8_t{0} : config_.arm_count;
  }
  if (trace_arm_ < config_.arm_count) {
    const auto& counts = trace_entry_.counts[trace_arm_];
    const auto tick_arm =
        static_cast<std::uint16_t>((trace_entry_.tick & 0x7FFFU) | static_cast<unsigned>(trace_arm_) << 15U);
    ++trace_arm_;
    frame = link::to_frame(link::TraceCounts{tick_arm, counts[0], counts[1], counts[2]}, config_.node_id);
    return true;
  }
  trace_entry_.checked = false;
  frame = link::to_frame(trace_entry_.check, config_.node_id);
  return true;
}

bool Controller::next_plane_frame(link::CanFrame& frame) noexcept {
  for (; plane_arm_ < control::kMaxArms; ++plane_arm_, plane_at_ = 0) {
    const unsigned count = picture_.plane_count[plane_arm_];
    if (plane_at_ >= count) continue;
    const Vec3& normal = picture_.planes[plane_arm_][plane_at_];
    const link::ContactPlane plane{
        static_cast<std::uint8_t>(plane_arm_ | static_cast<unsigned>(plane_at_) << 1U | count << 3U),
        picture_count_, normal.x(), normal.y(), normal.z()};
    ++plane_at_;
    frame = link::to_frame(plane, config_.node_id);
    return true;
  }
  return false;
}

// The picture of one tick, frame by frame: each body its position, its rotation and, when it is a control, its coordinate; the
// tissues; the planes. The next picture is fetched when this one is out, so a busy link shows fewer pictures, never half ones.
bool Controller::next_picture_frame(link::CanFrame& frame) noexcept {
  if (picture_at_ == picture_.body_count + picture_.tissue_count) {
    if (next_plane_frame(frame)) return true;
    if (!servo_.next_scene_state(picture_)) return false;
    ++picture_count_;
    picture_at_ = 0;
    picture_part_ = 0;
    plane_arm_ = 0;
    plane_at_ = 0;
    if (picture_.body_count + picture_.tissue_count == 0) return next_plane_frame(frame);
  }
  if (picture_at_ >= picture_.body_count) {
    frame = tissue_frame(picture_.tissues[picture_at_++ - picture_.body_count]);
    return true;
  }
  const control::BodyState& body = picture_.bodies[picture_at_];
  frame = body_frame(body, picture_part_);
  const std::uint8_t parts = body.controlled ? 3 : 2;
  if (++picture_part_ == parts) {
    picture_part_ = 0;
    ++picture_at_;
  }
  return true;
}

link::CanFrame Controller::body_frame(const control::BodyState& body, std::uint8_t part) const noexcept {
  if (part == 0) {
    link::BodyPosition position{body.object, picture_count_, body.position_m.x(), body.position_m.y(),
                                body.position_m.z()};
    return link::to_frame(position, config_.node_id);
  }
  if (part == 1) {
    const float side = body.rotation.w() < 0.0F ? -1.0F : 1.0F;  // both signs are the same rotation
    link::BodyRotation rotation{body.object, picture_count_, side * body.rotation.x(),
                                side * body.rotation.y(), side * body.rotation.z()};
    return link::to_frame(rotation, config_.node_id);
  }
  const link::ControlState control{body.object, picture_count_, static_cast<std::uint8_t>(body.on ? 1 : 0),
                                   body.q};
  return link::to_frame(control, config_.node_id);
}

link::CanFrame Controller::tissue_frame(const control::TissueView& tissue) const noexcept {
  const unsigned arm_inside = tissue.arm | (tissue.inside ? 2U : 0U);
  if (tissue.is_needle) {
    const link::NeedleState needle{
        tissue.object, static_cast<std::uint8_t>(arm_inside | static_cast<unsigned>(tissue.torn) << 2U),
        tissue.x_m, tissue.y_m, tissue.depth_m};
    return link::to_frame(needle, config_.node_id);
  }
  const link::TissueState state{tissue.object, static_cast<std::uint8_t>(arm_inside), tissue.x_m, tissue.y_m,
                                tissue.depth_m};
  return link::to_frame(state, config_.node_id);
}

std::uint8_t Controller::status_flags() const noexcept {
  const Conditions unmet = servo_.unmet();
  unsigned flags = 0;
  if ((unmet & kNotHomed) == 0) flags |= 1U << 0U;
  if ((unmet & kDeadManOpen) == 0) flags |= 1U << 1U;
  // Where the host renders, none is a condition for arming.
  if (params_.on(Param::host_forces) ? running_.scene() != nullptr : (unmet & kNoScene) == 0)
    flags |= 1U << 2U;
  if (params_.on(Param::host_supervision) || params_.on(Param::host_forces)) flags |= 1U << 3U;
  if (store_.downloading()) flags |= 1U << 4U;
  if (servo_.move_phase() != link::MovePhase::kNone) flags |= 1U << 5U;
  if (params_.on(Param::host_forces)) flags |= 1U << 6U;
  return static_cast<std::uint8_t>(flags);
}

link::DeviceState Controller::device_state() const noexcept {
  link::DeviceState state;
  state.mode = static_cast<std::uint8_t>(mode());
  state.fault = static_cast<std::uint8_t>(servo_.fault());
  state.flags = status_flags();
  state.tick = static_cast<std::uint32_t>(record_.tick);
  state.tick_rate_Hz = rate_Hz_;
  state.worst_tick_s = record_.worst_tick_us * 1e-6F;
  state.overruns = record_.overruns;
  state.contact_ticks = record_.contact_ticks;
  state.peak_force_N = record_.peak_force_N;
  state.mean_force_N = record_.mean_force_N;
  state.sweep_bound = record_.sweep_bound;
  state.slide_bound = record_.slide_bound;
  state.scene_bytes = static_cast<std::uint32_t>(store_.image_bytes());
  state.scene_crc = store_.image_crc();
  state.scene_sequence = store_.sequence();
  state.frames_received = frames_received_;
  state.frames_dropped = frames_dropped_;
  state.link_losses = link_losses_;
  return state;
}

link::Lateness Controller::lateness() const noexcept {
  link::Lateness late;
  std::uint32_t* const bins[] = {&late.below_1us,   &late.below_2us,  &late.below_5us,   &late.below_10us,
                                 &late.below_20us,  &late.below_50us, &late.below_100us, &late.below_200us,
                                 &late.below_500us, &late.below_1ms,  &late.below_2ms,   &late.below_5ms,
                                 &late.longer};
  static_assert(std::size(bins) == kLateBounds_us.size() + 1);
  for (std::size_t i = 0; i < std::size(bins); ++i) *bins[i] = servo_.late_ticks(i);
  late.worst_s = servo_.worst_late_us() * 1e-6F;
  return late;
}

// -------------------------------------------------------------------------------------------- the services

Nrc Controller::read_data(std::uint16_t did, link::ByteWriter& out) noexcept {
  fetch_records();
  switch (did) {
    case link::LinkInfo::kId: {
      link::LinkInfo info;
      info.protocol = link::kProtocolVersion;
      info.image = link::kImageVersion;
      info.frame_bytes = config_.classic_can ? link::kClassicDataBytes : link::kFdDataBytes;
      info.node = config_.node_id;
      info.arms = config_.arm_count;
      out.put_record(info);
      return Nrc::kOk;
    }
    case link::DeviceState::kId:
      out.put_record(device_state());
      return Nrc::kOk;
    case link::MoveState::kId:
      out.put_record(move_state());
      return Nrc::kOk;
    case link::TraceState::kId:
      out.put_record(servo_.trace().state());
      return Nrc::kOk;
    case link::Lateness::kId:
      out.put_record(lateness());
      return Nrc::kOk;
    case link::HostOrders::kId: {
      link::HostOrders orders = orders_;
      orders.expired = servo_.orders_expired();
      out.put_record(orders);
      return Nrc::kOk;
    }
    case link::kDidSerialNumber:
      out.put_text(config_.serial_number);
      return Nrc::kOk;
    case link::kDidFirmwareVersion:
      out.put_text(THIMBLE_VERSION);
      return Nrc::kOk;
    case link::kDidBoardName:
      out.put_text(config_.board);
      return Nrc::kOk;
    case link::kDidResetReason:
      out.put_text(config_.reset_reason);
      return Nrc::kOk;
    case link::kDidArmName:
      for (std::size_t i = 0; i < config_.arm_count && i < kMaxArms; ++i) {
        if (i != 0) out.put_text(",");
        out.put_text(config_.arm[i].model);
      }
      return Nrc::kOk;
    case link::kDidSceneName:
      if (running_.scene() != nullptr) out.put_text(running_.scene()->name()->c_str());
      return Nrc::kOk;
    case link::kDidRefusal:
      out.put_text(refusal_.data());
      return Nrc::kOk;
    default:
      break;
  }
  std::uint32_t bits = 0;
  if (params_.read(did, bits) != ParamStatus::kOk) return Nrc::kRequestOutOfRange;
  for (std::size_t i = 0; i < kParamBytes; ++i) out.put(static_cast<std::uint8_t>(bits >> (8 * i)));
  return Nrc::kOk;
}

Nrc Controller::write_data(std::uint16_t did, std::span<const std::uint8_t> data) noexcept {
  if (find_param(did) == nullptr) return Nrc::kRequestOutOfRange;
  if (data.size() != kParamBytes) return Nrc::kIncorrectLength;
  std::uint32_t bits = 0;
  for (std::size_t i = 0; i < kParamBytes; ++i) bits |= static_cast<std::uint32_t>(data[i]) << (8 * i);
  // The tick reads parameters whenever it likes: a trace must have ended before, and none may be about to begin.
  if (waited_for_ == Command::kTrace && servo_.command_pending()) return Nrc::kBusyRepeatRequest;
  if (did != row_of(Param::telemetry_decimation).id && servo_.trace().phase() == TracePhase::kRunning &&
      params_.check(did, bits, motors_off()) == ParamStatus::kOk) {
    servo_.trace().request_end(TraceEnd::kParameter);
    return Nrc::kResponsePending;
  }
  switch (write_param(did, bits)) {
    case ParamStatus::kOk:
      return Nrc::kOk;
    case ParamStatus::kUnknown:
    case ParamStatus::kOutOfRange:
      return Nrc::kRequestOutOfRange;
    case ParamStatus::kNotWhileArmed:
      return Nrc::kConditionsNotCorrect;
  }
  return Nrc::kGeneralReject;
}

ParamStatus Controller::read_param(std::uint16_t id, std::uint32_t& bits) const noexcept {
  return params_.read(id, bits);
}

ParamStatus Controller::write_param(std::uint16_t id, std::uint32_t bits) noexcept {
  if (id != row_of(Param::telemetry_decimation).id &&
      params_.check(id, bits, motors_off()) == ParamStatus::kOk)
    servo_.trace().request_end(TraceEnd::kParameter);
  return params_.write(id, bits, motors_off());
}

StoreStatus Controller::save_params() noexcept {
  return motors_off() ? param_store_.save(params_) : StoreStatus::kBusy;
}

Nrc Controller::save_parameters() noexcept {
  refuse("");
  if (!motors_off()) {
    refuse(kWrongMode);
    return Nrc::kConditionsNotCorrect;
  }
  return to_nrc(param_store_.save(params_));
}

bool Controller::motors_off() const noexcept {
  const Mode now = mode();
  return now != Mode::kArmed && now != Mode::kDamping && !servo_.command_pending();
}

// Posts a command and answers when the tick has obeyed it or has not.
Nrc Controller::run(Command command) noexcept {
  if (waited_for_ != command) {
    refuse("");
    const Conditions against = servo_.request(command);
    if (against != 0) {
      refuse(against);
      return Nrc::kConditionsNotCorrect;
    }
    waited_for_ = command;
  }
  return finish(command);
}

Nrc Controller::finish(Command command) noexcept {
  if (servo_.command_pending()) return Nrc::kResponsePending;
  waited_for_ = Command::kNone;
  const Mode now = mode();
  const bool moves = servo_.move_phase() != link::MovePhase::kNone;
  const bool done = command == Command::kArm       ? now == Mode::kArmed
                    : command == Command::kHome    ? now == Mode::kHoming || now == Mode::kReady
                    : command == Command::kMove    ? moves
                    : command == Command::kEndMove ? !moves
                    : command == Command::kTrace   ? servo_.trace().phase() == TracePhase::kRunning
                                                   : servo_.fault() == Fault::kNone;
  if (done) return Nrc::kOk;
  refuse(command == Command::kMove ? servo_.unmet_for_move()
                                   : servo_.unmet());  // something came between the check and the tick
  return Nrc::kConditionsNotCorrect;
}

Nrc Controller::arm() noexcept { return run(Command::kArm); }
Nrc Controller::home() noexcept { return run(Command::kHome); }

Nrc Controller::start_move(const link::MoveOrder& order) noexcept {
  if (waited_for_ != Command::kMove) {
    refuse("");
    const MoveOrder wanted = from_link(order);
    if (!servo_.move_in_range(wanted)) return Nrc::kRequestOutOfRange;
    if (servo_.command_pending()) return Nrc::kBusyRepeatRequest;
    const Conditions against = servo_.request_move(wanted);
    if (against != 0) {
      refuse(against);
      return Nrc::kConditionsNotCorrect;
    }
    waited_for_ = Command::kMove;
  }
  return finish(Command::kMove);
}

Nrc Controller::end_move() noexcept { return run(Command::kEndMove); }

link::MoveState Controller::move_state() const noexcept {
  link::MoveState state;
  state.phase = static_cast<std::uint8_t>(servo_.move_phase());
  state.end = static_cast<std::uint8_t>(servo_.move_end());
  if (const GuardedMove* results = servo_.move_results()) {
    state.samples = static_cast<std::uint16_t>(results->going().size() + results->coming_back().size());
    state.turn_x_m = results->turn_m().x();
    state.turn_y_m = results->turn_m().y();
    state.turn_z_m = results->turn_m().z();
    state.peak_force_N = results->peak_force_N();
    state.friction_N = results->friction_N();
  }
  return state;
}

Nrc Controller::move_samples(link::ByteWriter& out) noexcept {
  const GuardedMove* results = servo_.move_results();
  if (results == nullptr) return Nrc::kRequestSequenceError;
  for (const MoveSample& sample : results->going()) out.put_record(to_link(link::MovePhase::kGoing, sample));
  for (const MoveSample& sample : results->coming_back())
    out.put_record(to_link(link::MovePhase::kComingBack, sample));
  return Nrc::kOk;
}

Nrc Controller::start_trace() noexcept {
  if (waited_for_ != Command::kTrace) {
    if (servo_.scene_pending()) return Nrc::kBusyRepeatRequest;
    if (servo_.trace().phase() == TracePhase::kRunning) {
      refuse("trace_runs");
      return Nrc::kConditionsNotCorrect;
    }
    // Of the last trace nothing more is sent.
    for (std::uint32_t i = 0; i < Trace::kEntries && servo_.trace().next(trace_entry_); ++i) {
    }
    trace_arm_ = kMaxArms;
    trace_entry_.checked = false;
    trace_crc_ = store_.image_crc();
  }
  return run(Command::kTrace);
}

Nrc Controller::end_trace() noexcept {
  if (servo_.trace().phase() != TracePhase::kRunning) return Nrc::kOk;
  servo_.trace().request_end(TraceEnd::kStopped);
  return Nrc::kResponsePending;
}

Nrc Controller::trace_start(link::ByteWriter& out) noexcept {
  if (servo_.trace().phase() == TracePhase::kNone) return Nrc::kRequestSequenceError;
  link::TraceStart start = servo_.trace().start();
  start.scene_crc = trace_crc_;
  out.put_record(start);
  for (std::size_t i = 0; i < config_.arm_count; ++i) {
    link::TraceArm arm = servo_.trace().arms()[i];
    if (config_.arm[i].has_index) arm.flags |= link::kTraceHasIndex;
    const kinematics::BasePose& base = config_.arm[i].base;
    arm.home_x_m = base.home_m.x();
    arm.home_y_m = base.home_m.y();
    arm.home_z_m = base.home_m.z();
    const std::array<float*, 9> turn = {&arm.turn_xx, &arm.turn_xy, &arm.turn_xz, &arm.turn_yx, &arm.turn_yy,
                                        &arm.turn_yz, &arm.turn_zx, &arm.turn_zy, &arm.turn_zz};
    for (int k = 0; k < 9; ++k) *turn[static_cast<std::size_t>(k)] = base.rotation(k / 3, k % 3);
    out.put_record(arm);
  }
  return Nrc::kOk;
}

Nrc Controller::clear_faults() noexcept { return run(Command::kClear); }

Nrc Controller::disarm() noexcept {
  (void)servo_.request(Command::kDisarm);
  return Nrc::kOk;
}

void Controller::refuse(const char* reason) noexcept {
  const std::size_t length = std::min(std::strlen(reason), refusal_.size() - 1);
  std::copy_n(reason, length, refusal_.begin());
  refusal_[length] = '\0';
}

void Controller::refuse(Conditions conditions) noexcept {
  std::size_t at = 0;
  const auto append = [&](const char* text) {
    for (; *text != '\0' && at + 1 < refusal_.size(); ++text) refusal_[at++] = *text;
  };
  for (const ConditionRow& row : kConditionTable) {
    if ((conditions & row.bit) == 0) continue;
    if (at != 0) append(",");
    append(row.name);
    if (row.bit == kBoardLacks) {
      append("(");
      append(config_.lacks);
      append(")");
    }
  }
  refusal_[at] = '\0';
}

Nrc Controller::prepare_download(std::uint32_t length, std::uint32_t crc, std::uint32_t& has) noexcept {
  refuse("");
  if (servo_.scene_pending())
    return Nrc::kBusyRepeatRequest;  // the tick still reads the slot that is to be erased
  const StoreStatus status = store_.begin(length, crc);
  if (status != StoreStatus::kOk) refuse(name(status));
  has = static_cast<std::uint32_t>(store_.offset());
  return to_nrc(status);
}

Nrc Controller::write_download(std::uint32_t offset, std::span<const std::uint8_t> data) noexcept {
  return to_nrc(store_.write(offset, std::as_bytes(data)));
}

Nrc Controller::finish_download() noexcept {
  const StoreStatus status = store_.verify();
  if (status == StoreStatus::kRefused) {
    control::write_text(store_.image_verdict(), refusal_);
  } else if (status != StoreStatus::kOk) {
    refuse(name(status));
  }
  return to_nrc(status);
}

Nrc Controller::activate() noexcept {
  if (activating_) {
    if (servo_.scene_pending()) return Nrc::kResponsePending;
    activating_ = false;
    if (!store_.verified()) return Nrc::kOk;
  }
  if (servo_.scene_pending()) return Nrc::kBusyRepeatRequest;
  refuse("");
  const StoreStatus status = store_.commit(running_);
  if (status != StoreStatus::kOk) {
    refuse(name(status));
    return status == StoreStatus::kNoDownload ? Nrc::kConditionsNotCorrect : to_nrc(status);
  }
  (void)servo_.post_scene(running_, store_.sequence(), store_.binding());
  activating_ = true;
  return Nrc::kResponsePending;
}

StoreStatus Controller::load_scene(std::span<const std::byte> image) noexcept {
  if (servo_.scene_pending()) return StoreStatus::kBusy;
  StoreStatus status = store_.begin(image.size(), crc32(image));
  if (status == StoreStatus::kOk) status = store_.write(store_.offset(), image.subspan(store_.offset()));
  if (status == StoreStatus::kOk) status = store_.verify();
  if (status == StoreStatus::kOk) status = store_.commit(running_);
  if (status == StoreStatus::kOk) (void)servo_.post_scene(running_, store_.sequence(), store_.binding());
  return status;
}

std::size_t Controller::fault_count() const noexcept {
  return static_cast<std::size_t>(std::popcount(servo_.faults_seen()));
}

link::FaultRecord Controller::fault(std::size_t index) const noexcept {
  const std::uint32_t seen = servo_.faults_seen();
  if (index >= static_cast<std::size_t>(std::popcount(seen))) return {};
  const auto number = static_cast<std::uint8_t>(nth_bit(seen, index));
  const bool latched = number == static_cast<std::uint8_t>(servo_.fault());
  return {number, static_cast<std::uint8_t>(link::kFaultConfirmed | (latched ? link::kFaultActive : 0U))};
}

// The frames of all arms, tick by tick; when they are more than the link shows, the newest.
bool Controller::freeze_frame(std::uint8_t fault, std::size_t index, link::ByteWriter& out) const noexcept {
  if (fault != static_cast<std::uint8_t>(servo_.fault())) return false;
  const std::size_t arms = config_.arm_count;
  const std::size_t frames = servo_.freeze_count() * arms;
  if (index >= std::min(frames, link::kMaxFreezeFrames)) return false;
  if (frames > link::kMaxFreezeFrames) index += frames - link::kMaxFreezeFrames;
  Telemetry tick;
  if (!servo_.freeze_tick(index / arms, tick)) return false;
  const ArmTelemetry& arm = tick.arm[index % arms];
  link::FreezeFrame frame;
  frame.tick = static_cast<std::uint32_t>(tick.tick);
  frame.arm = static_cast<std::uint8_t>(index % arms);
  frame.mode = static_cast<std::uint8_t>(tick.mode);
  frame.limiter = arm.limiters;
  frame.contacts = arm.contacts;
  frame.count_0 = static_cast<std::int32_t>(arm.counts[0]);
  frame.count_1 = static_cast<std::int32_t>(arm.counts[1]);
  frame.count_2 = static_cast<std::int32_t>(arm.counts[2]);
  frame.tip_x_m = arm.tip_m.x();
  frame.tip_y_m = arm.tip_m.y();
  frame.tip_z_m = arm.tip_m.z();
  frame.force_x_N = arm.force_N.x();
  frame.force_y_N = arm.force_N.y();
  frame.force_z_N = arm.force_N.z();
  frame.current_0_A = arm.current_A.x();
  frame.current_1_A = arm.current_A.y();
  frame.current_2_A = arm.current_A.z();
  out.put_record(frame);
  return true;
}

void Controller::reset(link::Reset kind) noexcept {
  (void)servo_.request(Command::kDisarm);
  reset_ = kind;
}

void Controller::host_alive(link::Micros) noexcept { servo_.keep_alive(); }

}  // namespace thimble::firmware

#include "firmware/controller.h"

#include <algorithm>
#include <bit>
#include <cstring>

#include "firmware/sources/guarded_move_link.h"
#include "thimble_scene_schema/scene_generated.h"

namespace thimble::firmware {
namespace {

using link::Nrc;

constexpr std::size_t kParamBytes = 4;

// The n-th set bit's number; n counts from 0.
unsigned nth_bit(std::uint32_t bits, std::size_t n) noexcept {
  for (; n > 0; --n) bits &= bits - 1;
  return static_cast<unsigned>(std::countr_zero(bits));
}
static_assert(std::all_of(std::begin(kFaultTable), std::end(kFaultTable),
                          [](const FaultRow& row) { return static_cast<unsigned>(row.fault) < 32; }),
              "faults_seen() has 32 bits");

bool recorded(std::uint16_t id) noexcept {
  const ParamRow* row = find_param(id);
  return row != nullptr && row->recorded == Recording::kRecorded;
}

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
      core_(config, params_),
      store_(storage, config.pause),
      param_store_(storage),
      telemetry_frames_(core_, config.node_id),
      status_(core_, params_, store_, telemetry_frames_, config.node_id),
      recording_(core_.observers().recorder, std::min(config.arm_count, std::uint8_t{kMaxArms}),
                 config.node_id),
      picture_(core_, config.node_id),
      server_(*this, config.node_id, {}, config.block_bytes) {
  if (config_.arm_count > kMaxArms)
    config_.arm_count = kMaxArms;  // such a controller is faulted; its answers stay in bounds
  param_store_.load(params_);
  if (store_.open(running_) == StoreStatus::kOk)
    (void)core_.sources().scene.post(running_, store_.sequence());
}

// ------------------------------------------------------------------------------------------------ the link

void Controller::on_frame(const link::CanFrame& frame, link::Micros now) noexcept {
  ++frames_received_;
  if (!frame.extended && frame.id == link::EmergencyStop::kId) {  // with or without data, remote or not
    (void)core_.commands().request(Command::kStop);
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
  } else if (!core_.sources().host.order(order, now)) {
    ++orders_.old;
  } else {
    ++orders_.taken;
    core_.commands().keep_alive();
  }
}

void Controller::poll(link::Micros now) noexcept {
  fetch_records();
  server_.poll(now);
}

// The real-time frames first, the most urgent before the others. A recording can fill the bus, and then leaves the services
// one frame in nine.
bool Controller::next_frame(link::CanFrame& frame, link::Micros now) noexcept {
  if (status_.next_frame(frame, now)) return true;
  fetch_records();
  if (telemetry_frames_.next_tip_frame(frame)) return true;
  if (recording_.services_turn() && server_.next_frame(frame, now)) return true;
  return recording_.next_frame(frame) || telemetry_frames_.next_god_object_frame(frame) ||
         picture_.next_frame(frame) || server_.next_frame(frame, now);
}

std::optional<link::Reset> Controller::take_reset() noexcept {
  if (!reset_ || !motors_off()) return std::nullopt;  // first the tip is braked
  const std::optional<link::Reset> kind = reset_;
  reset_.reset();
  return kind;
}

void Controller::fetch_records() noexcept {
  if (telemetry_frames_.fetch()) picture_.on_record();
}

link::DeviceState Controller::device_state() const noexcept {
  const Telemetry& record = telemetry_frames_.record();
  link::DeviceState state;
  state.mode = mode();
  state.fault = static_cast<std::uint8_t>(core_.status().fault());
  state.flags = status_.flags();
  state.tick = static_cast<std::uint32_t>(record.tick);
  state.tick_rate_Hz = telemetry_frames_.rate_Hz();
  state.worst_tick_s = record.worst_tick_us * 1e-6F;
  state.overruns = record.overruns;
  state.contact_ticks = record.contact_ticks;
  state.peak_force_N = record.peak_force_N;
  state.mean_force_N = record.mean_force_N;
  state.sweep_bound = record.sweep_bound;
  state.slide_bound = record.slide_bound;
  state.scene_bytes = static_cast<std::uint32_t>(store_.image_bytes());
  state.scene_crc = store_.image_crc();
  state.scene_sequence = store_.sequence();
  state.frames_received = frames_received_;
  state.frames_dropped = telemetry_frames_.dropped();
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
  for (std::size_t i = 0; i < std::size(bins); ++i) *bins[i] = core_.observers().late_ticks.ticks(i);
  late.worst_s = core_.observers().late_ticks.worst_us() * 1e-6F;
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
      out.put_record(core_.observers().recorder.state());
      return Nrc::kOk;
    case link::Lateness::kId:
      out.put_record(lateness());
      return Nrc::kOk;
    case link::HostOrders::kId: {
      link::HostOrders orders = orders_;
      orders.expired = core_.sources().host.expired();
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
  // The tick reads parameters whenever it likes: a recording must have ended before, and none may be about to begin.
  if (waited_for_ == Command::kRecord && core_.commands().pending()) return Nrc::kBusyRepeatRequest;
  if (recorded(did) && core_.observers().recorder.phase() == TracePhase::kRunning &&
      params_.check(did, bits, motors_off()) == ParamStatus::kOk) {
    core_.observers().recorder.request_end(TraceEnd::kParameter);
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
  if (recorded(id) && params_.check(id, bits, motors_off()) == ParamStatus::kOk)
    core_.observers().recorder.request_end(TraceEnd::kParameter);
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
  return now != Mode::kArmed && now != Mode::kDamping && !core_.commands().pending();
}

// Posts a command and answers when the tick has obeyed it or has not.
Nrc Controller::run(Command command) noexcept {
  if (waited_for_ != command) {
    refuse("");
    const Conditions against = core_.commands().request(command);
    if (against != 0) {
      refuse(against);
      return Nrc::kConditionsNotCorrect;
    }
    waited_for_ = command;
  }
  return finish(command);
}

Nrc Controller::finish(Command command) noexcept {
  if (core_.commands().pending()) return Nrc::kResponsePending;
  waited_for_ = Command::kNone;
  const Mode now = mode();
  const bool moves = core_.sources().move.phase() != link::MovePhase::kNone;
  const bool done = command == Command::kArm       ? now == Mode::kArmed
                    : command == Command::kHome    ? now == Mode::kHoming || now == Mode::kReady
                    : command == Command::kMove    ? moves
                    : command == Command::kEndMove ? !moves
                    : command == Command::kRecord ? core_.observers().recorder.phase() == TracePhase::kRunning
                                                  : core_.status().fault() == Fault::kNone;
  if (done) return Nrc::kOk;
  refuse(command == Command::kMove
             ? core_.status().unmet_for_move()
             : core_.status().unmet());  // something came between the check and the tick
  return Nrc::kConditionsNotCorrect;
}

Nrc Controller::arm() noexcept { return run(Command::kArm); }
Nrc Controller::home() noexcept { return run(Command::kHome); }

Nrc Controller::start_move(const link::MoveOrder& order) noexcept {
  if (waited_for_ != Command::kMove) {
    refuse("");
    const MoveOrder wanted = from_link(order);
    if (!core_.commands().move_in_range(wanted)) return Nrc::kRequestOutOfRange;
    if (core_.commands().pending()) return Nrc::kBusyRepeatRequest;
    const Conditions against = core_.commands().request_move(wanted);
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
  state.phase = core_.sources().move.phase();
  state.end = core_.sources().move.end();
  if (const MoveResults* results = core_.sources().move.results()) {
    state.samples =
        static_cast<std::uint16_t>(results->going.samples().size() + results->coming_back.samples().size());
    state.turn_x_m = results->turn_m.x();
    state.turn_y_m = results->turn_m.y();
    state.turn_z_m = results->turn_m.z();
    state.peak_force_N = results->peak_force_N;
    state.friction_N = results->friction_N;
  }
  return state;
}

Nrc Controller::move_samples(link::ByteWriter& out) noexcept {
  const MoveResults* results = core_.sources().move.results();
  if (results == nullptr) return Nrc::kRequestSequenceError;
  for (const MoveSample& sample : results->going.samples())
    out.put_record(to_link(link::MovePhase::kGoing, sample));
  for (const MoveSample& sample : results->coming_back.samples())
    out.put_record(to_link(link::MovePhase::kComingBack, sample));
  return Nrc::kOk;
}

Nrc Controller::start_trace() noexcept {
  if (waited_for_ != Command::kRecord) {
    if (core_.sources().scene.pending()) return Nrc::kBusyRepeatRequest;
    if (core_.observers().recorder.phase() == TracePhase::kRunning) {
      refuse("trace_runs");
      return Nrc::kConditionsNotCorrect;
    }
    recording_.discard();
    trace_crc_ = store_.image_crc();
  }
  return run(Command::kRecord);
}

Nrc Controller::end_trace() noexcept {
  if (core_.observers().recorder.phase() != TracePhase::kRunning) return Nrc::kOk;
  core_.observers().recorder.request_end(TraceEnd::kStopped);
  return Nrc::kResponsePending;
}

Nrc Controller::trace_start(link::ByteWriter& out) noexcept {
  const RecordingStart* recording = core_.observers().recorder.start();
  if (recording == nullptr) return Nrc::kRequestSequenceError;
  link::TraceStart start = recording->start;
  start.scene_crc = trace_crc_;
  out.put_record(start);
  for (std::size_t i = 0; i < config_.arm_count; ++i) {
    link::TraceArm arm = recording->arms[i];
    arm.has_index = config_.arm[i].has_index;
    const kinematics::BasePose& base = config_.arm[i].base;
    for (int axis = 0; axis < 3; ++axis) arm.home_m[static_cast<std::size_t>(axis)] = base.home_m[axis];
    for (int k = 0; k < 9; ++k) arm.rotation[static_cast<std::size_t>(k)] = base.rotation(k / 3, k % 3);
    out.put_record(arm);
  }
  return Nrc::kOk;
}

Nrc Controller::clear_faults() noexcept { return run(Command::kClear); }

Nrc Controller::disarm() noexcept {
  (void)core_.commands().request(Command::kDisarm);
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
  if (core_.sources().scene.pending())
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
    if (core_.sources().scene.pending()) return Nrc::kResponsePending;
    activating_ = false;
    if (!store_.verified()) return Nrc::kOk;
  }
  if (core_.sources().scene.pending()) return Nrc::kBusyRepeatRequest;
  refuse("");
  const StoreStatus status = store_.commit(running_);
  if (status != StoreStatus::kOk) {
    refuse(name(status));
    return status == StoreStatus::kNoDownload ? Nrc::kConditionsNotCorrect : to_nrc(status);
  }
  (void)core_.sources().scene.post(running_, store_.sequence(), store_.binding());
  activating_ = true;
  return Nrc::kResponsePending;
}

StoreStatus Controller::load_scene(std::span<const std::byte> image) noexcept {
  if (core_.sources().scene.pending()) return StoreStatus::kBusy;
  StoreStatus status = store_.begin(image.size(), crc32(image));
  if (status == StoreStatus::kOk) status = store_.write(store_.offset(), image.subspan(store_.offset()));
  if (status == StoreStatus::kOk) status = store_.verify();
  if (status == StoreStatus::kOk) status = store_.commit(running_);
  if (status == StoreStatus::kOk)
    (void)core_.sources().scene.post(running_, store_.sequence(), store_.binding());
  return status;
}

std::size_t Controller::fault_count() const noexcept {
  return static_cast<std::size_t>(std::popcount(core_.status().faults_seen()));
}

link::FaultRecord Controller::fault(std::size_t index) const noexcept {
  const std::uint32_t seen = core_.status().faults_seen();
  if (index >= static_cast<std::size_t>(std::popcount(seen))) return {};
  const auto number = static_cast<std::uint8_t>(nth_bit(seen, index));
  const bool latched = number == static_cast<std::uint8_t>(core_.status().fault());
  return {number, static_cast<std::uint8_t>(link::kFaultConfirmed | (latched ? link::kFaultActive : 0U))};
}

// The frames of all arms, tick by tick; when they are more than the link shows, the newest.
bool Controller::freeze_frame(std::uint8_t fault, std::size_t index, link::ByteWriter& out) const noexcept {
  if (fault != static_cast<std::uint8_t>(core_.status().fault())) return false;
  const std::size_t arms = config_.arm_count;
  const std::size_t frames = core_.observers().freeze.count() * arms;
  if (index >= std::min(frames, link::kMaxFreezeFrames)) return false;
  if (frames > link::kMaxFreezeFrames) index += frames - link::kMaxFreezeFrames;
  Telemetry tick;
  if (!core_.observers().freeze.tick(index / arms, tick)) return false;
  const ArmTelemetry& arm = tick.arm[index % arms];
  link::FreezeFrame frame;
  frame.tick = static_cast<std::uint32_t>(tick.tick);
  frame.arm = static_cast<std::uint8_t>(index % arms);
  frame.mode = tick.mode;
  frame.limiters = arm.limiters;
  frame.contacts = arm.contacts;
  for (std::size_t joint = 0; joint < kJoints; ++joint) {
    frame.counts[joint] = static_cast<std::int32_t>(arm.counts[joint]);
    frame.current_A[joint] = arm.current_A[static_cast<int>(joint)];
  }
  frame.tip_x_m = arm.tip_m.x();
  frame.tip_y_m = arm.tip_m.y();
  frame.tip_z_m = arm.tip_m.z();
  frame.force_x_N = arm.force_N.x();
  frame.force_y_N = arm.force_N.y();
  frame.force_z_N = arm.force_N.z();
  out.put_record(frame);
  return true;
}

void Controller::reset(link::Reset kind) noexcept {
  (void)core_.commands().request(Command::kDisarm);
  reset_ = kind;
}

void Controller::host_alive(link::Micros) noexcept { core_.commands().keep_alive(); }

}  // namespace thimble::firmware

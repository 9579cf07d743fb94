#include "board/linux/drives/drive_life.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace thimble::board::drives {
namespace {

constexpr float kBrake_s = .3F;
constexpr unsigned kOffTicks = 3;  // how often a drive is told to switch off, should a frame be lost
constexpr unsigned kClearTicks = 3;
constexpr unsigned kAskTicks = 50;  // until a question is asked again
constexpr unsigned kAsks = 3;
constexpr float kSettle_s = .35F;  // three of ODrive's heartbeats and a half
constexpr float kEnable_s = 2;
constexpr float kRestShare = .05F;  // of the top speed
constexpr float kStands_s = .006F;  // moteus counts milliseconds
constexpr unsigned kDoubledTicks = 3;
constexpr std::uint16_t kCounterMask = 0x7FFF;
constexpr double kSameValue = 1e-5;  // relative: a float that went through decimal text

struct FaultText {
  DriveFault fault;
  const char* name;
  const char* sentence;
};
constexpr FaultText kFaultTexts[] = {
#define DRIVE_FAULT(enumerator, name, sentence) {DriveFault::enumerator, name, sentence},
#include "board/linux/drives/drive_faults.def"
#undef DRIVE_FAULT
};

const FaultText* text_of(DriveFault fault) {
  for (const FaultText& text : kFaultTexts)
    if (text.fault == fault) return &text;
  return nullptr;
}

float wrap_range_rad(const DriveConfig& config) {
  // The code overflows after its top one, so a wrap is one step longer than the range.
  return is_mit(config.kind) ? 65536 * config.ranges.position.step() : 0;
}

// Three ticks at the top speed, because up to two replies may be missed, and what the wire's steps add.
float longest_step_rad(const DriveConfig& config, float period_s) {
  const float steps_rad = is_mit(config.kind) ? 4 * config.ranges.position.step() : .002F;
  return 3 * config.top_speed_rad_s * std::max(period_s, config.reply_period_s) + steps_rad;
}

// The drive is not, or no longer, one that can brake.
bool without_power(DriveFault fault) {
  return fault == DriveFault::kRebooted || fault == DriveFault::kWatchdogExpired ||
         fault == DriveFault::kDriveReported || fault == DriveFault::kNotEnabled ||
         fault == DriveFault::kSwitchedOff;
}

}  // namespace

const char* name_of(DriveFault fault) noexcept {
  const FaultText* text = text_of(fault);
  return text == nullptr ? "none" : text->name;
}

const char* sentence_of(DriveFault fault) noexcept {
  const FaultText* text = text_of(fault);
  return text == nullptr ? "" : text->sentence;
}

const char* name_of(State state) noexcept {
  switch (state) {
    case State::kUnknown:
      return "unknown";
    case State::kFound:
      return "found";
    case State::kIdle:
      return "idle";
    case State::kEnabled:
      return "enabled";
    case State::kRunning:
      return "running";
    case State::kBraking:
      return "braking";
    case State::kSilent:
      return "silent";
    case State::kFault:
      return "fault";
  }
  return "";
}

DriveLife::DriveLife(const DriveConfig& config, WatchdogProof proof, float period_s)
    : config_(config),
      proof_(proof),
      period_s_(period_s),
      unwrap_(wrap_range_rad(config), longest_step_rad(config, period_s)),
      witness_(config.peak_torque_N_m, config.torque_lag_s, period_s) {
  const KindItems always = kind_items(config);
  for (std::size_t i = 0; i < always.count; ++i) items_[item_count_++] = always.items[i];
  for (const ConfigItem& item : config.items)
    if (item_count_ < kMostItems) items_[item_count_++] = item;
}

unsigned DriveLife::ticks(float time_s) const noexcept {
  return static_cast<unsigned>(std::lround(time_s / period_s_));
}

DriveLife::Wish DriveLife::wish() const noexcept {
  switch (state_) {
    case State::kUnknown:
      if (clearing_) return Wish::kClear;
      return in_state_ % 10 == 0 ? Wish::kDiscover : Wish::kNothing;
    case State::kFound:
      if (item_ < item_count_) return asked_ticks_ % kAskTicks == 0 ? Wish::kAsk : Wish::kAskAgain;
      if (!proven_) return proof_ticks_ == 0 ? Wish::kClear : Wish::kNothing;
      if (clearing_) return Wish::kClear;
      return poll_or_off();
    case State::kIdle:
      return in_state_ < off_ticks_ ? Wish::kOff : poll_or_off();
    case State::kEnabled:
      return enabling_ ? Wish::kEnable : Wish::kStandBy;
    case State::kRunning:
      return Wish::kRun;
    case State::kBraking:
      return Wish::kStandBy;
    case State::kSilent:
      if (in_state_ < ticks(kBrake_s)) return Wish::kUnheard;
      return in_state_ < ticks(kBrake_s) + kOffTicks ? Wish::kOff : poll_or_off();
    case State::kFault:
      return in_state_ < kOffTicks ? Wish::kOff : poll_or_off();
  }
  return Wish::kNothing;
}

// Where it says that it is on and should not be, it is told again; a moteus whose watchdog ended the commands still brakes.
DriveLife::Wish DriveLife::poll_or_off() const noexcept {
  return stage_ == Stage::kOn || stage_ == Stage::kTimedOut ? Wish::kOff : Wish::kPoll;
}

void DriveLife::enter(State state) noexcept {
  state_ = state;
  in_state_ = 0;
  missed_ = doubled_ = settled_ = counter_stands_ = off_ticks_ = 0;
}

void DriveLife::enable() noexcept {
  if (state_ != State::kIdle) return;
  enter(State::kEnabled);
  step_ = 0;
  enabling_ = true;
  since_torque_ = 0;
  witness_.reset();
}

void DriveLife::run() noexcept {
  if (ready()) enter(State::kRunning);
}

void DriveLife::brake() noexcept {
  if (state_ == State::kEnabled || state_ == State::kRunning) enter(State::kBraking);
}

void DriveLife::stop() noexcept {
  if (!powered()) return;
  enter(fault_ == DriveFault::kNone ? State::kIdle : State::kFault);
  off_ticks_ = kOffTicks;
}

void DriveLife::start_again() noexcept {
  if (state_ != State::kIdle) return;
  enter(State::kUnknown);
  clearing_ = true;
}

void DriveLife::clear() noexcept {
  if (state_ != State::kSilent && state_ != State::kFault) return;
  enter(State::kUnknown);
  fault_ = DriveFault::kNone;
  wrong_item_ = nullptr;
  position_known_ = counter_known_ = false;
  unwrap_.reset();
  clearing_ = true;
}

void DriveLife::fail(DriveFault fault) noexcept {
  if (state_ == State::kSilent || state_ == State::kFault) return;
  if (fault_ == DriveFault::kNone) fault_ = fault;
  if (fault == DriveFault::kSilent) {
    enter(State::kSilent);
  } else if (powered() && !without_power(fault)) {
    if (state_ != State::kBraking) enter(State::kBraking);
  } else {
    enter(State::kFault);
  }
}

void DriveLife::tick(const News& news, Protocol& protocol, const Sample& sample, float asked_N_m) noexcept {
  ++in_state_;
  stage_ = sample.stage;
  if (in_state_ >= kClearTicks) clearing_ = false;
  if (state_ == State::kSilent || state_ == State::kFault) return;
  if (state_ == State::kUnknown) return tick_unknown(news, protocol);
  take_position(news, sample);
  check_frames(news);
  check_clock(news, sample);
  if (powered()) take_torque(news, sample, asked_N_m);
  if (state_ == State::kFound) {
    if (protocol.wrong_version()) return fail(DriveFault::kVersion);
    tick_found(protocol, sample);
  } else if (state_ == State::kEnabled) {
    tick_enabled(sample);
  } else if (state_ == State::kBraking) {
    if (in_state_ >= ticks(kBrake_s)) enter(fault_ == DriveFault::kNone ? State::kIdle : State::kFault);
  } else if (state_ == State::kRunning || state_ == State::kIdle) {
    check_stage(sample);
  }
}

void DriveLife::tick_unknown(const News& news, const Protocol& protocol) noexcept {
  if (news.malformed) return fail(DriveFault::kWrongFrame);
  if (!news.heard || clearing_) return;
  if (protocol.wrong_version()) return fail(DriveFault::kVersion);
  enter(State::kFound);
  item_ = 0;
  asked_ticks_ = proof_ticks_ = 0;
  hash_ = 2166136261U;
  cleared_ = false;
  proven_ = proof_ != WatchdogProof::kBySilence;
}

void DriveLife::take_answer(double value) noexcept {
  const auto bits = std::bit_cast<std::uint64_t>(value);
  for (unsigned shift = 0; shift < 64; shift += 8)
    hash_ = (hash_ ^ static_cast<std::uint32_t>((bits >> shift) & 0xFFU)) * 16777619U;
  const double wanted = items_[item_].value;
  if (!(std::abs(value - wanted) <= kSameValue * std::abs(wanted))) {
    wrong_item_ = items_[item_].name;
    return fail(DriveFault::kConfigDiffers);
  }
  ++item_;
  asked_ticks_ = 0;
}

void DriveLife::tick_found(Protocol& protocol, const Sample& sample) noexcept {
  const std::optional<double> answer = protocol.take_answer();
  if (item_ < item_count_) {
    if (answer) return take_answer(*answer);
    if (++asked_ticks_ < kAsks * kAskTicks) return;
    wrong_item_ = items_[item_].name;
    return fail(DriveFault::kConfigSilent);
  }
  if (proof_ == WatchdogProof::kByHand && !config_.watchdog_proven)
    return fail(DriveFault::kWatchdogUnproven);
  if (!proven_) return tick_watchdog_proof(sample);
  // Off, without a fault, for the first time since the questions were answered.
  const bool off =
      sample.stage == Stage::kOff || (proof_ == WatchdogProof::kByHand && sample.stage == Stage::kUnknown);
  if (off && !std::isnan(sample.position_rad)) return check_start(sample);
  // Before this host spoke: a watchdog that is on has run out when a drive has power before its host.
  if (sample.stage == Stage::kTimedOut && !cleared_) {
    cleared_ = clearing_ = true;
    in_state_ = 0;
  }
  if (++proof_ticks_ < ticks(kSettle_s)) return;
  fail(sample.stage == Stage::kTimedOut || sample.stage == Stage::kFaulted ? DriveFault::kDriveReported
                                                                           : DriveFault::kSilent);
}

// First without errors, then silence until the drive reports its watchdog, then without errors again.
void DriveLife::tick_watchdog_proof(const Sample& sample) noexcept {
  if (proof_ticks_ == 0) {
    if (sample.stage == Stage::kOff) {
      proof_ticks_ = 1;
    } else if (in_state_ > 2 * ticks(kSettle_s)) {
      fail(DriveFault::kDriveReported);
    }
    return;
  }
  if (sample.stage == Stage::kTimedOut) {
    proven_ = cleared_ = clearing_ = true;
    in_state_ = proof_ticks_ = 0;
  } else if (++proof_ticks_ > ticks(config_.watchdog_s + kSettle_s)) {
    fail(DriveFault::kWatchdogUnproven);
  }
}

void DriveLife::check_start(const Sample& sample) noexcept {
  if (is_moteus(config_.kind) && sample.home_state < config_.needed_home_state)
    return fail(DriveFault::kNotHomed);
  if (position_known_ && (position_rad() < static_cast<double>(config_.start_lo_rad) ||
                          position_rad() > static_cast<double>(config_.start_hi_rad)))
    return fail(DriveFault::kStartPose);
  enter(State::kIdle);
}

void DriveLife::tick_enabled(const Sample& sample) noexcept {
  if (sample.stage == Stage::kFaulted || sample.stage == Stage::kTimedOut) return check_stage(sample);
  const bool on = !enabling_ && (sample.stage == Stage::kOn || proof_ == WatchdogProof::kByHand);
  const bool at_rest = std::abs(sample.velocity_rad_s) <= kRestShare * config_.top_speed_rad_s;
  // By its own timer one may come just behind the tick. A whole period more is too late; .999, because floats round.
  const bool fresh = static_cast<float>(missed_) * period_s_ < config_.reply_period_s + .999F * period_s_;
  settled_ = on && at_rest && fresh ? settled_ + 1 : 0;
  if (settled_ == kSettleTicks && (position_rad() < static_cast<double>(config_.start_lo_rad) ||
                                   position_rad() > static_cast<double>(config_.start_hi_rad)))
    return fail(DriveFault::kStartPose);
  if (in_state_ > ticks(kEnable_s) && !ready())
    fail(on && !at_rest ? DriveFault::kMoving : DriveFault::kNotEnabled);
}

void DriveLife::check_stage(const Sample& sample) noexcept {
  if (sample.stage == Stage::kTimedOut) return fail(DriveFault::kWatchdogExpired);
  if (sample.stage == Stage::kFaulted) return fail(DriveFault::kDriveReported);
  if (state_ == State::kRunning && (sample.stage == Stage::kOff || sample.stage == Stage::kStarting))
    fail(DriveFault::kRebooted);
}

void DriveLife::check_frames(const News& news) noexcept {
  if (news.malformed) return fail(DriveFault::kWrongFrame);
  if (news.rejected) return fail(DriveFault::kRejected);
  if (news.other_motor) return fail(DriveFault::kTwoReplies);
  const bool on_its_timer = config_.reply_period_s > 0;
  doubled_ = news.motions > 1 && !on_its_timer ? doubled_ + 1 : 0;
  if (doubled_ >= kDoubledTicks) return fail(DriveFault::kTwoReplies);
  if (state_ == State::kFound) return;
  missed_ = news.motions > 0 ? 0 : missed_ + 1;
  if (missed_ >= std::max(kSilentTicks, ticks(3 * config_.reply_period_s))) fail(DriveFault::kSilent);
}

// moteus counts milliseconds: a clock that goes back is a restart, one that stands is an old reply.
void DriveLife::check_clock(const News& news, const Sample& sample) noexcept {
  if (!is_moteus(config_.kind) || config_.short_frames || news.motions == 0) return;
  const auto forward = static_cast<std::uint16_t>((sample.counter_ms - counter_ms_) & kCounterMask);
  if (counter_known_ && forward > kCounterMask / 2) return fail(DriveFault::kRebooted);
  counter_stands_ = counter_known_ && forward == 0 ? counter_stands_ + 1 : 0;
  counter_ms_ = sample.counter_ms;
  counter_known_ = true;
  if (counter_stands_ > ticks(kStands_s) + 2) fail(DriveFault::kStale);
}

void DriveLife::take_position(const News& news, const Sample& sample) noexcept {
  if (news.motions == 0 || !sample.position_valid || std::isnan(sample.position_rad)) return;
  const bool jump = !unwrap_.take(sample.position_rad);
  position_known_ = true;
  if (jump && state_ != State::kFound)
    fail(sample.stage == Stage::kOff && powered() && !enabling_ ? DriveFault::kRebooted
                                                                : DriveFault::kPositionJump);
}

void DriveLife::take_torque(const News& news, const Sample& sample, float asked_N_m) noexcept {
  witness_.asked(asked_N_m);
  ++since_torque_;
  if (!news.torque || std::isnan(sample.torque_N_m)) return;
  witness_.reported(sample.torque_N_m, since_torque_);
  since_torque_ = 0;
  if (witness_.faulted()) fail(DriveFault::kTorqueDiffers);
}

}  // namespace thimble::board::drives

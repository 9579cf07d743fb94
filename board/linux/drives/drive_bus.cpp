#include "board/linux/drives/drive_bus.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "board/linux/drives/moteus.h"
#include "board/linux/drives/odrive.h"

namespace thimble::board::drives {
namespace {

// Nothing said yet. An ODrive's position is 0 until its first closed loop.
Sample silent_sample(const DriveConfig& config) {
  Sample sample;
  sample.position_valid = !is_odrive(config.kind);
  return sample;
}

float finite_or_zero(float value) { return std::isfinite(value) ? value : 0; }

}  // namespace

DriveBus::DriveBus(Descriptor socket, std::span<const DriveConfig> drives, float period_s)
    : socket_(std::move(socket)), states_(drives.size()) {
  slots_.reserve(drives.size());
  for (const DriveConfig& config : drives) {
    std::unique_ptr<Protocol> protocol = make_protocol(config);
    const WatchdogProof proof = protocol->proof();
    slots_.push_back(
        {config, std::move(protocol), DriveLife(config, proof, period_s), silent_sample(config), {}, {}});
  }
}

void DriveBus::begin_cycle(std::uint64_t now_us, std::span<const float> torque_N_m,
                           std::span<const float> damping_N_m_s_rad) noexcept {
  read(now_us, When::kLate);
  for (Slot& slot : slots_)
    if (begun_us_ != 0 && slot.life.powered() &&
        static_cast<float>(now_us - begun_us_) > slot.config.watchdog_s * 1e6F)
      slot.life.fail(DriveFault::kHostGap);
  // An ODrive's watchdog runs while it is off: after a pause it has expired, which is no fault of one that was off.
  for (Slot& slot : slots_)
    if (begun_us_ != 0 && is_odrive(slot.config.kind) &&
        static_cast<float>(now_us - begun_us_) > slot.config.watchdog_s * 1e6F)
      slot.life.start_again();
  begun_us_ = now_us;
  apply_bus_rules();

  outbox_.clear();
  sort_by_load(torque_N_m);
  for (const std::size_t i : std::span(order_).first(slots_.size()))
    add_frames(slots_[i], i < torque_N_m.size() ? torque_N_m[i] : 0,
               i < damping_N_m_s_rad.size() ? damping_N_m_s_rad[i] : 0);
  switch (socket_.send(outbox_.frames())) {
    case CanSocket::Sent::kAll:
      break;
    case CanSocket::Sent::kFull:
      fail_all(DriveFault::kBusFull);
      break;
    case CanSocket::Sent::kDown:
      fail_all(DriveFault::kBusOff);
      break;
  }
}

void DriveBus::sort_by_load(std::span<const float> torque_N_m) noexcept {
  const auto load = [&](std::size_t i) {
    return i < torque_N_m.size() ? std::abs(finite_or_zero(torque_N_m[i])) / slots_[i].config.peak_torque_N_m
                                 : 0.0F;
  };
  for (std::size_t i = 0; i < slots_.size(); ++i) {
    std::size_t at = i;
    for (; at > 0 && load(order_[at - 1]) < load(i); --at) order_[at] = order_[at - 1];
    order_[at] = i;
  }
}

void DriveBus::add_frames(Slot& slot, float torque_N_m, float damping_N_m_s_rad) noexcept {
  using Wish = DriveLife::Wish;
  const float base = slot.config.base_damping_N_m_s_rad;
  const float peak = slot.config.peak_torque_N_m;
  slot.sent = {};
  Protocol& protocol = *slot.protocol;
  switch (slot.life.wish()) {
    case Wish::kNothing:
      return;
    case Wish::kDiscover:
      return protocol.discover(outbox_);
    case Wish::kAsk:
      return protocol.ask(slot.life.item(), false, outbox_);
    case Wish::kAskAgain:
      return protocol.ask(slot.life.item(), true, outbox_);
    case Wish::kClear:
      protocol.clear_faults(outbox_);
      return protocol.poll(outbox_);
    case Wish::kPoll:
      return protocol.poll(outbox_);
    case Wish::kEnable: {
      const bool step = protocol.enable(slot.life.enable_step(), outbox_);
      slot.life.set_sent_enable_step(step);
      if (step) return;
      slot.sent = {0, base};
      return protocol.command(slot.sent, outbox_);
    }
    case Wish::kStandBy:
      slot.sent = {0, base};
      return protocol.command(slot.sent, outbox_);
    case Wish::kRun: {
      const float damping =
          is_odrive(slot.config.kind) ? base : std::max(finite_or_zero(damping_N_m_s_rad), base);
      slot.sent = {std::clamp(finite_or_zero(torque_N_m), -peak, peak), damping};
      return protocol.command(slot.sent, outbox_);
    }
    case Wish::kOff:
      return protocol.switch_off(outbox_);
    case Wish::kUnheard:
      return protocol.send_unheard(outbox_);
  }
}

bool DriveBus::collect(std::uint64_t now_us) noexcept {
  read(now_us, When::kInTime);
  return std::ranges::all_of(
      slots_, [](const Slot& slot) { return slot.news.motions > 0 || slot.config.reply_period_s > 0; });
}

void DriveBus::read(std::uint64_t now_us, When when) noexcept {
  // A bus of 1 Mbit/s brings at most 18 classic frames in a millisecond; what a longer pause left is old.
  constexpr int kMostReads = 64;
  for (int i = 0; i < kMostReads; ++i) {
    const std::span<const CanSocket::Received> received = socket_.receive(now_us);
    for (const CanSocket::Received& one : received) take(one, when);
    if (received.size() < kMostFrames) return;
  }
}

void DriveBus::take(const CanSocket::Received& received, When when) noexcept {
  if (received.bus_off) return fail_all(DriveFault::kBusOff);
  const auto owner = std::ranges::find_if(
      slots_, [&received](const Slot& slot) { return slot.protocol->owns(received.frame); });
  if (owner == slots_.end()) return note(received.frame);
  News& news = owner->news;
  news.heard = true;
  if (received.frame.fd != is_fd(owner->config.kind)) {
    news.malformed = true;
    return;
  }
  const bool on_its_timer = owner->config.reply_period_s > 0;
  const Sample before = owner->sample;
  const Reply reply = owner->protocol->hear(received.frame, owner->sample);
  switch (reply) {
    case Reply::kOther:
      news.other_motor = is_mit(owner->config.kind);
      return;
    case Reply::kMalformed:
      news.malformed = true;
      return;
    case Reply::kRejected:
      news.rejected = true;
      return;
    case Reply::kMotion: {
      if (!std::isfinite(owner->sample.position_rad) || !std::isfinite(owner->sample.velocity_rad_s)) {
        owner->sample = before;
        news.malformed = true;
        return;
      }
      const bool too_soon =
          received.stamp_us < begun_us_ + static_cast<std::uint64_t>(owner->config.least_reply_us);
      if ((when == When::kLate || too_soon) && !on_its_timer) {
        // It answers the command of a tick before: what it says of faults holds, its position is old.
        owner->sample.position_rad = before.position_rad;
        owner->sample.velocity_rad_s = before.velocity_rad_s;
        ++owner->late;
        return;
      }
      ++news.motions;
      owner->stamp_us = received.stamp_us;
      news.torque = news.torque || (is_mit(owner->config.kind) ||
                                    (is_moteus(owner->config.kind) && received.frame.size > 12));
      return;
    }
    case Reply::kTelemetry: {
      // ODrive's torque comes in a message of its own.
      const bool torque = is_odrive(owner->config.kind) && !std::isnan(owner->sample.torque_N_m);
      const auto message = static_cast<odrive::Message>(received.frame.id & 0x1FU);
      news.torque = news.torque ||
                    (torque && message == (owner->config.kind == Kind::kOdrive06 ? odrive::Message::kTorques
                                                                                 : odrive::Message::kIq));
      return;
    }
    case Reply::kAnswer:
      return;
  }
}

void DriveBus::note(const CanFrame& frame) noexcept {
  if (frame.remote) return;
  const Stranger stranger{frame.id, frame.size, frame.extended, frame.fd};
  const std::span<const Stranger> known = strangers();
  if (stranger_count_ == kMostStrangers || std::ranges::any_of(known, [&](const Stranger& one) {
        return one.id == stranger.id && one.extended == stranger.extended;
      }))
    return;
  strangers_[stranger_count_++] = stranger;
}

// Drives that are not yet found have no part in it: nobody acknowledges where none is switched on.
void DriveBus::fail_all(DriveFault fault) noexcept {
  for (Slot& slot : slots_)
    if (slot.life.state() != State::kUnknown && slot.life.state() != State::kFound) slot.life.fail(fault);
}

std::span<const DriveState> DriveBus::end_cycle(std::uint64_t now_us) noexcept {
  (void)collect(now_us);
  for (Slot& slot : slots_) {
    const bool had_failed = slot.life.fault() != DriveFault::kNone;
    const float velocity_rad_s = finite_or_zero(slot.sample.velocity_rad_s);
    slot.life.tick(slot.news, *slot.protocol, slot.sample,
                   slot.sent.torque_N_m - slot.sent.damping_N_m_s_rad * velocity_rad_s);
    if (!had_failed && slot.life.fault() != DriveFault::kNone) slot.fault_code = slot.sample.drive_fault;
    slot.news = {};
  }
  apply_bus_rules();
  for (std::size_t i = 0; i < slots_.size(); ++i) states_[i] = state_of(slots_[i], now_us);
  return states_;
}

void DriveBus::apply_bus_rules() noexcept {
  const auto is_ready = [](const Slot& slot) { return slot.life.ready(); };
  const auto has_failed = [](const Slot& slot) { return slot.life.fault() != DriveFault::kNone; };
  if (std::ranges::any_of(slots_, has_failed)) {
    for (Slot& slot : slots_) slot.life.brake();
  } else if (std::ranges::all_of(slots_, is_ready)) {
    for (Slot& slot : slots_) slot.life.run();
  }
}

DriveState DriveBus::state_of(const Slot& slot, std::uint64_t now_us) const noexcept {
  DriveState state;
  const Sample& sample = slot.sample;
  state.position_rad = slot.life.position_rad();
  state.velocity_rad_s = sample.velocity_rad_s;
  state.torque_N_m = sample.torque_N_m;
  state.torque_difference_N_m = slot.life.torque_difference_N_m();
  state.current_A = sample.current_A;
  state.supply_V = sample.supply_V;
  state.drive_C = sample.drive_C;
  state.motor_C = sample.motor_C;
  if (slot.stamp_us != 0) state.age_us = static_cast<float>(now_us - slot.stamp_us);
  state.position_known = slot.life.position_known();
  state.fresh = slot.stamp_us >= begun_us_ && slot.stamp_us != 0;
  state.state = slot.life.state();
  state.fault = slot.life.fault();
  state.drive_fault = state.fault == DriveFault::kNone ? sample.drive_fault : slot.fault_code;
  state.limiter = sample.limiter;
  if (state.limiter == Limiter::kNone && slot.life.limit_unseen()) state.limiter = Limiter::kUnseen;
  state.late_replies = slot.late;
  state.config_hash = slot.life.config_hash();
  state.wrong_item = slot.life.wrong_item();
  return state;
}

std::string_view DriveBus::enable() noexcept {
  if (stranger_count_ != 0) return "a frame on the bus has an id that no drive of the list sends";
  for (const Slot& slot : slots_)
    if (slot.life.state() != State::kIdle) return "a drive is not idle";
  for (Slot& slot : slots_) slot.life.enable();
  return {};
}

void DriveBus::disable() noexcept {
  for (Slot& slot : slots_) slot.life.brake();
}

void DriveBus::stop(bool cut) noexcept {
  for (Slot& slot : slots_) {
    if (cut && slot.life.powered()) slot.life.fail(DriveFault::kSwitchedOff);
    slot.life.stop();
  }
}

void DriveBus::clear() noexcept {
  for (Slot& slot : slots_) {
    if (slot.life.state() != State::kSilent && slot.life.state() != State::kFault) continue;
    slot.life.clear();
    slot.sample = silent_sample(slot.config);
    slot.fault_code = 0;
  }
  stranger_count_ = 0;
}

std::vector<can_filter> DriveBus::reply_filters() const {
  constexpr std::uint32_t kExact = CAN_EFF_FLAG | CAN_RTR_FLAG;
  std::vector<can_filter> out;
  for (const Slot& slot : slots_) {
    const std::uint8_t id = slot.config.id;
    if (is_moteus(slot.config.kind)) {  // from drive 8 on with 29 bits, and any prefix above 16 of them
      out.push_back({moteus::reply_id(id), CAN_SFF_MASK | kExact});
      out.push_back({moteus::reply_id(id) | CAN_EFF_FLAG, 0xFFFFU | kExact});
    } else if (is_odrive(slot.config.kind)) {
      out.push_back({static_cast<std::uint32_t>(id) << 5U, 0x7E0U | kExact});
    } else {
      out.push_back({slot.config.reply_id, CAN_SFF_MASK | kExact});
    }
  }
  return out;
}

}  // namespace thimble::board::drives

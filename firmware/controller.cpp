#include "firmware/controller.h"

#include <algorithm>
#include <string_view>
#include <utility>

#include "firmware/link/crc32.h"
#include "firmware/services/handlers.h"

namespace thimble::firmware {
namespace {

bool damaged(const Config& config, const ArmStore& arms) noexcept {
  for (std::size_t i = 0; i < std::min<std::size_t>(config.arm_count, kMaxArms); ++i)
    if (arms.damaged(i)) return true;
  return false;
}

// Stored arms go before those that the board names; where one is damaged, none of them is known to be the right one.
Config with_stored_arms(Config config, const ArmStore& arms) noexcept {
  for (std::size_t i = 0; i < kMaxArms; ++i) config.arm[i].image = arms.image(i);
  const bool lacks_nothing = config.lacks == nullptr || *config.lacks == '\0';
  if (damaged(config, arms) && lacks_nothing) config.lacks = "sound_arm_image";
  return config;
}

// A controller with more arms is faulted; its answers stay in bounds.
Config with_possible_arms(Config config) noexcept {
  config.arm_count = std::min(config.arm_count, std::uint8_t{kMaxArms});
  return config;
}

bool ended_badly(const Config& config) noexcept {
  const std::string_view reason = config.reset_reason;
  return reason == "watchdog" || reason == "crash";
}

}  // namespace

Controller::Controller(const Config& config, Storage& storage) noexcept
    : arms_(storage, config.pause),
      config_(with_possible_arms(with_stored_arms(config, arms_))),
      core_(with_stored_arms(config, arms_), params_),
      store_(storage, config.pause),
      param_store_(storage),
      keys_(storage),
      persistent_(storage, core_),
      audit_(storage, core_, persistent_),
      telemetry_(core_, params_, config.node_id),
      status_(core_, params_, store_, telemetry_, config.node_id),
      recording_(core_.observers().recorder, config_.arm_count, core_.setup().axes, config.node_id),
      picture_(core_, config.node_id),
      orders_(core_, params_, config.node_id, config_.arm_count),
      services_({config_, params_, core_, store_, running_, arms_, param_store_, keys_, persistent_, audit_,
                 telemetry_, status_, recording_, link_, orders_}),
      router_(services_, config.node_id) {
  param_store_.open();
  const bool scene = store_.open(running_) == StoreStatus::kOk;
  const bool crashed = ended_badly(config);
  const JournalRecord::InUse aside = persistent_.begin(in_store(), crashed);
  if (aside.params == 0) param_store_.apply(params_);
  if (aside.scene != 0) {
    store_.set_aside();
    running_ = {};
  }
  persistent_.resume_heat(params_, config.utc_s);
  keys_.open();
  services_.authenticator.begin(persistent_.starts());
  audit_.start(config.reset_reason);
  if (aside.scene != 0 || aside.params != 0) core_.begin_with(Fault::set_aside);
  if (store_.damaged() || param_store_.damaged() || damaged(config_, arms_))
    core_.begin_with(Fault::store_corrupt);
  if (crashed) core_.begin_with(Fault::watchdog_reset);
  if (scene && aside.scene == 0) static_cast<void>(core_.sources().scene.post(running_, store_.sequence()));
}

void Controller::on_frame(const link::CanFrame& frame, link::Micros now) noexcept {
  ++link_.frames_received;
  audit_.observe(now);
  fetch_records();
  if (!frame.extended && frame.id == link::EmergencyStop::kId) {  // with or without data, remote or not
    static_cast<void>(core_.commands().request(Command::kStop));
  } else if (!orders_.on_frame(frame, now)) {
    static_cast<void>(router_.on_frame(frame, now));
  }
}

void Controller::poll(link::Micros now) noexcept {
  fetch_records();
  audit_.observe(now);
  router_.poll(now);
  persistent_.poll(in_store(), now);
  audit_.poll(now, services_.restart_wanted.has_value());
}

// The real-time frames first, the most urgent before the others. A recording can fill the bus, and then leaves the services
// one frame in nine.
bool Controller::next_frame(link::CanFrame& frame, link::Micros now) noexcept {
  if (status_.next_frame(frame, now)) return true;
  fetch_records();
  if (telemetry_.next_tip_frame(frame)) return true;
  if (recording_.services_turn() && router_.next_frame(frame, now)) return true;
  return recording_.next_frame(frame) || telemetry_.next_detail_frame(frame) || picture_.next_frame(frame) ||
         router_.next_frame(frame, now);
}

PersistentState::InStore Controller::in_store() const noexcept {
  return {store_.sequence(), param_store_.sequence(), {store_.image_crc(), param_store_.crc()}};
}

void Controller::fetch_records() noexcept {
  if (telemetry_.fetch()) picture_.on_record();
}

std::optional<link::Reset> Controller::take_reset() noexcept {
  if (!motors_off(core_) || !audit_.finished()) return std::nullopt;  // first the tip is braked
  return std::exchange(services_.restart_wanted, std::nullopt);
}

link::MoveState Controller::move_state() const noexcept { return firmware::move_state(core_); }

ParamStatus Controller::read_param(std::uint16_t id, std::uint32_t& bits) const noexcept {
  return params_.read(id, bits);
}

ParamStatus Controller::write_param(std::uint16_t id, std::uint32_t bits) noexcept {
  const ParamStatus allowed = params_.check(id, bits, motors_off(core_));
  if (allowed != ParamStatus::kOk) return allowed;
  if (find_param(id)->recorded == Recording::kRecorded)
    core_.observers().recorder.request_end(RecordingEnd::kParameter);
  if (marks(*find_param(id)) && !post_mark(core_, params_, *find_param(id), bits)) return ParamStatus::kBusy;
  return params_.write(id, bits, motors_off(core_));
}

StoreStatus Controller::save_params() noexcept {
  return motors_off(core_) ? param_store_.save(params_) : StoreStatus::kBusy;
}

StoreStatus Controller::load_scene(std::span<const std::byte> image) noexcept {
  if (core_.sources().scene.pending()) return StoreStatus::kBusy;
  StoreStatus status = store_.begin(image.size(), crc32(image));
  if (status == StoreStatus::kOk) status = store_.write(store_.offset(), image.subspan(store_.offset()));
  if (status == StoreStatus::kOk) status = store_.verify();
  if (status == StoreStatus::kOk) status = store_.commit(running_);
  if (status == StoreStatus::kOk)
    static_cast<void>(core_.sources().scene.post(running_, store_.sequence(), store_.binding()));
  return status;
}

}  // namespace thimble::firmware

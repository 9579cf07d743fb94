#include "host-tools/viewer/device_session.h"

#include <algorithm>
#include <exception>
#include <string_view>
#include <utility>

#include "firmware/core/faults.h"

namespace thimble::host {
namespace {

using link::Micros;

constexpr Micros kRound_us = 5'000;  // how long a message of a page may wait
constexpr Micros kStatePeriod_us = 1'000'000 / 60;
constexpr Micros kSilence_us = 2'000'000;  // four heartbeats
constexpr Micros kRetry_us = 300'000;
constexpr Micros kHandHome_us = 3'000'000;  // from anywhere in a workspace
constexpr Micros kSettle_us = 200'000;      // the tip after the hand
constexpr Micros kHomingAnswer_us = 1'000'000;
constexpr Micros kStopRepeat_us = 20'000;

bool is_command(const PageMessage& message, ViewCommand verb) {
  const auto* command = std::get_if<CommandMessage>(&message);
  return command != nullptr && command->verb == verb;
}

}  // namespace

DeviceSession::DeviceSession(SessionOptions options, SessionLink& link, Scenes& scenes, SimulatedHands* hands,
                             std::optional<OpenScene> first, ViewSink& sink)
    : options_(std::move(options)),
      link_(link),
      scenes_(scenes),
      hands_(hands),
      sink_(sink),
      begun_us_(now_us()),
      to_upload_(std::move(first)),
      begin_(hands != nullptr) {
  options_.options.hurry = [this] { return urgent_waits(); };
}

void DeviceSession::post(PageMessage message) {
  if (const auto* hand = std::get_if<HandMessage>(&message)) {
    obey(*hand);
    return;
  }
  const MutexLock lock(mutex_);
  if (is_command(message, ViewCommand::kStop)) {
    std::erase_if(waiting_, [](const PageMessage& one) {
      return is_command(one, ViewCommand::kArm) || is_command(one, ViewCommand::kHome) ||
             is_command(one, ViewCommand::kClear);
    });
    ++stops_;
    stop_wanted_ = true;
    return;
  }
  if (const auto* material = std::get_if<MaterialMessage>(&message)) {
    if (merge(*material)) return;
  }
  if (auto* draft = std::get_if<DraftMessage>(&message)) {
    if (merge(*draft)) return;
  }
  if (std::holds_alternative<FileMessage>(message)) leave_room<FileMessage>();
  if (is_command(message, ViewCommand::kDisarm)) {
    // Never refused, and at most one beyond kMostWaiting: a queued disarm without an arm behind it suffices.
    for (auto one = waiting_.rbegin(); one != waiting_.rend() && !is_command(*one, ViewCommand::kArm);
         ++one) {
      if (is_command(*one, ViewCommand::kDisarm)) return;
    }
  } else if (waiting_.size() >= kMostWaiting) {
    throw Error(ExitCode::kRefused, "busy", "too many messages wait for the device", "send them slower");
  }
  waiting_.push_back(std::move(message));
}

// Only the last value of a slider counts. It replaces an earlier one unless another kind of message lies between.
bool DeviceSession::merge(const MaterialMessage& material) {
  for (auto one = waiting_.rbegin(); one != waiting_.rend(); ++one) {
    auto* waiting = std::get_if<MaterialMessage>(&*one);
    if (waiting == nullptr) return false;
    if (waiting->object != material.object || waiting->key != material.key) continue;
    waiting->value = material.value;
    return true;
  }
  return false;
}

// For what is large.
template <class Message>
void DeviceSession::leave_room() const {
  constexpr std::ptrdiff_t kMost = 8;
  const auto is_one = [](const PageMessage& one) { return std::holds_alternative<Message>(one); };
  if (std::ranges::count_if(waiting_, is_one) >= kMost)
    throw Error(ExitCode::kRefused, "busy", "too much waits for the device", "send it slower");
}

// Only the last draft counts, too.
bool DeviceSession::merge(DraftMessage& draft) {
  auto* waiting = waiting_.empty() ? nullptr : std::get_if<DraftMessage>(&waiting_.back());
  if (waiting != nullptr) {
    waiting->replaced.push_back(std::exchange(waiting->number, draft.number));
    waiting->text = std::move(draft.text);
    return true;
  }
  leave_room<DraftMessage>();
  return false;
}

std::optional<PageMessage> DeviceSession::next_message() {
  const MutexLock lock(mutex_);
  if (waiting_.empty()) return std::nullopt;
  PageMessage message = std::move(waiting_.front());
  waiting_.pop_front();
  stops_before_ = stops_;
  return message;
}

bool DeviceSession::urgent_waits() {
  if (stop_wanted_) return true;
  const MutexLock lock(mutex_);
  return std::ranges::any_of(
      waiting_, [](const PageMessage& message) { return is_command(message, ViewCommand::kDisarm); });
}

void DeviceSession::inform(const std::string& name, const std::string& cause, const std::string& remedy) {
  sink_.event(event_json("info", name, cause, remedy));
}

void DeviceSession::run(const std::atomic<bool>& stopping, const std::function<void()>& connected) {
  stopping_ = &stopping;
  connect();
  connected();
  while (!stopping) {
    if (!serve_until_lost(stopping)) wait_for_device(stopping);
  }
  device_.reset();
}

// False: the device has gone. Apart from the wait for it: in a page nothing may wait in a handler (host-tools/in_page).
bool DeviceSession::serve_until_lost(const std::atomic<bool>& stopping) {
  try {
    serve(stopping);
    return true;
  } catch (const Error& error) {
    break_off_recording(error.name);
    device_.reset();
    sink_.event(event_json(error));
    sink_.link(false);
    forget_save("the device has gone before the change ran");
    return false;
  }
}

void DeviceSession::connect() {
  device_ = std::make_unique<Device>(link_.connect(address_), options_.options);
  arms_ = device_->info().arms;
  learn_arms();
  heard_us_ = now_us();
  shown_crc_.reset();
  send_hello();
  device_state_ = device_->state();
  live_.take_state(device_state_);
  device_->set_listener([this](const link::CanFrame& frame) { hear(frame); });
  look_at_device();
}

void DeviceSession::wait_for_device(const std::atomic<bool>& stopping) {
  while (!stopping) {
    link_.pause(kRetry_us);
    while (const std::optional<PageMessage> message = next_message()) {
      sink_.event(event_json("error", "no-device", "the device is not there, so nothing was done",
                             "wait until it is back"));
    }
    if (stop_wanted_.exchange(false)) {
      stop_until_us_ = 0;
      sink_.event(event_json("error", "not-stopped", "the device is not there, so no stop was sent",
                             "press the e-stop button, or switch the motors' supply off"));
    }
    if (is_back()) return;
  }
}

bool DeviceSession::is_back() {
  try {
    connect();
    sink_.link(true);
    inform("link-back", "the device " + address_ + " answers again");
    return true;
  } catch (const Error&) {
    device_.reset();
    return false;
  }
}

void DeviceSession::serve(const std::atomic<bool>& stopping) {
  while (!stopping) {
    tend_stop();
    listen(now_us() + kRound_us);
    while (const std::optional<PageMessage> message = next_message()) obey(*message);
    tend_job();
    if (to_upload_ && now_us() >= upload_due_us_) {
      const OpenScene scene = std::move(*to_upload_);
      to_upload_.reset();
      bool runs = false;
      try {
        upload(scene);
        runs = true;
        begin_simulation();
      } catch (const Disturbed&) {
        if (!to_upload_) to_upload_ = scene;  // it will be resumed
      } catch (const Error& error) {
        if (!runs && scene.draft && error.code != ExitCode::kLinkLost)
          tell_of_draft(error);  // the device does not take it
        else if (!runs)
          drop_edits();
        if (error.code == ExitCode::kLinkLost) throw;
        sink_.event(event_json(error));
      }
    }
    if (now_us() >= look_due_us_) look_at_device();
    if (now_us() - heard_us_ > kSilence_us) {
      throw Error(ExitCode::kLinkLost, "link-lost", "the device " + address_ + " has been silent for 2 s",
                  "check that it still runs");
    }
  }
}

void DeviceSession::begin_simulation() {
  if (!begin_) return;
  begin_ = false;
  device_->home();
  device_->arm();
}

// Homing takes the present position as home, so the simulated hands move there first, with the motors off.
void DeviceSession::home_simulation() {
  const bool armed = device_->state().mode == link::Mode::kArmed;
  if (armed) device_->disarm();
  {
    const SimulatedHands::LedHome hands(*hands_);
    const Micros give_up_us = now_us() + kHandHome_us;
    while (!hands.there() && now_us() < give_up_us) listen(now_us() + kRound_us);
    if (!hands.there()) {
      throw Error(ExitCode::kRefused, "hand-not-home", "the simulated hand did not come home in 3 s",
                  "is this machine too busy? Home again");
    }
    const Micros settled_us = now_us() + kSettle_us;
    while (now_us() < settled_us) listen(now_us() + kRound_us);
    device_->home();
  }
  if (armed) device_->arm();
  inform("homed", armed ? "the hand went home; the arm is homed and armed again"
                        : "the hand went home, and the arm is homed");
}

// --- What comes from the device

void DeviceSession::hear(const link::CanFrame& frame) {
  const Micros now = now_us();
  heard_us_ = now;
  if (recording_) recording_->device.take(frame);
  const bool complete = live_.take(frame, now);
  if (live_.mode() != device_state_.mode) look_due_us_ = now;  // why is not in the frames
  tend_stop();
  if (const std::optional<std::uint8_t> fault = live_.take_emergency()) {
    const firmware::FaultRow* row = firmware::find_fault(static_cast<firmware::Fault>(*fault));
    if (row != nullptr) sink_.event(event_json("error", row->name, row->cause, row->remedy));
  }
  if (!complete || now < state_due_us_) return;
  // Keeps the average rate: a state that is a little late does not delay the next one.
  state_due_us_ = std::max(state_due_us_ + kStatePeriod_us, now - kStatePeriod_us);
  send_state(now);
}

void DeviceSession::tend_stop() {
  if (!stop_wanted_) return;
  const Micros now = now_us();
  if (stop_until_us_ == 0) {
    stop_until_us_ = now + kStop_us;
  } else if (live_.stopped()) {
    stop_wanted_ = false;
    stop_until_us_ = 0;
    return;
  } else if (now > stop_until_us_) {
    stop_wanted_ = false;
    stop_until_us_ = 0;
    sink_.event(event_json("error", "not-stopped", "the device has not confirmed the stop",
                           "press the e-stop button, or switch the motors' supply off"));
    return;
  } else if (now < stop_due_us_) {
    return;
  }
  stop_due_us_ = now + kStopRepeat_us;
  device_->send_stop();
}

// --- What pages ask for

void DeviceSession::obey(const PageMessage& message) {
  try {
    std::visit([this](const auto& one) { obey(one); }, message);
  } catch (const Error& error) {
    if (error.code == ExitCode::kLinkLost) throw;
    sink_.event(event_json(error));
  }
}

void DeviceSession::obey(const HandMessage& message) {
  if (hands_ == nullptr) {
    throw Error(ExitCode::kRefused, "not-simulated", "a real arm's hand is not moved from a page",
                "`thimble view --scene` starts a simulated one");
  }
  if (message.arm >= hands_->arms()) {
    throw Error(ExitCode::kUsage, "no-such-arm", "there is no arm " + std::to_string(message.arm),
                "`thimble view --arms 2` starts two");
  }
  hands_->want(message.arm, message.position_m);
}

void DeviceSession::obey(const CommandMessage& message) {
  switch (message.verb) {
    case ViewCommand::kHome:
      if (hands_ != nullptr) return home_simulation();
      try {
        device_->home(kHomingAnswer_us);
      } catch (const Error& error) {
        if (error.name != "not-in-time") throw;  // homing continues in the background
        inform("homing", "the arm looks for its home position", "move it there");
      }
      return;
    case ViewCommand::kArm:
      device_->arm();
      return;
    case ViewCommand::kDisarm:
      device_->disarm();
      return;
    case ViewCommand::kClear:
      device_->clear_faults([this] { return stops_ != stops_before_; });
      return;
    case ViewCommand::kStop:  // post() has taken it
      return;
  }
}

void DeviceSession::obey(const AnswerMessage& /*message*/) {
  throw Error(ExitCode::kUsage, "no-prompt", "nothing was asked here", "`thimble commission --page` asks");
}

void DeviceSession::obey(const ParameterMessage& message) {
  device_->write_param(*message.row, message.value);
  send_hello();
}

}  // namespace thimble::host

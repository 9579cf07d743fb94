#include "firmware/store/persistent_state.h"

#include <algorithm>
#include <utility>

#include "firmware/core/thermal.h"

namespace thimble::firmware {
namespace {

// Whole ones: to make a float of 64 bits takes the compiler's library of software floats on a board.
float seconds(link::Micros us) noexcept {
  return static_cast<float>(static_cast<std::uint32_t>(us / 1'000'000U));
}

constexpr float kWarm_K = 1;
constexpr float kCooled_K = 2;  // worth a record
constexpr float kCoolingInterval_s = 60;

template <class Is>
bool any_motor(const MotorsHeat& heat, Is is) noexcept {
  for (std::size_t i = 0; i < heat.size(); ++i)
    for (std::size_t j = 0; j < kJoints; ++j)
      if (is(heat[i][j], i, j)) return true;
  return false;
}

bool warm(const MotorsHeat& heat) noexcept {
  return any_motor(heat, [](const Heat& motor, std::size_t, std::size_t) {
    return motor.winding_K > kWarm_K || motor.housing_K > kWarm_K;
  });
}

bool cooler(const MotorsHeat& heat, const MotorsHeat& than) noexcept {
  return any_motor(heat, [&than](const Heat& motor, std::size_t i, std::size_t j) {
    return motor.winding_K < than[i][j].winding_K - kCooled_K ||
           motor.housing_K < than[i][j].housing_K - kCooled_K;
  });
}

// new_one: in the store, not left out yet, and never run for long.
bool new_one(std::uint32_t used, std::uint32_t proven) noexcept { return used != 0 && used != proven; }

JournalRecord::InUse blamed(const JournalRecord::InUse& used, const JournalRecord::InUse& proven) noexcept {
  const bool scene = new_one(used.scene, proven.scene);
  const bool params = new_one(used.params, proven.params);
  if (scene || params) return {scene ? used.scene : 0, params ? used.params : 0};
  return {used.scene, used.scene == 0 ? used.params : 0};
}

}  // namespace

JournalRecord::InUse PersistentState::begin(const InStore& in_store, bool crashed) noexcept {
  in_store_ = in_store;
  const std::optional<JournalRecord> before = journal_.open();
  record_ = before.value_or(JournalRecord{});
  JournalRecord::InUse& aside = record_.set_aside;
  if (aside.scene != in_store.crc.scene) aside.scene = 0;
  if (aside.params != in_store.crc.params) aside.params = 0;
  JournalRecord::InUse used = {aside.scene != 0 ? 0 : in_store.crc.scene,
                               aside.params != 0 ? 0 : in_store.crc.params};

  const bool same = used.scene == record_.used.scene && used.params == record_.used.params;
  if (!crashed || (same && !record_.on_trial)) {
    record_.crashes = 0;
  } else {
    record_.crashes = same ? static_cast<std::uint8_t>(record_.crashes + 1) : std::uint8_t{1};
  }
  if (record_.crashes >= kCrashes) {
    const JournalRecord::InUse cause = blamed(used, record_.proven);
    if (cause.scene != 0) aside.scene = std::exchange(used.scene, 0);
    if (cause.params != 0) aside.params = std::exchange(used.params, 0);
    record_.crashes = 0;
  }
  record_.used = used;
  record_.on_trial = true;
  ++record_.starts;
  return aside;
}

void PersistentState::resume_heat(const Params& params, std::uint32_t utc_s) noexcept {
  const Setup& setup = core_.setup();
  before_utc_s_ = heat_start_utc_s_ = record_.utc_s;
  at_start_ = record_.heat;
  if (record_.motors_on) {
    if (before_utc_s_ != 0) before_utc_s_ += kRefresh_s + static_cast<std::uint32_t>(kUnrecorded_s);
    for (std::size_t i = 0; i < setup.arm_count; ++i) {
      for (std::size_t j = 0; j < setup.axes[i]; ++j) {
        if (!setup.arm[i].is_driven(static_cast<int>(j))) continue;
        const kinematics::MotorModel& motor = setup.arm[i].data().axis[j].motor;
        const float limit_C = std::min(params.get(Param::winding_limit), motor.max_winding_C);
        at_start_[i][j] = heated(motor, at_start_[i][j], params.get(Param::ambient), limit_C, kUnrecorded_s);
      }
    }
  }
  if (utc_s >= kEarliest_s) {
    start_utc_s_ = utc_s;
    for (std::size_t i = 0; i < setup.arm_count; ++i)
      for (std::size_t j = 0; j < setup.axes[i]; ++j)
        if (setup.arm[i].is_driven(static_cast<int>(j)))
          at_start_[i][j] =
              cooled(setup.arm[i].data().axis[j].motor, at_start_[i][j], static_cast<float>(off_s()));
    heat_start_utc_s_ = std::max(utc_s, heat_start_utc_s_);
  }
  heat_ = at_start_;
  core_.begin_with(at_start_);
  record_.heat = at_start_;
  record_.utc_s = start_utc_s_ == 0 ? before_utc_s_ : heat_start_utc_s_;
  record_.motors_on = false;
  // Before the scene runs: if it crashes the board at once, this start counts.
  append();
  journal_.prepare();
}

// A clock that went backwards tells nothing.
std::uint32_t PersistentState::off_s() const noexcept {
  const bool known = start_utc_s_ != 0 && before_utc_s_ != 0;
  const std::uint64_t least_s = std::uint64_t{before_utc_s_} + kClockError_s;
  return known && start_utc_s_ > least_s ? static_cast<std::uint32_t>(start_utc_s_ - least_s) : 0;
}

link::Micros PersistentState::uptime_us(link::Micros now) noexcept {
  if (!polled_) {
    polled_ = true;
    started_us_ = taken_us_ = written_us_ = now;
  }
  return now - started_us_;
}

std::uint32_t PersistentState::up_s(link::Micros now) noexcept {
  return static_cast<std::uint32_t>(uptime_us(now) / 1'000'000);
}

std::uint32_t PersistentState::utc_s(link::Micros now) noexcept {
  return start_utc_s_ == 0 ? 0 : start_utc_s_ + up_s(now);
}

// What the heat at start would be less if the time off had been known then, as much of it as is left now: free cooling is linear. That
// the winding would have lost less of its current in a smaller resistance is not taken off.
void PersistentState::tell_time(std::uint32_t utc_s, link::Micros now) noexcept {
  const std::uint32_t whole_s = up_s(now);
  if (utc_s < kEarliest_s || utc_s > kLatest_s || utc_s - kEarliest_s < whole_s) return;
  const std::uint32_t start_s = utc_s - whole_s;
  if (start_utc_s_ != 0) {
    start_utc_s_ = std::max(start_utc_s_, start_s);
    heat_start_utc_s_ =
        std::max(heat_start_utc_s_, start_s);  // the later one gives less cooling after the next start
    return;
  }
  start_utc_s_ = start_s;
  if (const std::uint32_t off = off_s(); off != 0) {
    MotorsHeat less{};
    for (std::size_t i = 0; i < core_.setup().arm_count; ++i) {
      for (std::size_t j = 0; j < core_.setup().axes[i]; ++j) {
        if (!core_.setup().arm[i].is_driven(static_cast<int>(j))) continue;
        const kinematics::MotorModel& motor = core_.setup().arm[i].data().axis[j].motor;
        const Heat& before = at_start_[i][j];
        const Heat after = cooled(motor, before, static_cast<float>(off));
        less[i][j] = cooled(motor, {before.winding_K - after.winding_K, before.housing_K - after.housing_K},
                            seconds(uptime_us(now)));
      }
    }
    core_.heat().less.write(less);
  }
  heat_start_utc_s_ = std::max(start_s, heat_start_utc_s_);
  news_ = true;
}

void PersistentState::note(const InStore& in_store, link::Micros now) noexcept {
  const bool scene = in_store.scene_sequence != in_store_.scene_sequence;
  const bool params = in_store.params_sequence != in_store_.params_sequence;
  if (scene || params) {
    if (scene) record_.used.scene = in_store.crc.scene;
    if (scene) record_.set_aside.scene = 0;
    if (params) record_.used.params = in_store.crc.params;
    if (params) record_.set_aside.params = 0;
    in_store_ = in_store;
    taken_us_ = now;
    record_.crashes = 0;
    record_.on_trial = news_ = true;
  }
  if (record_.on_trial && seconds(now - taken_us_) >= kTrial_s) {
    if (record_.used.scene != 0) record_.proven.scene = record_.used.scene;
    if (record_.used.params != 0) record_.proven.params = record_.used.params;
    record_.crashes = 0;
    record_.on_trial = false;
    news_ = true;
  }
}

bool PersistentState::due(bool motors_on, link::Micros now) const noexcept {
  const float since_s = seconds(now - written_us_);
  if (failed_ && since_s < Journal::kLeastInterval_s) return false;
  if (news_ || failed_ || (motors_on && !record_.motors_on)) return true;
  if (since_s < Journal::kLeastInterval_s) return false;
  if (motors_on) return warm(heat_) || since_s >= static_cast<float>(kRefresh_s);
  if (record_.motors_on) return true;
  return since_s >= kCoolingInterval_s && !keeps_heat_of_start() && cooler(heat_, record_.heat);
}

void PersistentState::append() noexcept {
  failed_ = !journal_.append(record_);
  core_.heat().not_kept.set(failed_);
}

void PersistentState::write(bool motors_on, link::Micros now) noexcept {
  if (keeps_heat_of_start()) {
    record_.heat = at_start_;
    record_.utc_s = before_utc_s_;
  } else {
    record_.heat = heat_;
    record_.utc_s = start_utc_s_ == 0 ? 0 : heat_start_utc_s_ + up_s(now);
  }
  record_.motors_on = motors_on;
  written_us_ = now;
  append();
  news_ = false;
  if (!motors_on) journal_.prepare();
}

void PersistentState::poll(const InStore& in_store, link::Micros now) noexcept {
  static_cast<void>(uptime_us(now));
  note(in_store, now);
  static_cast<void>(core_.heat().now.read(heat_));
  const bool on = motors_on(core_.status().mode());
  motors_were_on_ = motors_were_on_ || on;
  if (due(on, now)) write(on, now);
}

}  // namespace thimble::firmware

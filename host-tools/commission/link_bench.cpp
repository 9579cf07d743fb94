// The device's side of the bench: connection, parameters, scene, recordings, and who the motors obey. link_motions.cpp has the motions.
#include "host-tools/commission/link_bench.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <span>

#include "firmware/core/faults.h"
#include "host-tools/arms/arm_writer.h"
#include "host-tools/client/arm_upload.h"
#include "host-tools/commission/expectation.h"
#include "host-tools/commission/sweeps.h"
#include "host-tools/compiler/compile.h"

namespace thimble::host {
namespace {

using link::Micros;

constexpr Micros kLastFrames_us = 1'000'000;
constexpr Micros kPositions_us = 8'000'000, kAgain_us = 100'000;  // a board looks 6 s for its drives
constexpr Micros kForget_us = 2'000'000;
constexpr double kWatchdog_s = .05;  // link_timeout while the host is silent on purpose; its least
constexpr double kWatchdogLate_s = .02;
constexpr double kSilence_s = .3;
constexpr double kLinkTimeout_s = .5;

std::int64_t widened(std::uint32_t counter, int bits) {
  const auto unused = static_cast<unsigned>(32 - bits);
  return static_cast<std::int32_t>(counter << unused) >> unused;
}

}  // namespace

LinkBench::LinkBench(Open open, Person& person, std::uint8_t number, const ArmFile& arm)
    : open_(std::move(open)), person_(person), arm_(number) {
  try {
    connect();
    use(arm);
  } catch (...) {
    give_back();
    throw;
  }
}

LinkBench::~LinkBench() { give_back(); }

void LinkBench::connect() {
  device_ = std::make_unique<Device>(open_());
  if (arm_ >= device_->info().arms)
    throw Error(
        ExitCode::kUsage, "no-such-arm",
        fmt::format("--number {}: the device has {} arm(s), counted from 0", arm_, device_->info().arms),
        "give the number of an arm that it has");
  device_->take_command();
  if (device_->state().fault != 0) check_fault();
  if (device_->recording_state().phase == link::RecordingPhase::kRunning)
    throw Error(ExitCode::kRefused, "recording-runs", "another program is recording this device",
                "wait until it has ended, or end its recording (`thimble record --force`)");
  device_->set_listener([this](const link::CanFrame& frame) {
    if (stream_) stream_->take(frame);
    link::Pose pose;
    link::Force force;
    const std::uint8_t node = device_->info().node;
    if (link::from_frame(frame, node, pose) && pose.arm == arm_) pose_ = pose;
    if (link::from_frame(frame, node, force) && force.arm == arm_)
      force_N_ = std::hypot(static_cast<double>(force.x_N), static_cast<double>(force.y_N),
                            static_cast<double>(force.z_N));
  });
  measures_current_ = device_->measured_currents().has_value();
  const std::vector<link::AuditRecord> audit = device_->audit();
  session_ =
      fmt::format("{} {}", device_->text(link::kDidSerialNumber), audit.empty() ? 0 : audit.back().start);
  scene_.clear();
  located_ = armed_ = holds_ = counted_ = false;
  set("allow_moves", 1);
  set("host_supervision", 1);
  set("link_timeout", kLinkTimeout_s);
  set("stop_time", 0);             // a brake needs signs that are right
  set("gravity_compensation", 0);  // and so does this
  limit_force();
}

void LinkBench::set(const char* parameter, double value) {
  const firmware::ParamRow& row = *firmware::find_param(parameter);
  const double now = device_->read_param(row);
  before_.try_emplace(parameter, now);
  if (static_cast<float>(now) != static_cast<float>(value)) device_->write_param(row, value);
}

void LinkBench::give_back() noexcept {
  if (!device_) return;
  try {
    let_go();
    for (const auto& [parameter, value] : before_)
      device_->write_param(*firmware::find_param(parameter), value);
    before_.clear();
    device_->set_listener({});
  } catch (const std::exception&) {
    return;  // the device is gone, or will stop by itself; the parameters were not saved
  }
}

void LinkBench::begin_step(int number) {
  constexpr int kFirstStrong = 7, kMarks = 3;
  let_go();
  is_strong_ = number >= kFirstStrong;
  proves_mark_ = number <= kMarks;
  place_.reset();
  limit_force();
}

void LinkBench::limit_force() {
  if (!before_.contains("max_force"))
    before_["max_force"] = device_->read_param(*firmware::find_param("max_force"));
  max_force_N_ = is_strong_ ? before_.at("max_force") : kTipForce_N;
  if (is_strong_) set("allow_uncommissioned", 1);
  set("max_force", max_force_N_);
}

BenchFacts LinkBench::facts() {
  if (tick_s_ <= 0) {
    begin_recording();
    end_recording();
  }
  // Between two runs a narrow counter may have wrapped.
  static const std::string this_run = fmt::format(" {:08x}", std::random_device{}());
  const bool wraps =
      std::ranges::any_of(given_->axes, [](const ArmAxis& axis) { return axis.encoder.counter_bits < 32; });
  return {.tick_s = tick_s_,
          .watchdog_s = kWatchdog_s + kWatchdogLate_s,
          .counts_illegal = false,
          .home_mark = has_mark_ ? HomeMark::kWholeArm : HomeMark::kNone,
          .session = wraps ? session_ + this_run : session_};
}

void LinkBench::use(const ArmFile& arm) {
  const std::vector<std::byte> image = arm_image(arm);
  given_ = std::make_unique<ArmFile>(arm);
  if (device_->arm_images().crc.at(arm_) == link::crc32(image)) return;
  give_back();
  device_->set_listener({});
  Device old = std::move(*device_);
  device_.reset();
  static_cast<void>(replace_arm(open_, std::move(old), arm_, arm.name, image));
  connect();
}

void LinkBench::locate(const PerAxis<double>& at_zero) {
  let_go();
  at_zero_ = at_zero;
  located_ = true;
  place_arm();
}

// The device counts from home. Until the arm is located, it stands there.
void LinkBench::place_arm() {
  begin_recording();
  end_recording();
  link::HomePlace place;
  place.arm = arm_;
  for (std::size_t j = 0; j < axes(); ++j) {
    const ArmAxis& axis = given_->axes[j];
    place.raw.at(j) = raw_.at(j);
    const double from_home =
        (at_zero_.at(j) - axis.home.value) / axis.per_count() + static_cast<double>(counts_.at(j));
    place.counts.at(j) = located_ ? static_cast<std::int32_t>(std::lround(from_home)) : 0;
  }
  device_->home_at(place);
}

void LinkBench::upload_scene(const std::string& text) {
  if (text == scene_) return;
  const CompiledScene scene = compile_scene_text(text, "commissioning", ".");
  static_cast<void>(device_->upload(scene.image, {}, {}));
  scene_ = text;
}

// --- Recordings

void LinkBench::begin_recording() {
  end_recording();
  if (scene_.empty()) upload_scene(kFreeSpace);
  stream_.emplace(device_->info().node, arm_);
  start_recording();
  const auto [start, arms] = device_->recording_start();
  const link::RecordingArm& arm = arms.at(arm_);
  if (arm.joints != axes())
    throw Error(ExitCode::kRefused, "other-arm",
                fmt::format("the device's arm has {} axes, the file's {}", arm.joints, axes()),
                "give the file of the device's arm");
  for (std::size_t j = 0; j < axes(); ++j) {
    const int bits = given_->axes[j].encoder.counter_bits;
    if (counted_) {
      counts_.at(j) += widened(arm.raw.at(j) - raw_.at(j), bits);
    } else {
      counts_.at(j) = widened(arm.raw.at(j), bits);
    }
    raw_.at(j) = arm.raw.at(j);
    from_home_.at(j) = arm.counts.at(j) - counts_.at(j);
  }
  counted_ = true;
  tick_s_ = static_cast<double>(start.period_s);
  has_mark_ = arm.has_index;
  stream_->begin(start, axes(), raw_, counts_);
}

// A drive on CAN may know no position before it has been on for a moment, as an ODrive after each start and each cleared fault.
void LinkBench::start_recording() {
  for (const Micros until_us = now_us() + kPositions_us;; pump(now_us() + kAgain_us)) {
    try {
      device_->start_recording(true);
      return;
    } catch (const Error&) {
      person_.check();
      if (now_us() >= until_us || device_->text(link::kDidRefusal) != "encoder_stale") throw;
    }
  }
}

void LinkBench::end_recording() {
  if (!stream_) return;
  device_->end_recording();
  raw_ = stream_->newest_raw();
  counts_ = stream_->newest();
  stream_.reset();
}

void LinkBench::wait_for_tick(std::uint64_t tick) {
  const Micros until_us = now_us() + kLastFrames_us;
  while (stream_->end() <= tick && !stream_->broken() && now_us() < until_us) pump(now_us() + kRound_us);
  if (stream_->end() > tick) return;
  counts_missing();
}

void LinkBench::counts_missing() {
  throw Error(ExitCode::kLinkLost, "counts-missing",
              "the counts of some ticks did not come: the link or the board has lost them",
              "repeat the step; if that does not help, use a faster link (USB or CAN FD), a board that loses "
              "no ticks (`thimble info`: late), or a lower tick rate");
}

// --- The motors

void LinkBench::pump(Micros until_us) {
  if (now_us() - alive_us_ > kRound_us) {
    alive_us_ = now_us();
    device_->keep_alive();
  }
  while (device_->telemetry(until_us)) {
  }
}

void LinkBench::check_fault() {
  const link::DeviceState state = device_->state();
  if (state.fault == 0) return;
  const firmware::FaultRow* row = firmware::find_fault(static_cast<firmware::Fault>(state.fault));
  armed_ = holds_ = false;
  throw Error(
      ExitCode::kFaulted, "device-faulted",
      fmt::format("the device has the fault {}: {}", row != nullptr ? row->name : "?",
                  row != nullptr ? row->cause : "?"),
      fmt::format("{}; then repeat the step", row != nullptr ? row->remedy : "see `thimble fault list`"));
}

// Until step 3 has seen the mark, home is where the stops tell, or nowhere; the device would take the mark for index_mismatch. So it knows no home
// while hands move the arm: it looks for its mark, and is told to stop that.
void LinkBench::forget_place() {
  if (!proves_mark_ || facts().home_mark != HomeMark::kWholeArm) return;
  if (device_->state().flags.homed) device_->home(kForget_us, [] { return true; });
}

void LinkBench::arm_motors() {
  constexpr Micros kRamp_us = 300'000;  // a motion begins when the force of the scene has ramped up
  if (!located_ || !device_->state().flags.homed) {
    end_recording();
    place_arm();
    begin_recording();
  }
  device_->keep_alive();
  device_->arm();
  armed_ = true;
  for (const Micros until_us = now_us() + kRamp_us; now_us() < until_us;) pump(now_us() + kRound_us);
  await_drives();
}

// Drives on CAN are switched on only now, and tell a current from when they give a torque. A motion that they miss would look like a dead encoder.
void LinkBench::await_drives() {
  constexpr Micros kPatience_us = 5'500'000;  // a board waits 3 s for idle drives, and 2 s until they are on
  if (!measures_current_) return;
  const auto gives_torque = [this] {
    const std::optional<link::MeasuredCurrents> now = device_->measured_currents();
    if (!now) return false;
    return std::ranges::any_of(std::span(now->current_A).subspan(arm_ * link::kMaxJoints, link::kMaxJoints),
                               [](float current_A) { return std::isfinite(current_A); });
  };
  const Micros until_us = now_us() + kPatience_us;
  while (!gives_torque()) {
    if (device_->state().mode != link::Mode::kArmed) return check_fault();
    if (now_us() > until_us) {
      measures_current_ = told_current_;  // nothing of this arm does, if it never has
      return;
    }
    person_.check();
    pump(now_us() + kRound_us);
  }
  told_current_ = true;
}

void LinkBench::let_go() {
  if (armed_) {
    armed_ = holds_ = false;
    device_->disarm();
  }
  law_ = {};
  end_recording();
}

PerAxis<AxisReading> LinkBench::read() {
  if (stream_) {
    pump(now_us());
  } else {
    begin_recording();
    end_recording();
  }
  const PerAxis<std::int64_t>& counts = stream_ ? stream_->newest() : counts_;
  PerAxis<AxisReading> readings{};
  for (std::size_t j = 0; j < axes(); ++j)
    readings.at(j) = {.counts = counts.at(j),
                      .illegal = 0,
                      .current_A = kNotMeasured,
                      .voltage_V = kNotMeasured,
                      .temperature_C = kNotMeasured};
  return readings;
}

Answer LinkBench::ask(const Prompt& prompt) {
  if (prompt.kind != Prompt::Kind::kLetGo && prompt.kind != Prompt::Kind::kHang) {
    let_go();
    if (prompt.kind == Prompt::Kind::kPlace) {
      place_ = prompt.place;
      held_.fill(true);
      if (prompt.axis < axes()) held_.at(prompt.axis) = false;
    }
    forget_place();
    return person_.ask(prompt);
  }
  // The board holds the arm before the hands let it go.
  if (!holds_) {
    begin_recording();
    ServoProgram hold = servo_to(Expectation(*given_), believed(), believed());
    hold.stay_s = .1;
    static_cast<void>(servo(hold));
  }
  held_.fill(false);
  return person_.ask(prompt, [&] {
    pump(now_us());
    return true;
  });
}

LineTrial LinkBench::try_line(Line line, const Prompt& prompt) {
  let_go();
  begin_recording();
  if (line == Line::kWatchdog) set("link_timeout", kWatchdog_s);
  arm_motors();
  const std::uint64_t armed_tick = stream_->end();
  std::uint64_t silent_tick = armed_tick;
  const auto off = [&]() -> const CountStream::Event* {
    for (const CountStream::Event& event : stream_->events())
      if (event.tick >= armed_tick && event.mode != link::Mode::kArmed) return &event;
    return nullptr;
  };
  if (line == Line::kWatchdog) {
    pump(now_us() + 2 * kRound_us);
    silent_tick = stream_->end();
    const Micros until_us = now_us() + static_cast<Micros>(kSilence_s * 1e6);
    while (now_us() < until_us) static_cast<void>(device_->telemetry(until_us));
  } else {
    static_cast<void>(person_.ask(prompt, [&] {
      pump(now_us());
      return off() == nullptr;
    }));
    pump(now_us() + kRound_us);
  }
  LineTrial trial;
  if (const CountStream::Event* fell = off()) {
    trial.fell = true;
    std::uint64_t since = silent_tick;
    if (line != Line::kWatchdog) {
      since = fell->tick;
      for (const CountStream::Event& event : stream_->events()) {
        const bool open = line == Line::kEStop ? event.levels.e_stop : !event.levels.dead_man;
        if (event.tick >= armed_tick && open) since = std::min(since, event.tick);
      }
      // Something else stopped it.
      trial.fell = line == Line::kEStop ? fell->levels.e_stop : !fell->levels.dead_man;
    }
    trial.seconds = static_cast<double>(fell->tick - since) * tick_s_;
  }
  let_go();
  if (line == Line::kEStop)
    static_cast<void>(person_.ask(Prompt{.kind = Prompt::Kind::kRest, .text = "Release the e-stop."}));
  if (device_->state().fault != 0) device_->clear_faults();
  if (line == Line::kWatchdog) set("link_timeout", kLinkTimeout_s);
  return trial;
}

}  // namespace thimble::host

// scan: the arm probes a surface point by point, and a scene is made from the result.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>

#include "board/sim/sim_probe.h"
#include "board/sim/specimen_file.h"
#include "firmware/core/faults.h"
#include "host-tools/cli/arm_watch.h"
#include "host-tools/cli/interrupt.h"
#include "host-tools/cli/open_remote.h"
#include "host-tools/cli/output.h"
#include "host-tools/cli/progress.h"
#include "host-tools/cli/verbs.h"
#include "host-tools/client/device.h"
#include "host-tools/client/discovery.h"
#include "host-tools/compiler/compile.h"
#include "host-tools/files/output_file.h"
#include "host-tools/lab/arm_choice.h"
#include "host-tools/lab/scan.h"
#include "host-tools/lab/scan_scene.h"

namespace thimble::host {
namespace {

using link::Micros;

// The arm stops by itself 0.5 s after the last request, so the timeout for an answer is short.
constexpr Micros kAnswer_us = 100'000;
constexpr Micros kPoll_us = 10'000;
constexpr Micros kRamp_us = 300'000;  // the force's ramp after arming
constexpr Micros kLongestMove_us = 600'000'000;

// A scene in which the tip touches nothing: a scan measures the real specimen.
CompiledScene free_space() {
  return compile_scene_text(R"({"thimble_scene": 1, "name": "free space", "objects": [{"name": "far below",
    "shape": {"plane": {"normal": [0, 0, 1], "offset_m": -9}}, "material": {"stiffness_N_m": 1}}]})",
                            "free space", {});
}

const firmware::ParamRow& allow_moves_row() { return *firmware::find_param(std::string_view("allow_moves")); }

// Arms the device; afterwards disarms it and restores its parameters. Killed between two moves it is disarmed, too.
class DeviceProbe final : public Probe {
 public:
  // The device is chosen.
  DeviceProbe(const Remote& remote, bool allow)
      : watch_([&remote] { disarm(open_transport(remote.device), options_of(remote)); }),
        device_(open(remote)) {
    const link::DeviceState now = device_.state();
    const bool allowed = device_.read_param(allow_moves_row()) != 0;
    if (!allow && !allowed) {
      throw Error(ExitCode::kRefused, "moves-not-allowed", "a scan moves the arm, and moves are not allowed",
                  "keep hands off the arm and its e-stop in reach, then give --allow-moves");
    }
    if (now.mode == link::Mode::kDisarmed) {
      throw Error(ExitCode::kRefused, "not-homed", "the arm is not homed", "home it (`thimble home`)");
    }
    if (!allowed) {
      if (now.mode == link::Mode::kArmed) device_.disarm();
      device_.write_param(allow_moves_row(), 1);
      restore_ = true;
    }
    if (now.scene_bytes == 0) device_.upload(free_space().image, {}, {});
    watch_.armed(true);
    device_.arm();
    wait(kRamp_us);
  }
  DeviceProbe(const DeviceProbe&) = delete;
  DeviceProbe& operator=(const DeviceProbe&) = delete;
  ~DeviceProbe() override {
    try {
      device_.disarm();
      watch_.armed(false);
      if (restore_) device_.write_param(allow_moves_row(), 0);
    } catch (const std::exception&) {
      // The link is lost: the arm has stopped by itself.
    }
  }

  Result move(const link::MoveOrder& order) override {
    device_.start_move(order);
    const Micros until_us = now_us() + kLongestMove_us;
    Result result;
    while (true) {
      result.state = device_.move_state();
      const link::MovePhase phase = result.state.phase;
      if (phase == link::MovePhase::kNone || phase == link::MovePhase::kHolding) break;
      if (now_us() > until_us) {
        device_.end_move();
        throw Error(ExitCode::kRefused, "not-in-time", "the arm did not reach its target in time",
                    "let the motors cool, then go on with --resume");
      }
      wait(kPoll_us);
    }
    if (const std::uint8_t number = device_.state().fault; number != 0) {
      const firmware::FaultRow* row = firmware::find_fault(static_cast<firmware::Fault>(number));
      throw Error(
          ExitCode::kFaulted, "device-faulted",
          row == nullptr ? "fault " + std::to_string(number) : std::string(row->name) + ": " + row->cause,
          "see `thimble fault list`; clear it, home or arm, then go on with --resume");
    }
    if (result.state.samples != 0) result.samples = device_.move_samples();
    return result;
  }

 private:
  static Device open(const Remote& remote) {
    DeviceOptions options = options_of(remote);
    options.answer_us = kAnswer_us;
    options.tries = std::max(1U, static_cast<unsigned>(remote.timeout_s * 1e6 / kAnswer_us));
    return Device(open_transport(remote.device), options);
  }
  void wait(Micros us) {
    const Micros until_us = now_us() + us;
    while (now_us() < until_us) static_cast<void>(device_.telemetry(until_us));
  }

  ArmWatch watch_;  // before the device is opened
  Device device_;
  bool restore_ = false;
};

class SimulatedProbe final : public Probe {
 public:
  explicit SimulatedProbe(const ScanChoice& choice) {
    try {
      board::SimBoardOptions options;
      options.arm = other_arm(choice.arm);
      if (!options.arm) options.variant = choice.arm;
      options.seed = choice.seed;
      options.specimen = std::make_shared<const board::Specimen>(board::read_specimen(choice.specimen));
      probe_ = std::make_unique<board::SimProbe>(options, free_space().image);
    } catch (const board::SpecimenError& error) {
      throw Error(ExitCode::kBadInput, "bad-specimen", error.what(), "correct the specimen file");
    } catch (const std::invalid_argument& error) {
      throw Error(ExitCode::kUsage, "unknown-arm", error.what(), "`thimble scan --help` names the arms");
    } catch (const board::ProbeError& error) {
      throw Error(ExitCode::kRefused, "refused", error.what(), "see docs/scan.md");
    }
  }
  Result move(const link::MoveOrder& order) override {
    try {
      board::SimProbe::Result result = probe_->move(order);
      return {result.state, std::move(result.samples)};
    } catch (const board::ProbeError& error) {
      throw Error(ExitCode::kRefused, "refused", error.what(),
                  "keep the scan inside the arm's workspace and its limits (docs/scan.md)");
    }
  }

 private:
  std::unique_ptr<board::SimProbe> probe_;
};

// pad.scene.json: pad.heights.csv beside it.
std::filesystem::path heights_of(const std::filesystem::path& scene) {
  std::string name = scene.filename().string();
  for (const std::string_view ending : {".json", ".scene"})
    if (name.ends_with(ending)) name.resize(name.size() - ending.size());
  return scene.parent_path() / (name + ".heights.csv");
}

void write(const std::filesystem::path& file, const std::string& text) {
  OutputFile output(file);
  output.stream() << text;
  output.commit();
}

Json result_json(const ScanChoice& choice, const ScanPlan& plan, const ScanResult& result) {
  Json json = document("scan");
  json["name"] = plan.name;
  json["log"] = choice.log.string();
  json["output"] = choice.output.string();
  if (!result.flat) json["heights"] = heights_of(choice.output).string();
  json["columns"] = plan.columns;
  json["rows"] = plan.rows;
  json["min_stiffness_N_m"] = result.least_stiffness_N_m;
  json["max_stiffness_N_m"] = result.most_stiffness_N_m;
  json["worst_residual_N"] = result.residual_N;
  json["worst_hysteresis_N"] = result.hysteresis_N;
  json["off_plane_rms_m"] = result.off_plane_rms_m;
  json["off_plane_most_m"] = result.off_plane_most_m;
  json["flat"] = result.flat;
  if (result.checks != 0) {
    json["shape_check"] = {
        {"places", result.checks}, {"rms_m", result.check_rms_m}, {"most_m", result.check_most_m}};
  }
  json["depth_m"] = result.depth_m;
  if (result.layers) {
    json["layers"] = {{"upper_stiffness_N_m", result.upper_N_m},
                      {"lower_stiffness_N_m", result.lower_N_m},
                      {"boundary_m", result.layers->boundary_m},
                      {"scene_off_N", result.off_N}};
  }
  if (const auto& damping = result.damping) {
    json["damping"] = {{"damping_N_s_m", damping->damping_N_s_m},
                       {"uncertainty_N_s_m", damping->uncertainty_N_s_m},
                       {"residual_N", damping->residual_N},
                       {"presses", damping->presses}};
  }
  if (const auto& friction = result.friction) {
    const auto part = [](const CoefficientFit& fit) {
      return Json{{"coefficient", fit.coefficient},
                  {"spread", fit.spread},
                  {"residual_N", fit.residual_N},
                  {"strokes", fit.strokes}};
    };
    json["static_friction"] = part(friction->breakaway);
    json["dynamic_friction"] = part(friction->sliding);
  }
  json["points"] = Json::array();
  for (std::size_t i = 0; i < result.points.size(); ++i) {
    const ScannedPoint& point = result.points[i];
    Json entry = {{"column", plan.column_of(i)},          {"row", plan.row_of(i)},
                  {"stiffness_N_m", point.stiffness_N_m}, {"height_m", result.height_m(plan, i)},
                  {"residual_N", point.fit.residual_N},   {"hysteresis_N", point.fit.hysteresis_N},
                  {"samples", point.fit.samples}};
    if (point.fit.layer) {
      entry["upper_stiffness_N_m"] = point.fit.stiffness_N_m;
      entry["lower_stiffness_N_m"] = point.fit.layer->below_N_m;
      entry["boundary_m"] = point.fit.layer->boundary_m;
    }
    json["points"].push_back(entry);
  }
  return json;
}

void report(const Common& common, const ScanChoice& choice, const ScanPlan& plan, const ScanResult& result) {
  if (common.json) {
    print(result_json(choice, plan, result));
    return;
  }
  say("{}: {} x {} points, {:.0f} to {:.0f} N/m, residual at most {:.3f} N -> {}\n", plan.name, plan.columns,
      plan.rows, result.least_stiffness_N_m, result.most_stiffness_N_m, result.residual_N,
      choice.output.string());
  say("shape: {}, off its plane {:.3f} mm RMS, {:.3f} mm at most\n",
      result.flat ? "a plane" : "a height field in " + heights_of(choice.output).string(),
      1e3 * result.off_plane_rms_m, 1e3 * result.off_plane_most_m);
  if (result.checks != 0) {
    say("shape between the points: off {} other contacts {:.3f} mm RMS, {:.3f} mm at most\n", result.checks,
        1e3 * result.check_rms_m, 1e3 * result.check_most_m);
  }
  if (const auto& damping = result.damping) {
    say("damping: {:.2f} N s/m, uncertain by {:.2f}, residual {:.3f} N over {} presses\n",
        damping->damping_N_s_m, damping->uncertainty_N_s_m, damping->residual_N, damping->presses);
  }
  const auto coefficient = [](const char* what, const CoefficientFit& fit) {
    say("{} friction: {:.3f}, from site to site {:.3f}, residual {:.3f} N over {} strokes\n", what,
        fit.coefficient, fit.spread, fit.residual_N, fit.strokes);
  };
  if (const auto& friction = result.friction) {
    coefficient("static", friction->breakaway);
    coefficient("dynamic", friction->sliding);
  } else if (plan.measure_friction) {
    say(stderr,
        "warning: the friction was not measured: no stroke slid. Give a longer stroke_m; a "
        "coefficient above 1.7 "
        "cannot be measured\n");
  }
  if (result.layers) {
    say(stderr,
        "warning: the specimen is layered: {:.0f} N/m down to {:.2f} mm, {:.0f} N/m below. A surface "
        "of a scene has one "
        "stiffness: that of the scene is nearest to the forces down to {:.2f} mm, and off them by at "
        "most {:.2f} N\n",
        result.upper_N_m, 1e3 * result.layers->boundary_m, result.lower_N_m, 1e3 * result.depth_m,
        result.off_N);
  }
}

}  // namespace

void scan(const Common& common, const Remote& remote, const ScanChoice& choice) {
  if (choice.simulate && choice.specimen.empty()) {
    throw Error(ExitCode::kUsage, "usage", "--simulate needs a --specimen",
                "give what the simulated arm touches");
  }
  for (const auto& input : {choice.plan, choice.specimen}) {
    keep_apart(input, choice.log);
    keep_apart(input, choice.output);
  }
  keep_outputs_apart(choice.log, choice.output);
  const ScanPlan plan = read_scan_plan(choice.plan);
  ScanLog log(choice.log, plan, choice.resume);
  heed_interrupts();

  Remote chosen = remote;
  std::unique_ptr<Probe> probe;  // only when there is something to probe
  const auto probe_of = [&]() -> Probe& {
    if (!probe && choice.simulate) probe = std::make_unique<SimulatedProbe>(choice);
    if (!probe) {
      chosen.device = choose_device(remote.device);
      probe = std::make_unique<DeviceProbe>(chosen, choice.allow_moves);
    }
    return *probe;
  };
  const auto steps = static_cast<double>(plan.steps());
  const std::size_t before = log.steps().empty() ? 0 : log.steps().back().step + 1;
  Progress progress(common.json, static_cast<double>(before) / steps, true);
  const bool whole = probe_steps(plan, log, probe_of, [&](std::size_t done) {
    progress.show(static_cast<double>(done) / steps, fmt::format("step {} of {}", done, plan.steps()));
    return interrupted == 0;
  });
  probe.reset();
  progress.end();
  if (!whole) {
    throw Error(ExitCode::kRefused, "interrupted",
                fmt::format("the scan was interrupted after {} steps; they are in {}", log.steps().size(),
                            choice.log.string()),
                "go on with --resume");
  }
  const ScanResult result = result_of(plan, log);
  if (!result.flat) write(heights_of(choice.output), heights_text(plan, result));
  write(choice.output, scene_text(plan, result, heights_of(choice.output).filename().string()));
  report(common, choice, plan, result);
}

}  // namespace thimble::host

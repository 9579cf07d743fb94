// record, replay and plot.
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <functional>
#include <optional>
#include <vector>

#include "firmware/core/faults.h"
#include "firmware/link/services.h"
#include "host-tools/cli/arm_watch.h"
#include "host-tools/cli/interrupt.h"
#include "host-tools/cli/open_remote.h"
#include "host-tools/cli/output.h"
#include "host-tools/cli/progress.h"
#include "host-tools/cli/verbs.h"
#include "host-tools/client/discovery.h"
#include "host-tools/files/output_file.h"
#include "host-tools/lab/event_table.h"
#include "host-tools/lab/plot.h"
#include "host-tools/lab/record_run.h"
#include "host-tools/lab/recording_json.h"
#include "host-tools/lab/replay_recording.h"
#include "host-tools/lab/run_log.h"

namespace thimble::host {
namespace {

std::string in_words(const ReplayVerdict& verdict) {
  std::string text = fmt::format("{} ticks replayed, peak {:.3f} N, {} in contact; ", verdict.ticks,
                                 verdict.peak_force_N, verdict.contact_ticks);
  if (verdict.differs_at) {
    text +=
        fmt::format("the forces differ between tick {} and tick {}", verdict.exact_to, *verdict.differs_at);
  } else {
    text += fmt::format("{} checks: every force up to tick {} is the device's, to the bit", verdict.checks,
                        verdict.exact_to);
  }
  if (verdict.gap_at)
    text += fmt::format("; tick {} or its check is missing, {} ticks behind it are not replayed",
                        *verdict.gap_at, verdict.not_replayed);
  return text;
}

std::string marks_in_words(const Recording& recording) {
  const auto trials = std::ranges::count(recording.marks, link::MarkKind::kTrial, &RecordedMark::what);
  if (recording.marks.empty()) return "";
  return fmt::format("; {} events, {} switches of the trial", std::ranges::ssize(recording.marks) - trials,
                     trials);
}

void warn_of_missing_events(const Recording& recording) {
  if (recording.end && recording.end->marks_missing != 0)
    say(stderr, "warning: {} events or switches of the trial are missing: their frames were lost\n",
        recording.end->marks_missing);
}

std::string end_in_words(const Recording& recording) {
  if (!recording.end) return "cut off";
  const RecordingEnd& end = *recording.end;
  const firmware::FaultRow* fault = firmware::find_fault(static_cast<firmware::Fault>(end.fault));
  return end.reason + (end.fault != 0 && fault != nullptr ? std::string(" ") + fault->name : "");
}

// replay_recording(), which shows how far it is.
ReplayVerdict replay_with_progress(const Recording& recording, bool quiet,
                                   const std::function<void(const board::LogRow&)>& row = {}) {
  double counts = 0;
  for (const RecordedTicks& run : recording.ticks) counts += static_cast<double>(run.counts.size());
  const double rows = std::max(counts / kRecordedCounts, 1.0);  // of all arms
  double done = 0;
  Progress progress(quiet);
  return replay_recording(recording, [&](const board::LogRow& now) {
    progress.show(++done / rows, "replaying");
    if (row) row(now);
  });
}

// The rows to plot: those of the replay for a recording, those of the file for a log.
std::vector<board::LogRow> rows_of(const std::filesystem::path& file, int arm, bool quiet) {
  std::vector<board::LogRow> rows;
  if (is_recording(file)) {
    const ReplayVerdict verdict =
        replay_with_progress(read_recording(file), quiet, [&](const board::LogRow& row) {
          if (row.arm == arm) rows.push_back(row);
        });
    if (!verdict.exact()) say(stderr, "warning: {}\n", in_words(verdict));
  } else {
    rows = read_run_log(file);
    std::erase_if(rows, [arm](const board::LogRow& row) { return row.arm != arm; });
  }
  return rows;
}

[[noreturn]] void differs(const std::filesystem::path& file, const ReplayVerdict& verdict) {
  throw Error(ExitCode::kVerification, "replay-differs",
              fmt::format("{}: {}", file.string(), in_words(verdict)),
              "replay it with the thimble that recorded it; if that is this one, report it with the file");
}

}  // namespace

void record(const Common& common, const Remote& remote, const RecordChoice& choice) {
  keep_apart(choice.scene, choice.output);
  RecordOptions options;
  options.output = choice.output;
  options.scene = choice.scene;
  options.seconds = choice.seconds;
  options.home = choice.home;
  options.arm = choice.arm;
  options.take_over = choice.force;
  options.tool = THIMBLE_VERSION;
  std::error_code none;
  if (std::filesystem::exists(choice.output, none) && !choice.force) {
    throw Error(ExitCode::kRefused, "recording-exists", choice.output.string() + " exists already",
                "give another file, or --force");
  }
  heed_interrupts();
  Remote chosen = remote;
  chosen.device = choose_device(remote.device);
  std::optional<ArmWatch> watch;
  if (choice.arm) {
    watch.emplace([&] { disarm(open_transport(chosen.device), options_of(chosen)); });
    options.armed = [&watch](bool yes) { watch->armed(yes); };
  }
  Device device = open_remote(chosen);
  Progress progress(common.json);
  std::optional<link::Micros> begun_us;
  const auto stopping = [&] {
    if (begun_us) {
      const double now_s = static_cast<double>(now_us() - *begun_us) * 1e-6;
      if (choice.seconds > 0)
        progress.show(now_s / choice.seconds, "recorded");
      else
        progress.show(fmt::format("recorded {:.0f} s", now_s));
    }
    return interrupted != 0;
  };
  const RecordReport report = record(device, options, stopping, [&] {
    begun_us = now_us();
    say(stderr, "recording{}: Ctrl-C ends it\n", choice.arm ? ", armed" : "; now arm (`thimble arm`)");
  });
  progress.end();
  heed_interrupts_no_more();
  const Recording recording = read_recording(choice.output);
  const ReplayVerdict verdict = replay_with_progress(recording, common.json);
  if (common.json) {
    Json json = document("record");
    json["file"] = choice.output.string();
    json.update(about_json(recording));
    json["ticks"] = report.ticks;
    json["marks"] = recording.marks.size();
    json["telemetry_every_ticks"] = report.telemetry_ticks;
    json["recording_frames_per_s"] = report.frames_per_s;
    json["replay"] = verdict_json(verdict);
    print(json);
  } else {
    say("{}: {} ticks at {} Hz, {} missing; other telemetry every {} ticks; "
        "ended: {}{}\n",
        choice.output.string(), report.ticks, report.counts_Hz, report.end.missing, report.telemetry_ticks,
        end_in_words(recording), marks_in_words(recording));
    say("{}\n", in_words(verdict));
  }
  if (report.end.missing != 0) {
    say(stderr,
        "warning: {} ticks are missing ({} of them the device could not send): the link does not "
        "carry {} frames a second; "
        "replay is exact up to tick {}\n",
        report.end.missing, report.end.dropped, report.frames_per_s, verdict.exact_to);
  }
  warn_of_missing_events(recording);
  if (verdict.differs_at) differs(choice.output, verdict);
}

void replay(const Common& common, const ReplayChoice& choice) {
  keep_apart(choice.file, choice.log);
  keep_apart(choice.file, choice.events);
  keep_outputs_apart(choice.log, choice.events);
  const Recording recording = read_recording(choice.file);
  ReplayVerdict verdict;
  if (choice.log.empty()) {
    verdict = replay_with_progress(recording, common.json);
  } else {
    OutputFile log(choice.log);
    const SceneColumns columns(recording.header.scene);
    write_log_header(log.stream(), columns);
    verdict = replay_with_progress(
        recording, common.json, [&](const board::LogRow& row) { write_log_row(log.stream(), row, columns); });
    log.commit();
  }
  if (!choice.events.empty()) {
    OutputFile events(choice.events);
    write_events_csv(events.stream(), recording);
    events.commit();
  }
  if (verdict.differs_at) differs(choice.file, verdict);
  if (!recording.end)
    say(stderr, "warning: {} was cut off: it has no end, and {} bytes of a message that is not whole\n",
        choice.file.string(), recording.cut_bytes);
  warn_of_missing_events(recording);
  if (common.json) {
    Json json = document("replay");
    json["file"] = choice.file.string();
    json.update(about_json(recording));
    json.update(verdict_json(verdict));
    json["events"] = events_json(recording);
    print(json);
    return;
  }
  say("{}: scene '{}', {} {} on board {}, {:.0f} Hz; ended: {}{}\n", choice.file.string(),
      recording.header.scene_name, fmt::format("{}", fmt::join(recording.header.models, ",")),
      recording.header.firmware, recording.header.board,
      1.0 / static_cast<double>(recording.header.start.period_s), end_in_words(recording),
      marks_in_words(recording));
  say("{}\n", in_words(verdict));
}

void plot(const Common& common, const PlotChoice& choice) {
  keep_apart(choice.file, choice.output);
  PlotChoices wanted;
  const bool all = choice.kind == "all";
  wanted.time = all || choice.kind == "time";
  wanted.depth = all || choice.kind == "depth";
  wanted.spectrum = all || choice.kind == "spectrum";
  wanted.title = choice.file.filename().string() + (choice.tip == 0 ? "" : ", arm 1");
  const std::vector<board::LogRow> rows = rows_of(choice.file, static_cast<int>(choice.tip), common.json);
  const PlotResult result = plot(rows, wanted, choice.output);
  if (common.json) {
    Json json = document("plot");
    json["output"] = choice.output.string();
    json["rows"] = rows.size();
    json["rate_Hz"] = result.rate_Hz;
    json["seconds"] = result.seconds;
    json["peak_force_N"] = result.peak_force_N;
    json["deepest_m"] = result.deepest_m;
    if (wanted.spectrum)
      json["spectrum_peak"] = {{"frequency_Hz", result.peak_Hz}, {"amplitude_N", result.peak_amplitude_N}};
    print(json);
    return;
  }
  say("{} rows, {:.2f} s at {:.0f} Hz, peak {:.3f} N -> {}\n", rows.size(), result.seconds, result.rate_Hz,
      result.peak_force_N, choice.output.string());
}

}  // namespace thimble::host

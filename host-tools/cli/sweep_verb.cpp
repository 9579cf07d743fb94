// sweep: many simulations of one plan.
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <optional>
#include <thread>

#include "host-tools/cli/compile_progress.h"
#include "host-tools/cli/interrupt.h"
#include "host-tools/cli/output.h"
#include "host-tools/cli/progress.h"
#include "host-tools/cli/slurm.h"
#include "host-tools/cli/verbs.h"
#include "host-tools/files/output_file.h"
#include "host-tools/sweep/sweep.h"
#include "host-tools/sweep/sweep_table.h"

namespace thimble::host {
namespace {

constexpr std::size_t kMostParts = 100'000;
constexpr link::Micros kLook_us = 1'000'000;  // between two looks at what the tasks have written

// "2/8", from 1.
SweepPart part_of(const std::string& text) {
  if (text.empty()) return {};
  SweepPart part;
  const char* const end = text.data() + text.size();
  const auto first = std::from_chars(text.data(), end, part.part);
  const bool has_slash = first.ec == std::errc() && first.ptr != end && *first.ptr == '/';
  const auto second = has_slash ? std::from_chars(first.ptr + 1, end, part.parts)
                                : std::from_chars_result{end, std::errc::invalid_argument};
  if (second.ec != std::errc() || second.ptr != end || part.part < 1 || part.part > part.parts ||
      part.parts > kMostParts)
    throw Error(ExitCode::kUsage, "bad-part", "--array is '" + text + "', allowed is I/N with I from 1 to N",
                "give the number of this part and of all: --array 2/8");
  --part.part;
  return part;
}

std::size_t jobs_of(const SweepChoice& choice) {
  if (choice.jobs > 0) return choice.jobs;
  if (choice.slurm > 0) return 1;
  return std::max(1U, std::thread::hardware_concurrency());  // those that this process may use
}

// In the name of its file; "" without --array.
std::string name_of(const SweepChoice& choice, const SweepPart& part) {
  return choice.array.empty() ? "" : fmt::format("{}-of-{}", part.part + 1, part.parts);
}

void list_runs(const Common& common, const SweepRuns& runs) {
  if (common.json) {
    Json json = document("sweep");
    json["runs"] = runs.count();
    json["axes"] = Json::array();
    for (const SweepAxis& axis : runs.plan().axes) {
      json["axes"].push_back({{"what", axis.what}, {"values", Json::array()}});
      for (const SweepValue& value : axis.values) json["axes"].back()["values"].push_back(value.text);
    }
    print(json);
    return;
  }
  say("{}: {} runs\n", runs.plan().name, runs.count());
  for (const SweepAxis& axis : runs.plan().axes)
    say("  {}: {} values, {} to {}\n", axis.what, axis.values.size(), axis.values.front().text,
        axis.values.back().text);
}

[[noreturn]] void interrupt_with(const SweepResults& results) {
  throw Error(
      ExitCode::kRefused, "interrupted",
      fmt::format("the sweep was interrupted; {} of {} runs are kept", results.done(), results.runs()),
      "give the same command again: it goes on from there");
}

void submit(const Common& common, const SweepChoice& choice, SweepResults& results) {
  Progress progress(common.json, 0, true);
  const auto of = static_cast<double>(results.runs());
  link::Micros looked_us = now_us(), pause_us = kLook_us;
  run_in_slurm({choice.plan, choice.output, choice.slurm, jobs_of(choice)}, [&] {
    if (const link::Micros begin_us = now_us(); begin_us - looked_us > pause_us) {
      results.read_again();
      looked_us = now_us();
      pause_us = std::max(kLook_us, 20 * (looked_us - begin_us));  // millions of rows take a while
    }
    progress.show(static_cast<double>(results.done()) / of,
                  fmt::format("run {} of {}", results.done(), results.runs()));
    return interrupted == 0;
  });
  results.read_again();
  progress.end();
  if (interrupted != 0) interrupt_with(results);
  if (!results.is_whole())
    throw Error(
        ExitCode::kRefused, "slurm-incomplete",
        fmt::format("the job array has ended, and {} of {} runs are missing; {}.slurm.1 and the files "
                    "of the other tasks may say why",
                    results.runs() - results.done(), results.runs(), choice.output.string()),
        "correct it and give the same command again: only what is missing is run");
  for (std::size_t task = 1; task <= choice.slurm; ++task) {
    std::error_code none;
    std::filesystem::remove(fmt::format("{}.slurm.{}", choice.output.string(), task), none);
  }
}

SweepTimes run_here(const Common& common, const SweepChoice& choice, const SweepRuns& runs,
                    SweepResults& results, const SweepPart& part) {
  const auto of = static_cast<double>(results.runs());
  Progress progress(common.json, static_cast<double>(results.done()) / of, true);
  const SweepTimes times = run_sweep(runs, results, part, jobs_of(choice), [&](const SweepProgress& now) {
    progress.show(static_cast<double>(now.done) / of, fmt::format("run {} of {}", now.done, now.of),
                  now.left_s);
    return interrupted == 0;
  });
  progress.end();
  if (!times.whole) interrupt_with(results);
  return times;
}

// part: "2-of-8", or "" of a whole sweep.
void report(const Common& common, const SweepChoice& choice, const std::string& part,
            const SweepResults& results, const SweepTimes& times, std::size_t failed) {
  const std::size_t jobs = jobs_of(choice);
  const double ideal_s = times.ideal_s(jobs);
  if (common.json) {
    Json json = document("sweep");
    json["output"] = choice.output.string();
    json["runs"] = results.runs();
    json["done"] = results.done();
    json["run_now"] = times.runs;
    json["failed"] = failed;
    json["jobs"] = jobs;
    json["seconds"] = times.wall_s;
    json["ideal_s"] = ideal_s;
    print(json);
    return;
  }
  if (times.runs > 0)
    say(stderr, "{} runs in {:.2f} s with {} job{}; ideal {:.2f} s, {:.0f} % more\n", times.runs,
        times.wall_s, jobs, jobs == 1 ? "" : "s", ideal_s, 100 * (times.wall_s / ideal_s - 1));
  const std::string own = fmt::format("{}.runs.{}", choice.output.string(), part);
  const bool is_own =
      !part.empty() && std::filesystem::exists(own);  // not of a part that was collected before
  if (is_own)
    say(stderr, "part {} -> {}; {} of {} runs are done\n", part, own, results.done(), results.runs());
  else
    say(stderr, "{} of {} runs -> {}\n", results.done(), results.runs(), choice.output.string());
}

void write_table(OutputFile& table, const SweepChoice& choice, const SweepRuns& runs,
                 const SweepResults& results) {
  table.stream() << table_page(runs.plan(), runs.head(), results,
                               fmt::format("thimble sweep {} --output {} --table {}", choice.plan.string(),
                                           choice.output.string(), choice.table.string()));
  table.commit();
}

}  // namespace

void sweep(const Common& common, const SweepChoice& choice) {
  const SweepPart part = part_of(choice.array);
  help_compiler(true);  // from now on several threads compile
  std::optional<Busy> busy(std::in_place, common.json, "checking the plan");
  const SweepRuns runs(read_sweep_plan(choice.plan));
  busy.reset();
  if (choice.dry_run) {
    list_runs(common, runs);
    return;
  }
  if (choice.output.empty())
    throw Error(ExitCode::kUsage, "usage", "--output is missing", "say where the results go");
  if (!choice.table.empty() && !runs.plan().table)
    throw Error(ExitCode::kUsage, "no-table", "the plan has no \"table\"",
                "say in the plan which of the values are its rows and columns");
  for (const std::filesystem::path& output : {choice.output, choice.table}) {
    keep_apart(choice.plan, output);
    keep_apart(runs.plan().files, output);
  }
  keep_outputs_apart(choice.output, choice.table);
  SweepResults results(choice.output, runs.head(), runs.columns(), runs.count());
  std::optional<OutputFile> table;  // before the runs: it may be no place to write to
  if (!choice.table.empty()) table.emplace(choice.table);
  heed_interrupts();
  SweepTimes times{.whole = true};
  if (choice.slurm > 0 && !results.is_whole()) {
    submit(common, choice, results);
  } else if (!missing_runs(results, part).empty()) {
    results.open(name_of(choice, part));
    times = run_here(common, choice, runs, results, part);
  }
  heed_interrupts_no_more();
  std::size_t failed = 0;
  if (choice.array.empty()) {
    results.finish();
    failed = results.failed();
    if (table) write_table(*table, choice, runs, results);
  }
  report(common, choice, name_of(choice, part), results, times, failed);
  if (failed > 0 && !common.json)
    say(stderr, "warning: {} runs ended early: the column status says how\n", failed);
}

}  // namespace thimble::host

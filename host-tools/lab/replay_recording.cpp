#include "host-tools/lab/replay_recording.h"

#include <algorithm>
#include <stdexcept>
#include <vector>

#include "board/sim/replay.h"
#include "firmware/link/services.h"
#include "host-tools/error.h"

namespace thimble::host {
namespace {

constexpr std::uint64_t kCheckTicks = 16;  // no two checks are farther from each other, unless one was lost

std::unique_ptr<board::Replay> open_replay(const Recording& recording) {
  const RecordingHeader& header = recording.header;
  try {
    return std::make_unique<board::Replay>(board::RecordedRun{
        header.start, header.arms, header.models, header.parameters, header.scene, recording.first_trial()});
  } catch (const std::invalid_argument& error) {
    throw Error(ExitCode::kBadInput, "cannot-replay",
                std::string("the recording cannot be replayed: ") + error.what(),
                "replay it with the thimble that recorded it (" + header.tool + ")");
  }
}

}  // namespace

ReplayVerdict replay_recording(const Recording& recording,
                               const std::function<void(const board::LogRow&)>& row) {
  const auto replay = open_replay(recording);
  const std::size_t arms = recording.header.start.arms;
  const std::size_t each = kRecordedCounts * arms;
  ReplayVerdict verdict;
  verdict.first_tick = std::uint64_t{recording.header.start.tick} + 1;
  verdict.exact_to = recording.header.start.tick;
  std::uint64_t next = verdict.first_tick;
  std::uint64_t last_check = recording.header.start.tick;
  link::Levels levels = recording.header.start.levels;
  auto check = recording.checks.begin();
  auto mark = recording.marks.begin();
  const auto missing = [&](std::uint64_t tick) {
    if (!verdict.gap_at) verdict.gap_at = tick;
  };
  for (const RecordedTicks& run : recording.ticks) {
    const std::size_t count = run.counts.size() / each;
    if (run.first != next) missing(next);
    for (std::size_t i = 0; i < count && !verdict.gap_at; ++i, ++next) {
      if (check != recording.checks.end() && check->tick > last_check + kCheckTicks &&
          next > last_check + kCheckTicks) {
        missing(last_check + 1);
        break;
      }
      board::Replay::Tick tick;
      tick.counts = std::span(run.counts).subspan(i * each, each);
      for (auto now = check; now != recording.checks.end() && now->tick == next; ++now) {
        levels = now->levels;
        if (now->command != link::RecordedCommand::kNone) tick.command = now->command;
      }
      tick.levels = levels;
      for (; mark != recording.marks.end() && mark->tick <= next; ++mark)
        if (mark->tick == next && mark->what == link::MarkKind::kTrial) tick.trial = mark->value;
      replay->tick(tick);
      ++verdict.ticks;
      bool contact = false;
      for (std::size_t arm = 0; arm < arms; ++arm) {
        const board::LogRow shown = replay->row(arm);
        verdict.peak_force_N = std::max(verdict.peak_force_N, shown.force_N.norm());
        contact = contact || shown.contacts != 0;
        if (row) row(shown);
      }
      if (contact) ++verdict.contact_ticks;
      for (; check != recording.checks.end() && check->tick <= next; ++check) {
        if (check->tick != next) continue;
        last_check = next;
        const bool agrees = check->crc == replay->check().crc && check->mode == replay->check().mode;
        if (!agrees && !verdict.differs_at) verdict.differs_at = next;
        if (agrees && !verdict.differs_at) {
          ++verdict.checks;
          verdict.exact_to = next;
        }
      }
    }
  }
  verdict.not_replayed = recording.tick_count() - verdict.ticks;
  return verdict;
}

}  // namespace thimble::host

#include "host-tools/lab/scan_log.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <optional>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>

#include "board/files/csv.h"
#include "host-tools/error.h"
#include "host-tools/files/input_file.h"

namespace thimble::host {
namespace {

constexpr std::string_view kColumns = "point,phase,x_m,y_m,z_m,force_N\n";
constexpr std::string_view kForceLimit = "force_limit";
// The phases of a press, and of a stroke.
struct Names {
  std::string_view out, back, target;
};
constexpr Names kPress{"press", "release", "depth"}, kStroke{"out", "back", "target"};

constexpr double kPlacesPer_m = 1e7, kStepsPer_N = 1e5;  // written to seven and five places

std::string header(std::uint32_t plan_crc) {
  std::array<char, 64> line{};
  const int size = std::snprintf(line.data(), line.size(), "# thimble scan of plan %08x\n", plan_crc);
  return std::string(line.data(), static_cast<std::size_t>(size)) + std::string(kColumns);
}

bool is_stroke(bool site, std::size_t move) { return site && move >= kSitePresses; }
std::size_t moves_of(bool site) { return site ? kSiteMoves : 1; }

struct Row {
  std::size_t step = 0;
  std::string_view phase;
  std::array<double, 4> numbers{};
};

// False: not a row.
bool parse(const board::CsvReader& csv, Row& row) {
  if (csv.cells().size() != 2 + row.numbers.size()) return false;
  const std::string_view step = csv.cells()[0];
  const auto [end, error] = std::from_chars(step.data(), step.data() + step.size(), row.step);
  if (error != std::errc() || end != step.data() + step.size()) return false;
  row.phase = csv.cells()[1];
  for (std::size_t i = 0; i < row.numbers.size(); ++i) {
    const std::optional<double> number = csv.number(2 + i);
    if (!number) return false;
    row.numbers.at(i) = *number;
  }
  return true;
}

}  // namespace

ScanLog::ScanLog(std::filesystem::path file, const ScanPlan& plan, bool resume)
    : file_(std::move(file)), sites_from_(2 * plan.points()) {
  if (std::filesystem::exists(file_)) {
    if (!resume) {
      throw Error(ExitCode::kRefused, "log-exists", file_.string() + " exists already",
                  "continue it (--resume), or give another file");
    }
    read(read_input(file_), plan);
  }
  out_.open(file_, whole_bytes_, header(plan.crc));
}

void ScanLog::read(const std::string& text, const ScanPlan& plan) {
  const std::string head = header(plan.crc);
  if (head.starts_with(text)) return;  // interrupted in the header
  if (!text.starts_with(head)) {
    throw Error(ExitCode::kBadInput, "wrong-log", file_.string() + ":1: it is not the log of this plan",
                "give the plan that it was begun with, or another file for this one");
  }
  whole_bytes_ = head.size();
  ProbedStep step;
  ProbedMove move;
  bool begun = false;  // the step has a row
  board::CsvReader csv(text, file_.string(), '#');
  static_cast<void>(csv.next());  // the header
  while (csv.next()) {
    if (!csv.whole()) return;  // interrupted in a line
    Row row;
    const std::size_t due = steps_.empty() ? 0 : steps_.back().step + 1;
    const bool a_row = parse(csv, row);
    const Names& names = is_stroke(row.step >= sites_from_, step.moves.size()) ? kStroke : kPress;
    const bool sample = row.phase == names.out || row.phase == names.back;
    // Every point is pressed along the approach; of the presses along the normal some are left out.
    const bool in_order =
        begun ? row.step == step.step : row.step == due || (due >= plan.points() && row.step > due);
    if (!a_row || !in_order || row.step >= plan.steps() ||
        (!sample && row.phase != kForceLimit && row.phase != names.target)) {
      throw Error(ExitCode::kBadInput, "bad-log",
                  csv.place() + ": it is not a row of point " + std::to_string(begun ? step.step : due) +
                      ", which is due here",
                  "remove the rows from there on");
    }
    begun = true;
    step.step = row.step;
    const Eigen::Vector3d tip_m(row.numbers[0], row.numbers[1], row.numbers[2]);
    if (sample) {
      move.samples.push_back({row.phase == names.out, tip_m, row.numbers[3]});
      continue;
    }
    move.force_limit = row.phase == kForceLimit;
    move.turn_m = tip_m;
    move.peak_force_N = row.numbers[3];
    step.moves.push_back(std::exchange(move, {}));
    if (step.moves.size() < moves_of(row.step >= sites_from_)) continue;
    steps_.push_back(std::exchange(step, {}));
    begun = false;
    whole_bytes_ = csv.offset();
  }
}

const ProbedStep* ScanLog::find(std::size_t step) const {
  const auto found = std::ranges::lower_bound(steps_, step, {}, &ProbedStep::step);
  return found != steps_.end() && found->step == step ? &*found : nullptr;
}

void ScanLog::append(const ProbedStep& measured) {
  // Keeps the rounded values of the file, so that a scene made from the file is the same.
  ProbedStep step = measured;
  const auto round_m = [](Eigen::Vector3d& v) { v = (v * kPlacesPer_m).array().round() / kPlacesPer_m; };
  const auto round_N = [](double& force) { force = std::round(force * kStepsPer_N) / kStepsPer_N; };
  const auto row = [&](std::string_view phase, const Eigen::Vector3d& tip_m, double force_N) {
    std::array<char, 160> line{};
    const int size =
        std::snprintf(line.data(), line.size(), "%zu,%.*s,%.7f,%.7f,%.7f,%.5f\n", step.step,
                      static_cast<int>(phase.size()), phase.data(), tip_m.x(), tip_m.y(), tip_m.z(), force_N);
    out_.stream().write(line.data(), size);
  };
  for (std::size_t i = 0; i < step.moves.size(); ++i) {
    ProbedMove& move = step.moves[i];
    const Names& names = is_stroke(step.step >= sites_from_, i) ? kStroke : kPress;
    for (PointSample& sample : move.samples) {
      round_m(sample.tip_m);
      round_N(sample.force_N);
      row(sample.out ? names.out : names.back, sample.tip_m, sample.force_N);
    }
    round_m(move.turn_m);
    round_N(move.peak_force_N);
    row(move.force_limit ? kForceLimit : names.target, move.turn_m, move.peak_force_N);
  }
  out_.flush();
  steps_.push_back(std::move(step));
}

}  // namespace thimble::host

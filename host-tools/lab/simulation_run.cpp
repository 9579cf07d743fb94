#include "host-tools/lab/simulation_run.h"

#include <algorithm>
#include <utility>

#include "board/sim/hand_path_file.h"
#include "host-tools/error.h"

namespace thimble::host {
namespace {

[[noreturn]] void fail(const board::SimulationResult& result) {
  using board::SimulationStatus;
  switch (result.status) {
    case SimulationStatus::kUnknownArm:
      throw Error(ExitCode::kUsage, "unknown-arm", result.detail, "`thimble simulate --help` names the arms");
    case SimulationStatus::kBadRate:
      throw Error(ExitCode::kUsage, "bad-rate", result.detail, "choose --rate between 100 and 20000");
    case SimulationStatus::kBadPath:
      throw Error(ExitCode::kBadInput, "bad-path", result.detail, "correct the path file");
    case SimulationStatus::kOutOfReach:
      throw Error(ExitCode::kBadInput, "out-of-reach", result.detail,
                  "keep the path inside the arm's workspace, or use --ideal");
    case SimulationStatus::kImageRefused:
      throw Error(ExitCode::kBadInput, "bad-image", result.detail, "compile the scene again");
    case SimulationStatus::kFaulted:
      throw Error(ExitCode::kFaulted, "device-faulted", result.detail,
                  "the log ends where it tripped; see `thimble fault explain`");
    case SimulationStatus::kNotArmed:
    case SimulationStatus::kOk:
      break;
  }
  throw Error(ExitCode::kRefused, "not-armed", result.detail, "see what stands against arming in the cause");
}

std::vector<board::PathPoint> read_path(const std::filesystem::path& file) {
  try {
    return board::read_hand_path(file);
  } catch (const board::HandPathError& error) {
    throw Error(ExitCode::kBadInput, "bad-path", error.what(),
                "correct the path file: time_s,x_m,y_m,z_m[,arm]");
  }
}

}  // namespace

SimulationRun::SimulationRun(ImageFile scene, std::vector<board::PathPoint> path)
    : scene_(std::move(scene)), path_(std::move(path)) {
  if (path_.empty()) return;  // which go() refuses
  const auto [first, last] = std::ranges::minmax(path_, {}, &board::PathPoint::time_s);
  start_s_ = first.time_s;
  end_s_ = last.time_s;
}

SimulationRun::SimulationRun(ImageFile scene, const std::filesystem::path& path)
    : SimulationRun(std::move(scene), read_path(path)) {}

board::SimulationResult SimulationRun::go(const board::SimulationOptions& options,
                                          const std::function<void(const board::LogRow&)>& row) const {
  board::SimulationResult result = board::simulate(scene_.image, path_, options, row);
  if (result.status != board::SimulationStatus::kOk && result.status != board::SimulationStatus::kFaulted)
    fail(result);
  return result;
}

void throw_if_failed(const board::SimulationResult& result) {
  if (result.status != board::SimulationStatus::kOk) fail(result);
}

void throw_if_faulted(const board::SimulationResult& result) {
  if (result.status == board::SimulationStatus::kFaulted) fail(result);
}

}  // namespace thimble::host

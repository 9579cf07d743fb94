#include "host-tools/lab/scan_log.h"

#include <array>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <optional>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>

#include "board/files/csv.h"
#include "host-tools/error.h"

namespace thimble::host {
namespace {

constexpr std::string_view kColumns = "point,phase,x_m,y_m,z_m,force_N\n";
constexpr std::string_view kPress = "press", kRelease = "release", kForceLimit = "force_limit",
                           kDepth = "depth";

constexpr double kPlacesPer_m = 1e7, kStepsPer_N = 1e5;  // written to seven and five places

std::string header(std::uint32_t plan_crc) {
  std::array<char, 64> line{};
  const int size = std::snprintf(line.data(), line.size(), "# thimble scan of plan %08x\n", plan_crc);
  return std::string(line.data(), static_cast<std::size_t>(size)) + std::string(kColumns);
}

struct Row {
  std::size_t point = 0;
  std::string_view phase;
  std::array<double, 4> numbers{};
};

// False: not a row.
bool parse(const board::CsvReader& csv, Row& row) {
  if (csv.cells().size() != 2 + row.numbers.size()) return false;
  const std::string_view point = csv.cells()[0];
  const auto [end, error] = std::from_chars(point.data(), point.data() + point.size(), row.point);
  if (error != std::errc() || end != point.data() + point.size()) return false;
  row.phase = csv.cells()[1];
  for (std::size_t i = 0; i < row.numbers.size(); ++i) {
    const std::optional<double> number = csv.number(2 + i);
    if (!number) return false;
    row.numbers.at(i) = *number;
  }
  return row.phase == kPress || row.phase == kRelease || row.phase == kForceLimit || row.phase == kDepth;
}

[[noreturn]] void cannot(const std::filesystem::path& file, const char* verb, int error) {
  throw Error(
      error == EACCES || error == EPERM || error == EROFS ? ExitCode::kPermission : ExitCode::kRefused,
      "cannot-write", std::string("cannot ") + verb + " " + file.string() + ": " + std::strerror(error),
      "choose a place that you may write to, with space left");
}

}  // namespace

ScanLog::ScanLog(std::filesystem::path file, std::uint32_t plan_crc, std::size_t points, bool resume)
    : file_(std::move(file)) {
  if (std::filesystem::exists(file_)) {
    if (!resume) {
      throw Error(ExitCode::kRefused, "log-exists", file_.string() + " exists already",
                  "continue it (--resume), or give another file");
    }
    std::ifstream in(file_, std::ios::binary);
    std::ostringstream text;
    text << in.rdbuf();
    read(text.str(), plan_crc, points);
    std::error_code failed;
    std::filesystem::resize_file(file_, whole_bytes_, failed);
    if (failed) cannot(file_, "shorten", failed.value());
  }
  errno = 0;
  out_.open(file_, std::ios::binary | std::ios::app);
  if (whole_bytes_ == 0) out_ << header(plan_crc);
  out_.flush();
  if (!out_) cannot(file_, "write", errno);
}

void ScanLog::read(const std::string& text, std::uint32_t plan_crc, std::size_t points) {
  const std::string head = header(plan_crc);
  if (head.starts_with(text)) return;  // interrupted in the header
  if (!text.starts_with(head)) {
    throw Error(ExitCode::kBadInput, "wrong-log", file_.string() + ":1: it is not the log of this plan",
                "give the plan that it was begun with, or another file for this one");
  }
  whole_bytes_ = head.size();
  ProbedPoint point;
  board::CsvReader csv(text, file_.string(), '#');
  static_cast<void>(csv.next());  // the header
  while (csv.next()) {
    if (!csv.whole()) return;  // interrupted in a line
    Row row;
    if (!parse(csv, row) || row.point != points_.size() || row.point >= points) {
      throw Error(ExitCode::kBadInput, "bad-log",
                  csv.place() + ": it is not a row of point " + std::to_string(points_.size()) +
                      ", which is due here",
                  "remove the rows from there on");
    }
    const Eigen::Vector3d tip_m(row.numbers[0], row.numbers[1], row.numbers[2]);
    if (row.phase == kPress || row.phase == kRelease) {
      point.samples.push_back({row.phase == kPress, tip_m, row.numbers[3]});
      continue;
    }
    point.point = row.point;
    point.force_limit = row.phase == kForceLimit;
    point.turn_m = tip_m;
    point.peak_force_N = row.numbers[3];
    points_.push_back(std::exchange(point, {}));
    whole_bytes_ = csv.offset();
  }
}

void ScanLog::append(const ProbedPoint& measured) {
  // Keeps the rounded values of the file, so that a scene made from the file is the same.
  ProbedPoint point = measured;
  const auto round_m = [](Eigen::Vector3d& v) { v = (v * kPlacesPer_m).array().round() / kPlacesPer_m; };
  const auto round_N = [](double& force) { force = std::round(force * kStepsPer_N) / kStepsPer_N; };
  for (PointSample& sample : point.samples) {
    round_m(sample.tip_m);
    round_N(sample.force_N);
  }
  round_m(point.turn_m);
  round_N(point.peak_force_N);
  const auto row = [&](std::string_view phase, const Eigen::Vector3d& tip_m, double force_N) {
    std::array<char, 160> line{};
    const int size =
        std::snprintf(line.data(), line.size(), "%zu,%.*s,%.7f,%.7f,%.7f,%.5f\n", point.point,
                      static_cast<int>(phase.size()), phase.data(), tip_m.x(), tip_m.y(), tip_m.z(), force_N);
    out_.write(line.data(), size);
  };
  for (const PointSample& sample : point.samples)
    row(sample.pressing ? kPress : kRelease, sample.tip_m, sample.force_N);
  errno = 0;
  row(point.force_limit ? kForceLimit : kDepth, point.turn_m, point.peak_force_N);
  out_.flush();
  if (!out_) cannot(file_, "write", errno);
  points_.push_back(std::move(point));
}

}  // namespace thimble::host

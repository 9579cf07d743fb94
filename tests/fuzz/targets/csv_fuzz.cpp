// Every file of rows: the path of a hand, heights, tissues, the log of a scan and that of a run. The first byte says which.
#include <algorithm>
#include <cmath>

#include "board/sim/hand_path_file.h"
#include "host-tools/compiler/height_grid.h"
#include "host-tools/error.h"
#include "host-tools/lab/run_log.h"
#include "host-tools/lab/scan_log.h"
#include "host-tools/lab/tissue_table.h"
#include "tests/fuzz/targets/target.h"

namespace {

using namespace thimble;

void read_path(const std::filesystem::path& file) {
  try {
    for (const int arm : {0, 1}) {
      std::vector<board::PathPoint> points = board::read_hand_path(file);
      std::erase_if(points, [arm](const board::PathPoint& point) { return point.arm != arm; });
      if (points.empty()) continue;
      const board::HandPath path(points);
      for (const double part : {-1.0, 0.0, 0.3, 1.0, 2.0}) {
        const auto sample = path.at(path.start_s() + part * (path.end_s() - path.start_s()));
        fuzz::demand(sample.position_m.allFinite() && sample.velocity_m_s.allFinite(), "a hand is somewhere");
      }
    }
  } catch (const board::HandPathError&) {
  }
}

void read_heights(const std::filesystem::path& file) {
  const host::HeightGrid grid = host::read_height_grid(file, 4096, "heights.csv");
  fuzz::demand(grid.values.size() == grid.columns * grid.rows, "the grid is as large as it says");
  fuzz::demand(std::ranges::all_of(grid.values, [](double value) { return std::isfinite(value); }),
               "a height is finite");
}

void read_tissues(const std::filesystem::path& file) {
  for (const host::TissueKind& kind : host::read_tissue_table(file))
    fuzz::demand(kind.from < kind.to && kind.stiffness_N_m >= 0 && kind.tear_N >= 0, "a tissue is possible");
}

// What is read is read again from the shortened file: no step is lost, and none comes back.
void read_scan_log(const std::filesystem::path& file) {
  host::ScanPlan plan;
  plan.columns = plan.rows = 2;
  plan.cell_m = 0.01;
  std::size_t steps = 0;
  for (const bool again : {false, true}) {
    const host::ScanLog log(file, plan, true);
    fuzz::demand(!again || log.steps().size() == steps, "a log that was cut to whole steps keeps them");
    steps = log.steps().size();
    for (const host::ProbedStep& step : log.steps())
      fuzz::demand(step.step < plan.steps() && !step.moves.empty(), "a step is one of the plan");
  }
}

void read_run(const std::filesystem::path& file) {
  for (const board::LogRow& row : host::read_run_log(file))
    fuzz::demand(
        std::isfinite(row.time_s) && row.force_N.allFinite() && row.contacts >= 0 && row.contacts <= 3,
        "a row is finite");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  constexpr void (*kReaders[])(const std::filesystem::path&) = {read_path, read_heights, read_tissues,
                                                                read_scan_log, read_run};
  static const fuzz::MemoryFile kFile;
  if (size == 0) return 0;
  try {
    kReaders[data[0] % std::size(kReaders)](kFile.with(fuzz::text_of({data + 1, size - 1})));
  } catch (const host::Error& error) {
    fuzz::demand(error.code == host::ExitCode::kBadInput, "a bad file is bad input");
  }
  return 0;
}

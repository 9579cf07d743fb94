// `thimble simulate` in a page: a scene image and the path of a hand in, the log out. The same bytes as on a PC.
#include <algorithm>
#include <cstring>
#include <span>
#include <sstream>
#include <vector>

#include "board/sim/simulation.h"
#include "host-tools/in_page/exports.h"
#include "host-tools/lab/run_log.h"

// In: a scene image of `image_bytes`, then rows of time_s, x_m, y_m, z_m, arm as doubles. Out: the log, CSV; or a sentence that says why not.
THIMBLE_EXPORT(int, simulate)(std::size_t image_bytes, int ideal, double rate_Hz) {
  using namespace thimble;
  struct Row {
    double time_s, x_m, y_m, z_m, arm;
  };
  const std::string in = host::page_buffer;
  const std::span image = std::as_bytes(std::span(in)).first(std::min(image_bytes, in.size()));
  std::vector<Row> rows((in.size() - image.size()) / sizeof(Row));
  std::memcpy(rows.data(), in.data() + image.size(), rows.size() * sizeof(Row));
  std::vector<board::PathPoint> path;
  for (const Row& row : rows)
    path.push_back({row.time_s, board::Vector3d(row.x_m, row.y_m, row.z_m), static_cast<int>(row.arm)});
  board::SimulationOptions options;
  options.ideal = ideal != 0;
  options.rate_Hz = rate_Hz;
  std::ostringstream log;
  const host::SceneColumns columns(image);
  host::write_log_header(log, columns);
  const board::SimulationResult result = board::simulate(
      image, path, options, [&](const board::LogRow& row) { host::write_log_row(log, row, columns); });
  return host::give(result.status == board::SimulationStatus::kOk ? log.str() : result.detail);
}

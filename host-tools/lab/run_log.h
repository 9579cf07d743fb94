// The log of a run: one row a tick and arm, CSV. What `thimble simulate` and `thimble replay` write, and `thimble plot` reads.
#pragma once

#include <filesystem>
#include <ostream>
#include <string_view>
#include <vector>

#include "board/sim/simulation.h"
#include "host-tools/lab/scene_columns.h"

namespace thimble::host {

inline constexpr std::string_view kLogHeader =
    "time_s,arm,tip_x_m,tip_y_m,tip_z_m,proxy_x_m,proxy_y_m,proxy_z_m,force_x_N,force_y_N,force_z_N,contacts";

// The fixed columns, then those of the scene.
void write_log_header(std::ostream& out, const SceneColumns& scene);
void write_log_row(std::ostream& out, const board::LogRow& row, const SceneColumns& scene);

// The fixed columns; others are passed over.
// Error kBadInput `bad-log` with file and line, `cannot-read`; kPermission.
[[nodiscard]] std::vector<board::LogRow> read_run_log(const std::filesystem::path& file);

}  // namespace thimble::host

// The log of a run: one row a tick and arm, CSV. What `thimble simulate` and `thimble replay` write, and `thimble plot` reads.
#pragma once

#include <filesystem>
#include <ostream>
#include <vector>

#include "board/sim/simulation.h"
#include "host-tools/lab/scene_columns.h"

namespace thimble::host {

// The fixed columns, then those of the scene.
void write_log_header(std::ostream& out, const SceneColumns& scene);
void write_log_row(std::ostream& out, const board::LogRow& row, const SceneColumns& scene);

// The fixed columns; others are passed over.
// Error kBadInput `bad-log` with file and line, `cannot-read`; kPermission.
[[nodiscard]] std::vector<board::LogRow> read_run_log(const std::filesystem::path& file);

}  // namespace thimble::host

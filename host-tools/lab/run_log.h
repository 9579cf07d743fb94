// The log of a run: one row a tick and arm, CSV. What `thimble simulate` and `thimble replay` write, and `thimble plot` reads.
#pragma once

#include <filesystem>
#include <ostream>
#include <vector>

#include "board/sim/simulation.h"

namespace thimble::host {

void write_log_header(std::ostream& out);
void write_log_row(std::ostream& out, const board::LogRow& row);

// Error kBadInput `bad-log` with file and line, `cannot-read`; kPermission.
[[nodiscard]] std::vector<board::LogRow> read_run_log(const std::filesystem::path& file);

}  // namespace thimble::host

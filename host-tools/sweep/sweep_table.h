// The table that a plan asks for, as a page of Markdown.
#pragma once

#include <string>

#include "host-tools/sweep/sweep_results.h"
#include "host-tools/sweep/sweep_runs.h"

namespace thimble::host {

// made_by: the command, for the page's second paragraph. The results are whole, and the plan has a table.
[[nodiscard]] std::string table_page(const SweepPlan& plan, const std::string& head,
                                     const SweepResults& results, const std::string& made_by);

}  // namespace thimble::host

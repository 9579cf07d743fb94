// Sweep plans. In a plan that is read every run has its values, and the head of the results names their columns.
#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "host-tools/error.h"
#include "host-tools/sweep/sweep_runs.h"
#include "tests/fuzz/targets/target.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace thimble;
  std::unique_ptr<host::SweepRuns> read;
  try {
    read = std::make_unique<host::SweepRuns>(host::read_sweep_plan_text(
        std::string(fuzz::text_of({data, size})), std::filesystem::path(THIMBLE_FUZZ_FILES) / "sweep.json"));
  } catch (const host::Error& error) {
    fuzz::demand(error.code == host::ExitCode::kBadInput || error.code == host::ExitCode::kPermission,
                 "a bad plan is bad input");
    fuzz::demand(!error.cause.empty() && !error.remedy.empty(), "an error has a cause and a remedy");
    return 0;
  }
  const host::SweepPlan& plan = read->plan();
  fuzz::demand(read->count() >= 1 && read->count() <= host::SweepPlan::kMostRuns,
               "there are so many runs as may be");
  for (const std::size_t run : {std::size_t{0}, read->count() / 2, read->count() - 1}) {
    const std::vector<std::size_t> place = plan.place(run);
    for (std::size_t i = 0; i < place.size(); ++i)
      fuzz::demand(place[i] < plan.axes[i].values.size(), "a run has a value of each axis");
    fuzz::demand(read->cost(run) > 0, "a run takes time");
  }
  const std::string head = read->head();
  fuzz::demand(std::ranges::count(head, '\n') == 2, "the head has two lines");
  fuzz::demand(read->columns() >= plan.axes.size() + 4, "each axis has a column");
  for (const host::SweepAxis& axis : plan.axes)
    for (const host::SweepValue& value : axis.values)
      fuzz::demand(value.text.find_first_of(",\n\"") == std::string::npos, "a value is one cell");
  return 0;
}

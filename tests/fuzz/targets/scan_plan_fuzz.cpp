// Scan plans. In a plan that is read, every point and site has a finite place on its grid.
#include "host-tools/error.h"
#include "host-tools/lab/scan_plan.h"
#include "tests/fuzz/targets/target.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace thimble;
  host::ScanPlan plan;
  try {
    plan = host::read_scan_plan_text(std::string(fuzz::text_of({data, size})), "plan");
  } catch (const host::Error& error) {
    fuzz::demand(error.code == host::ExitCode::kBadInput, "a bad plan is bad input");
    return 0;
  }
  fuzz::demand(plan.points() >= 4 && plan.points() <= 1U << 20U, "the plan has so many points as may be");
  for (const std::size_t point : {std::size_t{0}, plan.points() / 2, plan.points() - 1}) {
    fuzz::demand(plan.column_of(point) < plan.columns && plan.row_of(point) < plan.rows,
                 "a point is on the grid");
    fuzz::demand(plan.place_m(plan.column_of(point), plan.row_of(point)).allFinite(), "its place is finite");
  }
  for (const Eigen::Vector2d& site : plan.sites())
    fuzz::demand((site.array() >= 0).all() && site.x() <= static_cast<double>(plan.columns - 1) &&
                     site.y() <= static_cast<double>(plan.rows - 1),
                 "a site is on the grid");
  fuzz::demand(plan.approach.dot(plan.normal()) < 0, "the approach is into the surface");
  return 0;
}

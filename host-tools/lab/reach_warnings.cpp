#include "host-tools/lab/reach_warnings.h"

#include <fmt/format.h>

#include "host-tools/arms/arm_reach.h"
#include "host-tools/compiler/object_regions.h"

namespace thimble::host {

std::vector<std::string> reach_warnings(std::span<const std::byte> image, const ArmChoice& arm,
                                        double tip_radius_m) {
  std::vector<std::string> warnings;
  const ArmReach reach(arm.data);
  for (const ObjectRegion& region : object_regions(image)) {
    const double away_m = reach.nearest_m([&region](const auto& p) { return region.nearest(p); });
    if (away_m <= tip_radius_m + ArmReach::kReachTolerance_m) continue;
    warnings.push_back(fmt::format("{}: out of reach; the tip of {} comes no nearer than {:.2g} mm",
                                   region.name, arm.name, 1e3 * (away_m - tip_radius_m)));
  }
  return warnings;
}

}  // namespace thimble::host

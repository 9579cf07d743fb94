// The cost of a scene in JSON, for compile and upload.
#pragma once

#include "host-tools/cli/output.h"
#include "host-tools/lab/cost_report.h"

namespace thimble::host {

[[nodiscard]] inline Json to_json(const CostReport& report) {
  const board::SceneCost& cost = report.cost;
  Json json = {{"board", report.board},
               {"rate_Hz", report.rate_Hz},
               {"typical_units", cost.typical.units},
               {"worst_units", cost.worst.units},
               {"work_units", cost.work_units},
               {"put_off", cost.put_off}};
  if (cost.period > 0) {
    json["typical_instructions"] = std::lround(cost.typical.instructions);
    json["worst_instructions"] = std::lround(cost.worst.instructions);
    json["period_instructions"] = std::lround(cost.period);
  }
  json["fits"] = cost.fits();
  if (!cost.fits()) json["fits_Hz"] = report.fits_Hz;
  return json;
}

}  // namespace thimble::host

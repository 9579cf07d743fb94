// A step that is not there yet.
#include "host-tools/commission/steps.h"

namespace thimble::host {

StepResult find_walls(StepContext& /*context*/) {
  StepResult result;
  result.notes.emplace_back("This step is not written yet.");
  return result;
}

}  // namespace thimble::host

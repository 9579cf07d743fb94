// Logs of a HAPI DeviceLog, in either frame. Times rise, and the frames differ by a rotation.
#include <cmath>

#include "host-tools/error.h"
#include "host-tools/lab/device_log.h"
#include "tests/fuzz/targets/target.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace thimble;
  const std::span<const char> bytes(reinterpret_cast<const char*>(data), size);
  try {
    const host::DeviceLog own = host::parse_device_log(bytes, "log", true);
    const host::DeviceLog log = host::parse_device_log(bytes, "log", false);
    fuzz::demand(!log.samples.empty() && log.samples.size() == own.samples.size(),
                 "both have as many samples");
    double last_s = -1e308;
    for (std::size_t i = 0; i < log.samples.size(); ++i) {
      const host::DeviceLogSample& sample = log.samples[i];
      fuzz::demand(std::isfinite(sample.time_s) && sample.time_s > last_s, "times are finite and rise");
      last_s = sample.time_s;
      fuzz::demand(sample.position_m.allFinite() && sample.force_N.allFinite(), "a sample is finite");
      fuzz::demand(sample.position_m.z() == own.samples[i].position_m.y(), "y of the log is up");
    }
  } catch (const host::Error& error) {
    fuzz::demand(error.code == host::ExitCode::kBadInput, "a bad log is bad input");
  }
  return 0;
}

// Everything that watches the tick and changes nothing in it. publish() of firmware/core/ calls each one once a tick; the background
// reads what they keep. A new observer is a file here, a member below, and a call in publish().
#pragma once

#include "firmware/observe/freeze.h"
#include "firmware/observe/late_ticks.h"
#include "firmware/observe/picture.h"
#include "firmware/observe/recorder.h"
#include "firmware/observe/telemetry_records.h"

namespace thimble::firmware {

struct Observers {
  explicit Observers(const Request<Command>& commands) noexcept : freeze(commands), recorder(commands) {}

  TelemetryRecords records;
  PictureExchange picture;
  FreezeFrame freeze;
  Recorder recorder;
  LateTicks late_ticks;
};

}  // namespace thimble::firmware

// The observers: they read the results of a tick and do not influence them. The steps sense() and publish() of firmware/core/ call each
// one once a tick; the background reads what they keep. A new observer is a file here, a member below, and a call in one of the two.
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

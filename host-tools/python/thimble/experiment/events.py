"""Events with the tick of the controller that they belong to."""

from __future__ import annotations

import math
import time
from typing import Any


class Ticks:
    """Tells the tick of this moment.

    Telemetry frames have no tick numbers. So the controller is asked for its state, which has the tick of its newest telemetry record. That is up to
    `telemetry_decimation` ticks old, and question and answer take some ticks, too: hence the bounds, which mark() gives with the tick. A
    lower telemetry_decimation makes them narrower.
    """

    def __init__(self, device: Any):
        self._device = device

    def mark(self) -> dict[str, int | float]:
        """{"tick", "within_ticks", "host_s"} of now: the tick of an event at the time of the call is at most within_ticks from `tick`. host_s is this
        machine's monotonic clock, as in time.monotonic()."""
        asked_s = time.monotonic()
        info = self._device.info
        took_ticks = (time.monotonic() - asked_s) * info["tick_rate_Hz"]
        earliest = info["tick"] - math.ceil(took_ticks)
        latest = info["tick"] + int(self._device.parameters["telemetry_decimation"])
        return {"tick": (earliest + latest) // 2, "within_ticks": (latest - earliest + 1) // 2, "host_s": round(asked_s, 6)}

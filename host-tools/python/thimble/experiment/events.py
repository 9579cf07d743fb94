"""Events with the tick of the controller that they belong to."""

from __future__ import annotations

import time
from typing import Any


class Ticks:
    """Tells the tick of this moment.

    Telemetry has no tick numbers. So the controller is asked for its present tick (`tick` of DeviceState), and the answer is dated by this
    machine's clock: an event at the time of the question happened at most `within_ticks` ticks before `tick`, which is what the question and
    its answer took.
    """

    def __init__(self, device: Any):
        self._device = device

    def mark(self) -> dict[str, int | float]:
        """{"tick", "within_ticks", "host_s"} of now; host_s is this machine's monotonic clock, as in time.monotonic()."""
        asked_s = time.monotonic()
        info = self._device.info
        took_s = time.monotonic() - asked_s
        return {"tick": info["tick"], "within_ticks": int(took_s * info["tick_rate_Hz"]) + 1, "host_s": round(asked_s, 6)}

"""Who compares the two intervals of a trial: a person, or a simulated observer, with a device or with the simulated arm alone.

Each is a function of a trial and its scene that returns whether the first stimulus (on the left) feels greater. So a study is written once.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from .. import Error
from .intervals import halves, simulated, upload, wait_until_free
from .observer import Observer
from .session import Trial

LEAST_ROWS = 10  # of telemetry, on each block
Compare = Callable[[Trial, Mapping[str, Any]], bool]


def by_observer(observer: Observer, path: np.ndarray, **options: Any) -> Compare:
    """The observer holds the simulated arm, whose hand takes the path (presses(), strokes()); options as of intervals.simulated()."""
    return lambda trial, scene: observer.first_is_greater(*halves(simulated(scene, path, **options)), trial.random())


def _still_armed(device: Any) -> None:
    """Raises thimble.Error "not-armed" if a stop, a fault or a person has ended the forces: what was felt does not count, and the trial comes again."""
    info = device.info
    if info["mode"] != "armed":
        raise Error("not-armed", f"the arm was stopped during the trial ({info['stopped_by'] or info['mode']})", "arm it, and open the session again", 1)


def by_observer_at(device: Any, observer: Observer, seconds: float) -> Compare:
    """The observer feels the telemetry of a device, whose hand visits both blocks within these seconds: `thimble-sim --hand PATH --loop`.
    What was touched while the scene changed does not count."""

    def compare(trial: Trial, scene: Mapping[str, Any]) -> bool:
        wait_until_free(device)
        upload(device, scene)
        wait_until_free(device)
        rows = device.telemetry(seconds)
        for _ in range(30):  # a simulator on a busy machine is slower than the clock
            if min(map(len, halves(rows))) >= LEAST_ROWS:
                break
            _still_armed(device)
            rows = np.concatenate([rows, device.telemetry(seconds)])
        else:
            raise TimeoutError("the hand does not touch both blocks")
        _still_armed(device)
        return observer.first_is_greater(*halves(rows), trial.random())

    return compare


def by_person(device: Any, question: str, ask: Callable[[str], str] = input) -> Compare:
    """A person feels both blocks for as long as wanted, lifts the finger, and answers 1 (left) or 2 (right). Anything else is asked again; q raises
    KeyboardInterrupt: the session is paused, and this trial comes again."""

    def compare(trial: Trial, scene: Mapping[str, Any]) -> bool:
        wait_until_free(device)
        upload(device, scene)
        while (answer := ask(f"{trial.number + 1}: {question} Lift the finger. 1 (left), 2 (right), q (pause) ").strip()) not in ("1", "2"):
            if answer == "q":
                raise KeyboardInterrupt
        _still_armed(device)
        return answer == "1"

    return compare

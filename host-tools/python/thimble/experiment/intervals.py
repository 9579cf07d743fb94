"""Two intervals, with both stimuli in one scene: nothing is uploaded between them.

Two blocks stand side by side, the first stimulus on the left and the second on the right. Between two trials only their materials change:
the controller takes these in the next tick, without a ramp (docs/decisions.md).
"""

from __future__ import annotations

import functools
import json
import os
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from .._scene import SceneText

SURFACE_M = -0.02  # the top of the blocks
CENTRE_M = 0.03  # the blocks are at x = -CENTRE_M and CENTRE_M
SIZE_M = (0.05, 0.08, 0.02)

Material = Mapping[str, Any]


def side_by_side(left: Material, right: Material) -> dict[str, Any]:
    """A scene with a block of each material (keys of docs/scene-format.md), 50 mm wide, 10 mm apart, with their tops 20 mm below home."""
    blocks = [{"name": name, "shape": {"box": {"size_m": list(SIZE_M)}}, "pose": {"position_m": [x, 0, SURFACE_M - SIZE_M[2] / 2]},
               "material": dict(material)} for name, x, material in (("left", -CENTRE_M, left), ("right", CENTRE_M, right))]
    return {"thimble_scene": 1, "name": "side by side", "objects": blocks}


def ordered(trial: Any, comparison: Material, standard: Material) -> dict[str, Any]:
    """The scene of a trial: the comparison on the left if it comes first, else on the right."""
    return side_by_side(comparison, standard) if trial.comparison_first else side_by_side(standard, comparison)


def save(scene: Mapping[str, Any], path: str | os.PathLike[str]) -> Path:
    """Writes a scene as a file, for thimble.simulate() or the command."""
    Path(path).write_text(SceneText(scene).text)
    return Path(path)


def upload(device: Any, scene: Mapping[str, Any]) -> None:
    """Sends the scene to a device, which runs it. Where only materials differ from the running scene an armed arm stays armed, and feels on."""
    device.upload(scene)


def wait_until_free(device: Any, timeout_s: float = 60.0) -> None:
    """Returns when no tip touches anything, so that a change of the scene is not felt as one. TimeoutError if a tip still does."""
    end_s = time.monotonic() + timeout_s
    while time.monotonic() < end_s:
        rows = device.telemetry(seconds=0.05)
        if len(rows) and not rows["contacts"].any():
            return
    raise TimeoutError("the hand has not left the blocks")


def presses(depth_m: float = 0.004, seconds: float = 0.4, rest_s: float = 0.3) -> np.ndarray:
    """The path of a hand that presses on the left block, then on the right one: rows of time_s, x_m, y_m, z_m. It rests above the left one
    first, until the force has ramped up after arming, and returns there."""
    above, deep, step_s = SURFACE_M + 0.002, SURFACE_M - depth_m, seconds / 2
    rows = [(rest_s, -CENTRE_M, above)]
    for x in (-CENTRE_M, CENTRE_M):
        rows += [(step_s, x, above), (step_s, x, deep), (step_s, x, above)]
    return _path([*rows, (step_s, -CENTRE_M, above)])


def strokes(depth_m: float = 0.002, seconds: float = 0.3, rest_s: float = 0.3) -> np.ndarray:
    """The path of a hand that strokes 30 mm of the left block, then of the right one: rows of time_s, x_m, y_m, z_m. It rests first, and
    returns, as in presses(). Both strokes go outwards: what the arm itself adds is the same in both."""
    above, deep, half = SURFACE_M + 0.002, SURFACE_M - depth_m, 0.015
    inner, outer = CENTRE_M - half, CENTRE_M + half
    rows = [(rest_s, -inner, above)]
    for side in (-1, 1):
        rows += [(seconds / 2, side * inner, above), (seconds / 5, side * inner, deep)]
        rows += [(seconds, side * outer, deep), (seconds / 5, side * outer, above)]
    return _path([*rows, (seconds / 2, -inner, above)])


def _path(points: Sequence[tuple[float, float, float]]) -> np.ndarray:
    """From points with the time that it takes to reach each of them; the first one is where it begins, and rests."""
    rest_s, x, z = points[0]
    rows = [(0.0, x, 0.0, z), (rest_s, x, 0.0, z)]
    for seconds, x, z in points[1:]:
        rows.append((rows[-1][0] + seconds, x, 0.0, z))
    return np.array(rows)


def halves(rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """What was felt on the left and on the right: the rows in contact, of thimble.simulate() or Device.telemetry()."""
    touching = rows["contacts"] > 0
    left = rows["tip_m"][:, 0] < 0
    return rows[touching & left], rows[touching & ~left]


@functools.lru_cache(maxsize=4096)
def _simulated(scene: str, path: bytes, shape: tuple[int, ...], rate_Hz: float, arm: str, ideal: bool) -> np.ndarray:
    import thimble

    rows = thimble.simulate(json.loads(scene), np.frombuffer(path).reshape(shape), rate_Hz=rate_Hz, arm=arm, ideal=ideal)
    rows.flags.writeable = False
    return rows


def simulated(scene: Mapping[str, Any], path: np.ndarray, *, rate_Hz: float = 4000.0, arm: str = "premium-1.5", ideal: bool = False) -> np.ndarray:
    """What a hand on this path feels of the scene: the rows of thimble.simulate(), with the arm, its motors and the hand; ideal: of the renderer
    alone. Scenes that were felt before are looked up; the array is for reading only."""
    points = np.ascontiguousarray(path, float)
    return _simulated(SceneText(scene).text, points.tobytes(), points.shape, rate_Hz, arm, ideal)

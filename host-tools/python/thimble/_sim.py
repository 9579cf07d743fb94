"""Runs on the simulated arm."""

import os

import numpy as np

from . import _thimble
from ._arm import Arm
from ._scene import taken
from ._whole import whole

_MOST_TICKS = 10_000_000  # at once: their rows have to fit into the memory


def _given(arm):
    return arm._arm if isinstance(arm, Arm) else os.fspath(arm)


def _seed_and_trial(seed, trial):
    return whole("seed", seed, 2**64 - 1), whole("trial", trial, 255)


def simulate(scene, path, *, rate_Hz=4000.0, arm="premium-1.5", ideal=False, seed=1, trial=0):
    """Runs a scene on the simulated arm along a path, faster than real time. The same arguments give the same bytes.

    scene: a dict, the path of a scene file or image, or an image (bytes). path: a CSV file, or an array of rows time_s, x_m, y_m, z_m[, arm]: the
    target of the hand. rate_Hz: 100 to 20000. arm: a simulated arm by its name, the path of an arm file or arm image, or an Arm. ideal: the tip
    follows the path exactly, and the force does not act. seed: of the encoders and the friction. trial: which force fields of the scene act, 0 to 255.

    Returns a structured array, one row for each tick and arm (n rows): time_s, arm, contacts (0 to 3), tip_m, proxy_m (the god object) and force_N
    (n x 3); then what the scene has: counts of bounds (sweep_bound ...), moving objects ("ball.position_m" n x 3, "ball.rotation" n x 4 as w, x, y,
    z, "ball.velocity_m_s", "ball.spin_rad_s" n x 3, "ball.kinetic_J"), control elements ("knob.q_rad", "knob.on") and tissues ("skin.depth_m"
    ...), as in docs/cli.md#simulate. World frame."""
    return _thimble.simulate(taken(scene)[0], path, rate_Hz, _given(arm), ideal, *_seed_and_trial(seed, trial))


class Sim:
    """A simulated hand that a program moves step by step, in place of a path that is known before.

        sim = thimble.Sim(scene, seed=1)
        state = sim.step([0, 0, -0.01], ticks=40)   # 10 ms at 4 kHz
        state["force_N"]

    scene, rate_Hz, arm, ideal, seed and trial as of simulate(). start_m: where the hand begins (3 numbers, m, world frame), or 2 x 3 for two arms. When the
    Sim is made, the arm is homed and armed, the hand is at start_m and the force acts in full. The same calls give the same bytes, and those of
    simulate() along the same path. One thread at a time."""

    def __init__(self, scene, *, start_m=(0.0, 0.0, 0.0), rate_Hz=4000.0, arm="premium-1.5", ideal=False, seed=1, trial=0):
        start = np.asarray(start_m, float)
        self.arms = 1 if start.ndim == 1 else len(start)
        self.rate_Hz = rate_Hz
        image, _, self._text = taken(scene)
        self._sim = _thimble.Simulation(image, self._points(start, 1), rate_Hz, _given(arm), ideal, *_seed_and_trial(seed, trial))

    def _points(self, targets, count):
        targets = np.asarray(targets, float)
        if targets.size != count * self.arms * 3:
            raise ValueError("a target has x_m, y_m, z_m for each arm")
        return targets.reshape(count, self.arms, 3)

    @property
    def ticks(self):
        """The number of ticks done so far."""
        return self._sim.ticks

    @property
    def time_s(self):
        """The time of the next tick; 0 at the beginning."""
        return self._sim.ticks / self.rate_Hz

    def step(self, target_m, ticks=1):
        """Moves the hand to target_m (3 numbers, m; 2 x 3 for two arms) on a straight line, in so many ticks (1 to 10 million): it is there when the next step begins.
        Returns the state in the last of these ticks: a row of simulate(), or an array of one for each arm."""
        rows = self._sim.advance(self._points(target_m, 1), whole("ticks", ticks, _MOST_TICKS, 1))
        return rows[-1] if self.arms == 1 else rows[-self.arms:]

    def run(self, targets_m, ticks=1):
        """As step() for each of targets_m (n x 3, m; n x 2 x 3 for two arms), so many ticks each. Returns all rows, as simulate()."""
        targets = np.asarray(targets_m, float)
        return self._sim.advance(self._points(targets, len(targets)), whole("ticks", ticks, _MOST_TICKS, 1))

    def set_trial(self, trial):
        """From the next tick on the force fields of this trial act (0 to 255), without a ramp. Returns the number of that tick, as event() does."""
        return self._sim.set_trial(whole("trial", trial, 255))

    def event(self, code):
        """An event code (0 to 65535) that belongs to the next tick, as Device.event(). Returns the number of that tick, counted as `ticks` counts. A tick
        takes one event or trial: of those that are given before a step, each next one belongs to the tick behind."""
        return self._sim.event(whole("code", code, 65535))

    def load(self, scene):
        """Another scene, as an upload to a device: with other materials only it is felt from the next tick on, and contacts stay; else the force
        is ramped down for 50 ms first, but not with ideal; of the scenes that come meanwhile the newest follows. It has to have the same moving objects, because the rows keep their fields."""
        image, _, text = taken(scene)
        self._sim.load(image)
        self._text = text

    def set_material(self, object, **values):
        """Changes numbers of the material of an object, by its name, from the next tick on: set_material("wall", stiffness_N_m=400). Contacts stay. Keys
        and units: docs/scene-format.md#materials. Not of a Sim that was made of an image."""
        if self._text is None:
            raise ValueError("the material of an image cannot be changed: give the scene as a dict or a scene file")
        changed = self._text.with_material(object, values)
        self._sim.load(changed.image())
        self._text = changed

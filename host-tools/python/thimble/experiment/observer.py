"""A simulated observer: it compares what was rendered, with noise of a known size. It tells what an analysis should find.

The magnitude that is felt is the logarithm of a measure of the rendered force plus Gaussian noise of standard deviation `weber` (Weber's law).
For two magnitudes in the ratio r the proportion of correct comparisons is Phi(ln r / (weber sqrt 2)), d' over the root of 2 with d' = ln r / weber
(D. M. Green and J. A. Swets, Signal detection theory and psychophysics, 1966), apart from lapses.
"""

from __future__ import annotations

import math
import random
from collections.abc import Callable
from dataclasses import dataclass
from statistics import NormalDist

import numpy as np


def stiffness_N_m(rows: np.ndarray) -> float:
    """The slope of the force upwards over depth in these rows, by least squares."""
    return -float(np.polyfit(rows["tip_m"][:, 2], rows["force_N"][:, 2], 1)[0])


def friction(rows: np.ndarray, least_N: float = 0.2) -> float:
    """The coefficient of friction: the median of force along the surface over force upwards, where that is at least least_N."""
    force = rows["force_N"][rows["force_N"][:, 2] >= least_N]
    return float(np.median(np.hypot(force[:, 0], force[:, 1]) / force[:, 2]))


def roughness_N(rows: np.ndarray, least_N: float = 0.2) -> float:
    """The standard deviation of the force along x over the middle 80 % of a stroke along x, without its landing and lifting, where the force
    upwards is at least least_N."""
    x = rows["tip_m"][:, 0]
    low, high = x.min(), x.max()
    counts = (rows["force_N"][:, 2] >= least_N) & (np.abs(x - (low + high) / 2) <= 0.4 * (high - low))
    return float(np.std(rows["force_N"][counts, 0]))


@dataclass(frozen=True)
class Observer:
    """measure: a function of rows, whose value is felt. weber: the standard deviation of the noise of each interval, as a part of the
    magnitude. lapse: the share of comparisons that are guessed. bias: by how much the first interval feels greater, as a part."""

    measure: Callable[[np.ndarray], float]
    weber: float
    lapse: float = 0.0
    bias: float = 0.0

    def first_is_greater(self, first: np.ndarray, second: np.ndarray, random: random.Random) -> bool:
        """Compares two intervals, each the rows of what was rendered."""
        noise = random.gauss(0, self.weber) - random.gauss(0, self.weber)
        guessed, coin = random.random() < self.lapse, random.random() < 0.5
        if guessed:
            return coin
        return math.log(self.measure(first) / self.measure(second)) + math.log1p(self.bias) + noise > 0

    def proportion(self, ratio: float) -> float:
        """How often a magnitude that is greater by this ratio is found to be so, without a bias."""
        return self.lapse / 2 + (1 - self.lapse) * NormalDist().cdf(math.log(ratio) / (self.weber * math.sqrt(2)))

    def ratio(self, proportion: float) -> float:
        """The ratio that is found with this proportion: the inverse of proportion()."""
        share = (proportion - self.lapse / 2) / (1 - self.lapse)
        return math.exp(self.weber * math.sqrt(2) * NormalDist().inv_cdf(share))

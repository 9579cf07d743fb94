"""QUEST: the level of each trial is the best estimate of the threshold so far.

A. B. Watson and D. G. Pelli, "QUEST: a Bayesian adaptive psychometric method", Percept. Psychophys. 33, 113, 1983. The posterior over the
threshold T, with x and T in log10 of the level (the paper has decibels, 20 log10):

    p(x; T) = lapse * guess + (1 - lapse) * (1 - (1 - guess) * exp(-10^(slope * (x - T + epsilon))))
    log posterior(T) = log prior(T) + sum over trials of log p(x; T) where correct, log(1 - p(x; T)) where wrong

with epsilon such that p(T; T) = target. The mean of the posterior is presented instead of its mode: its error is smaller
(P. E. King-Smith et al., Vision Res. 34, 885, 1994).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from .._whole import whole


@dataclass
class Quest:
    """One run of QUEST. Ask `level`, present it, tell `answer(correct)`, until `done`.

    guess_level: what the threshold is expected to be, above 0, in the unit of the level.
    sd: standard deviation of that expectation, in log10 units: 0.5 means within a factor of 3. Rather too large.
    target: proportion of correct answers at the threshold.
    slope: beta of the Weibull function: 3.5 for detection, as in the paper. 1.3 for comparisons in which d' is proportional to the difference.
    guess: proportion correct far below the threshold: 0.5 with two intervals. lapse: share of answers that do not depend on the stimulus.
    trials: how many end it.
    step: the spacing of the levels presented and of the grid of thresholds, in log10 units. least, most: bounds of the level.
    """

    guess_level: float
    sd: float = 0.5
    target: float = 0.75
    slope: float = 3.5
    guess: float = 0.5
    lapse: float = 0.01
    trials: int = 40
    step: float = 0.01
    least: float = 0.0
    most: float = math.inf

    answers: int = field(init=False, default=0, repr=False)
    grid: np.ndarray = field(init=False, repr=False)
    log_posterior: np.ndarray = field(init=False, repr=False)

    def __post_init__(self) -> None:
        if not all(0 < value < math.inf for value in (self.guess_level, self.sd, self.slope, self.step)) or not 0 < self.lapse < 1:
            raise ValueError("QUEST needs guess_level, sd, slope and step above 0 and finite, and a lapse between 0 and 1")
        best = self.lapse * self.guess + 1 - self.lapse
        if not 0 <= self.guess < self.target < best:
            raise ValueError(f"guess is not below 0, and target is between guess and {best}, the best that an observer with this lapse reaches")
        if not (self.least <= self.most and self.least < math.inf and self.most > 0):
            raise ValueError(f"the levels are from {self.least} to {self.most}: give a finite least, and a most that is not below it and above 0")
        whole("trials", self.trials, 2**63, 1)
        half = 4 * self.sd / self.step
        if not half <= 1e6:
            raise ValueError(f"sd is {self.sd} and step {self.step}: give an sd of at most 250 000 steps")
        half = math.ceil(half)
        self.grid = math.log10(self.guess_level) + self.step * np.arange(-half, half + 1)
        self.log_posterior = -0.5 * ((self.grid - math.log10(self.guess_level)) / self.sd) ** 2

    def probability(self, level: float, threshold: float | np.ndarray) -> float | np.ndarray:
        """Of a correct answer at this level, with this threshold, both in the unit of the level."""
        return self._probability(math.log10(level), np.log10(threshold))

    def _probability(self, x: float, thresholds: np.ndarray) -> np.ndarray:
        at_threshold = (self.target - self.lapse * self.guess) / (1 - self.lapse)
        epsilon = math.log10(-math.log((1 - at_threshold) / (1 - self.guess))) / self.slope
        raised = 10.0 ** np.minimum(self.slope * (x - thresholds + epsilon), 300.0)
        weibull = self.guess - (1 - self.guess) * np.expm1(-raised)  # 1 - (1 - guess) * exp(-raised), also where that is far below 1e-16
        return self.lapse * self.guess + (1 - self.lapse) * weibull

    @property
    def posterior(self) -> np.ndarray:
        """Probabilities of the thresholds 10 ** grid; their sum is 1."""
        likely = np.exp(self.log_posterior - self.log_posterior.max())
        return likely / likely.sum()

    def _moments(self) -> tuple[float, float]:
        weights = self.posterior
        mean = float(weights @ self.grid)
        return mean, math.sqrt(float(weights @ (self.grid - mean) ** 2))

    @property
    def level(self) -> float:
        """The next level: the mean of the posterior, on the grid, within the bounds."""
        first = self.grid[0]
        nearest = first + self.step * round((self._moments()[0] - first) / self.step)
        return min(max(10.0**nearest, self.least), self.most)

    @property
    def done(self) -> bool:
        """Whether all trials have been answered."""
        return self.answers >= self.trials

    def answer(self, correct: bool) -> None:
        """The answer to the present level."""
        if self.done:
            raise ValueError("QUEST has ended")
        probability = self._probability(math.log10(self.level), self.grid)
        self.log_posterior = self.log_posterior + np.log(np.maximum(probability if correct else 1 - probability, 1e-300))
        self.answers += 1

    def threshold(self) -> tuple[float, float]:
        """The mean of the posterior as a level, and the posterior's standard deviation in the unit of the level."""
        mean, sd = self._moments()
        return 10.0**mean, 10.0**mean * math.log(10) * sd

    def interval(self, confidence: float = 0.95) -> tuple[float, float]:
        """The threshold is between these levels with this probability, and below and above with the same one."""
        beside = (1 - confidence) / 2
        low, high = np.interp([beside, 1 - beside], np.cumsum(self.posterior) - self.posterior / 2, self.grid)
        return float(10.0**low), float(10.0**high)

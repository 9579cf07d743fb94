"""Psychometric functions and their maximum-likelihood fit.

    p(x) = guess + (1 - guess - lapse) * F(x)       (F. A. Wichmann and N. J. Hill, Percept. Psychophys. 63, 1293, 2001)

    "weibull": F(x) = 1 - exp(-(x / location)^width)     x above 0; location in the unit of x, width without unit
    "normal":  F(x) = Phi((x - location) / width)        both in the unit of x

The fit is Fisher's scoring: Newton's method on the log likelihood with the expected information, whose inverse gives the standard errors.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from statistics import NormalDist

import numpy as np

MOST_LAPSE = 0.1
_NORMAL = NormalDist()
_erf = np.vectorize(math.erf, otypes=[float])


def _core(function: str, x: np.ndarray, location: float, log_width: float) -> tuple[np.ndarray, np.ndarray]:
    """F, and its derivatives by location and log(width), 2 x len(x)."""
    width = math.exp(log_width)
    if function == "normal":
        z = (x - location) / width
        density = np.exp(-0.5 * z**2) / math.sqrt(2 * math.pi)
        return 0.5 * (1 + _erf(z / math.sqrt(2))), np.array([-density / width, -density * z])
    raised = np.where(x > 0, np.exp(np.minimum(width * np.log(np.maximum(x, 1e-300) / location), 300.0)), 0.0)
    common = np.exp(-np.minimum(raised, 700.0)) * raised
    logs = np.log(np.maximum(x, 1e-300) / location)
    return -np.expm1(-raised), np.array([-common * width / location, np.where(x > 0, common * width * logs, 0.0)])


def psychometric(function: str, x, location: float, width: float, guess: float | str = 0.5, lapse: float = 0.0) -> np.ndarray:
    """p(x). guess "lapse": as large as the lapse, for answers such as "the second was stiffer" that go from 0 to 1."""
    floor = _floor(guess, lapse)
    return floor + (1 - floor - lapse) * _core(_known(function), np.atleast_1d(np.asarray(x, float)), location, math.log(width))[0]


def _known(function: str) -> str:
    if function not in ("weibull", "normal"):
        raise ValueError('a psychometric function is "weibull" or "normal"')
    return function


def _floor(guess: float | str, lapse: float) -> float:
    """The proportion far below. ValueError if the function would not rise from there."""
    if isinstance(guess, str) and guess != "lapse":
        raise ValueError(f'guess is "{guess}": give a number or "lapse"')
    floor = lapse if isinstance(guess, str) else guess
    if not (floor >= 0 and lapse >= 0 and floor + lapse < 1):
        raise ValueError(f"guess is {guess} and the lapse {lapse}: give proportions from 0 on whose sum is below 1 "
                         f"(a lapse that is estimated is up to {MOST_LAPSE})")
    return floor


@dataclass(frozen=True)
class Fit:
    """A fitted function. Standard errors are nan where the data do not determine them; that of a lapse that is given, or at its bound, is 0."""

    function: str
    location: float
    width: float
    lapse: float
    guess: float | str
    location_error: float
    width_error: float
    lapse_error: float
    covariance: np.ndarray  # of location, width and lapse, 3 x 3
    log_likelihood: float
    deviance: float  # about chi-squared with `freedom` degrees of freedom, if the function is the right one and there are many trials a level
    freedom: int

    def p(self, x) -> np.ndarray:
        """The fitted proportion at these levels."""
        return psychometric(self.function, x, self.location, self.width, self.guess, self.lapse)

    def _level(self, proportion: float, location: float, width: float, lapse: float) -> float:
        floor = lapse if isinstance(self.guess, str) else self.guess
        share = (proportion - floor) / (1 - floor - lapse)
        if not 0 < share < 1:
            raise ValueError(f"the function does not reach {proportion}")
        if self.function == "normal":
            return location + width * _NORMAL.inv_cdf(share)
        return location * (-math.log(1 - share)) ** (1 / width)

    def level(self, proportion: float) -> tuple[float, float]:
        """The level with this proportion, and its standard error by the delta method."""
        best = np.array([self.location, self.width, self.lapse])
        at = self._level(proportion, *best)
        gradient = np.zeros(3)
        for i, size in enumerate(best):
            step = 1e-6 * max(abs(size), 1e-3)
            if i == 2 and self.lapse_error == 0:
                continue
            ahead, behind = best.copy(), best.copy()
            ahead[i] += step
            behind[i] -= step
            gradient[i] = (self._level(proportion, *ahead) - self._level(proportion, *behind)) / (2 * step)
        return at, math.sqrt(max(float(gradient @ self.covariance @ gradient), 0.0)) if np.isfinite(self.covariance).all() else math.nan

    def interval(self, proportion: float, confidence: float = 0.95) -> tuple[float, float]:
        """Confidence interval of the level with this proportion, from its standard error."""
        at, error = self.level(proportion)
        wide = _NORMAL.inv_cdf(0.5 + confidence / 2) * error
        return at - wide, at + wide


class _Likelihood:
    """Of location, log(width) and lapse, for answers `yes` of `trials` at x."""

    def __init__(self, function: str, x: np.ndarray, yes: np.ndarray, trials: np.ndarray, guess: float | str):
        self.function, self.x, self.yes, self.trials, self.guess = function, x, yes, trials, guess

    def proportions(self, parameters: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        location, log_width, lapse = parameters
        core, slopes = _core(self.function, self.x, location, log_width)
        floor = lapse if self.guess == "lapse" else self.guess
        span = 1 - floor - lapse
        by_lapse = 1 - 2 * core if self.guess == "lapse" else -core
        p = np.clip(floor + span * core, 1e-12, 1 - 1e-12)
        return p, np.vstack([span * slopes, by_lapse])

    def log(self, parameters: np.ndarray) -> float:
        if self.function == "weibull" and parameters[0] <= 0:
            return -math.inf
        p, _ = self.proportions(parameters)
        return float(self.yes @ np.log(p) + (self.trials - self.yes) @ np.log1p(-p))

    def score_and_information(self, parameters: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        p, slopes = self.proportions(parameters)
        weight = 1 / (p * (1 - p))
        return slopes @ ((self.yes - self.trials * p) * weight), (slopes * (self.trials * weight)) @ slopes.T


def _starts(likelihood: _Likelihood, lapses: Sequence[float]) -> list[np.ndarray]:
    """The best five of a coarse grid over the range of the levels: with few trials there are several maxima."""
    x = likelihood.x
    low, high = float(x.min()), float(x.max())
    if likelihood.function == "weibull":
        locations, widths = np.geomspace(max(low, high * 1e-3) / 2, high * 2, 15), np.geomspace(0.3, 50, 10)
    else:
        locations, widths = np.linspace(low, high, 15), np.geomspace((high - low) / 50, 3 * (high - low), 8)
    grid = [np.array([a, math.log(b), c]) for a in locations for b in widths for c in lapses]
    return sorted(grid, key=likelihood.log)[-5:]


def _climb(likelihood: _Likelihood, parameters: np.ndarray, free: list[int], bounded: bool) -> tuple[np.ndarray, bool]:
    """Fisher's scoring with halved steps; whether it came to rest."""
    best = likelihood.log(parameters)
    for _ in range(200):
        score, information = likelihood.score_and_information(parameters)
        part = information[np.ix_(free, free)]
        ridge = 1e-9 * np.diag(np.diag(part)) + 1e-12 * np.eye(len(free))
        step = np.zeros(3)
        step[free] = np.linalg.solve(part + ridge, score[free])
        step[1] = np.clip(step[1], -1, 1)
        if abs(float(score @ step)) < 1e-12 * (1 + abs(best)):
            return parameters, True
        for _ in range(40):
            tried = parameters + step
            if bounded:
                tried[2] = min(max(tried[2], 0.0), MOST_LAPSE)
            reached = likelihood.log(tried)
            if reached > best:
                break
            step /= 2
        else:
            return parameters, True
        parameters, best = tried, reached
    return parameters, False


def _maximum(likelihood: _Likelihood, at: np.ndarray, with_lapse: bool) -> tuple[np.ndarray, bool, list[int]]:
    """The best parameters, whether they were reached, and which of them are free: a lapse at its bound is not."""
    if not with_lapse:
        return *_climb(likelihood, at, [0, 1], False), [0, 1]
    for _ in range(10):
        at, rest = _climb(likelihood, at, [0, 1, 2], True)
        if 1e-9 < at[2] < MOST_LAPSE - 1e-9:
            return at, rest, [0, 1, 2]
        at, rest = _climb(likelihood, at, [0, 1], False)
        slope = likelihood.score_and_information(at)[0][2]
        if (slope <= 0) == (at[2] <= 1e-9):
            break
    return at, rest, [0, 1]


def fit(levels, yes, trials, *, function: str = "weibull", guess: float | str = 0.5, lapse: float | None = None) -> Fit:
    """Fits the function to `yes` answers of `trials` at each of the levels (arrays of one length).

    guess: the proportion far below: 0.5 for correct answers with two intervals; "lapse" for answers from 0 to 1.
    lapse: a number that is taken as it is; None: estimated, from 0 to 0.1.
    """
    x, k, n = (np.asarray(values, float) for values in (levels, yes, trials))
    if not (x.ndim == 1 and x.shape == k.shape == n.shape):
        raise ValueError("levels, yes and trials are arrays of one length")
    if not all(np.isfinite(values).all() for values in (x, k, n)):
        raise ValueError("levels, yes and trials are finite numbers")
    _floor(guess, MOST_LAPSE if lapse is None else lapse)
    if (n <= 0).any() or (k < 0).any() or (k > n).any():
        raise ValueError("each level has trials, and no more answers than trials")
    if len(np.unique(x)) < 2 or (_known(function) == "weibull" and (x < 0).any()):
        raise ValueError("a fit needs two levels, and for a Weibull function none below 0")
    likelihood = _Likelihood(function, x, k, n, guess)
    starts = _starts(likelihood, [0.0, 0.02, 0.05, MOST_LAPSE] if lapse is None else [lapse])
    ends = [_maximum(likelihood, start, lapse is None) for start in starts]
    at, rest, free = max(ends, key=lambda end: likelihood.log(end[0]))
    covariance = np.zeros((3, 3))
    _, information = likelihood.score_and_information(at)
    part = information[np.ix_(free, free)]
    scale = np.sqrt(np.diag(part))
    best = likelihood.log(at)
    # Where all answers are no below a level and yes above it, an ever steeper function is as good.
    settled = rest and all(likelihood.log(at + [0, change, 0]) < best - 1e-4 for change in (-math.log(2), math.log(2)))
    if settled and (scale > 0).all() and np.linalg.cond(part / np.outer(scale, scale)) < 1e10:
        covariance[np.ix_(free, free)] = np.linalg.inv(part)
    else:
        covariance[np.ix_(free, free)] = math.nan
    width = math.exp(at[1])
    covariance[1, :] *= width
    covariance[:, 1] *= width
    observed = k / n
    with np.errstate(divide="ignore", invalid="ignore"):
        full = float(np.sum(np.where(k > 0, k * np.log(observed), 0) + np.where(k < n, (n - k) * np.log1p(-observed), 0)))
    errors = np.sqrt(np.diag(covariance))
    return Fit(function, float(at[0]), width, float(at[2]), guess, float(errors[0]), float(errors[1]), float(errors[2]), covariance, best,
               2 * (full - best), len(x) - len(free))

"""Up-down staircases.

Transformed up-down (H. Levitt, J. Acoust. Soc. Am. 49, 467, 1971): the level falls after `down` correct answers in a row and rises after each
wrong one. Weighted up-down (C. Kaernbach, Percept. Psychophys. 49, 227, 1991): one correct answer, with steps of different size up and down.
Both come to rest where the expected step is zero: p^down * step_down = (1 - p^down) * step_up, which is `Staircase.target`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from .._whole import whole


@dataclass
class Staircase:
    """One staircase. Ask `level`, present it, tell `answer(correct)`, until `done`.

    start: the first level, in any unit.
    steps: size of a step down, one after the other: the next one from each reversal on, then the last one for good. With log=True a factor
    above 1, by which the level is divided or multiplied; else an amount of the level's unit.
    down: how many correct answers in a row make it easier no more: 1 with weight 1 goes to 0.5, 2 to 0.707, 3 to 0.794.
    weight: step up / step down (in the logarithm with log=True). Kaernbach's 3 with down=1 goes to 0.75.
    reversals: how many end it, counted from the first one with the last step; most_trials ends it, too.
    least, most: bounds of the level.
    """

    start: float
    steps: Sequence[float]
    down: int = 1
    weight: float = 1.0
    log: bool = False
    reversals: int = 8
    most_trials: int = 1000
    least: float = -math.inf
    most: float = math.inf

    level: float = field(init=False, repr=False)
    trials: int = field(init=False, default=0, repr=False)
    reversal_levels: list[float] = field(init=False, default_factory=list, repr=False)
    _correct: int = field(init=False, default=0, repr=False)
    _direction: int = field(init=False, default=0, repr=False)

    def __post_init__(self) -> None:
        self.steps = tuple(map(float, self.steps))
        if not all(map(math.isfinite, (self.start, self.weight, *self.steps))):
            raise ValueError("start, weight and steps are finite numbers")
        for count in ("down", "reversals", "most_trials"):
            whole(count, getattr(self, count), 2**63, 1)
        if not (self.weight > 0 and self.steps):
            raise ValueError("a staircase needs weight > 0 and a step")
        if min(self.steps) <= (1 if self.log else 0):
            raise ValueError("a step is above 0, or with log=True a factor above 1")
        if self.log and (self.start <= 0 or self.least == 0):
            raise ValueError("levels are above 0 with log=True")
        if not self.least <= self.start <= self.most:
            raise ValueError("start is between least and most")
        self.level = float(self.start)

    @classmethod
    def weighted(cls, start: float, steps: Sequence[float], target: float = 0.75, **others) -> Staircase:
        """Kaernbach's staircase for this proportion of correct answers."""
        if not 0 < target < 1:
            raise ValueError(f"target is {target}: give a proportion between 0 and 1")
        return cls(start, steps, down=1, weight=target / (1 - target), **others)

    @property
    def target(self) -> float:
        """The proportion of correct answers to which it goes. Exact for small steps on a straight psychometric function."""
        return (self.weight / (1 + self.weight)) ** (1 / self.down)

    @property
    def done(self) -> bool:
        """Whether it has its reversals, or most_trials."""
        return len(self.reversal_levels) - (len(self.steps) - 1) >= self.reversals or self.trials >= self.most_trials

    def answer(self, correct: bool) -> None:
        """The answer to the present level."""
        if self.done:
            raise ValueError("the staircase has ended")
        self.trials += 1
        if correct:
            self._correct += 1
            if self._correct == self.down:
                self._correct = 0
                self._move(-1)
        else:
            self._correct = 0
            self._move(1)

    def _move(self, direction: int) -> None:
        if self._direction == -direction:
            self.reversal_levels.append(self.level)
        self._direction = direction
        step = self.steps[min(len(self.reversal_levels), len(self.steps) - 1)]
        size = direction * (self.weight if direction > 0 else 1) * (math.log(step) if self.log else step)
        moved = self.level * math.exp(size) if self.log else self.level + size
        self.level = min(max(moved, self.least), self.most)

    def threshold(self) -> tuple[float, float]:
        """Mean of the middles of its runs at the last step (Levitt's mid-run estimate), and its standard error, both in the unit of the level;
        geometric with log=True. A run goes from one reversal to the next, and every second one counts. nan with fewer than two such runs.
        Levels of successive runs are correlated: the error is a lower bound."""
        levels = np.array(self.reversal_levels[len(self.steps) - 1 :])
        if len(levels) < 4:
            return math.nan, math.nan
        used = levels[len(levels) % 2 :]
        middles = (np.log(used) if self.log else used).reshape(-1, 2).mean(axis=1)
        error = float(middles.std(ddof=1) / math.sqrt(len(middles)))
        mean = float(middles.mean())
        return (math.exp(mean), math.exp(mean) * error) if self.log else (mean, error)

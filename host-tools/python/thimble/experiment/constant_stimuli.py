"""The method of constant stimuli: each of some levels equally often, in random order."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from .._whole import whole
from .blocks import shuffled_blocks
from .psychometric import Fit, fit


@dataclass
class ConstantStimuli:
    """Ask `level`, present it, tell `answer(yes)`, until `done`. Each block has every level once, so a run that ends early is balanced, too.

    levels: in any unit. repeats: trials of each level. seed: of the order.
    """

    levels: Sequence[float]
    repeats: int
    seed: int

    answers: list[tuple[float, bool]] = field(init=False, default_factory=list, repr=False)
    _order: list[float] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        self.levels = tuple(map(float, self.levels))
        if len(set(self.levels)) != len(self.levels) or len(self.levels) < 2 or not all(map(math.isfinite, self.levels)):
            raise ValueError("constant stimuli are two levels or more, all different and finite")
        whole("repeats", self.repeats, 2**63, 1)
        self._order = [level for block in shuffled_blocks(self.levels, self.repeats, self.seed) for level in block]

    @property
    def level(self) -> float:
        """The level of the next trial."""
        if self.done:
            raise ValueError("all trials have been answered")
        return self._order[len(self.answers)]

    @property
    def done(self) -> bool:
        """Whether each level has had its repeats."""
        return len(self.answers) == len(self._order)

    def answer(self, yes: bool) -> None:
        """The answer to the present level: whether it was yes, or correct."""
        self.answers.append((self.level, bool(yes)))

    def counts(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Levels in ascending order, answers `yes` and trials at each of them so far."""
        asked = sorted({level for level, _ in self.answers})
        yes = [sum(answer for at, answer in self.answers if at == level) for level in asked]
        return np.array(asked), np.array(yes), np.array([sum(at == level for at, _ in self.answers) for level in asked])

    def fit(self, **options) -> Fit:
        """The psychometric function of the answers so far, with the options of fit()."""
        return fit(*self.counts(), **options)

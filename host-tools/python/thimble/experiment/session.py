"""The trials of one participant, and the file that has them.

What is presented follows from the experiment, its seed and the answers so far. So the file needs only the answers, and a run that was paused or
killed goes on where it was: the answers are told to new staircases.

The file is JSON lines, and lines are only appended. Each is on the disk (fsync) before the next trial begins. The first one has the
experiment; then a line for each trial, for each event, and for each time that the file was opened again.
"""

from __future__ import annotations

import fcntl
import json
import math
import os
import random
import re
import stat
import time
import warnings
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Protocol

from .._arrays import of_numpy
from .._whole import whole
from .blocks import derive_seed, order_for, shuffled

FORMAT = 1


class Method(Protocol):
    """What chooses the levels: a Staircase, Quest, ConstantStimuli, or one's own class with these three. Its levels depend on its arguments and
    the answers only, and its repr() has the arguments."""

    @property
    def level(self) -> float:
        """The level of the next trial."""

    @property
    def done(self) -> bool:
        """Whether there is no next trial."""

    def answer(self, answer: bool, /) -> None:
        """The answer at the present level: correct, or yes."""


class Marker(Protocol):
    """What gives an event its tick: a thimble.Device or a thimble.Sim."""

    def event(self, code: int, /) -> int:
        """Marks a tick with the code, and returns its number."""


class FileError(Exception):
    """The file of a session cannot be used: it is of another experiment, damaged before its last line, open in another program, or not a regular
    file."""


@dataclass(frozen=True)
class Trial:
    """number: from 0. seed: of whatever is random in this trial. level: what the method asks for. comparison_first: whether the comparison is
    the first of two intervals (or on the left), and the standard the second."""

    number: int
    seed: int
    condition: str
    level: float
    comparison_first: bool

    def random(self) -> random.Random:
        """Random numbers of this trial: the same each time it is presented."""
        return random.Random(self.seed)


@dataclass
class Experiment:
    """What is run.

    name: of the experiment. conditions: for each a function that makes its method from a seed. seed: all others are derived from it.
    participant: number, from 0: its row of the Latin square, and part of all seeds.
    blocked: one condition after the other, in the order of the participant. Otherwise they are interleaved: rounds with one trial of each
    condition that is not done, in random order.
    settings: what else the file should have, as JSON: the standard, the arm, the date of the calibration.
    """

    name: str
    conditions: Mapping[str, Callable[[int], Method]]
    seed: int
    participant: int = 0
    blocked: bool = False
    settings: Mapping[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if not self.conditions:
            raise ValueError("an experiment has a condition")
        whole("participant", self.participant, 2**63)
        for name in (self.name, *self.conditions):
            if not isinstance(name, str):
                raise TypeError(f"{name!r} is no name of an experiment or a condition: give a text")
        self.header()  # what cannot be in the file is told before there is one

    def methods(self) -> dict[str, Method]:
        """New methods, without answers."""
        return {name: make(derive_seed(self.seed, self.participant, "method", name)) for name, make in self.conditions.items()}

    def header(self) -> dict[str, Any]:
        """The first line of the file, as it is read again: JSON has texts as keys, and lists only."""
        methods, again = self.methods(), self.methods()
        for name, method in methods.items():
            if repr(method) != repr(again[name]) or re.search(r" at 0x[0-9a-fA-F]+>", repr(method)):
                raise ValueError(f"the method of '{name}' is {method!r}, which is another text in each run, so that its file could not be continued: "
                                 f"give {type(method).__name__} a __repr__() that has its arguments only")
        header = {"thimble_experiment": FORMAT, "name": self.name, "seed": self.seed, "participant": self.participant, "blocked": self.blocked,
                  "methods": {name: repr(method) for name, method in methods.items()}, "settings": dict(self.settings)}
        return dict(json.loads(_text_of(header)))


class _Presenter:
    """Which trial is next."""

    def __init__(self, experiment: Experiment):
        self.experiment = experiment
        self.methods = experiment.methods()
        self.counts = dict.fromkeys(self.methods, 0)
        self.number = 0
        self._waiting: list[str] = []
        self._rounds = 0

    def next(self) -> Trial | None:
        """None: all methods are done."""
        experiment = self.experiment
        self._waiting = [name for name in self._waiting if not self.methods[name].done]
        if not self._waiting:
            left = [name for name in self._ordered() if not self.methods[name].done]
            if not left:
                return None
            seed = derive_seed(experiment.seed, experiment.participant, "round", self._rounds)
            self._waiting = left[:1] if experiment.blocked else shuffled(left, seed)
            self._rounds += 1
        condition = self._waiting[0]
        pair, place = divmod(self.counts[condition], 2)  # of two trials of a condition, one has the comparison first
        sides = shuffled([True, False], derive_seed(experiment.seed, experiment.participant, "sides", condition, pair))
        seed = derive_seed(experiment.seed, experiment.participant, "trial", self.number)
        return Trial(self.number, seed, condition, float(self.methods[condition].level), sides[place])

    def _ordered(self) -> list[str]:
        return order_for(list(self.methods), self.experiment.participant)

    def answer(self, trial: Trial, answer: bool) -> None:
        self.methods[trial.condition].answer(answer)
        self.counts[trial.condition] += 1
        self.number += 1
        if not self.experiment.blocked:
            self._waiting.remove(trial.condition)


class Session:
    """A run of an experiment with its file: made if it is not there, continued if it is.

        with Session("p00.jsonl", experiment) as session:
            for trial in session:
                ...                      # present it; `break` is a pause
                session.answer(correct)

    methods: by condition, with all answers so far. records: the lines of the trials, as dictionaries. notices: what was found when the file
    was opened, such as a last line that was cut off; each is a warning, too.
    """

    def __init__(self, path: str | os.PathLike[str], experiment: Experiment):
        self.experiment = experiment
        self.path = Path(path)
        self.notices: list[str] = []
        self.records: list[dict[str, Any]] = []
        self.events: list[dict[str, Any]] = []
        self._presenter = _Presenter(experiment)
        self._trial: Trial | None = None
        self._run = 0
        self._file = os.open(self.path, os.O_RDWR | os.O_CREAT | os.O_APPEND | os.O_CLOEXEC, 0o644)
        try:
            if not stat.S_ISREG(os.fstat(self._file).st_mode):
                raise FileError(f"{self.path} is not a regular file: give the path of a new file, or of one of this experiment")
            fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            self._open()
        except BlockingIOError:
            self.close()
            raise FileError(f"{self.path} is open in another program") from None
        except BaseException:
            self.close()
            raise

    def __enter__(self) -> Session:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Ends the run: a pause, unless it is done."""
        if self._file >= 0:
            file, self._file = self._file, -1
            os.close(file)

    @property
    def methods(self) -> dict[str, Method]:
        """The method of each condition, with all answers so far."""
        return self._presenter.methods

    @property
    def done(self) -> bool:
        """Whether all methods are done."""
        return self._presenter.next() is None

    def __iter__(self) -> Iterator[Trial]:
        while (trial := self._presenter.next()) is not None:
            self._check_open()
            self._trial = trial
            yield trial
            if self._trial is trial:
                self._check_open()
                raise ValueError(f"trial {trial.number} has no answer: session.answer()")

    def answer(self, answer: bool, **more: Any) -> None:
        """The answer to the trial that was presented last (correct, or yes), with anything else that is to be in its line, as JSON. It is on the
        disk when this returns. Where this is interrupted (Ctrl-C) or fails after it has begun to write, the session is closed; opened again, it goes
        on after the lines that are whole on the disk."""
        trial = self._trial
        if trial is None:
            raise ValueError("no trial waits for an answer")
        record = {**_line_of(trial), "answer": bool(answer), "run": self._run, "utc_s": round(time.time(), 3)}
        if clash := (record.keys() | {"event", "opened"}) & more.keys():
            raise ValueError(f"these names are taken: {', '.join(sorted(clash))}")
        text = _text_of({**record, **more})
        try:
            self._append(text)
            self._presenter.answer(trial, bool(answer))
            self._trial = None
        except BaseException:
            self.close()  # the line may be on the disk without the presenter's knowing: the same trial must not be written twice
            raise

    def event(self, code: str | int, *, at: Marker | None = None, **more: Any) -> int | None:
        """Writes an event of the present trial at once. at: a device or a Sim, which marks a tick with the code, a number; the tick is in the line, and
        returned: session.event(7, at=device). For what happened elsewhere, Ticks.mark() tells the tick within bounds: session.event("touch",
        **ticks.mark())."""
        record = {"event": code, "trial": self._presenter.number, "run": self._run, "utc_s": round(time.time(), 3)}
        if clash := (record.keys() | {"condition", "opened"} | ({"tick"} if at is not None else set())) & more.keys():
            raise ValueError(f"these names are taken: {', '.join(sorted(clash))}")
        text = _text_of({**record, **more})
        if at is None:
            self._append(text)
            return None
        if isinstance(code, str):
            raise ValueError(f"a device marks a tick with a number, not with '{code}'")
        self._check_open()
        tick = at.event(code)
        self._append(_text_of({**record, "tick": tick, **more}))
        return tick

    def _check_open(self) -> None:
        if self._file < 0:
            raise ValueError("the session is closed: open it again to go on")

    def _append(self, text: str) -> None:
        """Writes a line. Where that does not succeed the session is closed."""
        self._check_open()
        rest, size = (text + "\n").encode(), os.fstat(self._file).st_size
        try:
            try:
                while rest:
                    rest = rest[os.write(self._file, rest) :]
                os.fsync(self._file)
            except OSError:
                os.ftruncate(self._file, size)  # no part of a line; the trial comes again when the file is opened
                raise
            self._keep(json.loads(text))
        except BaseException:
            self.close()
            raise

    def _keep(self, line: dict[str, Any]) -> None:
        if "event" in line:
            self.events.append(line)
        elif "condition" in line:
            self.records.append(line)

    def _open(self) -> None:
        lines, good, torn = self._read()
        header = self.experiment.header()
        if not lines:
            if not (_text_of(header) + "\n").encode().startswith(torn.rstrip(b"\0")):
                raise FileError(f"{self.path} is no file of an experiment")
            self._drop(good, torn)
            self._append(_text_of(header))
            folder = os.open(self.path.parent, os.O_RDONLY | os.O_DIRECTORY)
            os.fsync(folder)  # the name of the new file, too
            os.close(folder)
            return
        if lines[0] != header:
            others = [key for key in header if not isinstance(lines[0], dict) or lines[0].get(key) != header[key]]
            raise FileError(f"{self.path} is of another experiment: {', '.join(others)} {'differs' if len(others) == 1 else 'differ'}")
        for number, line in enumerate(lines[1:], 2):
            self._replay(line, number)
        self._drop(good, torn)
        self._run = 1 + sum("opened" in line for line in lines)
        self._append(_text_of({"opened": self._run, "utc_s": round(time.time(), 3)}))

    def _read(self) -> tuple[list[Any], int, bytes]:
        data = bytearray()
        while part := os.pread(self._file, 1 << 20, len(data)):
            data += part
        return _lines_of(bytes(data), self.path)

    def _drop(self, good: int, torn: bytes) -> None:
        """Only from a file that has proved to be this experiment's."""
        if torn:
            self._notice(f"{self.path}: its last line was cut off ({len(torn)} bytes). It is dropped; its trial is presented again")
            os.ftruncate(self._file, good)
            os.fsync(self._file)

    def _notice(self, text: str) -> None:
        self.notices.append(text)
        warnings.warn(text, stacklevel=4)

    def _replay(self, line: Any, number: int) -> None:
        if not {"event", "opened", "condition"} & _record(line, number, self.path).keys():
            raise FileError(f"{self.path}:{number} is no line of an experiment")
        self._keep(line)
        if "event" in line or "condition" not in line:
            return
        trial = self._presenter.next()
        if trial is None or not _same_trial(line, _line_of(trial)) or not isinstance(line.get("answer"), bool):
            raise FileError(f"{self.path}:{number} is not the trial that this experiment presents there")
        self._presenter.answer(trial, line["answer"])


def _line_of(trial: Trial) -> dict[str, Any]:
    return {"trial": trial.number, "seed": trial.seed, "condition": trial.condition, "level": trial.level, "comparison_first": trial.comparison_first}


def _same_trial(line: dict[str, Any], expected: dict[str, Any]) -> bool:
    """Levels may differ in their last bits: another machine's exp() rounds in its own way."""
    found = {key: line.get(key) for key in expected}
    level = found.pop("level")
    return isinstance(level, float) and math.isclose(level, expected["level"], rel_tol=1e-9) and found == {
        key: value for key, value in expected.items() if key != "level"}


def read_trials(path: str | os.PathLike[str]) -> list[dict[str, Any]]:
    """The trials of a file, for an analysis: a dictionary each. A last line that was cut off is left out, and the file left as it is."""
    lines, _, _ = _lines_of(Path(path).read_bytes(), path)
    records = [_record(line, number, path) for number, line in enumerate(lines, 1)]
    return [record for record in records if "condition" in record and "event" not in record]


def _lines_of(data: bytes, path: str | os.PathLike[str]) -> tuple[list[Any], int, bytes]:
    """The lines, how many bytes they are, and what is left of a last one that was cut off."""
    *complete, torn = data.split(b"\n")
    lines: list[Any] = []
    good = 0
    for number, text in enumerate(complete, 1):
        try:
            lines.append(json.loads(text))
        except ValueError:
            if number < len(complete) or torn:
                raise FileError(f"{path}:{number} is damaged") from None
            torn = text + b"\n"
            break
        good += len(text) + 1
    return lines, good, torn


def _record(line: Any, number: int, path: str | os.PathLike[str]) -> dict[str, Any]:
    if not isinstance(line, dict):
        raise FileError(f"{path}:{number} is no line of an experiment")
    return line


def _text_of(line: Mapping[str, Any]) -> str:
    """A line as JSON, also of numpy's numbers and arrays."""
    try:
        return json.dumps(line, separators=(",", ":"), allow_nan=False, default=of_numpy)
    except (TypeError, ValueError):
        if len(line) > 1:
            for key, value in line.items():
                _text_of({key: value})  # raises for the one that it is
        raise ValueError(f"{line} cannot be in the file of a session: give what JSON has (finite numbers, texts, true, false, None, lists and "
                         "dictionaries with texts as keys), or numpy's numbers and arrays") from None

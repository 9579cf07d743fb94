"""The file of a session: killed, cut off, damaged, of another experiment; and orders, seeds and balance."""

import itertools
import math
import os
import random
import shutil
import signal
import tempfile
import time
import unittest
import warnings
from collections import Counter
from pathlib import Path
from unittest import mock

import numpy as np
import thimble
from thimble.experiment import (ConstantStimuli, Experiment, FileError, Quest, Session, Staircase, derive_seed, latin_square, order_for, read_trials,
                                shuffled, shuffled_blocks)

MEMORY = "/dev/shm"  # a kill leaves the same there as on a disk, whose fsync takes milliseconds


def experiment(seed=3, **others):
    conditions = {"stairs": lambda _: Staircase(0.4, [1.5, 1.25], down=2, log=True, reversals=12, most_trials=40),
                  "quest": lambda _: Quest(0.2, sd=0.4, trials=30),
                  "levels": lambda method_seed: ConstantStimuli([0.1, 0.2, 0.3], 10, method_seed)}
    return Experiment("three methods", conditions, seed, settings={"standard": 1.5}, **others)


def answer(trial):
    return trial.random().random() < 0.5 + 0.5 * min(trial.level / 0.4, 1)


def run(path, what, pause_s=None, trials=None):
    with Session(path, what) as session:
        for trial in itertools.islice(session, trials):
            session.event("shown", tick=17 * trial.number)
            if pause_s:
                time.sleep(pause_s)
            session.answer(answer(trial))
    return session


def without_times(trials):
    return [{key: value for key, value in trial.items() if key not in ("utc_s", "run")} for trial in trials]


class Files(unittest.TestCase):
    def setUp(self):
        self.folder = Path(tempfile.mkdtemp(prefix="thimble-session-", dir=MEMORY))
        self.addCleanup(shutil.rmtree, self.folder)
        self.file, self.whole_file = self.folder / "p.jsonl", self.folder / "whole.jsonl"

    def whole(self):
        whole = run(self.whole_file, experiment())
        self.assertTrue(whole.done)
        self.assertGreater(len(whole.records), 80)
        self.assertEqual(read_trials(self.whole_file), whole.records)
        return whole

    def test_killed_at_any_moment(self):
        """SIGKILL when the file has grown by a random number of bytes, and a random moment later, again and again, until a run ends by itself:
        each trial is in the file once, and all are as in a run that was not disturbed."""
        whole, draw, kills = self.whole(), random.Random(5), 0

        def size():
            return self.file.stat().st_size if self.file.exists() else 0

        while True:
            child = os.fork()
            if child == 0:
                try:
                    with warnings.catch_warnings():
                        warnings.simplefilter("ignore")
                        run(self.file, experiment(), pause_s=0.0005)
                    os._exit(0)
                except BaseException:
                    os._exit(1)
            until = size() + draw.randrange(2500)
            while size() < until and os.waitid(os.P_PID, child, os.WEXITED | os.WNOWAIT | os.WNOHANG) is None:
                time.sleep(0.0002)
            time.sleep(draw.uniform(0, 0.002))
            os.kill(child, signal.SIGKILL)
            ended = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
            if ended == 0:
                break
            self.assertEqual(ended, -signal.SIGKILL)
            kills += 1
        trials = read_trials(self.file)
        runs = len({trial["run"] for trial in trials})
        print("[ figure ] %d kills; %d trials, from %d runs" % (kills, len(trials), runs))
        self.assertGreater(kills, 5)
        self.assertGreater(runs, 3)
        self.assertEqual([trial["trial"] for trial in trials], list(range(len(whole.records))))
        self.assertEqual(without_times(trials), without_times(whole.records))

    def test_a_last_line_cut_off_at_any_byte(self):
        whole = self.whole()
        data = self.whole_file.read_bytes()
        ends = [i + 1 for i, byte in enumerate(data) if byte == ord("\n")]
        last = ends[20]  # an answer
        for cut in range(ends[19] + 1, last):
            self.file.write_bytes(data[:cut])
            self.assertEqual(len(read_trials(self.file)), 9, "for an analysis")
            with self.assertWarnsRegex(UserWarning, r"p.jsonl: its last line was cut off \(%d bytes\)" % (cut - ends[19])):
                session = Session(self.file, experiment())
            self.assertEqual(len(session.notices), 1)
            self.assertEqual(len(session.records), 9)
            session.close()
            self.assertTrue(self.file.read_bytes().startswith(data[: ends[19]] + b'{"opened":1,'))
        resumed = run(self.file, experiment())
        self.assertEqual(without_times(resumed.records), without_times(whole.records))
        for cut in (1, ends[0] - 1):  # the experiment itself
            self.file.write_bytes(data[:cut])
            with self.assertWarns(UserWarning):
                Session(self.file, experiment()).close()
            self.assertEqual(self.file.read_bytes(), data[: ends[0]])
        self.file.write_bytes(data[:last] + b"\0" * 512)  # what a file system may leave after a power cut
        with self.assertWarns(UserWarning), Session(self.file, experiment()) as session:
            self.assertEqual(len(session.records), 10)

    def test_a_pause_and_the_events(self):
        whole = self.whole()
        for trials in (1, 0, 7, 30):
            self.assertFalse(run(self.file, experiment(), trials=trials).done)
        session = run(self.file, experiment())
        self.assertEqual(session.notices, [])
        self.assertEqual(without_times(session.records), without_times(whole.records))
        self.assertEqual([record["run"] for record in session.records][:8], [0] + 7 * [2])
        self.assertEqual([(event["trial"], event["tick"]) for event in session.events], [(i, 17 * i) for i in range(len(whole.records))])
        for name, method in session.methods.items():
            if name != "levels":
                self.assertEqual(method.threshold(), whole.methods[name].threshold())
        before = self.file.read_bytes()
        self.assertEqual(list(run(self.file, experiment())), [])
        self.assertTrue(self.file.read_bytes().startswith(before))

    def test_what_is_not_continued(self):
        self.whole()
        data = self.whole_file.read_bytes()
        for other, named in ((experiment(seed=4), "seed, methods differ"), (experiment(participant=1), "participant, methods differ"),
                             (experiment(blocked=True), "blocked differs")):
            with self.assertRaisesRegex(FileError, named):
                Session(self.whole_file, other)
        self.assertEqual(self.whole_file.read_bytes(), data, "left as it was")
        lines = data.split(b"\n")
        damaged = (b"\n".join(lines[:5] + [lines[5][:-3]] + lines[6:]), ":6 is damaged"), \
            (b"\n".join(lines[:2] + lines[3:]), ":4 is not the trial"), \
            (b"\n".join(lines[:3] + lines[2:]), ":4 is not the trial"), \
            (data.replace(b'"level":0.4', b'"level":0.5', 1), " is not the trial"), \
            (b"\n".join(lines[:3] + [b"[]"] + lines[3:]), ":4 is no line"), \
            (b"[]\n", "of another experiment"), \
            (b'{"precious":[1,2,3]}', "is no file of an experiment"), \
            (b"notes\n", "is damaged|is no file of an experiment")
        for text, named in damaged:
            self.file.write_bytes(text)
            with self.assertRaisesRegex(FileError, named):
                Session(self.file, experiment())
            self.assertEqual(self.file.read_bytes(), text)
        self.file.write_bytes(data[:-3])
        with self.assertRaisesRegex(FileError, "seed, methods differ"):
            Session(self.file, experiment(seed=4))
        self.assertEqual(self.file.read_bytes(), data[:-3], "a cut off one of another experiment, too")
        with Session(self.folder / "open.jsonl", experiment()), self.assertRaisesRegex(FileError, "open in another program"):
            Session(self.folder / "open.jsonl", experiment())

    def test_a_disk_that_is_full(self):
        """A line that could not be written whole leaves nothing, and the session ends; the trial comes again."""
        written = os.write

        def fills(file, data):
            if len(data) < 60:
                raise OSError(28, "no space")
            return written(file, data[: len(data) - 30])

        for fails in ("write", "fsync"):
            self.file.unlink(missing_ok=True)
            session = Session(self.file, experiment())
            trials = iter(session)
            next(trials)
            session.answer(True, felt=np.float32(1.5), rows=np.arange(3))
            before = self.file.read_bytes()
            next(trials)
            how = {"write": fills, "fsync": OSError(5, "input/output error")}[fails]
            with mock.patch("os." + fails, side_effect=how), self.assertRaises(OSError):
                session.answer(False)
            self.assertEqual(self.file.read_bytes(), before)
            with self.assertRaisesRegex(ValueError, "closed"):
                session.answer(False)
            self.assertEqual(len(run(self.file, experiment(), trials=1).records), 2)

    def test_ctrl_c_while_an_answer_is_written(self):
        """Wherever it comes, the session is closed, and goes on with the same file: a line that is on the disk counts, once."""
        whole, fsync, write = self.whole(), os.fsync, os.write

        def after(call):
            def interrupted(*arguments):
                call(*arguments)
                raise KeyboardInterrupt
            return interrupted

        for what, how, kept in (("os.fsync", after(fsync), 2), ("os.write", after(write), 2), ("os.fsync", KeyboardInterrupt, 2),
                                ("os.write", lambda file, data: after(write)(file, data[:9]), 1), ("os.write", KeyboardInterrupt, 1),
                                ("thimble.experiment.session._Presenter.answer", KeyboardInterrupt, 2)):
            self.file.unlink(missing_ok=True)
            with Session(self.file, experiment()) as session:
                trials = iter(session)
                session.answer(answer(next(trials)))
                trial = next(trials)
                with mock.patch(what, side_effect=how), self.assertRaises(KeyboardInterrupt):
                    session.answer(answer(trial))
                for call in (lambda: session.answer(True), lambda: next(trials), lambda: next(iter(session)), lambda: session.event("late")):
                    with self.assertRaisesRegex(ValueError, "closed: open it again"):
                        call()
            self.assertEqual(len(read_trials(self.file)), kept)
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                self.assertEqual(without_times(run(self.file, experiment()).records), without_times(whole.records))

    def test_what_is_started_can_be_continued(self):
        def make(seed):
            return ConstantStimuli([1, 2], 2, seed)

        other = Experiment("e", {"c": make}, np.int64(7), participant=np.int64(1), settings={"pair": (1, 2), 3: np.float32(0.5)})
        self.assertFalse(run(self.file, other, trials=1).done)
        self.assertTrue(run(self.file, other).done)
        for name, conditions in (("e", {1: make, "1": make}), ("e", {np.int64(2): make}), (("a", "b"), {"c": make})):
            with self.assertRaisesRegex(TypeError, "is no name of an experiment or a condition: give a text"):
                Experiment(name, conditions, 7)
        for participant in (-1, 1.5):
            with self.assertRaisesRegex((TypeError, ValueError), "participant is .*: give a whole number"):
                Experiment("e", {"c": make}, 7, participant=participant)

    def test_a_method_that_is_another_text_in_each_run(self):
        class Own:
            level, done = 1.0, False

            def answer(self, answer):
                pass

        class Random(Own):
            def __repr__(self):
                return f"Random({random.random()})"

        only = Own()
        for make in (lambda _: Own(), lambda _: only, lambda _: Random()):
            with self.assertRaisesRegex(ValueError, r"the method of 'own' is .*: give (Own|Random) a __repr__\(\)"):
                Experiment("e", {"own": make}, 7)

    def test_what_no_file_can_have(self):
        for settings, named in (({"good": 1, "arm": Path("a")}, "'arm': PosixPath"), ({"a": math.nan}, "'a': nan"), ({"a": {1}}, r"'a': \{1\}"),
                                ({"a": np.longdouble(1)}, "'a': ")):
            with self.assertRaisesRegex(ValueError, named + ".* cannot be in the file of a session: give"):
                Experiment("e", {"c": lambda seed: ConstantStimuli([1, 2], 2, seed)}, 7, settings=settings)
        device = mock.Mock(event=mock.Mock(return_value=5))
        with Session(self.file, experiment()) as session:
            before = self.file.read_bytes()
            next(iter(session))
            for call in (lambda: session.answer(True, good=1, x=Path("a")), lambda: session.event("shown", x=Path("a")),
                         lambda: session.event(1, at=device, x=Path("a"))):
                with self.assertRaisesRegex(ValueError, r"^\{'x': PosixPath\('a'\)\} cannot be in the file"):
                    call()
            self.assertEqual(self.file.read_bytes(), before)
            session.answer(True)
        with self.assertRaisesRegex(ValueError, "closed"):
            session.event(1, at=device)
        device.event.assert_not_called()

    def test_what_is_not_a_regular_file(self):
        with self.assertRaisesRegex(FileError, "/dev/null is not a regular file: give"):  # /dev/full, too, which has zeros without end
            Session("/dev/null", experiment())

    def test_a_header_that_cannot_be_written(self):
        with mock.patch("os.fsync", side_effect=OSError(28, "no space")), self.assertRaisesRegex(OSError, "no space"):
            Session(self.file, experiment())
        self.assertEqual(self.file.read_bytes(), b"")

    def test_an_analysis_reads_what_a_session_opens(self):
        run(self.file, experiment(), trials=3)
        with self.file.open("ab") as file:
            file.write(b"\0\0\0\n")
        self.assertEqual(len(read_trials(self.file)), 3)
        with self.assertWarns(UserWarning), Session(self.file, experiment()) as session:
            self.assertEqual(session.records, read_trials(self.file))
        for text, named in ((b"5\n", ":1 is no line of an experiment"), (b"notes\n{}\n", ":1 is damaged")):
            self.file.write_bytes(text)
            with self.assertRaisesRegex(FileError, named):
                read_trials(self.file)

    def test_an_event_with_its_tick(self):
        """The tick that a Sim or a device gives is in the line, and returned."""
        sim = thimble.Sim(thimble.scene("nothing", thimble.plane("floor", normal=[0, 0, 1], offset_m=-0.05, material={"stiffness_N_m": 100})))
        with Session(self.file, experiment()) as session:
            for trial in session:
                sim.step([0, 0, 0], ticks=5)
                self.assertEqual(session.event(trial.number, at=sim, side="left"), 5 * (trial.number + 1))
                session.answer(True)
            with self.assertRaisesRegex(ValueError, "with a number, not with 'shown'"):
                session.event("shown", at=sim)
            with self.assertRaisesRegex(ValueError, "taken: tick"):
                session.event(1, at=sim, tick=3)
            self.assertIsNone(session.event("shown", tick=3))
        with Session(self.file, experiment()) as again:
            self.assertEqual([event["tick"] for event in again.events], [5 * (i + 1) for i in range(len(again.records))] + [3])
            self.assertEqual(again.events[1]["event"], 1)

    def test_what_an_event_may_say(self):
        with Session(self.file, experiment()) as session:
            session.event("shown", side="left", force_N=np.array([0.5, 1.0]))
            for name in ("condition", "opened", "trial", "run", "utc_s"):
                with self.assertRaisesRegex(ValueError, f"these names are taken: {name}"):
                    session.event("shown", **{name: 1})
        self.assertEqual(read_trials(self.file), [])
        self.assertEqual(Session(self.file, experiment()).events[0]["force_N"], [0.5, 1.0])

    def test_what_a_program_forgets(self):
        with Session(self.file, experiment()) as session:
            with self.assertRaisesRegex(ValueError, "no trial waits"):
                session.answer(True)
            trials = iter(session)
            next(trials)
            for name in ("level", "run", "opened"):
                with self.assertRaisesRegex(ValueError, "taken: " + name):
                    session.answer(True, **{name: 1})
            with self.assertRaises(ValueError):
                session.answer(True, reaction_s=float("nan"))
            session.answer(True, reaction_s=0.7)
            next(trials)
            with self.assertRaisesRegex(ValueError, "trial 1 has no answer"):
                next(trials)
        with self.assertRaisesRegex(ValueError, "closed"):
            session.event("late")
        self.assertEqual([trial["reaction_s"] for trial in read_trials(self.file)], [0.7])


class Orders(unittest.TestCase):
    def test_a_latin_square_is_balanced(self):
        for size in range(1, 9):
            rows = latin_square(size)
            self.assertEqual(len(rows), 1 if size == 1 else size * (1 + size % 2))
            for row in rows:
                self.assertEqual(sorted(row), list(range(size)))
            for column in zip(*rows):
                self.assertEqual(set(Counter(column).values()), {len(rows) // size})
            pairs = Counter(pair for row in rows for pair in zip(row, row[1:]))
            self.assertEqual(len(pairs), size * (size - 1))
            self.assertLessEqual(len(set(pairs.values())), 1)
        self.assertEqual([order_for("abcd", participant)[0] for participant in range(5)], list("abcda"))

    def test_orders_are_random_and_fixed_by_their_seed(self):
        self.assertEqual(shuffled("abcdef", 1), shuffled("abcdef", 1))
        counts = Counter("".join(shuffled("abc", derive_seed(8, i))) for i in range(6000))
        self.assertEqual(len(counts), 6)
        self.assertLess(sum((n - 1000) ** 2 / 1000 for n in counts.values()), 20.5, "chi-squared with 5 degrees of freedom, 0.999")
        blocks = shuffled_blocks(range(5), 20, seed=2)
        self.assertTrue(all(sorted(block) == list(range(5)) for block in blocks))
        self.assertGreater(len({tuple(block) for block in blocks}), 15)
        self.assertEqual(derive_seed(3, 0, "trial", 0), 544978389935954017, "files are continued by later versions")
        self.assertNotEqual(derive_seed(1, 23), derive_seed(12, 3))

    def trials(self, **others):
        folder = Path(tempfile.mkdtemp(prefix="thimble-session-", dir=MEMORY))
        self.addCleanup(shutil.rmtree, folder)
        return run(folder / "p.jsonl", experiment(**others)).records

    def test_interleaved(self):
        trials = self.trials()
        for i in range(0, 60, 3):
            self.assertEqual({trial["condition"] for trial in trials[i : i + 3]}, {"stairs", "quest", "levels"})
        self.assertGreater(len({tuple(trial["condition"] for trial in trials[i : i + 3]) for i in range(0, 60, 3)}), 3)
        self.assertEqual(len({trial["seed"] for trial in trials}), len(trials))
        for condition in ("stairs", "quest", "levels"):
            first = [trial["comparison_first"] for trial in trials if trial["condition"] == condition]
            self.assertTrue(all(a != b for a, b in zip(first[::2], first[1::2])), "each pair has both orders")
            self.assertGreater(len(set(first[::2])), 1)

    def test_blocked(self):
        for participant in range(6):
            trials = self.trials(blocked=True, participant=participant)
            order = [condition for condition, _ in itertools.groupby(trial["condition"] for trial in trials)]
            self.assertEqual(order, order_for(["stairs", "quest", "levels"], participant))


if __name__ == "__main__":
    unittest.main()

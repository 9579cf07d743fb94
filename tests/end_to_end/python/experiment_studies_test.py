"""The three studies of docs/examples against simulated observers whose thresholds are known, and live against the simulated device."""

import functools
import importlib
import math
import random
import subprocess
import sys
import tempfile
import time
import unittest
import warnings
from pathlib import Path
from unittest import mock

import numpy as np
import thimble
from thimble.experiment import (ConstantStimuli, Experiment, Observer, Session, Ticks, by_observer, by_observer_at, by_person, friction, intervals,
                                roughness_N, stiffness_N_m)

ROOT = Path(__file__).resolve().parents[3]
sys.path[:0] = [str(ROOT / "tests/end_to_end"), str(ROOT / "docs/examples")]
from rig import PATIENCE_S, Rig  # noqa: E402

stiffness_jnd, friction_discrimination, texture_roughness = map(importlib.import_module, ("stiffness_jnd", "friction_discrimination", "texture_roughness"))
ARM_N_M = thimble.Arm("premium-1.5").limits["tip_stiffness_N_m"]
STROKES = intervals.strokes(seconds=0.2, rest_s=0.25)
PRESSES = intervals.presses(seconds=0.3, rest_s=0.3)


WEBER = (0.05, 0.15)


def measured(material, measure, path):
    """What an observer without noise feels of a material."""
    return measure(intervals.halves(intervals.simulated(intervals.side_by_side(material, material), path, rate_Hz=1000))[0])


class Rendered(unittest.TestCase):
    def test_what_is_felt_in_closed_form(self):
        for ordered in (380, 500, 640):  # the block and the arm itself are springs in series
            felt = measured(stiffness_jnd.material(ordered), stiffness_N_m, PRESSES)
            self.assertAlmostEqual(felt * (1 / ordered + 1 / ARM_N_M), 1, delta=0.01)
        for coefficient in (0.3, 0.42):
            self.assertAlmostEqual(measured(friction_discrimination.material(coefficient), friction, STROKES), coefficient, delta=0.001)
        low, high = (measured(texture_roughness.material(height), roughness_N, STROKES) for height in (0.0002, 0.0003))
        self.assertAlmostEqual(high / low, 1.5, delta=0.1)

    def test_left_and_right(self):
        scene = intervals.side_by_side(stiffness_jnd.material(400), stiffness_jnd.material(600))
        left, right = intervals.halves(intervals.simulated(scene, PRESSES))
        self.assertGreater(min(len(left), len(right)), 500)
        self.assertAlmostEqual(stiffness_N_m(right) / stiffness_N_m(left), (1 / 400 + 1 / ARM_N_M) / (1 / 600 + 1 / ARM_N_M), delta=0.02)
        with self.assertRaises(ValueError):  # what is looked up is not written
            intervals.simulated(scene, PRESSES)["force_N"][0] = 0

    def test_scenes_with_the_numbers_that_compile_takes(self):
        """numpy's, which are felt, saved and sent as Python's; what is no number is told as of the dict that was given."""
        scene = intervals.side_by_side({"stiffness_N_m": np.int64(400)}, {"stiffness_N_m": np.float32(600)})
        plain = intervals.side_by_side({"stiffness_N_m": 400}, {"stiffness_N_m": 600})
        felt = intervals.simulated(scene, PRESSES, rate_Hz=1000)
        self.assertEqual(felt.tobytes(), intervals.simulated(plain, PRESSES, rate_Hz=1000).tobytes())
        with_arm = np.column_stack([PRESSES, np.zeros(len(PRESSES))])
        self.assertEqual(felt.tobytes(), intervals.simulated(plain, with_arm, rate_Hz=1000).tobytes())
        with tempfile.TemporaryDirectory() as folder:
            self.assertEqual(thimble.compile(intervals.save(scene, Path(folder) / "a.scene.json")), thimble.compile(plain))
        device = mock.Mock(upload=mock.Mock(side_effect=thimble.compile))
        intervals.upload(device, scene)
        device.upload.assert_called_once_with(scene)
        wrong = intervals.side_by_side({"stiffness_N_m": math.nan}, {"stiffness_N_m": 600})
        for call in (lambda: intervals.simulated(wrong, PRESSES), lambda: intervals.upload(device, wrong)):
            with self.assertRaises(thimble.Error) as caught:
                call()
            self.assertRegex(str(caught.exception), "^(?!.*trial.scene.json).*scene: .*stiffness_N_m")

    def test_the_observer_answers_as_often_as_its_formula_says(self):
        observer, draw = Observer(float, 0.15, lapse=0.1), random.Random(4)
        for ratio in (1.0, 1.1, 1.3):
            share = np.mean([observer.first_is_greater(ratio, 1.0, draw) for _ in range(4000)])
            expected = observer.proportion(ratio)
            self.assertLess(abs(share - expected), 3.5 * math.sqrt(expected * (1 - expected) / 4000), ratio)
            self.assertAlmostEqual(observer.ratio(expected), ratio)
        biased = Observer(float, 0.1, bias=0.05)
        self.assertGreater(np.mean([biased.first_is_greater(1.0, 1.0, draw) for _ in range(1000)]), 0.55)


def study(module, seed, weber, path, **rendered):
    """The session of one simulated participant. Its file is in memory: fsync takes longer than the study."""
    with tempfile.TemporaryDirectory(dir="/dev/shm") as folder, Session(Path(folder) / "p.jsonl", module.experiment(seed)) as session:
        module.run(session, by_observer(module.observer(weber), path, rate_Hz=1000, **rendered))
    return session


class Studies(unittest.TestCase):
    """Each study is run with observers of two known Weber fractions. What it finds agrees with the one that answered, and not with the other."""

    def compare(self, name, found, truths):
        """found: by Weber fraction, an array of (estimate, its standard error) for each seed, in logarithms; truths: likewise."""
        (low, high), figures = sorted(truths), []
        for weber in (low, high):
            estimates, told = np.array(found[weber]).T
            error = estimates.std(ddof=1) / math.sqrt(len(estimates))
            off = estimates.mean() - truths[weber]
            figures.append("%.2f: %.3f, found %.3f, +-%.3f of one" % (weber, math.exp(truths[weber]), math.exp(estimates.mean()), estimates.std(ddof=1)))
            self.assertLess(abs(off), 3 * error + self.BIAS, f"{name}, {weber}")
            other = truths[high if weber == low else low]
            self.assertGreater(abs(estimates.mean() - other), 3 * error + self.BIAS, f"{name}: the wrong observer is told apart")
        print("[ figure ] %s: Weber fraction %s" % (name, "; ".join(figures)))

    BIAS = 0.1  # an estimator's own, as a part of the threshold

    def test_stiffness(self):
        """The fit of each seed has the truth within its 99.9 % interval, and the mean of the seeds within 3 standard errors. The observer feels
        the block and the arm in series, so a step of ln(stiffness) is felt as ARM / (STANDARD + ARM) of it."""
        share = ARM_N_M / (stiffness_jnd.STANDARD + ARM_N_M)
        found, truths = {}, {}
        for weber in WEBER:
            truths[weber] = math.log(weber * math.sqrt(2) / share)
            fits = [stiffness_jnd.analyse(study(stiffness_jnd, seed, weber, PRESSES)) for seed in range(12)]
            found[weber] = [(math.log(one.width), one.width_error / one.width) for one in fits]
            for one in fits:
                self.assertLess(abs(one.location), 3.29 * one.location_error + 0.005)
                self.assertLess(abs(math.log(one.width) - truths[weber]), 3.29 * one.width_error / one.width + 0.02)
        self.compare("stiffness, width of the curve", found, truths)

    def test_friction(self):
        for name in ("two down", "weighted"):
            found, truths = {}, {}
            for weber in WEBER:
                observer = friction_discrimination.observer(weber)
                sessions = friction_sessions(weber)
                target = sessions[0].methods[name].target
                truths[weber] = math.log(observer.ratio(target) - 1)
                estimates = [session.methods[name].threshold() for session in sessions]
                found[weber] = [(math.log(at), error / at) for at, error in estimates]
            self.compare("friction, " + name, found, truths)

    def test_texture(self):
        """The roughness that is felt is not quite proportional to the height: the truth is the height at which the felt ratio is that of the
        observer, by interpolation."""
        heights = texture_roughness.STANDARD * (1 + np.linspace(0, 0.6, 13))
        felt = np.array([measured(texture_roughness.material(height), roughness_N, STROKES) for height in heights])
        self.assertTrue((np.diff(felt) > 0).all())
        found, truths = {}, {}
        for weber in WEBER:
            ratio = texture_roughness.observer(weber).ratio(0.75)
            truths[weber] = math.log(np.interp(ratio * felt[0], felt, heights) / texture_roughness.STANDARD - 1)
            estimates = [study(texture_roughness, seed, weber, STROKES).methods["ridges"].threshold() for seed in range(10)]
            found[weber] = [(math.log(at), error / at) for at, error in estimates]
            for at, told in found[weber]:
                self.assertLess(abs(at - truths[weber]), 3.29 * told + self.BIAS)
        self.compare("texture", found, truths)


@functools.lru_cache
def friction_sessions(weber):
    return [study(friction_discrimination, seed, weber, STROKES, ideal=True) for seed in range(10)]


class Examples(Rig):
    def test_they_run_and_continue(self):
        for module, line in ((stiffness_jnd, r"equal at \d+ N/m, standard error \d+\nJND \d+\.\d %"), (friction_discrimination, "two down: 70.7 % correct at"),
                             (texture_roughness, "75 % correct at")):
            command = [sys.executable, "-B", module.__file__, self.folder / (module.__name__ + ".jsonl")]
            first = subprocess.run(command, check=True, capture_output=True, text=True, timeout=240).stdout
            self.assertRegex(first, line)
            if module is texture_roughness:  # all trials are in the file: the result again
                self.assertEqual(subprocess.run(command, check=True, capture_output=True, text=True, timeout=240).stdout, first)
            print("[ figure ] " + first.strip().replace("\n", "; "))


class Live(Rig):
    def device(self, path):
        hand = self.folder / "hand.csv"
        hand.write_text("time_s,x_m,y_m,z_m\n" + "".join("%g,%g,%g,%g\n" % tuple(row) for row in path))
        sim = self.sim("--no-pty", "--tcp", 0, "--hand", hand, "--loop")
        device = thimble.connect(sim.tcp)
        self.addCleanup(device.close)
        return sim, device

    def start(self, device):
        standard = stiffness_jnd.material(stiffness_jnd.STANDARD)
        intervals.upload(device, intervals.side_by_side(standard, standard))
        device.home()
        device.arm()

    def test_an_observer_at_the_device(self):
        """The observer is nearly without noise: it finds each comparison to be what it is, over the link, with no arming in between."""
        path = intervals.presses(seconds=0.3, rest_s=0.1)
        sim, device = self.device(path)
        self.start(device)
        levels = Experiment("live", {"stiffness": lambda seed: ConstantStimuli([300, 800], 3, seed)}, seed=2)
        ticks = Ticks(device)
        with Session(self.folder / "live.jsonl", levels) as session:
            compare = by_observer_at(device, Observer(stiffness_N_m, 0.01), seconds=path[-1, 0] + 0.2)

            def marked(trial, scene):
                session.event("asked", **ticks.mark())
                return compare(trial, scene)

            stiffness_jnd.run(session, marked)
        self.assertEqual(device.info["mode"], "armed")
        self.assertEqual([event["event"] for event in device.audit()].count("armed"), 1)
        device.disarm()
        self.assertEqual(list(session.methods["stiffness"].counts()[1]), [0, 3])
        self.assertEqual({record["first_is_greater"] for record in session.records}, {True, False})
        asked = np.array([event["tick"] for event in session.events])
        within = np.array([event["within_ticks"] for event in session.events])
        self.assertEqual(len(asked), 6)
        self.assertTrue((np.diff(asked) > 0).all())
        self.assertTrue((within >= 20).all(), "records are 40 ticks apart")
        print("[ figure ] events: within %d ticks as median, %d at most" % (np.median(within), within.max()))

    def arm_again(self, device):
        """The fault ends after 0.1 s of the simulator's time, which may be more of this machine's."""
        end_s = time.monotonic() + PATIENCE_S
        while True:
            try:
                device.clear_faults()
                device.arm()
                return
            except thimble.Error:
                if time.monotonic() > end_s:
                    raise
                time.sleep(0.1)

    def test_the_tick_of_an_event(self):
        """A fault of the simulated hardware right after an event latches in a tick within the bounds of the event, whether there are few ticks or
        many between two telemetry records. The simulator may lose 0.1 s against the clock of this machine."""
        sim, device = self.device(intervals.presses())
        self.start(device)
        ticks = Ticks(device)
        for decimation in (4, 4000):
            device.parameters["telemetry_decimation"] = decimation
            time.sleep(0.5)  # the newest of the records that are 1 s apart is then 2000 ticks old
            before = ticks.mark()
            device.inject("drive-fault", for_s=0.1)
            took_ticks = 4000 * (time.monotonic() - before["host_s"])
            self.wait_for_mode(sim.tcp, "faulted")
            after = ticks.mark()
            frozen = self.ok("fault", "list", "--device", sim.tcp, "--json").json["faults"][0]
            latched = max(frame["tick"] for frame in frozen["freeze_frames"])
            self.assertLessEqual(before["tick"] - before["within_ticks"], latched)
            self.assertLessEqual(latched, before["tick"] + before["within_ticks"] + took_ticks + 400)
            self.assertLessEqual(latched, after["tick"] + after["within_ticks"])
            self.assertGreaterEqual(before["within_ticks"], decimation / 2)
            self.assertLess(before["within_ticks"], decimation / 2 + took_ticks + 2)
            print("[ figure ] latched %d ticks after an event known within %d" % (latched - before["tick"], before["within_ticks"]))
            self.arm_again(device)

    def test_a_person(self):
        sim, device = self.device(intervals.presses(seconds=0.2, rest_s=0.1))
        self.start(device)
        asked, said = [], iter(["2", "left", " 1 ", "q"])

        def ask(question):
            asked.append(question)
            return next(said)

        compare = by_person(device, "Which is stiffer?", ask)
        path = self.folder / "person.jsonl"
        with self.assertRaises(KeyboardInterrupt), Session(path, stiffness_jnd.experiment(seed=1)) as session:
            stiffness_jnd.run(session, compare)
        self.assertEqual([record["first_is_greater"] for record in session.records], [False, True])
        self.assertEqual([question.split(":")[0] for question in asked], ["1", "2", "2", "3"])
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            with Session(path, stiffness_jnd.experiment(seed=1)) as again:
                self.assertEqual(next(iter(again)).number, 2)

    def test_a_trial_in_which_the_arm_was_stopped_does_not_count(self):
        sim, device = self.device(intervals.presses(seconds=0.2, rest_s=0.1))
        self.start(device)
        said = ["1", "2"]

        def ask(_):
            if len(said) == 1:
                self.ok("disarm", "--device", sim.tcp)
            return said.pop(0)

        with Session(self.folder / "stopped.jsonl", stiffness_jnd.experiment(seed=1)) as session:
            with self.assertRaises(thimble.Error) as caught:
                stiffness_jnd.run(session, by_person(device, "Which is stiffer?", ask))
        self.assertEqual(caught.exception.name, "not-armed")
        self.assertIn("disarm", caught.exception.cause)
        self.assertEqual(len(session.records), 1)
        with self.assertRaises(thimble.Error):
            by_observer_at(device, Observer(stiffness_N_m, 0.1), 0.1)(None, intervals.side_by_side({"stiffness_N_m": 400}, {"stiffness_N_m": 500}))

    def test_a_hand_that_stays_on_the_block(self):
        sim, device = self.device(np.array([[0, -0.03, 0, -0.018], [0.3, -0.03, 0, -0.025], [100, -0.03, 0, -0.025]]))
        self.start(device)
        while not device.telemetry(0.1)["contacts"].any():
            pass
        with self.assertRaises(TimeoutError):
            intervals.wait_until_free(device, timeout_s=0.3)


if __name__ == "__main__":
    unittest.main()

"""A simulated hand that a program moves step by step, against runs along paths that are known before."""

import sys
import time
import signal
import unittest
from pathlib import Path

import numpy as np
import thimble

ROOT = Path(__file__).resolve().parents[3]
sys.path.insert(0, str(ROOT / "tests/end_to_end"))
from rig import Rig, figure  # noqa: E402


def bench(stiffness_N_m=600):
    wood = thimble.material(stiffness_N_m=stiffness_N_m, damping_N_s_m=1, static_friction=0.5, dynamic_friction=0.3)
    return thimble.scene(
        "bench", thimble.plane("floor", normal=[0, 0, 1], offset_m=-0.01, material=wood),
        thimble.box("block", size_m=[0.02, 0.02, 0.02], position_m=[0.02, 0, 0], material=wood, body=thimble.body(motion="free", mass_kg=0.1)),
        gravity_m_s2=[0, 0, -9.81])


def path_of(start, targets, ticks, rate_Hz):
    """The path that a hand takes which is at each target when the next step begins."""
    return [[0, *start]] + [[(i + 1) * ticks / rate_Hz, *target] for i, target in enumerate(targets)]


class Steps(Rig):
    TARGETS = [[0, 0, -0.012], [0.005, 0, -0.013], [0.012, 0.001, -0.004], [0.02, 0.001, -0.004], [0, 0, 0.01]]

    def test_the_rows_of_simulate(self):
        """Driven along the same path, with and without the arm, the bytes are the same; the row of the path's last time is no step's."""
        for more in ({"ideal": True, "rate_Hz": 1000}, {"rate_Hz": 4000}, {"rate_Hz": 3000, "arm": "wooden", "seed": 7}):
            ticks = int(0.06 * more["rate_Hz"])
            path = path_of([0, 0, 0.01], self.TARGETS, ticks, more["rate_Hz"])
            known = thimble.simulate(bench(), path, **more)
            sim = thimble.Sim(bench(), start_m=[0, 0, 0.01], **more)
            rows = sim.run(self.TARGETS, ticks)
            self.assertEqual(len(rows), ticks * len(self.TARGETS))
            self.assertEqual(rows.tobytes(), known[:-1].tobytes(), more)
            self.assertGreater(rows["force_N"][:, 2].max(), 0.5)
            self.assertGreater(np.ptp(rows["block.position_m"][:, 0]), 1e-3)
            again = thimble.Sim(bench(), start_m=[0, 0, 0.01], **more)
            states = [again.step(target, ticks) for target in self.TARGETS]
            for i, state in enumerate(states):
                self.assertEqual(state.tobytes(), rows[(i + 1) * ticks - 1].tobytes())
            self.assertEqual((again.ticks, again.time_s), (len(rows), len(rows) / more["rate_Hz"]))

    def test_trials(self):
        """The force field of a trial acts from the next tick on; a run with it from the start is that of simulate()."""
        fields = thimble.scene("fields", thimble.force_field("curl", curl_N_s_m=[0, 0, 10], trial=1),
                               thimble.force_field("wind", constant_N=[0, 0, 2], trial=2))
        sim = thimble.Sim(fields, ideal=True, rate_Hz=1000)
        sim.step([0.1, 0, 0], ticks=500)
        for trial, force_N in ((0, [0, 0, 0]), (1, [0, 2, 0]), (2, [0, 0, 2]), (1, [0, 2, 0]), (3, [0, 0, 0])):
            sim.set_trial(trial)
            x_m = 0.1 + 2e-4 * (sim.ticks - 499)
            np.testing.assert_allclose(sim.step([x_m, 0, 0])["force_N"], force_N, atol=2e-3)
        path = path_of([0, 0, 0], [[0.02, 0, 0], [0, 0, 0]], 1200, 4000)
        for trial in (0, 1, 2):
            known = thimble.simulate(fields, path, trial=trial)
            rows = thimble.Sim(fields, trial=trial).run([[0.02, 0, 0], [0, 0, 0]], 1200)
            self.assertEqual(rows.tobytes(), known[:-1].tobytes())
            self.assertEqual(known["force_N"].any(), trial > 0)

    def test_events(self):
        """Each event and each trial has a tick of its own, the next one; what is given before a step is taken in its order."""
        fields = thimble.scene("fields", thimble.force_field("wind", constant_N=[0, 0, 2], trial=2))
        for ideal in (True, False):
            sim = thimble.Sim(fields, ideal=ideal)
            self.assertEqual(sim.event(7), 0)
            sim.step([0, 0, 0], ticks=10)
            self.assertEqual([sim.event(65535), sim.set_trial(2), sim.event(0)], [10, 11, 12])
            rows = sim.run([[0, 0, 0]] * 4)
            np.testing.assert_allclose(rows["force_N"], [[0, 0, 0], [0, 0, 2], [0, 0, 2], [0, 0, 2]], atol=1e-5)
            self.assertEqual((sim.ticks, sim.event(1)), (14, 14))

    def test_whole_numbers(self):
        """Those of numpy are some; others are named, with what is allowed."""
        scene = bench()
        sim = thimble.Sim(scene)
        self.assertEqual((sim.event(np.uint16(1)), sim.set_trial(np.int64(1))), (0, 1))
        path = [[0, 0, 0, 0], [0.01, 0, 0, 0]]
        for named, call in (("trial is 256: .* 0 to 255", lambda: thimble.simulate(scene, path, trial=256)), ("seed is -1", lambda: thimble.Sim(scene, seed=-1)),
                            ("trial is -1", lambda: sim.set_trial(-1)), ("code is 65536: .* 0 to 65535", lambda: sim.event(65536)),
                            ("ticks is 0: .* 1 to ", lambda: sim.step([0, 0, 0], ticks=0)), ("ticks is 1000", lambda: sim.run([[0, 0, 0]], ticks=10**12))):
            with self.assertRaisesRegex(ValueError, named):
                call()
        for call in (lambda: sim.event(1.5), lambda: sim.step([0, 0, 0], ticks=2.0), lambda: sim.set_trial("1")):
            with self.assertRaisesRegex(TypeError, "give a whole number"):
                call()
        self.assertEqual(sim.ticks, 0)

    def test_two_arms(self):
        start = [[-0.02, 0, 0.01], [0.04, 0, 0.01]]
        sim = thimble.Sim(bench(), start_m=start, ideal=True, rate_Hz=1000)
        state = sim.step([[-0.02, 0, -0.012], [0.04, 0, -0.013]], ticks=100)
        self.assertEqual(state["arm"].tolist(), [0, 1])
        state = sim.step([[-0.02, 0, -0.012], [0.04, 0, -0.013]])
        np.testing.assert_allclose(state["tip_m"][:, 2], [-0.012, -0.013], atol=1e-7)
        np.testing.assert_allclose(state["force_N"][:, 2], [1.2, 1.8], atol=0.02)

    def test_a_hand_that_decides(self):
        """It pushes until it feels 1 N, which no path can know: force control in closed form."""
        sim = thimble.Sim(bench(), ideal=True, rate_Hz=1000)
        at = np.zeros(3)
        while (state := sim.step(at))["force_N"][2] < 1 and sim.ticks < 1000:
            at[2] -= 1e-4
        self.assertAlmostEqual(state["tip_m"][2], -0.01 - 1 / 600, delta=4e-4)

    def test_kinetic_energy_in_closed_form(self):
        """A block that falls has gained what gravity gave it; one that turns has the energy of its spin."""
        block = thimble.box("block", size_m=[0.02, 0.04, 0.06], position_m=[0, 0.1, 0.3], rotation_deg=[30, 40, 50], material={"stiffness_N_m": 500},
                            body=thimble.body(motion="free", mass_kg=0.2, spin_rad_s=[0, 0, 5], centre_m=[0.001, 0, 0.002]))
        still = thimble.simulate(thimble.scene("turns", block), [[0, 0, 0, 0], [0.3, 0, 0, 0]], ideal=True)
        falls = thimble.simulate(thimble.scene("falls", block, gravity_m_s2=[0, 0, -9.81]), [[0, 0, 0, 0], [0.1, 0, 0, 0]], ideal=True)
        energy = still["block.kinetic_J"]
        self.assertGreater(energy[0], 1e-4)
        np.testing.assert_allclose(energy, energy[0], rtol=2e-3, err_msg="without a force it stays, whatever axis it turns about")
        gained = falls["block.kinetic_J"] - still["block.kinetic_J"][:len(falls)]
        np.testing.assert_allclose(gained[-1], 0.2 * (9.81 * (falls["time_s"][-1] + 1 / 4000))**2 / 2, rtol=0.01)

    def test_material_and_scene_change_between_steps(self):
        for ideal in (True, False):
            sim = thimble.Sim(bench(), arm="premium-1.5-frictionless", ideal=ideal)
            sim.step([-0.04, 0, -0.013], ticks=1200)

            def stiffness():
                """The slope between two depths."""
                rows = sim.run([[-0.04, 0, z_m] for z_m in (-0.014, -0.014, -0.022, -0.022)], ticks=1200)
                self.assertTrue((rows["contacts"] > 0).all())
                shallow, deep = rows[2399], rows[4799]
                return -(deep["force_N"][2] - shallow["force_N"][2]) / (deep["tip_m"][2] - shallow["tip_m"][2])

            def felt(floor_N_m):
                """The encoders are before the arm's compliance: floor and arm are springs in series."""
                return floor_N_m if ideal else 1 / (1 / floor_N_m + 1 / thimble.Arm("premium-1.5-frictionless").limits["tip_stiffness_N_m"])

            np.testing.assert_allclose(stiffness(), felt(600), rtol=0.02)
            sim.set_material("floor", stiffness_N_m=300)
            np.testing.assert_allclose(stiffness(), felt(300), rtol=0.02)
            sim.load(bench(150))
            np.testing.assert_allclose(stiffness(), felt(150), rtol=0.02)
            for floor_N_m in (300, 500, 200):  # no tick between them
                sim.set_material("floor", stiffness_N_m=floor_N_m)
            np.testing.assert_allclose(stiffness(), felt(200), rtol=0.02)
            with self.assertRaisesRegex(ValueError, "other moving objects"):
                sim.load(thimble.scene("empty"))
        sim = thimble.Sim(thimble.compile(bench()), ideal=True)
        with self.assertRaisesRegex(ValueError, "image"):
            sim.set_material("floor", stiffness_N_m=300)

    def test_interrupted_and_on(self):
        """After Ctrl-C the hand stays where it is, and goes on from there."""
        for ideal in (True, False):
            sim = thimble.Sim(bench(), ideal=ideal)
            signal.setitimer(signal.ITIMER_REAL, 0.2)
            before = signal.signal(signal.SIGALRM, signal.default_int_handler)
            with self.assertRaises(KeyboardInterrupt):
                sim.step([0.01, 0, 0.01], ticks=10_000_000)
            signal.signal(signal.SIGALRM, before)
            self.assertGreater(sim.ticks, 1000)
            there = sim.step([-0.01, 0, 0.01], ticks=4000)
            self.assertLess(there["tip_m"][0], 0)
            if ideal:
                np.testing.assert_allclose(sim.step([-0.01, 0, 0.01])["tip_m"], [-0.01, 0, 0.01], atol=1e-7)

    def test_what_is_refused(self):
        sim = thimble.Sim(bench())
        with self.assertRaises(thimble.Error) as caught:
            sim.step([1, 0, 0])
        self.assertEqual(caught.exception.name, "out-of-reach")
        self.assertEqual(sim.ticks, 0)
        for target in ([0, 0], [0, 0, float("nan")], [[0, 0, 0], [0, 0, 0]]):
            with self.assertRaises(ValueError):
                sim.step(target)
        with self.assertRaises(ValueError):
            sim.step([0, 0, 0], ticks=0)
        for more, name in (({"rate_Hz": 10}, "bad-rate"), ({"arm": "octopus"}, "unknown-arm"), ({"start_m": [1, 0, 0]}, "out-of-reach")):
            with self.assertRaises(thimble.Error) as caught:
                thimble.Sim(bench(), **more)
            self.assertEqual(caught.exception.name, name)
        with self.assertRaises(thimble.Error) as caught:
            thimble.Sim(b"no image")
        self.assertEqual(caught.exception.name, "bad-image")

    def test_it_is_faster_than_real_time(self):
        told = []
        for ideal in (False, True):
            sim = thimble.Sim(bench(), arm="premium-1.5-frictionless", ideal=ideal)
            began = time.perf_counter()
            for i in range(2000):
                sim.step([0, 0, 0.005 - 1e-5 * i * 0.8])
            step_s = (time.perf_counter() - began) / 2000
            began = time.perf_counter()
            sim.run(np.tile([0.0, 0.0, -0.011], (4000, 1)))
            told += [1 / step_s, 4000 / (time.perf_counter() - began)]
        figure("steps a second with the arm: %.0f one by one, %.0f by run(); ideal: %.0f, %.0f" % tuple(told))


if __name__ == "__main__":
    unittest.main()

"""The Python package against the simulated device, against the command, and against closed forms."""

import csv
import os
import signal
import subprocess
import sys
import threading
import time
import unittest
from pathlib import Path

import numpy as np
import thimble

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests/e2e"))
from rig import Rig  # noqa: E402

SCENES = ROOT / "scenes"


class Simulate(Rig):
    def test_the_same_as_the_command(self):
        scene, path, log = SCENES / "walls/walls.scene.json", SCENES / "walls/stroke.csv", self.folder / "log.csv"
        self.ok("simulate", scene, "--path", path, "--log", log)
        felt = thimble.simulate(scene, path)
        with open(log) as file:
            rows = list(csv.DictReader(file))
        self.assertEqual(len(felt), len(rows))
        for name, column, axis in (("time_s", "time_s", None), ("force_N", "force_z_N", 2), ("tip_m", "tip_x_m", 0), ("proxy_m", "proxy_z_m", 2),
                                   ("contacts", "contacts", None)):
            ours = felt[name] if axis is None else felt[name][:, axis]
            theirs = np.array([float(row[column]) for row in rows])
            np.testing.assert_allclose(ours, theirs, rtol=1e-8, atol=1e-12, err_msg=name)
        np.testing.assert_array_equal(felt, thimble.simulate(str(scene), str(path)))

    def test_a_plane_in_closed_form(self):
        depth = np.linspace(-0.002, 0.005, 50)
        path = np.column_stack([np.arange(50) * 0.01, np.zeros(50), np.zeros(50), -depth])
        felt = thimble.simulate(self.plane_scene(), path, ideal=True, rate_Hz=1000)
        below = -felt["tip_m"][:, 2]
        damping = np.gradient(below, felt["time_s"])  # bounds what the damper adds
        np.testing.assert_allclose(felt["force_N"][:, 2], 800 * np.maximum(below, 0), atol=0.01 + 5 * abs(damping).max())
        self.assertGreater(felt["force_N"][:, 2].max(), 3.5)
        self.assertEqual(felt["contacts"][0], 0)
        self.assertEqual(felt["contacts"][-1], 1)

    def test_bad_input(self):
        with self.assertRaises(thimble.Error) as caught:
            thimble.simulate(self.folder / "none.scene.json", SCENES / "walls/stroke.csv")
        self.assertEqual(caught.exception.exit_code, 10)
        self.assertTrue(caught.exception.name and caught.exception.cause and caught.exception.remedy)
        scene = SCENES / "walls/walls.scene.json"
        for path in (np.zeros((3, 2)), np.zeros(4), [[0, 0, 0]]):
            with self.assertRaisesRegex(ValueError, "a path has rows of"):
                thimble.simulate(scene, path)
        for path in (np.zeros((0, 4)), [[0, 0, 0, 0], [0, 0, 0, 0]], [[0, 0, 0, float("nan")]], [[0, 0, 0, 0, 7]]):
            with self.assertRaises(thimble.Error) as caught:
                thimble.simulate(scene, path)
            self.assertEqual(caught.exception.name, "bad-path")
        with self.assertRaises(thimble.Error) as caught:
            thimble.simulate(scene, SCENES / "walls/stroke.csv", arm="octopus")
        self.assertEqual(caught.exception.name, "unknown-arm")

    def test_it_can_be_interrupted(self):
        path = [[0, 0, 0, 0.02], [3000, 0, 0, 0.02]]
        threading.Timer(0.5, lambda: os.kill(os.getpid(), signal.SIGINT)).start()
        begin = time.monotonic()
        with self.assertRaises(KeyboardInterrupt):
            thimble.simulate(SCENES / "walls/walls.scene.json", path, ideal=True)
        self.assertLess(time.monotonic() - begin, 5)

    def test_compile(self):
        image = self.folder / "walls.thim"
        self.ok("compile", SCENES / "walls/walls.scene.json", "--output", image)
        ours = thimble.compile(SCENES / "walls/walls.scene.json")
        self.assertEqual(ours, image.read_bytes()[:len(ours)])


class Connect(Rig):
    def test_a_day(self):
        sim = self.sim("--tcp", 0, "--hand", SCENES / "asteroid/stroke.csv", "--loop")
        with thimble.connect(sim.tcp) as device:
            self.assertEqual(device.info["mode"], "disarmed")
            sent = device.upload(SCENES / "asteroid/asteroid.scene.json")
            self.assertGreater(sent["bytes"], 10000)
            self.assertEqual(device.info["scene"], "asteroid")
            device.home()
            device.arm()
            rows = device.telemetry(seconds=3.0)
            self.assertEqual(device.info["mode"], "armed")
            device.disarm()
        self.assertGreater(len(rows), 100)
        self.assertTrue((np.diff(rows["time_s"]) >= 0).all())
        self.assertEqual(rows["tip_m"].shape, (len(rows), 3))
        touching = rows[rows["contacts"] > 0]
        self.assertGreater(len(touching), 20)
        self.assertGreater(np.linalg.norm(touching["force_N"], axis=1).max(), 0.3)
        print("[ figure ] %d rows in 3 s, %.2f N at most" % (len(rows), np.linalg.norm(rows["force_N"], axis=1).max()))
        with self.assertRaisesRegex(ValueError, "closed"):
            device.info

    def test_parameters(self):
        sim = self.sim("--tcp", 0)
        with thimble.connect(sim.tcp) as device:
            self.assertIn("max_force", device.parameters)
            device.parameters["max_force"] = 3.5
            self.assertEqual(device.parameters["max_force"], 3.5)
            with self.assertRaises(KeyError):
                device.parameters["max_farce"]
            with self.assertRaises(thimble.Error) as caught:
                device.parameters["max_force"] = 1000
            self.assertEqual(caught.exception.exit_code, 1)
            self.assertEqual(device.faults, [])

    def test_what_the_device_refuses(self):
        sim = self.sim("--tcp", 0)
        with thimble.connect(sim.tcp) as device:
            with self.assertRaises(thimble.Error) as caught:
                device.arm()
            self.assertEqual((caught.exception.name, caught.exception.exit_code), ("refused", 1))
            self.assertIn("not_homed", caught.exception.cause)

    def test_no_device(self):
        with self.assertRaises(thimble.Error) as caught:
            thimble.connect("tcp:127.0.0.1:1")
        self.assertIn(caught.exception.exit_code, (3, 6))

    def test_a_device_that_goes_away(self):
        sim = self.sim("--tcp", 0)
        device = thimble.connect(sim.tcp, timeout_s=0.5)
        sim.stop()
        with self.assertRaises(thimble.Error) as caught:
            device.info
        self.assertEqual(caught.exception.exit_code, 6)


class Example(Rig):
    def test_the_example_draws_its_curve(self):
        picture = self.folder / "curve.svg"
        subprocess.run([sys.executable, ROOT / "docs/examples/force_curve.py", picture], check=True, cwd=self.folder, timeout=120)
        self.assertIn("Depth / mm", picture.read_text())


if __name__ == "__main__":
    unittest.main()

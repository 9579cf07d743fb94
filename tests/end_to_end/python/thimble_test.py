"""The Python package against the simulated device, against the command, and against closed forms."""

import csv
import json
import os
import signal
import socket
import subprocess
import sys
import threading
import time
import unittest
from pathlib import Path

import numpy as np
import thimble

ROOT = Path(__file__).resolve().parents[3]
sys.path.insert(0, str(ROOT / "tests/end_to_end"))
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

    def test_the_columns_of_the_scene(self):
        """Moving objects, control elements, tissues and bounds: the fields of the array are the columns of the CSV file."""
        for name, ideal, some in (("blocks", True, "near_block.position_m"), ("buttons", False, "click_button.q_m"), ("needle", True, "needle_s_way.depth_m")):
            scene, path, log = SCENES / name / (name + ".scene.json"), SCENES / name / "stroke.csv", self.folder / (name + ".csv")
            self.ok("simulate", scene, "--path", path, "--log", log, "--rate", 1000, *(["--ideal"] if ideal else []))
            felt = thimble.simulate(scene, path, ideal=ideal, rate_Hz=1000)
            self.assertGreater(np.ptp(felt[some]), 1e-3, some)
            flat = [np.atleast_2d(felt[field].T) for field in felt.dtype.names]
            ours = np.vstack(flat[:2] + flat[3:6] + [flat[2]] + flat[6:]).T  # contacts are behind the force in the file
            theirs = np.loadtxt(log, delimiter=",", skiprows=1)
            np.testing.assert_allclose(ours, theirs, rtol=1e-7, atol=1e-12, err_msg=name)

    def test_a_ball_falls_in_closed_form(self):
        ball = {"shape": {"sphere": {"radius_m": 0.005}}, "pose": {"position_m": [0, 0.1, 0.3]}, "material": "wood",
                "body": {"motion": "free", "mass_kg": 0.05}}
        scene = self.folder / "falls.scene.json"
        scene.write_text(json.dumps({"thimble_scene": 1, "name": "falls", "gravity_m_s2": [0, 0, -9.81], "materials": {"wood": {"stiffness_N_m": 500}},
                                     "objects": [{"name": "ball, red", **ball}, {"name": "ball; red", **ball, "pose": {"position_m": [0.1, 0, 0]}}]}))
        felt = thimble.simulate(scene, [[0, 0, 0, 0], [0.1, 0, 0, 0]], ideal=True, rate_Hz=4000)
        after_s = felt["time_s"] + 1 / 4000
        for name, z_m in (("ball__red", 0.3), ("ball__red_2", 0)):
            np.testing.assert_allclose(felt[name + ".position_m"][:, 2], z_m - 9.81 / 2 * after_s**2, atol=2e-4)
            np.testing.assert_allclose(felt[name + ".velocity_m_s"][:, 2], -9.81 * after_s, atol=1e-4)
        self.assertEqual(felt["contact_bound"].max(), 0)

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


class Arms(Rig):
    def test_an_arm_file_and_its_image_are_one_arm(self):
        file, image = ROOT / "arms/falcon.arm.json", self.folder / "falcon.tarm"
        self.ok("model", "compile", file, "--output", image)
        one, other = thimble.Arm(file), thimble.Arm(image)
        shown = self.ok_json("model", "show", file)
        self.assertEqual((one.name, len(one.axes), one.limits["max_force_N"]), ("falcon", 3, np.float32(shown["max_force_N"])))
        self.assertEqual((one.axes, one.limits, one.name), (other.axes, other.limits, other.name))
        for axis, told in zip(one.axes, shown["axes"]):
            self.assertEqual((axis["name"], axis["driven"]), (told["name"], told["driven"]))
            self.assertAlmostEqual(axis["lower"], told["lower_rad"], 6)
        np.testing.assert_allclose(one.tip_m(one.home), 0, atol=1e-7)
        moved = [angle + 0.1 for angle in one.home]
        np.testing.assert_allclose(one.tip_m(moved), other.tip_m(moved), atol=1e-12)

    def test_the_jacobian_is_the_derivative_of_the_tip(self):
        for name in ("premium-1.5", "touch", "falcon", "pantograph", "paddle", "chain-7"):
            arm = thimble.Arm(ROOT / "arms" / (name + ".arm.json"))
            at = np.array(arm.home) + 0.05
            jacobian, step = arm.jacobian(at), 1e-6
            self.assertEqual(jacobian.shape, (3, len(arm.axes)))
            for j in range(len(at)):
                ahead, behind = at.copy(), at.copy()
                ahead[j] += step
                behind[j] -= step
                np.testing.assert_allclose(jacobian[:, j], (arm.tip_m(ahead) - arm.tip_m(behind)) / (2 * step), atol=1e-6, err_msg=name)
            lines = arm.links(at)
            self.assertTrue(all(line.ndim == 2 and line.shape[1] == 3 and len(line) > 1 for line in lines), name)
        np.testing.assert_allclose(lines[-1][-1], arm.tip_m(at), atol=1e-7)

    def test_the_rotation_is_that_of_the_last_link(self):
        rng = np.random.default_rng(3)
        for name in ("touch", "chain-7", "paddle"):
            arm = thimble.Arm(ROOT / "arms" / (name + ".arm.json"))
            seen = []
            for _ in range(5):
                at = [axis["lower"] + rng.uniform(0.3, 0.7) * (axis["upper"] - axis["lower"]) for axis in arm.axes]
                rotation, line = arm.rotation(at), arm.links(at)[-1]
                np.testing.assert_allclose(rotation @ rotation.T, np.eye(3), atol=1e-6)  # the numbers of an image are float
                self.assertAlmostEqual(np.linalg.det(rotation), 1, 5)
                last = next(line[-1] - point for point in reversed(line) if np.linalg.norm(line[-1] - point) > 1e-3)
                seen.append((rotation.T @ last, last))
            for in_link, _ in seen:
                np.testing.assert_allclose(in_link, seen[0][0], atol=1e-6, err_msg=name)
            self.assertGreater(np.linalg.norm(seen[0][1] - seen[1][1]), 1e-3, "it turns in the world")

    def test_walls_of_the_file(self):
        arm = json.loads((ROOT / "arms/paddle.arm.json").read_text())
        arm["limits"]["largest_walls"] = [{"rate_Hz": 4000, "damping_N_s_m": 1, "stiffness_N_m": 640}]
        file = self.folder / "own.arm.json"
        file.write_text(json.dumps(arm))
        self.assertEqual(thimble.Arm(file).limits["largest_walls"], [(4000, 1, 640)])
        self.assertEqual(thimble.Arm(ROOT / "arms/paddle.arm.json").limits["largest_walls"], [])

    def test_simulate_with_an_arm(self):
        scene, log = self.plane_scene(offset_m=-0.004), self.folder / "log.csv"
        path = self.folder / "down.csv"
        path.write_text("time_s,x_m,y_m,z_m\n0,0,0,0\n0.1,0,0,-0.01\n0.2,0,0,-0.01\n")
        file = ROOT / "arms/falcon.arm.json"
        felt = thimble.simulate(scene, path, arm=thimble.Arm(file))
        np.testing.assert_array_equal(felt, thimble.simulate(scene, path, arm=file))
        self.ok("simulate", scene, "--path", path, "--arm", file, "--log", log)
        theirs = np.genfromtxt(log, delimiter=",", names=True)
        np.testing.assert_allclose(felt["force_N"][:, 2], theirs["force_z_N"], rtol=1e-7, atol=1e-12)
        self.assertGreater(felt["force_N"][:, 2].max(), 1)
        self.assertGreater(abs(felt["tip_m"] - thimble.simulate(scene, path)["tip_m"]).max(), 1e-6)

    def test_what_is_no_arm(self):
        for arm, name in (("octopus", "unknown-arm"), (self.folder / "none.tarm", "unknown-arm")):
            with self.assertRaises(thimble.Error) as caught:
                thimble.Arm(arm)
            self.assertEqual((caught.exception.name, caught.exception.exit_code), (name, 2))
        bad = self.folder / "bad.tarm"
        bad.write_bytes(b"no arm")
        with self.assertRaises(thimble.Error) as caught:
            thimble.Arm(bad)
        self.assertEqual((caught.exception.name, caught.exception.exit_code), ("bad-arm-image", 10))
        arm = thimble.Arm("premium-1.5")
        for axes in ([0, 0], [0, 0, 0, 0], [float("nan"), 0, 0]):
            with self.assertRaises(ValueError):
                arm.tip_m(axes)


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
            audit = device.audit()
        self.assertEqual([entry["event"] for entry in audit], ["start", "scene", "homing", "armed", "disarmed"])
        self.assertTrue(audit[3]["text"].endswith("python") and "@" in audit[3]["text"], audit)
        self.assertEqual((audit[1]["value"], audit[4]["text"], audit[0]["text"]), (sent["crc"], audit[3]["text"], "power_on"))
        self.assertLess(abs(audit[3]["utc_s"] - time.time()), 60)
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
            for value in (1.5, -1, 256, float("nan"), 1e20):
                with self.assertRaises(thimble.Error) as caught:
                    device.parameters["trial"] = value
                self.assertEqual(caught.exception.name, "bad-value")
                self.assertIn("is not a value of trial: a whole number from 0 to 255", caught.exception.cause)
            for seconds in (float("nan"), -1, 1e20):
                for call in (device.telemetry, device.next_tip, lambda seconds: thimble.connect(sim.tcp, timeout_s=seconds)):
                    with self.assertRaisesRegex(ValueError, "give seconds from 0"):
                        call(seconds)
            for call, value in ((device.event, 65536), (device.set_trial, 256), (device.event, -1)):
                with self.assertRaisesRegex(ValueError, "give a whole number from 0 to "):
                    call(value)
            self.assertEqual(device.faults, [])

    def test_stop(self):
        sim = self.sim("--tcp", 0)
        with thimble.connect(sim.tcp) as device:
            device.stop()
            self.assertEqual(device.info["fault"], "host_stop")

    def test_a_program_that_has_read_nothing_for_long(self):
        """The board has closed its channel: it stops and disarms nevertheless."""
        for verb in ("stop", "disarm"):
            sim = self.sim("--no-pty", "--tcp", 0)
            with thimble.connect(sim.tcp) as device:
                device.upload(self.plane_scene(offset_m=-0.01))
                device.stop()
                with socket.create_connection(("127.0.0.1", sim.port)) as other:
                    other.sendall(b"S8\rO\r")
                    heard = 0
                    while heard < 8_000_000:  # each hears the answers to all: the ticks before the fault, again and again
                        other.sendall(b"T18DA01F1806190400000EFFCC\r")
                        time.sleep(0.003)
                        other.sendall(b"T18DA01F18300000CCCCCCCCCC\r")
                        time.sleep(0.003)
                        heard += len(other.recv(1 << 20))
                self.ok("fault", "clear", "--device", sim.tcp)
                self.ok("home", "--device", sim.tcp)
                self.ok("arm", "--device", sim.tcp)
                getattr(device, verb)()
                self.assertEqual(device.info["stopped_by"], verb)

    def test_an_interrupt_ends_homing(self):
        sim = self.sim("--no-pty", "--tcp", 0, "--senses", "index")
        with thimble.connect(sim.tcp) as device:
            device.inject("index-missing")
            began = time.monotonic()
            threading.Timer(0.5, os.kill, (os.getpid(), signal.SIGINT)).start()
            with self.assertRaises(KeyboardInterrupt):
                device.home()
            self.assertLess(time.monotonic() - began, 3)
            self.assertEqual(device.info["mode"], "disarmed")

    def test_what_the_device_refuses(self):
        sim = self.sim("--tcp", 0)
        with thimble.connect(sim.tcp) as device:
            with self.assertRaises(thimble.Error) as caught:
                device.arm()
            self.assertEqual((caught.exception.name, caught.exception.exit_code), ("refused", 1))
            self.assertIn("not_homed", caught.exception.cause)

    def test_faults_of_the_simulated_hardware(self):
        sim = self.sim("--tcp", 0)
        with thimble.connect(sim.tcp) as device:
            self.assertIsNone(device.info["stopped_by"])
            device.upload(self.plane_scene(offset_m=-0.02))
            device.home()
            for fault, stopped_by, named in (("dead-man", "dead_man", []), ("drive-fault", "fault", ["drive_fault"])):
                device.arm()
                device.inject(fault, for_s=0.2)
                self.wait_for_mode(sim.tcp, "faulted" if named else "ready")
                self.assertEqual(device.info["stopped_by"], stopped_by)
                self.assertEqual(device.faults, named)
                time.sleep(0.3)
            device.clear_faults()
            device.arm()
            device.inject("encoder-slip", joint=1, value=500)
            self.wait_for_mode(sim.tcp, "faulted")
            self.assertEqual(device.faults, ["encoder_jump"])
            with self.assertRaisesRegex(KeyError, "there is no fault 'encoder-mad'"):
                device.inject("encoder-mad")
            with self.assertRaises(ValueError):
                device.inject("encoder-dead", joint=255)
            for absent in {"joint": 3}, {"arm": 1}:
                with self.assertRaises(thimble.Error) as caught:
                    device.inject("encoder-dead", **absent)
                self.assertEqual((caught.exception.name, caught.exception.exit_code), ("refused", 1))

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


class HostRendering(Rig):
    def pressed_sim(self):
        hand = self.folder / "press.csv"
        hand.write_text("time_s,x_m,y_m,z_m\n0,0,0,0\n0.5,0,0,-0.02\n1.0,0,0,-0.02\n1.5,0,0,0\n")
        return self.sim("--tcp", 0, "--hand", hand, "--loop")

    def test_a_wall_of_ones_own(self):
        sim = self.pressed_sim()
        readings = []

        def wall(tip):
            readings.append((tip.tip_m[2], tip.force_N[2], tip.age_s))
            return np.array([0, 0, 300 * max(-0.01 - tip.tip_m[2], 0)])

        with thimble.connect(sim.tcp) as device:
            device.home()
            decimation = device.parameters["telemetry_decimation"]
            device.take_over()
            self.assertEqual(device.parameters["telemetry_decimation"], 4)
            first, before = device.info["tick"], device.orders
            sent = device.render(wall, seconds=4)
            last, after = device.info["tick"], device.orders
            self.assertEqual(device.info["mode"], "armed")
            tip = device.next_tip(timeout_s=5)
            self.assertEqual((tip.tip_m.shape, tip.force_N.shape), ((3,), (3,)))
            device.hand_back()
            self.assertEqual((device.parameters["host_forces"], device.parameters["telemetry_decimation"]), (0, decimation))
        taken = after["taken"] - before["taken"]
        self.assertEqual((taken, after["old"], after["wrong"]), (sent, 0, 0))
        height, force, age_s = np.array(readings).T
        print("[ figure ] %d orders in %d ticks, %.0f a second; age of a reading %.2f ms as median; %d times none in time" % (
            taken, last - first, taken / (last - first) * 4000, 1e3 * np.median(age_s), after["expired"]))
        self.assertGreater(taken, 400)
        self.assertLess(np.median(age_s), 0.01)
        deep = -0.01 - height > 0.0005
        self.assertGreater(deep.sum(), 50)
        slope = (force[deep] * (-0.01 - height[deep])).sum() / ((-0.01 - height[deep]) ** 2).sum()
        self.assertAlmostEqual(slope, 300, delta=15)

    def test_other_threads_run_while_one_waits(self):
        sim = self.sim("--tcp", 0)
        with thimble.connect(sim.tcp) as device:
            device.home()
            device.take_over(readings_per_s=0.1)  # as good as none
            counted, done = [0], threading.Event()

            def count():
                while not done.is_set():
                    counted[0] += 1

            counter = threading.Thread(target=count)
            counter.start()
            before = counted[0]
            device.next_tip(timeout_s=0.5)
            during = counted[0] - before
            done.set()
            counter.join()
            device.hand_back()
        self.assertGreater(during, 1000)

    def test_what_is_no_force(self):
        sim = self.sim("--tcp", 0)
        with thimble.connect(sim.tcp) as device:
            for force, arm in (([0, 0, float("nan")], 0), ([0, 0, float("inf")], 0), ([0, 0, 1], 1)):
                with self.assertRaises(thimble.Error) as caught:
                    device.order_force(force, arm)
                self.assertEqual(caught.exception.name, "bad-force")
            for force in ([0, 0], 1.0, [[0, 0, 1]]):
                with self.assertRaisesRegex(ValueError, "three numbers"):
                    device.order_force(force)
            with self.assertRaises(thimble.Error) as caught:
                device.take_over()
            self.assertIn("not_homed", caught.exception.cause)
            self.assertEqual(device.parameters["host_forces"], 0, "what was refused leaves nothing behind")

    def test_somebody_else_disarms(self):
        sim = self.sim("--tcp", 0)
        with thimble.connect(sim.tcp) as device:
            device.home()
            device.take_over()
            self.ok("disarm", "--device", sim.pty)
            with self.assertRaises(thimble.Error) as caught:
                device.render(lambda tip: [0, 0, 0], seconds=10)
            self.assertEqual(caught.exception.name, "not-armed")


class Example(Rig):
    def test_the_wall_of_the_example(self):
        sim = self.sim("--tcp", 0)
        run = subprocess.run([sys.executable, ROOT / "docs/examples/host_wall.py", sim.tcp, "2"], check=True, capture_output=True, text=True,
                             timeout=60)
        self.assertRegex(run.stdout, r"^\d+ orders/s, \d+ times none in time$")
        print("[ figure ] " + run.stdout.strip())

    def test_the_example_draws_its_curve(self):
        picture = self.folder / "curve.svg"
        subprocess.run([sys.executable, ROOT / "docs/examples/force_curve.py", picture], check=True, cwd=self.folder, timeout=120)
        self.assertIn("Depth / mm", picture.read_text())


if __name__ == "__main__":
    unittest.main()

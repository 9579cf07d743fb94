"""A scan over the link: the simulated device probes a specimen by itself; the scan is interrupted and resumed, and stops when its host is lost."""

import json
import signal
import socket
import time
import unittest

from rig import Rig, figure

STIFFNESS = 400


class Scan(Rig):
    def specimen(self):
        file = self.folder / "specimen.json"
        file.write_text(json.dumps({"thimble_specimen": 1, "origin_m": [-0.05, -0.05, -0.004], "u": [1, 0, 0], "v": [0, 1, 0],
                                    "cell_m": 0.1, "columns": 2, "rows": 2, "stiffness_N_m": [STIFFNESS] * 4}))
        return file

    def plan(self, name="pad", **changes):
        file = self.folder / (name + ".plan.json")
        plan = {"thimble_scan": 1, "name": name, "origin_m": [-0.003, -0.003, -0.004], "u": [1, 0, 0], "v": [0, 1, 0],
                "columns": 2, "rows": 2, "cell_m": 0.006, "clearance_m": 0.002, "depth_m": 0.006, "force_limit_N": 1.0,
                "speed_m_s": 0.03, "friction": False}
        plan.update(changes)
        file.write_text(json.dumps(plan))
        return file

    def device(self):
        """Homed, with nobody at the thimble."""
        sim = self.sim("--tcp", 0, "--no-pty", "--specimen", self.specimen())
        self.ok("home", "--device", sim.tcp)
        return sim

    def wait_for_row(self, log, begin, process):
        end = time.monotonic() + 30
        while not (log.exists() and "\n" + begin in log.read_text()):
            if process.poll() is not None:
                self.fail("the scan ended: " + process.stderr.read())
            self.assertLess(time.monotonic(), end, log.read_text() if log.exists() else "there is no log")
            time.sleep(0.02)

    def test_a_small_grid(self):
        sim = self.device()
        scan = ["scan", self.plan(), "--log", self.folder / "small.csv", "--output", self.folder / "small.scene.json",
                "--device", sim.tcp]
        error = self.fails(1, "moves-not-allowed", *scan, "--resume")
        self.assertIn("hands off", error["remedy"])
        start = time.monotonic()
        result = self.ok_json(*scan, "--resume", "--allow-moves")
        figure("4 points over the link in %.1f s: %s N/m of %d" % (
            time.monotonic() - start, [round(p["stiffness_N_m"]) for p in result["points"]], STIFFNESS))
        for point in result["points"]:
            self.assertAlmostEqual(point["stiffness_N_m"], STIFFNESS, delta=0.05 * STIFFNESS)
            self.assertAlmostEqual(point["height_m"], 0, delta=1e-4)
        self.assertTrue(result["flat"])
        scene = json.loads((self.folder / "small.scene.json").read_text())
        self.assertEqual(scene["objects"][0]["material"]["stiffness_map"]["cell_m"], 0.006)
        # The device is left as it was.
        self.assertIn(self.ok_json("info", "--device", sim.tcp)["state"]["mode"], ("ready", "damping"))
        self.assertEqual(self.ok_json("param", "get", "allow_moves", "--device", sim.tcp)["value"], 0)
        # What was measured is not overwritten; from the whole log the scene comes without a device.
        self.fails(1, "log-exists", *scan)
        sim.stop()
        before = (self.folder / "small.scene.json").read_bytes()
        self.ok(*scan, "--resume")
        self.assertEqual((self.folder / "small.scene.json").read_bytes(), before)

    def test_breaks_off_and_goes_on(self):
        sim = self.device()
        log, scene = self.folder / "broken.csv", self.folder / "broken.scene.json"
        scan = ["scan", self.plan("broken", columns=3), "--log", log, "--output", scene, "--device", sim.tcp, "--allow-moves",
                "--resume"]
        process = self.start(*scan)
        self.wait_for_row(log, "1,press", process)
        process.send_signal(signal.SIGINT)
        _, err = process.communicate(timeout=30)
        self.assertEqual(process.returncode, 1, err)
        self.assertIn("interrupted", err)
        self.assertFalse(scene.exists())
        kept = log.read_text()
        figure("interrupted with %d of 6 points" % kept.count("force_limit"))
        self.assertGreaterEqual(kept.count("force_limit"), 2)
        self.ok(*scan)
        self.assertTrue(log.read_text().startswith(kept))
        self.assertEqual(log.read_text().count("force_limit"), 6)
        self.assertTrue(scene.exists())

    def test_the_arm_stops_when_its_host_hangs(self):
        sim = self.device()
        log = self.folder / "hangs.csv"
        scan = ["scan", self.plan("hangs", speed_m_s=0.002), "--log", log, "--output", self.folder / "hangs.scene.json",
                "--device", sim.tcp, "--allow-moves"]
        process = self.start(*scan)
        self.addCleanup(process.communicate)
        self.addCleanup(process.kill)
        self.wait_for_row(log, "0,press", process)  # not by asking the device: every answered question is a sign of life
        process.send_signal(signal.SIGSTOP)
        self.assertTrue(self.ok_json("info", "--device", sim.tcp)["state"]["flags"]["moves_itself"])
        time.sleep(2)  # silence: a question would be a sign of life
        faults = self.ok_json("fault", "list", "--device", sim.tcp)["faults"]
        self.assertEqual([fault["name"] for fault in faults], ["host_lost"])
        self.assertEqual(self.ok_json("info", "--device", sim.tcp)["state"]["mode"], "faulted")

    def test_killed_it_leaves_no_arm_armed(self):
        """In a move, and before the first one: then no move is under way, which would end without its host."""
        sim = self.device()
        for moment in ("move", "armed"):
            log = self.folder / (moment + ".csv")
            scan = self.start("scan", self.plan(moment, speed_m_s=0.002), "--log", log, "--output", self.folder / (moment + ".scene.json"),
                              "--allow-moves", "--device", sim.tcp)
            if moment == "move":
                self.wait_for_row(log, "0,press", scan)
            else:
                with socket.create_connection(("127.0.0.1", sim.port)) as bus:
                    bus.sendall(b"S8\rO\r")
                    bus.settimeout(20)
                    heard = b""
                    while b"\rt381803" not in heard:  # a status: armed
                        heard = heard[-16:] + bus.recv(4096)
            scan.kill()
            self.wait_for_mode(sim.tcp, "ready", 3)
            self.assertIn("it was disarmed", scan.communicate()[1])
            self.assertEqual(self.ok_json("fault", "list", "--device", sim.tcp)["faults"], [])

    def test_a_curved_specimen(self):
        """A cap of 60 mm with friction, scanned by the simulated arm: the scene is a height field that compiles, and says what was found."""
        n, cell = 31, 0.002
        at = [cell * (i - (n - 1) / 2) for i in range(n)]
        specimen = self.folder / "cap.json"
        specimen.write_text(json.dumps({
            "thimble_specimen": 1, "origin_m": [at[0], at[0], -0.01], "u": [1, 0, 0], "v": [0, 1, 0], "cell_m": cell,
            "columns": n, "rows": n, "stiffness_N_m": [STIFFNESS] * n * n, "damping_N_s_m": 2, "static_friction": 0.5,
            "dynamic_friction": 0.4, "height_m": [(0.06 ** 2 - x * x - y * y) ** 0.5 - 0.06 for y in at for x in at]}))
        plan = self.plan("cap", origin_m=[-0.008, -0.008, -0.01], columns=3, rows=3, cell_m=0.008, clearance_m=0.004,
                         depth_m=0.008, friction=True, friction_sites=1, force_limit_N=2)
        scene = self.folder / "cap.scene.json"
        scan = ["scan", plan, "--simulate", "--specimen", specimen, "--log", self.folder / "cap.csv", "--output", scene]
        result = self.ok_json(*scan)
        figure("cap: %.0f to %.0f N/m, B %.2f, friction %.3f and %.3f, between the points %.3f mm off" % (
            result["min_stiffness_N_m"], result["max_stiffness_N_m"], result["damping"]["damping_N_s_m"],
            result["static_friction"]["coefficient"], result["dynamic_friction"]["coefficient"],
            1e3 * result["shape_check"]["most_m"]))
        self.assertFalse(result["flat"])
        self.assertAlmostEqual(result["static_friction"]["coefficient"], 0.5, delta=0.05)
        self.assertAlmostEqual(result["dynamic_friction"]["coefficient"], 0.4, delta=0.04)
        self.assertAlmostEqual(result["min_stiffness_N_m"], STIFFNESS, delta=0.03 * STIFFNESS)
        self.assertEqual(json.loads(scene.read_text())["objects"][0]["shape"]["height_field"]["file"], "cap.heights.csv")
        self.ok("compile", scene, "--output", self.folder / "cap.image")
        text = self.ok(*scan, "--resume")  # from the whole log
        self.assertIn("static friction: 0.", text.out)

    def test_mistakes(self):
        plan, specimen = self.plan("mistakes"), self.specimen()
        log, scene = self.folder / "mistakes.csv", self.folder / "mistakes.scene.json"
        rest = ["--log", log, "--output", scene]
        self.fails(2, "usage", "scan", plan, "--simulate", *rest)
        self.fails(10, "bad-value", "scan", self.plan("fast", speed_m_s=1), *rest)
        self.fails(10, "bad-specimen", "scan", plan, "--simulate", "--specimen", plan, *rest, "--resume")
        self.fails(10, "wrong-log", "scan", self.plan("other", depth_m=0.005), *rest, "--resume")
        self.fails(3, "no-device", "scan", plan, *rest, "--resume")
        self.assertFalse(scene.exists())
        simulated = self.ok_json("scan", plan, "--simulate", "--specimen", specimen, *rest, "--resume")
        self.assertEqual(len(simulated["points"]), 4)


if __name__ == "__main__":
    unittest.main()

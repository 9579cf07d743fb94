"""thimble commission: a simulated arm is proved and measured, its faults are named, and the work is resumed after each end."""

import fcntl
import json
import os
import shutil
import signal
import subprocess
import tempfile
import time
import unittest
from pathlib import Path

from rig import BIN, PATIENCE_S, Rig

ARMS = Path(__file__).parents[2] / "arms"
UNDER_SANITIZERS = "THIMBLE_UNDER_SANITIZERS" in os.environ
LONG = "all steps take a minute and more there; the long check has commission_test under the sanitizers"


class Commission(Rig):
    def arm(self, name="paddle"):
        """A copy of the quickest arm in a folder of its own."""
        folder = self.runtime / ("arm-%d" % len(list(self.runtime.iterdir())))
        folder.mkdir()
        return Path(shutil.copy(ARMS / (name + ".arm.json"), folder))

    def found(self, fault, *arguments):
        """Ends with a fault that is named: the findings are on stdout, the error is on stderr."""
        result = self.run_thimble("commission", *arguments, "--simulate", "--json")
        self.assertEqual(result.code, 8, result.err)
        error = json.loads(result.err)["error"]
        self.assertEqual((error["name"], error["exit_code"]), ("arm-fault", 8))
        self.assertIn(fault, error["cause"])
        self.assertFalse(result.json["complete"])
        step = result.json["steps"][-1]
        self.assertFalse(step["passed"])
        self.assertEqual(step["findings"][0]["fault"], fault)
        return result.json, step

    @unittest.skipIf(UNDER_SANITIZERS, LONG)
    def test_a_fault_is_named_repaired_and_the_result_is_an_arm(self):
        arm = self.arm()
        given = arm.read_bytes()
        report, result = arm.with_name("paddle.commission.md"), arm.with_name("paddle.commissioned.arm.json")
        document, step = self.found("motor-sign", arm, "--fault", "motor-sign@paddle")
        self.assertEqual((document["next"], step["number"], step["step"]), (5, 5, "motors"))
        self.assertEqual([entry["passed"] for entry in document["steps"]], 5 * [True] + [False])
        self.assertEqual(step["findings"][0]["axis"], "paddle")
        self.assertEqual(step["findings"][0]["corrections"], [{"pointer": "/axes/0/drive/sign", "value": -1}])
        self.assertIsNone(document["arm"])
        self.assertFalse(result.exists())
        self.assertIn("**motor-sign**", report.read_text())

        # The same in words: nothing on stdout, and steps that passed are not done again but for step 2.
        words = self.run_thimble("commission", arm, "--simulate", "--fault", "motor-sign@paddle")
        self.assertEqual((words.code, words.out), (8, ""))
        self.assertIn("The counters have begun anew: step 2 comes again, then step 5.", words.err)
        self.assertIn("step 2 of 10, encoders", words.err)
        self.assertNotIn("step 1 of 10", words.err)
        self.assertIn("remedy: repair it, then give the command again", words.err)

        whole = self.ok("commission", arm, "--simulate")  # it is repaired
        self.assertNotIn("step 4 of 10", whole.err)
        self.assertIn("step 10 of 10", whole.err)
        self.assertIn("paddle: all steps passed, 0 corrections", whole.out)
        self.assertIn("coulomb_N_m", whole.out)
        self.assertEqual(arm.read_bytes(), given)
        self.assertEqual(self.ok_json("model", "check", result)["warnings"], self.ok_json("model", "check", arm)["warnings"])
        measured = json.loads(result.read_text())
        friction = measured["axes"][0]["friction"]["coulomb_N_m"]
        self.assertRegex(friction["by"], r"^simulated commission \d{4}-\d\d-\d\d$")
        self.assertGreater(friction["spread"], 0)
        self.assertNotEqual(friction["value"], 0.004)  # of the file: a guess
        self.assertEqual([(wall["rate_Hz"], wall["damping_N_s_m"]) for wall in measured["limits"]["largest_walls"]],
                         [(4000, 0), (4000, 1), (4000, 2)])
        self.assertIn("| paddle | coulomb_N_m | 0.004 | ", report.read_text())
        self.assertNotIn("FAILED", report.read_text())

        # Another arm than the one that passed.
        self.fails(1, "other-arm", "commission", arm, "--simulate", "--seed", 2)
        self.fails(1, "other-arm", "commission", arm, "--simulate", "--fault", "motor-sign@paddle")

        again = self.ok_json("commission", arm, "--simulate", "--step", 6)
        self.assertTrue(again["complete"])
        self.assertEqual([step["number"] for step in again["steps"]], list(range(11)))
        self.assertEqual(self.ok_json("commission", arm, "--simulate")["steps"], again["steps"])  # nothing is left to do

        document, _ = self.found("motor-sign", arm, "--step", 5, "--fault", "motor-sign@paddle")
        self.assertEqual(document["warnings"], [f"{result} is the result of an earlier run"])

        edited = json.loads(given)
        edited["limits"]["max_force_N"] = 4
        arm.write_text(json.dumps(edited))
        self.fails(10, "arm-changed", "commission", arm, "--simulate")
        self.found("encoder-sign", arm, "--restart", "--fault", "encoder-sign@paddle")

    @unittest.skipIf(UNDER_SANITIZERS, LONG)
    def test_corrections_go_into_the_new_file(self):
        arm = self.arm()
        state = self.runtime / "state.json"
        faults = ("--fault", "encoder-sign@paddle", "--fault", "wrong-counts@paddle:4", "--fault", "motor-sign@paddle")
        self.found("encoder-sign", arm, "--state", state, *faults)
        self.assertFalse(arm.with_name("paddle.commission.json").exists())
        document = self.ok_json("commission", arm, "--state", state, "--simulate", "--accept-corrections", *faults)
        self.assertEqual(document["corrections"], [{"pointer": "/axes/0/encoder/sign", "value": -1},
                                                   {"pointer": "/axes/0/encoder/counts_per_turn", "value": 8192},
                                                   {"pointer": "/axes/0/drive/sign", "value": -1}])
        axis = json.loads(Path(document["arm"]).read_text())["axes"][0]
        self.assertEqual((axis["encoder"]["sign"], axis["encoder"]["counts_per_turn"], axis["drive"]["sign"]), (-1, 8192, -1))
        self.assertIsNone(self.ok_json("model", "check", document["arm"])["commissioned"], "no real arm")
        self.assertIn("`/axes/0/drive/sign` is -1", Path(document["report"]).read_text())

    def test_a_correction_that_the_file_cannot_take_is_not_made(self):
        arm = self.arm("premium-1.5")  # with counters of 16 bits
        document, step = self.found("wrong-counts", arm, "--accept-corrections", "--fault", "wrong-counts@yaw:2")
        self.assertEqual((document["corrections"], step["number"]), ([], 2))
        self.assertIn("half of its counter of 16 bits", step["notes"][-1])

    def ask(self, arm, answers, *arguments):
        return subprocess.run([BIN / "thimble", "commission", arm, "--simulate", "--ask", *arguments], input=answers, text=True,
                              capture_output=True, env=self.environment, timeout=PATIENCE_S)

    def test_a_person_plays_the_builder(self):
        arm = self.arm()
        fault = "--fault", "encoder-sign@paddle"
        stopped = self.ask(arm, "\n\n\nmaybe\n\nq\n", *fault)  # step 0 has three prompts, step 1 one
        self.assertEqual((stopped.returncode, stopped.stdout), (1, ""), stopped.stderr)
        self.assertIn("thimble: interrupted: stopped in step 2; ", stopped.stderr)
        self.assertIn("Press the e-stop.", stopped.stderr)
        self.assertEqual(stopped.stderr.count("[Enter: done, q: stop here]"), 6)
        for answers in "\n", 200 * "x":  # the input ends; it is no person's
            self.assertIn("stopped in step 2; ", self.ask(arm, answers, *fault).stderr)
        # Two prompts for step 2; it is no fault of the file; it is repaired; two prompts again.
        repaired = self.ask(arm, "\n\nn\n\n\n\n", *fault, "--step", "2")
        self.assertEqual(repaired.returncode, 0, repaired.stderr)
        self.assertIn("Is the arm right as it is, and the file wrong?", repaired.stderr)
        self.assertIn("paddle: step 2 passed; the next is 3", repaired.stdout)

    def test_ctrl_c_loses_one_step_at_most(self):
        arm = self.arm("premium-1.5")
        state = arm.with_name("premium-1.5.commission.json")
        process = self.start("commission", arm, "--simulate", "--json")
        deadline = time.monotonic() + 30
        while not state.exists() or '"passed": true' not in state.read_text():
            self.assertLess(time.monotonic(), deadline)
            time.sleep(.02)
        process.send_signal(signal.SIGINT)
        out, err = process.communicate(timeout=30)
        self.assertEqual((process.returncode, out), (1, ""), err)
        self.assertEqual(json.loads(err)["error"]["name"], "interrupted")
        done = json.loads(state.read_text())["steps"]
        self.assertTrue(done["0"]["passed"])
        self.assertEqual(sorted(path.name for path in arm.parent.iterdir()), [arm.name, state.name])

    def refused_loop(self, file, arm):
        file.write_text(json.dumps(arm))
        return self.fails(1, "links-part", "commission", file, "--simulate")

    def held(self, lock):
        """Whether another program holds this lock."""
        if not lock.exists():
            return False
        with lock.open() as file:
            try:
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                return True
        return False

    def test_one_at_a_time_works_with_a_state(self):
        arm = self.arm()
        first = subprocess.Popen([BIN / "thimble", "commission", arm, "--simulate", "--ask"], stdin=subprocess.PIPE,
                                 stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, env=self.environment)
        lock = arm.with_name(".paddle.commission.json.lock")
        deadline = time.monotonic() + 20
        while not self.held(lock):  # that it exists is not enough: it is made first and taken then
            self.assertLess(time.monotonic(), deadline)
            time.sleep(.02)
        error = self.fails(1, "state-in-use", "commission", arm, "--simulate")
        self.assertIn("--state", error["remedy"])
        first.kill()  # dies with its lock file: the next one takes it over
        first.communicate()
        self.assertTrue(lock.exists())
        self.found("line-ignored", arm, "--restart", "--fault", "line-ignored")
        self.assertFalse(lock.exists())

    def test_bad_input(self):
        arm = self.arm()
        self.fails(2, "usage", "commission", "--simulate")
        folded = json.loads((ARMS / "pantograph.arm.json").read_text())
        folded["axes"][1] |= {"home_deg": 105, "upper_deg": 175}
        folded["axes"][0] |= {"home_deg": 139}
        self.assertIn("first", self.refused_loop(arm.with_name("folded.arm.json"), folded)["cause"])
        rail = json.loads(arm.read_text())
        rail["kinematics"]["serial"]["joints"][0] |= {"type": "prismatic", "axis": [1, 0, 0]}
        for end, value in ("lower", -.05), ("upper", .05):
            del rail["axes"][0][end + "_deg"]
            rail["axes"][0][end + "_m"] = value
        sliding = arm.with_name("rail.arm.json")
        sliding.write_text(json.dumps(rail))
        self.found("motor-sign", sliding, "--fault", "motor-sign@paddle")
        self.fails(10, "cannot-read", "commission", "no-such-arm", "--simulate")
        error = self.fails(2, "unknown-fault", "commission", arm, "--simulate", "--fault", "rust@paddle")
        self.assertIn("motor-sign", error["remedy"])
        error = self.fails(2, "unknown-axis", "commission", arm, "--simulate", "--fault", "motor-sign@elbow")
        self.assertIn("paddle", error["remedy"])
        for fault in "motor-sign", "weak-motor@paddle:many", "motors-swapped@paddle,paddle":
            self.fails(2, "bad-fault", "commission", arm, "--simulate", "--fault", fault)
        self.fails(2, "bad-fault", "commission", arm, "--simulate", "--fault", "slip@paddle", "--fault", "slip@paddle:3")
        self.fails(2, "usage", "commission", arm, "--simulate", "--step", 11)
        self.fails(1, "step-order", "commission", arm, "--simulate", "--step", 5)
        for output in arm, arm.with_name("paddle.commission.md"), arm.with_name("paddle.commissioned.arm.json"):
            self.fails(2, "same-file", "commission", arm, "--simulate", "--state", output)
        self.fails(2, "usage", "commission", arm, "--simulate", "--seed", -1)
        self.fails(2, "usage", "commission", arm, "--simulate", "--ask", "--accept-corrections")

    def test_files_that_are_not_its_own(self):
        arm = self.arm()
        state = arm.with_name("paddle.commission.json")
        state.write_text('{"thimble_commission": 1, "name": "paddle"')
        error = self.fails(10, "bad-state", "commission", arm, "--simulate")
        self.assertIn(str(state), error["cause"])
        self.assertIn("--restart", error["remedy"])
        self.found("line-ignored", arm, "--fault", "line-ignored", "--restart")
        damaged = json.loads(state.read_text())
        damaged["steps"]["0"]["findings"][0]["axis"] = 7
        state.write_text(json.dumps(damaged))
        self.fails(10, "bad-state", "commission", arm, "--simulate")
        other = arm.with_name("notes.json")
        other.write_text("mine")
        self.fails(10, "bad-state", "commission", arm, "--simulate", "--state", other, "--restart")
        self.assertEqual(other.read_text(), "mine")
        self.assertFalse(arm.with_name("paddle.commissioned.arm.json").exists())

    def test_a_folder_that_may_not_be_written(self):
        # Root may write everywhere, so the command runs as nobody.
        place = Path(tempfile.mkdtemp(prefix="thimble-nobody-", dir="/tmp"))
        self.addCleanup(shutil.rmtree, place, ignore_errors=True)
        shutil.copy(BIN / "thimble", place)
        shutil.copy(ARMS / "paddle.arm.json", place)
        place.chmod(0o555)
        become = (lambda: os.setuid(65534)) if os.getuid() == 0 else None
        result = subprocess.run([place / "thimble", "commission", place / "paddle.arm.json", "--simulate", "--json"], text=True,
                                capture_output=True, preexec_fn=become, env=self.environment, timeout=PATIENCE_S)
        self.assertEqual((result.returncode, result.stdout), (5, ""), result.stderr)
        self.assertEqual(json.loads(result.stderr)["error"]["name"], "permission")
        # The progress is kept elsewhere; where the result goes is found before the work all the same.
        elsewhere = place.with_name(place.name + "-state.json")
        self.addCleanup(elsewhere.unlink, missing_ok=True)
        result = subprocess.run([place / "thimble", "commission", place / "paddle.arm.json", "--simulate", "--state", elsewhere], text=True,
                                capture_output=True, preexec_fn=become, env=self.environment, timeout=PATIENCE_S)
        self.assertEqual((result.returncode, result.stdout), (5, ""), result.stderr)
        place.chmod(0o755)


    def device(self):
        """A simulated device, and an arm file of its arm. Nobody moves that arm: what can be tried is what needs no hand."""
        return self.sim("--tcp", 0), self.arm("premium-1.5")

    def commission_by(self, answers, *arguments):
        return subprocess.run([BIN / "thimble", "commission", *map(str, arguments)], input=answers, capture_output=True, text=True,
                              env=self.environment, timeout=PATIENCE_S)

    def test_a_line_that_nobody_opened_is_named_on_a_device(self):
        sim, arm = self.device()
        before = self.ok_json("param", "list", "--device", sim.tcp)
        result = self.commission_by("\n\n\nn\n", arm, "--device", sim.tcp)
        self.assertEqual((result.returncode, result.stdout), (8, ""), result.stderr)
        self.assertIn("> Press the e-stop.", result.stderr)
        self.assertIn("! line-ignored: The e-stop", result.stderr)
        self.assertNotIn("! line-ignored: The watchdog", result.stderr)
        info = self.ok_json("info", "--device", sim.tcp)
        self.assertEqual((info["state"]["mode"], info["state"]["fault"]), ("ready", 0))
        self.assertEqual(self.ok_json("param", "list", "--device", sim.tcp), before)

        # The progress is that of this device.
        self.fails(1, "other-arm", "commission", arm, "--simulate")

    def test_it_ends_with_the_motors_off(self):
        sim, arm = self.device()
        result = self.commission_by("q\n", arm, "--device", sim.tcp)
        self.assertEqual(result.returncode, 1, result.stderr)
        self.assertIn("thimble: interrupted: stopped in step 0", result.stderr)
        self.assertEqual(self.ok_json("info", "--device", sim.tcp)["state"]["mode"], "ready")

    def test_what_is_of_a_simulated_arm_only(self):
        arm = self.arm()
        self.fails(2, "usage", "commission", arm, "--fault", "motor-sign@paddle")
        self.fails(2, "usage", "commission", arm, "--simulate", "--device", "tcp:127.0.0.1:1")
        self.fails(3, "no-device", "commission", arm, "--device", "tcp:127.0.0.1:1")

if __name__ == "__main__":
    unittest.main()

"""record, replay, plot and import devicelog: a contact recorded over the link is replayed bit for bit; lost links, corrupt files and
devices that are not ready are reported."""

import csv
import json
import math
import os
import shutil
import signal
import socket
import struct
import subprocess
import time
import unittest
import xml.etree.ElementTree
from pathlib import Path

from rig import BIN, Proxy, Rig, LinkFaults, figure

SCENES = Path(__file__).resolve().parents[2] / "scenes"
SLOW = "THIMBLE_UNDER_SANITIZERS" in os.environ


class RecordingThief(Proxy):
    """Takes one of the recording's frames in 2000, and nothing else."""

    def __init__(self, port):
        super().__init__(port, LinkFaults())

    def relay(self, source, sink):
        rest = b""
        try:
            while data := source.recv(65536):
                *lines, rest = (rest + data).split(b"\r")
                kept = [line + b"\r" for line in lines if not line.startswith(b"t681") or self.random.random() > 0.0005]
                sink.sendall(b"".join(kept))
        except OSError:
            pass


class Record(Rig):
    def touching(self, *arguments, scene=None, seconds=3.0):
        """A simulator whose hand presses on a floor, over and over."""
        hand = self.folder / "press.csv"
        hand.write_text("time_s,x_m,y_m,z_m\n0,0,0,0.004\n0.3,0,0,-0.003\n0.6,0.01,0,-0.003\n0.9,0,0.005,0.004\n1.2,0,0,0.004\n")
        sim = self.sim("--tcp", 0, "--hand", hand, "--loop", *arguments)
        scene = scene or self.plane_scene(offset_m=0.0)
        self.ok("upload", scene, "--device", sim.tcp)
        return sim, scene

    def recorded(self, sim, scene, name="felt.rec", uri=None, seconds=2):
        file = self.folder / name
        file.unlink(missing_ok=True)
        return file, self.ok_json("record", file, "--scene", scene, "--home", "--arm", "--seconds", seconds, "--device",
                                  uri or sim.tcp)

    def test_a_contact_comes_out_again(self):
        sim, scene = self.touching()
        for uri in (sim.tcp, sim.pty):
            with self.subTest(uri=uri):
                file, said = self.recorded(sim, scene, uri=uri)
                # A pty holds 4 kB, 45 ms of a recording: on a machine that is busy its reader may come too late for it.
                if uri == sim.pty and said["missing"] != 0:
                    figure("%d ticks are missing over the pty: the machine is busy" % said["missing"])
                    self.assertNotIn("differs_at", said["replay"])
                    self.assertLess(said["replay"]["exact_to"], said["replay"].get("gap_at", math.inf))  # none: the last ones are missing
                    continue
                self.assertEqual(said["missing"], 0)
                self.assertTrue(said["replay"]["exact"])
                self.assertEqual(said["end"], "stopped")
                self.assertEqual(said["telemetry_every_ticks"], 40)
                log = self.folder / "felt.csv"
                again = self.ok_json("replay", file, "--log", log)
                self.assertTrue(again["exact"])
                self.assertEqual(again["ticks"], said["ticks"])
                self.assertGreaterEqual(again["checks"], again["ticks"] // 16)
                self.assertGreater(again["contact_ticks"], 0 if SLOW else 500)
                self.assertGreater(again["peak_force_N"], 0 if SLOW else 0.5)
                self.assertEqual((again["arms"], again["board"], again["scene"]), (["premium-1.5"], "sim", "floor"))
                figure("%d ticks over %s, %d in contact, %d checks, all the same" %
                       (again["ticks"], uri.split(":")[0], again["contact_ticks"], again["checks"]))
                with log.open(newline="") as rows:
                    self.check_log(list(csv.DictReader(rows)), again)
        self.assertEqual(self.ok_json("info", "--device", sim.tcp)["state"]["mode"], "ready")

    def check_log(self, rows, said):
        self.assertEqual(list(rows[0]), "time_s,arm,tip_x_m,tip_y_m,tip_z_m,proxy_x_m,proxy_y_m,proxy_z_m,force_x_N,force_y_N,"
                         "force_z_N,contacts,sweep_bound,slide_bound,contact_bound,put_off".split(","))
        self.assertEqual(len(rows), said["ticks"])
        middle = len(rows) // 2
        self.assertAlmostEqual(float(rows[middle]["time_s"]), (middle + 1) / 4000, 8)
        # The floor is a plane: its god object is on it, and the force is the spring's once the ramp is over.
        for row in rows:
            if row["contacts"] == "1":
                self.assertAlmostEqual(float(row["proxy_z_m"]), 0, 6)

    def test_events_and_trials(self):
        """The trial is switched, and events are marked, by other programs while a recording runs: it goes on, has each with its tick, and comes out
        again."""
        fields = self.folder / "fields.scene.json"
        fields.write_text(json.dumps({"thimble_scene": 1, "name": "fields", "objects": [
            {"name": "up", "shape": {"force_field": {"constant_N": [0, 0, 1], "trial": 1}}},
            {"name": "curl", "shape": {"force_field": {"curl_N_s_m": [0, 0, 10], "trial": 2}}},
            {"name": "floor", "shape": {"plane": {"normal": [0, 0, 1]}}, "material": {"stiffness_N_m": 500}}]}))
        sim, _ = self.touching(scene=fields)
        file = self.folder / "trials.rec"
        recorder = self.start("record", file, "--scene", fields, "--home", "--seconds", 6, "--device", sim.tcp, "--json")
        self.assertIn("recording", recorder.stderr.readline())
        self.ok("arm", "--device", sim.tcp)
        written = [("trial", 1), ("event", 65535), ("trial", 2), ("event", 0), ("event", 0), ("trial", 2), ("trial", 0), ("trial", 1)]
        for name, value in written:
            self.ok("param", "set", name, value, "--device", sim.tcp)
        self.ok("disarm", "--device", sim.tcp)
        out, err = recorder.communicate(timeout=120)
        self.assertEqual(recorder.returncode, 0, err)
        said = json.loads(out)
        self.assertEqual((said["end"], said["missing"], said["marks"], said["events_missing"]), ("stopped", 0, len(written), 0))
        table = self.folder / "events.csv"
        self.fails(2, "same-file", "replay", file, "--events", table, "--log", f"{self.folder}/./events.csv")
        again = self.ok_json("replay", file, "--events", table)
        self.assertTrue(again["exact"])
        self.assertEqual([(event["kind"], event["code"]) for event in again["events"]], written)
        ticks = [event["tick"] for event in again["events"]]
        self.assertEqual(ticks, sorted(set(ticks)))
        with table.open(newline="") as rows:
            rows = list(csv.DictReader(rows))
        self.assertEqual([(int(row["tick"]), row["kind"], int(row["code"])) for row in rows], [(tick, *mark) for tick, mark in zip(ticks, written)])
        for row in rows:
            self.assertAlmostEqual(float(row["time_s"]), (int(row["tick"]) - again["first_tick"] + 1) / 4000, 9)
        self.assertNotIn("parameter", [entry["event"] for entry in self.ok_json("audit", "--device", sim.tcp)["entries"]])
        self.fails(2, "same-file", "replay", file, "--events", file)

    def test_two_arms(self):
        hand = self.folder / "two.csv"
        hand.write_text("time_s,x_m,y_m,z_m,arm\n" + "".join(
            "%g,%g,0,%g,%d\n" % (t, -0.1 + 0.2 * arm, z, arm) for arm in (0, 1) for t, z in ((0, 0.004), (0.3, -0.003), (1, 0.004))))
        sim = self.sim("--tcp", 0, "--hand", hand, "--loop")
        scene = self.plane_scene("two")
        self.ok("upload", scene, "--device", sim.tcp)
        _, said = self.recorded(sim, scene, "two.rec")
        self.assertTrue(said["replay"]["exact"])
        self.assertEqual(said["arms"], ["premium-1.5", "premium-1.5"])
        self.assertGreater(said["replay"]["contact_ticks"], 0)

    def test_others_arm_and_stop(self):
        """Without --arm: another program homes, arms and stops, and the fault is the recording's end."""
        sim, scene = self.touching()
        file = self.folder / "others.rec"
        recording = self.start("record", file, "--scene", scene, "--device", sim.tcp)
        self.assertIn("now arm", recording.stderr.readline())
        self.ok("home", "--device", sim.tcp)
        self.ok("arm", "--device", sim.tcp)
        self.fails(1, "recording-runs", "record", self.folder / "second.rec", "--scene", scene, "--device", sim.tcp)
        self.assertFalse((self.folder / "second.rec").exists())
        self.assertIsNone(recording.poll())
        recording.send_signal(signal.SIGINT)
        out, err = recording.communicate(timeout=30)
        self.assertEqual(recording.returncode, 0, err)
        self.assertIn("to the bit", out)
        self.ok("disarm", "--device", sim.tcp)
        left = self.start("record", self.folder / "left.rec", "--scene", scene, "--json", "--device", sim.tcp)
        self.assertIn("recording", left.stderr.readline())
        recording = self.start("record", file, "--force", "--scene", scene, "--arm", "--json", "--device", sim.tcp)
        self.assertIn("recording", recording.stderr.readline())
        out, err = left.communicate(timeout=30)
        self.assertEqual(left.returncode, 0, err)
        self.assertIn(json.loads(out)["end"], ("stopped", "taken_over"))
        self.assertTrue(json.loads(out)["replay"]["exact"])
        with socket.create_connection(("127.0.0.1", sim.port)) as bus:
            bus.sendall(b"S8\rO\rt0010\r")  # the e-stop frame
            out, err = recording.communicate(timeout=30)
        self.assertEqual(recording.returncode, 0, err)
        said = json.loads(out)
        self.assertEqual(said["end"], "fault")
        self.assertTrue(said["replay"]["exact"])
        self.assertIn("ended: fault host_stop", self.ok("replay", file).out)

    def test_it_goes_on_while_another_program_commands(self):
        """Without --arm: another program has armed the arm and says nothing for longer than link_timeout; a third one writes a parameter."""
        sim, scene = self.touching()
        recording = self.start("record", self.folder / "looker.rec", "--scene", scene, "--json", "--device", sim.tcp)
        self.assertIn("now arm", recording.stderr.readline())
        self.ok("home", "--device", sim.tcp)
        with socket.create_connection(("127.0.0.1", sim.port)) as bus:
            bus.sendall(b"S8\rO\r" + b"".join(b"T18DA01F18%s\r" % said for said in (b"021003CCCCCCCCCC", b"023E00CCCCCCCCCC", b"0431010201CCCCCC")))
            self.ok("param", "set", "telemetry_decimation", 20, "--device", sim.tcp)
            time.sleep(2.5)
            recording.send_signal(signal.SIGINT)
            out, err = recording.communicate(timeout=30)
        self.assertEqual(recording.returncode, 0, err)
        said = json.loads(out)
        self.assertEqual((said["end"], said["replay"]["exact"], self.mode(sim)), ("stopped", True, "armed"))

    def test_a_parameter_ends_it(self):
        sim, scene = self.touching()
        file = self.folder / "param.rec"
        recording = self.start("record", file, "--scene", scene, "--home", "--arm", "--json", "--device", sim.tcp)
        self.assertIn("recording", recording.stderr.readline())
        self.ok("param", "set", "telemetry_decimation", 20, "--device", sim.tcp)
        time.sleep(0.3)
        self.assertIsNone(recording.poll())
        self.fails(12, "other-program", "param", "set", "host_supervision", 1, "--device", sim.tcp)  # the recorder commands
        time.sleep(0.3)
        self.assertIsNone(recording.poll())
        self.ok("param", "set", "max_force", 2, "--device", sim.tcp)
        out, err = recording.communicate(timeout=30)
        self.assertEqual(recording.returncode, 0, err)
        said = json.loads(out)
        self.assertEqual(said["end"], "parameter_written")
        self.assertTrue(said["replay"]["exact"])
        self.assertEqual(self.mode(sim), "ready")

    def mode(self, sim):
        return self.ok_json("info", "--device", sim.tcp)["state"]["mode"]

    def test_a_start_that_fails_leaves_nothing(self):
        sim, scene = self.touching()
        file = self.folder / "early.rec"
        ask = ("record", file, "--scene", scene, "--device", sim.tcp, "--seconds", 0.5, "--arm")
        self.assertIn("not_homed", self.fails(1, "refused", *ask)["cause"])
        self.assertEqual(list(self.folder.glob("early.rec*")), [])
        self.assertEqual(self.ok_json(*ask, "--home")["end"], "stopped")

    def test_a_short_link_timeout(self):
        sim, scene = self.touching()
        self.ok("param", "set", "link_timeout", 0.3 if SLOW else 0.1, "--device", sim.tcp)
        _, said = self.recorded(sim, scene)
        self.assertEqual(said["end"], "stopped")

    def test_interrupted_before_it_arms(self):
        sim, scene = self.touching()
        for wait_s in (0.01, 0.03, 0.1):
            recording = self.start("record", self.folder / "early.rec", "--scene", scene, "--home", "--arm", "--force", "--device", sim.tcp)
            time.sleep(wait_s)
            recording.send_signal(signal.SIGINT)
            recording.communicate(timeout=30)
            self.assertIn(self.mode(sim), ("ready", "disarmed"))

    @unittest.skipUnless(os.geteuid() == 0 and shutil.which("unshare"), "a small disk takes root")
    def test_the_disk_is_full(self):
        sim, scene = self.touching()
        disk = self.folder / "disk"
        disk.mkdir()
        script = ('mount -t tmpfs -o size=64k small "$1" 2>/dev/null || exit 77; shift; "$@"; status=$?; ls "$0"; exit $status')
        thimble = [str(BIN / "thimble"), "record", str(disk / "full.rec"), "--scene", str(scene), "--home", "--arm", "--seconds", "20",
                   "--device", sim.tcp]
        begun = time.monotonic()
        run = subprocess.run(["unshare", "--mount", "sh", "-c", script, str(disk), str(disk), *thimble], capture_output=True, text=True,
                             env=self.environment, timeout=60)
        if run.returncode == 77 or "unshare" in run.stderr:
            self.skipTest("no disk can be mounted here")
        self.assertEqual(run.returncode, 1, run.stderr)
        self.assertIn("thimble: cannot-write: ", run.stderr)
        self.assertRegex(run.stderr, r"what was written until now is .*full\.rec\.part-")
        self.assertRegex(run.stdout, r"full\.rec\.part-")
        self.assertLess(time.monotonic() - begun, 15)
        self.assertEqual(self.mode(sim), "ready")

    def test_interrupted(self):
        sim, scene = self.touching()
        file = self.folder / "interrupted.rec"
        recording = self.start("record", file, "--scene", scene, "--home", "--arm", "--device", sim.tcp)
        self.assertIn("recording", recording.stderr.readline())
        time.sleep(0.5)
        recording.send_signal(signal.SIGINT)
        out, err = recording.communicate(timeout=30)
        self.assertEqual(recording.returncode, 0, err)
        self.assertIn("ended: stopped", out)
        self.assertTrue(self.ok_json("replay", file)["exact"])
        self.assertEqual(list(self.folder.glob("interrupted.rec.part*")), [])

    def test_the_controller_dies(self):
        sim, scene = self.touching()
        file = self.folder / "dies.rec"
        recording = self.start("record", file, "--scene", scene, "--home", "--arm", "--device", sim.tcp)
        self.assertIn("recording", recording.stderr.readline())
        time.sleep(1)
        sim.stop(signal.SIGKILL)
        out, err = recording.communicate(timeout=30)
        self.assertEqual(recording.returncode, 6, err)
        self.assertIn("thimble: link-lost: ", err)
        said = self.ok_json("replay", file)
        self.assertTrue(said["exact"])
        self.assertEqual(said["end"], "link-lost")
        self.assertGreater(said["ticks"], 100)

    def test_the_recorder_dies(self):
        sim, scene = self.touching()
        file = self.folder / "killed.rec"
        recording = self.start("record", file, "--scene", scene, "--home", "--arm", "--device", sim.tcp)
        self.assertIn("recording", recording.stderr.readline())
        time.sleep(1)
        recording.kill()
        recording.communicate(timeout=30)
        self.assertFalse(file.exists())
        (draft,) = self.folder.glob("killed.rec.part*")
        result = self.run_thimble("replay", draft)
        self.assertEqual(result.code, 0, result.err)
        self.assertIn("was cut off", result.err)
        self.assertIn("ended: cut off", result.out)

    def test_a_killed_recorder_leaves_no_arm_armed(self):
        """At several moments, over TCP and the pty, which one program at a time may open; with its whole process group, too."""
        sim, scene = self.touching()
        most_s = 8 if SLOW else 2  # the simulator is slower than real time under the sanitizers
        slowest_s = 0
        for number, (uri, pause_s, group) in enumerate(((sim.tcp, 0.0, False), (sim.pty, 0.3, False), (sim.tcp, 0.5, True), (sim.pty, 0.0, True))):
            recorder = subprocess.Popen([BIN / "thimble", "record", self.folder / ("killed%d.rec" % number), "--scene", scene, "--home", "--arm",
                                         "--force", "--device", uri], stderr=subprocess.PIPE, text=True, env=self.environment, start_new_session=True)
            self.addCleanup(recorder.kill)
            self.assertIn("armed", recorder.stderr.readline())
            self.wait_for_mode(sim.tcp, "armed")
            time.sleep(pause_s)
            killed = time.monotonic()
            os.killpg(recorder.pid, signal.SIGKILL) if group else recorder.kill()
            self.wait_for_mode(sim.tcp, "ready", most_s)
            slowest_s = max(slowest_s, time.monotonic() - killed)
            self.assertIn("it was disarmed", recorder.stderr.read())
            recorder.wait()
            recorder.stderr.close()
            self.assertEqual(self.ok_json("info", "--device", sim.tcp)["state"]["fault"], 0)
        figure("disarmed %.2f s after SIGKILL at the latest" % slowest_s)

    def test_a_link_that_loses_frames(self):
        sim, scene = self.touching()
        proxy = RecordingThief(sim.port)
        self.addCleanup(proxy.close)
        file = self.folder / "lossy.rec"
        result = self.run_thimble("record", file, "--scene", scene, "--home", "--arm", "--seconds", 2, "--device", proxy.uri, "--json")
        self.assertEqual(result.code, 0, result.err)
        said = result.json
        self.assertGreater(said["missing"], 0)
        self.assertFalse(said["replay"]["exact"])
        self.assertNotIn("differs_at", said["replay"])
        self.assertLess(said["replay"]["exact_to"], said["replay"]["gap_at"])
        self.assertIn("ticks are missing", result.err)
        self.assertIn("replay is exact up to tick %d" % said["replay"]["exact_to"], result.err)
        self.assertEqual(self.ok_json("replay", file)["gap_at"], said["replay"]["gap_at"])

    def test_what_is_refused(self):
        sim = self.sim("--tcp", 0)
        scene, other = self.plane_scene(), self.plane_scene("other", stiffness=300)
        file = self.folder / "refused.rec"
        ask = ("record", file, "--device", sim.tcp, "--scene")
        self.fails(2, "usage", "record", file, "--device", sim.tcp)
        self.fails(1, "no-scene", *ask, scene)
        self.ok("upload", scene, "--device", sim.tcp)
        self.assertIn("floor", self.fails(8, "other-scene", *ask, other)["cause"])
        self.fails(10, "cannot-read", *ask, self.folder / "none.thim")
        self.ok("home", "--device", sim.tcp)
        self.ok("arm", "--device", sim.tcp)
        self.fails(1, "motors-on", *ask, scene)
        self.fails(1, "motors-on", *ask, scene, "--force")
        self.assertFalse(file.exists())
        self.assertEqual(list(self.folder.glob("refused.rec*")), [])
        file.write_text("precious")
        self.fails(1, "recording-exists", *ask, scene)
        self.assertEqual(file.read_text(), "precious")

    def test_broken_recordings(self):
        sim, scene = self.touching()
        file, said = self.recorded(sim, scene, "whole.rec", seconds=0.5)
        whole = file.read_bytes()
        broken = self.folder / "broken.rec"
        for verb in (("replay", broken), ("plot", broken, "--output", self.folder / "broken.svg")):
            broken.write_bytes(whole[:50])
            self.fails(10, "broken-recording", *verb)
            broken.write_bytes(whole[:-100] + bytes([whole[-100] ^ 0xFF]) + whole[-99:])
            self.assertIn("at byte", self.fails(10, "broken-recording", *verb)["cause"])
            broken.write_bytes(whole + b"more")
            self.fails(10, "broken-recording", *verb)
        broken.write_bytes(b"anything else")
        self.fails(10, "not-a-recording", "replay", broken)
        self.fails(10, "bad-log", "plot", broken, "--output", self.folder / "broken.svg")
        self.fails(10, "cannot-read", "replay", self.folder / "none.rec")
        self.assertFalse((self.folder / "broken.svg").exists())

        broken.write_bytes(whole[: len(whole) * 2 // 3])
        cut = self.run_thimble("replay", broken, "--json")
        self.assertEqual(cut.code, 0, cut.err)
        self.assertTrue(cut.json["exact"])
        self.assertEqual(cut.json["end"], "cut_off")
        self.assertLess(cut.json["ticks"], said["ticks"])

    @unittest.skipUnless(shutil.which("gnuplot"), "gnuplot is not there")
    def test_plots(self):
        sim, scene = self.touching()
        file, _ = self.recorded(sim, scene, "plot.rec")
        panels = {}
        for kind in ("all", "time", "depth", "spectrum"):
            picture = self.folder / (kind + ".svg")
            said = self.ok_json("plot", file, "--output", picture, "--kind", kind)
            tree = xml.etree.ElementTree.parse(picture)
            self.assertTrue(tree.getroot().tag.endswith("svg"))
            panels[kind] = "".join(tree.getroot().itertext())
            self.assertAlmostEqual(said["rate_Hz"], 4000, 3)
        self.assertIn("time in s", panels["time"])
        self.assertNotIn("depth", panels["time"])
        self.assertIn("depth", panels["depth"])
        self.assertIn("frequency in Hz", panels["spectrum"])
        for words in ("time in s", "depth", "frequency in Hz", "plot.rec"):
            self.assertIn(words, panels["all"])
        self.fails(2, "same-file", "replay", file, "--log", file)
        trap = self.folder / "t`touch trapped`.rec"
        shutil.copy(file, trap)
        self.ok("plot", trap, "--output", self.folder / "it's.svg")
        self.assertIn("`touch trapped`", (self.folder / "it's.svg").read_text())
        self.assertFalse(Path("trapped").exists())
        png = self.folder / "felt.png"
        self.ok("plot", file, "--output", png)
        data = png.read_bytes()
        self.assertEqual(data[:8], b"\x89PNG\r\n\x1a\n")
        self.assertEqual(struct.unpack(">II", data[16:24]), (1000, 1200))
        self.fails(2, "bad-output", "plot", file, "--output", self.folder / "felt.pdf")
        self.fails(10, "too-short", "plot", file, "--output", png, "--tip", 1)
        self.fails(2, "usage", "plot", file, "--output", png, "--kind", "pie")

    @unittest.skipUnless(shutil.which("gnuplot"), "gnuplot is not there")
    def test_the_spectrum_of_a_sine(self):
        log = self.folder / "sine.csv"
        rate, frequency, amplitude = 4000, 250.0, 0.8
        with log.open("w") as rows:
            rows.write("time_s,arm,tip_x_m,tip_y_m,tip_z_m,proxy_x_m,proxy_y_m,proxy_z_m,force_x_N,force_y_N,force_z_N,contacts\n")
            for i in range(20000):
                force = amplitude * math.sin(2 * math.pi * frequency * i / rate)
                rows.write("%.9g,0,0,0,0,0,0,0.001,%.9g,%.9g,1,1\n" % (i / rate, 0.6 * force, 0.8 * force))
        peak = self.ok_json("plot", log, "--output", self.folder / "sine.svg")["spectrum_peak"]
        self.assertAlmostEqual(peak["frequency_Hz"], frequency, delta=0.25)
        self.assertAlmostEqual(peak["amplitude_N"], amplitude, delta=0.002)
        figure("a sine of %g N at %g Hz: %.4f N at %.2f Hz" % (amplitude, frequency, peak["amplitude_N"], peak["frequency_Hz"]))

    def test_without_gnuplot(self):
        log = self.folder / "flat.csv"
        log.write_text("time_s,arm,tip_x_m,tip_y_m,tip_z_m,proxy_x_m,proxy_y_m,proxy_z_m,force_x_N,force_y_N,force_z_N,contacts\n" +
                       "".join("%g,0,0,0,0,0,0,0,0,0,1,1\n" % (i / 100) for i in range(20)))
        self.environment["PATH"] = str(self.runtime)  # nothing is there
        error = self.fails(3, "no-gnuplot", "plot", log, "--output", self.folder / "flat.svg")
        self.assertIn("gnuplot-nox", error["remedy"])
        self.assertFalse((self.folder / "flat.svg").exists())

    def test_a_device_log_leads_a_hand(self):
        text = self.folder / "hapi.log"
        rows = [(0.01 * i, 0.005 * math.sin(0.1 * i)) for i in range(150)]
        text.write_text("TIME POSITION FORCE BUTTONS\n" +
                        "".join("%.5f 0.00000 %.5f 0.00000 0.00000 %.5f 0.00000 0\n" % (t, y, max(-800 * y, 0)) for t, y in rows))
        binary = self.folder / "hapi.dat"
        binary.write_bytes(b"TIME\0POSITION\0FORCE\0BUTTONS\0\0" + b"".join(
            struct.pack("<7di", t, 0, y, 0, 0, max(-800 * y, 0), 0, 0) for t, y in rows))
        scene = self.plane_scene("hapi")
        peaks = []
        for log in (text, binary):
            path, forces = self.folder / "hapi.path.csv", self.folder / "hapi.log.csv"
            said = self.ok_json("import", "devicelog", log, "--output", path, "--log", forces)
            self.assertEqual(said["rows"], 150)
            self.assertEqual(said["kind"], "text" if log is text else "binary")
            peaks.append(self.ok_json("simulate", scene, "--path", path, "--ideal", "--log", self.folder / "felt.csv")["peak_force_N"])
            with forces.open(newline="") as file:
                most = max(float(row["force_z_N"]) for row in csv.DictReader(file))
            self.assertAlmostEqual(most, 4, delta=0.01)
        # HAPI's y is up: down to -5 mm in a floor of 800 N/m (and 1 Ns/m).
        for peak in peaks:
            self.assertAlmostEqual(peak, 4, delta=0.1)
        self.fails(2, "usage", "import", "devicelog", text)
        both = self.folder / "both.csv"
        self.fails(2, "same-file", "import", "devicelog", text, "--output", both, "--log", self.folder / "." / "both.csv")
        self.assertFalse(both.exists())
        for names in (("both.csv", "./both.csv"), ("both.csv", both), ("./x/../both.csv", "both.csv")):  # none of which is there
            for verb in (("import", "devicelog", text, "--output", names[0], "--log", names[1]),
                         ("replay", scene, "--log", names[0], "--events", names[1])):
                told = subprocess.run([BIN / "thimble", *verb], cwd=self.folder, env=self.environment, capture_output=True, text=True)
                self.assertEqual((told.returncode, "same-file" in told.stderr), (2, True), (verb, told.stderr))
        self.assertFalse(both.exists())
        self.ok("import", "devicelog", text, "--output", "/dev/null", "--log", "/dev/null")
        self.fails(10, "bad-device-log", "import", "devicelog", scene, "--output", self.folder / "none.csv")
        text.write_text("TIME POSITION\n0 0 0 0\n")
        self.fails(10, "no-force", "import", "devicelog", text, "--log", self.folder / "none.csv")
        self.assertFalse((self.folder / "none.csv").exists())


if __name__ == "__main__":
    unittest.main()

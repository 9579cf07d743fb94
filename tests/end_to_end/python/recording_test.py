"""Recordings as arrays, tables and HDF5, against what `thimble replay` writes and against an independent reader."""

import json
import resource
import signal
import subprocess
import sys
import unittest
from pathlib import Path
from unittest import mock

import numpy as np
import thimble

ROOT = Path(__file__).resolve().parents[3]
sys.path.insert(0, str(ROOT / "tests/end_to_end"))
from rig import LinkFaults, Proxy, Rig, figure  # noqa: E402


MARKS = """
import json, sys, thimble

told = []
with thimble.connect(sys.argv[1], timeout_s=2) as device:
    for i in range(24):
        told.append((device.set_trial(i), i, 1) if i % 10 == 9 else (device.event(i % 3 * 1000), i % 3 * 1000, 0))
    try:
        device.event(65536)
    except ValueError:
        print(json.dumps(told))
"""


class ServicesThief(Proxy):
    """Takes one frame in 20 of requests and answers, and nothing of the recording, which is thousands of frames a second."""

    def __init__(self, port):
        super().__init__(port, LinkFaults(), 7)

    def relay(self, source, sink):
        rest = b""
        try:
            while data := source.recv(65536):
                *lines, rest = (rest + data).split(b"\r")
                kept = [line + b"\r" for line in lines if line[:1] not in (b"T", b"D", b"B") or self.random.random() > 0.05]
                self.counts["dropped"] += len(lines) - len(kept)
                sink.sendall(b"".join(kept))
        except OSError:
            pass


class Recordings(Rig):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.file = cls.folder / "felt.rec"

    def setUp(self):
        super().setUp()
        if self.file.exists():
            return
        ball = thimble.sphere("red ball", radius_m=0.01, position_m=[0.01, 0, 0], material={"stiffness_N_m": 500},
                              body=thimble.body(motion="free", mass_kg=0.05, spring_N_m=50, damping_N_s_m=0.5))
        scene, hand = self.folder / "ball.thim", self.folder / "press.csv"
        scene.write_bytes(thimble.compile(thimble.scene("ball", ball)))
        hand.write_text("time_s,x_m,y_m,z_m\n0,0.01,0,0.02\n0.3,0.01,0,0.005\n0.6,0.01,0,0.02\n")
        sim = self.sim("--tcp", 0, "--hand", hand, "--loop")
        self.ok("upload", scene, "--device", sim.tcp)
        self.said = self.ok_json("record", self.file, "--scene", scene, "--home", "--arm", "--seconds", 2, "--device", sim.tcp)
        sim.stop()

    def test_what_it_contains(self):
        recording = thimble.Recording(self.file)
        said = self.ok_json("replay", self.file)
        self.assertEqual((recording.about["scene"], recording.about["arms"], recording.about["end"]), ("ball", ["premium-1.5"], "stopped"))
        self.assertEqual(recording.about["scene_crc"], said["scene_crc"])
        n = len(recording.ticks)
        self.assertGreater(n, 4000)
        self.assertEqual(recording.counts.shape, (n, 1, 3))
        self.assertEqual(recording.ticks[0], said["first_tick"])
        self.assertGreater(np.ptp(recording.counts.astype(int)[:, 0, 1]), 10)
        self.assertEqual(recording.verdict["exact"], said["exact"])
        self.assertEqual((len(recording.rows), recording.verdict["ticks"]), (said["ticks"], said["ticks"]))
        self.assertAlmostEqual(np.linalg.norm(recording.rows["force_N"], axis=1).max(), said["peak_force_N"], places=6)
        self.assertGreater(said["peak_force_N"], 0.1)
        self.assertEqual(recording.parameters["telemetry_decimation"], 40)
        self.assertGreaterEqual(len(recording.checks), said["checks"])
        self.assertTrue((np.diff(recording.frames["time_s"]) >= 0).all())
        self.assertGreater(np.ptp(recording.rows["red_ball.position_m"][:, 2]), 1e-4)
        again = thimble.simulate(recording.scene, [[0, 0, 0, 0.05], [0.01, 0, 0, 0.05]], ideal=True)
        self.assertEqual(again.dtype, recording.rows.dtype)

    def test_events(self):
        """A program marks events over a link that loses frames, another one records over a sound link: it has each event once, in the tick that the
        first was told. Then the table in pandas and HDF5."""
        import h5py

        scene, file = self.folder / "wall.thim", self.folder / "events.rec"
        scene.write_bytes(thimble.compile(thimble.scene("wall", thimble.plane("wall", normal=[0, 0, 1], offset_m=-0.02,
                                                                               material={"stiffness_N_m": 500}))))
        sim = self.sim("--tcp", 0)
        self.ok("upload", scene, "--device", sim.tcp)
        recorder = self.start("record", file, "--scene", scene, "--home", "--device", sim.tcp)
        self.assertIn("recording", recorder.stderr.readline())
        lossy = ServicesThief(sim.port)
        self.addCleanup(lossy.close)
        # In a process of its own: the relay is a thread of this one, which would have to wait for the interpreter.
        marked = subprocess.run([sys.executable, "-c", MARKS, lossy.uri], capture_output=True, text=True, timeout=300)
        self.assertEqual(marked.returncode, 0, marked.stderr)
        told = [tuple(mark) for mark in json.loads(marked.stdout)]
        self.assertEqual(len(told), 24)
        self.assertGreater(lossy.counts["dropped"], 3)
        recorder.send_signal(signal.SIGINT)
        _, err = recorder.communicate(timeout=120)
        self.assertEqual(recorder.returncode, 0, err)
        recording = thimble.Recording(file)
        self.assertEqual([(row["tick"], row["code"], row["kind"]) for row in recording.events], told)
        self.assertEqual(recording.about["events_missing"], 0)
        self.assertTrue(recording.verdict["exact"])
        table = thimble.to_pandas(recording.events)
        self.assertEqual(list(table.columns), ["tick", "time_s", "code", "kind"])
        np.testing.assert_allclose(table["time_s"], (table["tick"] - recording.ticks[0] + 1) / 4000)
        recording.to_hdf5(self.folder / "events.h5")
        with h5py.File(self.folder / "events.h5") as hdf5:
            self.assertEqual(list(hdf5["events/code"]), list(table["code"]))
            self.assertEqual(hdf5["events/time_s"].attrs["unit"], "s")

    def test_the_table_is_the_log(self):
        import pandas

        log, ours = self.folder / "log.csv", self.folder / "ours.csv"
        self.ok("replay", self.file, "--log", log)
        recording = thimble.Recording(self.file)
        recording.to_csv(ours)
        self.assertEqual(ours.read_bytes(), log.read_bytes())
        table, theirs = recording.to_pandas(), pandas.read_csv(log)
        self.assertEqual(set(table.columns), set(theirs.columns))
        for column in theirs.columns:
            np.testing.assert_allclose(table[column], theirs[column], rtol=1e-8, atol=1e-12, err_msg=column)
        felt = thimble.simulate(ROOT / "scenes/buttons/buttons.scene.json", ROOT / "scenes/buttons/stroke.csv", rate_Hz=500, ideal=True)
        self.assertIn("click_button.q_m", thimble.to_pandas(felt).columns)

    def test_hdf5_for_an_independent_reader(self):
        """h5dump, the reader of the HDF5 Group, finds the numbers, units and frames."""
        import h5py

        file = self.folder / "felt.h5"
        recording = thimble.Recording(self.file)
        recording.to_hdf5(file)
        dump = lambda *what: subprocess.run(["h5dump", *what, file], check=True, capture_output=True, text=True).stdout  # noqa: E731
        raw = self.folder / "force.bin"
        subprocess.run(["h5dump", "-d", "/arm0/force_N", "-b", "LE", "-o", raw, file], check=True, capture_output=True)
        np.testing.assert_array_equal(np.fromfile(raw, "<f8").reshape(-1, 3), recording.rows["force_N"])
        self.assertIn('"N"', dump("-a", "/arm0/force_N/unit"))
        self.assertIn('"world"', dump("-a", "/arm0/force_N/frame"))
        self.assertIn('"rad/s"', dump("-a", "/arm0/objects/red_ball/spin_rad_s/unit"))
        self.assertIn('"ball"', dump("-a", "/scene"))
        with h5py.File(file) as stored:
            np.testing.assert_array_equal(stored["counts"], recording.counts)
            np.testing.assert_array_equal(stored["arm0/objects/red_ball/position_m"], recording.rows["red_ball.position_m"])
            self.assertEqual(bytes(stored["scene_image"]), recording.scene)
            self.assertEqual(stored.attrs["rate_Hz"], recording.about["rate_Hz"])
            self.assertEqual(stored["parameters"].attrs["max_force"], recording.parameters["max_force"])
            values = []
            stored.visititems(lambda name, item: values.append(item) if isinstance(item, h5py.Dataset) else None)
            self.assertTrue(all("unit" in value.attrs for value in values))
        figure("%d ticks: %d kB recorded, %d kB as HDF5" % (len(recording.ticks), self.file.stat().st_size // 1000, file.stat().st_size // 1000))

    def test_what_is_missing_is_named(self):
        recording = thimble.Recording(self.file)
        for module, package, call in (("pandas", "python3-pandas", recording.to_pandas), ("h5py", "python3-h5py", lambda: recording.to_hdf5("no.h5"))):
            with mock.patch.dict(sys.modules, {module: None}), self.assertRaisesRegex(ImportError, package):
                call()

    def test_nothing_is_lost(self):
        """Onto the recording itself, and where there is no space: what was there stays."""
        recording, before = thimble.Recording(self.file), self.file.read_bytes()
        link = self.folder / "link"
        link.symlink_to(self.file)
        for write in (recording.to_csv, recording.to_hdf5):
            for place in (self.file, link):
                with self.assertRaises(thimble.Error) as caught:
                    write(place)
                self.assertEqual((caught.exception.name, self.file.read_bytes() == before), ("same-file", True))
            with self.assertRaises(thimble.Error) as caught:
                write(self.folder / "none" / "felt")
            self.assertEqual(caught.exception.name, "cannot-write")
            kept = self.folder / "kept"
            kept.write_text("precious")
            limits = resource.getrlimit(resource.RLIMIT_FSIZE)
            handler = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
            resource.setrlimit(resource.RLIMIT_FSIZE, (20000, limits[1]))
            try:
                with self.assertRaises(thimble.Error) as caught:
                    write(kept)
            finally:
                resource.setrlimit(resource.RLIMIT_FSIZE, limits)
                signal.signal(signal.SIGXFSZ, handler)
            self.assertEqual((caught.exception.name, kept.read_text()), ("cannot-write", "precious"))

    def test_a_broken_file(self):
        bad = self.folder / "bad.rec"
        bad.write_bytes(b"no recording")
        with self.assertRaises(thimble.Error) as caught:
            thimble.Recording(bad)
        self.assertEqual((caught.exception.name, caught.exception.exit_code), ("not-a-recording", 10))


if __name__ == "__main__":
    unittest.main()

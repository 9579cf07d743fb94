"""sweep: interrupted and resumed, killed, in parts, refused; the same bytes in every way. THIMBLE_LONG: docs/stability.md from its plan."""

import json
import os
import random
import re
import signal
import time
import unittest
from pathlib import Path

from rig import Rig, figure

ROOT = Path(__file__).resolve().parents[2]


class Sweep(Rig):
    def setUp(self):
        super().setUp()
        for old in self.folder.iterdir():
            old.unlink()

    def plan(self, runs=24, **changes):
        """Presses of 0.4 s on a floor."""
        self.plane_scene(offset_m=-0.005)
        (self.folder / "press.csv").write_text("time_s,x_m,y_m,z_m\n0,0,0,0\n0.1,0,0,-0.007\n0.4,0,0,-0.007\n")
        plan = {"thimble_sweep": 1, "name": "presses", "scene": "floor.scene.json", "path": "press.csv", "steady_s": 0.2,
                "vary": [{"what": "/objects/0/material/stiffness_N_m", "values": [500, 2000]},
                         {"what": "seed", "from": 1, "to": runs // 2, "count": runs // 2}],
                "table": {"rows": "seed", "columns": "/objects/0/material/stiffness_N_m", "value": "peak_force_N"}}
        plan.update(changes)
        file = self.folder / "presses.plan.json"
        file.write_text("// Presses on a floor.\n" + json.dumps({key: value for key, value in plan.items() if value is not None}))
        return file

    def rows_of(self, file):
        return file.read_bytes().count(b"\n") - 2 if file.exists() else 0

    def wait_for_rows(self, file, process, rows):
        end = time.monotonic() + 60
        while self.rows_of(file) < rows:
            self.assertIsNone(process.poll(), "it ended")
            self.assertLess(time.monotonic(), end)
            time.sleep(0.01)

    def test_the_same_bytes_in_every_way(self):
        plan, whole = self.plan(), self.folder / "whole.csv"
        said = self.ok_json("sweep", plan, "--dry-run")
        self.assertEqual(said["runs"], 24)
        self.assertEqual([len(axis["values"]) for axis in said["axes"]], [2, 12])
        once = self.ok_json("sweep", plan, "--output", whole, "--jobs", 1)
        self.assertEqual((once["runs"], once["run_now"], once["failed"], once["jobs"]), (24, 24, 0, 1))
        rows = whole.read_text().splitlines()
        self.assertEqual([row.split(",")[0] for row in rows[2:]], [str(run) for run in range(24)])
        self.assertEqual({row.split(",")[3] for row in rows[2:]}, {"ok"})
        for jobs in (2, 7):
            other = self.folder / ("jobs%d.csv" % jobs)
            self.ok("sweep", plan, "-o", other, "--jobs", jobs)
            self.assertEqual(other.read_bytes(), whole.read_bytes())
        parts = self.folder / "parts.csv"
        for part in (3, 1):
            said = self.ok("sweep", plan, "--output", parts, "--array", "%d/3" % part).err
            self.assertIn("8 runs in", said)
            self.assertIn("part %d-of-3 -> %s.runs.%d-of-3; " % (part, parts, part), said)
        self.assertFalse(parts.exists())
        self.assertEqual(self.ok_json("sweep", plan, "--output", parts)["run_now"], 8)
        self.assertEqual(parts.read_bytes(), whole.read_bytes())
        # What is whole is not run again; the table is written from it.
        table = self.folder / "table.md"
        self.assertEqual(self.ok_json("sweep", plan, "--output", parts, "--table", table)["run_now"], 0)
        self.assertEqual(len(re.findall(r"^\| \d+ \| [\d.]+ \| [\d.]+ \|$", table.read_text(), re.M)), 12)
        self.assertEqual(parts.read_bytes(), whole.read_bytes())
        self.assertEqual(sorted(file.name for file in self.folder.glob("*.csv*")),
                         ["jobs2.csv", "jobs7.csv", "parts.csv", "press.csv", "whole.csv"])

    def test_interrupted_and_killed_it_goes_on(self):
        plan, whole, out = self.plan(100), self.folder / "whole.csv", self.folder / "out.csv"
        grows = self.folder / "out.csv.runs"
        self.ok("sweep", plan, "--output", whole)
        for how, code, least in ((signal.SIGINT, 1, 3), (signal.SIGKILL, -9, 10), (signal.SIGTERM, 1, 20)):
            with self.start("sweep", plan, "--output", out, "--jobs", 2) as process:
                self.wait_for_rows(grows, process, least)
                process.send_signal(how)
                _, err = process.communicate(timeout=60)
                self.assertEqual(process.returncode, code, err)
            if code == 1:
                self.assertIn("thimble: interrupted: ", err)
                self.assertIn("%d of 100 runs are kept" % self.rows_of(grows), err)
            self.assertFalse(out.exists())
        # And at any byte, as on a machine that lost its power.
        generator, kept = random.Random(18), grows.read_bytes()
        for _ in range(2):
            grows.write_bytes(kept[:generator.randrange(len(kept))])
            missing = 100 - max(self.rows_of(grows), 0)
            done = self.ok_json("sweep", plan, "--output", out)
            self.assertEqual(done["run_now"], missing)
            self.assertEqual(out.read_bytes(), whole.read_bytes())
            out.unlink()
        figure("killed with %d of 100 runs" % (kept.count(b"\n") - 2))

    def test_refusals(self):
        plan, out = self.plan(4), self.folder / "out.csv"
        self.fails(2, "usage", "sweep", plan)
        for array in ("0/3", "4/3", "2", "a/b", "1/0", "1/2/3", "1/-1"):
            self.fails(2, "bad-part", "sweep", plan, "--output", out, "--array", array)
        self.fails(2, "usage", "sweep", plan, "--output", out, "--array", "1/2", "--slurm", 2)
        self.fails(2, "usage", "sweep", plan, "--output", out, "--array", "1/2", "--table", self.folder / "t.md")
        self.fails(2, "usage", "sweep", plan, "--output", out, "--jobs", 0)
        self.fails(2, "same-file", "sweep", plan, "--output", plan)
        for used in ("floor.scene.json", "press.csv"):
            self.fails(2, "same-file", "sweep", plan, "--output", out, "--table", self.folder / used)
        self.fails(2, "same-file", "sweep", plan, "--output", out, "--table", out)  # which is not there yet
        self.fails(10, "cannot-read", "sweep", self.folder / "none.json", "--output", out)
        self.fails(1, "cannot-write", "sweep", plan, "--output", self.folder / "none" / "out.csv")
        self.fails(1, "cannot-write", "sweep", plan, "--output", out, "--table", self.folder / "none" / "t.md")
        self.assertFalse((self.folder / "out.csv.runs").exists(), "it is told before the first run")
        self.environment["PATH"] = str(self.folder)
        self.fails(3, "no-slurm", "sweep", plan, "--output", out, "--slurm", 2)
        self.ok("sweep", plan, "--output", out)
        before = out.read_bytes()
        self.fails(10, "wrong-results", "sweep", self.plan(6), "--output", out)
        self.assertEqual(out.read_bytes(), before)
        self.fails(2, "no-table", "sweep", self.plan(4, table=None), "--output", out, "--table", self.folder / "t.md")
        # All errors at once.
        self.plan(4, colour=1, steady_s=-1, path="none.csv")
        errors = self.run_thimble("sweep", plan, "--output", out, "--json")
        self.assertEqual(errors.code, 10)
        self.assertEqual(sorted(error["name"] for error in json.loads(errors.err)["errors"]),
                         ["bad-value", "cannot-read", "unknown-key"])

    def test_two_sweeps_with_one_output(self):
        plan, out = self.plan(400), self.folder / "out.csv"
        with self.start("sweep", plan, "--output", out, "--jobs", 1) as first:
            self.wait_for_rows(self.folder / "out.csv.runs", first, 1)
            self.fails(1, "sweep-in-use", "sweep", plan, "--output", out)
            first.send_signal(signal.SIGINT)
            first.communicate(timeout=60)

    def test_runs_that_end_early_are_told(self):
        (self.folder / "far.csv").write_text("time_s,x_m,y_m,z_m\n0,0,0,0\n1,0,0,3\n")
        result = self.ok("sweep", self.plan(4, path="far.csv"), "--output", self.folder / "out.csv")
        self.assertIn("warning: 4 runs ended early", result.err)
        self.assertEqual(self.ok_json("sweep", self.folder / "presses.plan.json", "-o", self.folder / "out.csv")["failed"], 4)

    def test_progress_on_a_terminal(self):
        plan = self.plan(150)
        text = self.on_terminal("sweep", plan, "--output", self.folder / "out.csv", "--jobs", 1)
        self.assertRegex(text, r"\r\x1b\[K\d+ %  run \d+ of 150, \d+ s left")
        self.assertRegex(text, r"150 runs in [\d.]+ s with 1 job; ideal [\d.]+ s, -?\d+ % more\r\n150 of 150 runs -> ")

    @unittest.skipUnless("THIMBLE_LONG" in os.environ, "a minute and more")
    def test_the_page_of_stability(self):
        page = self.folder / "stability.md"
        self.ok("sweep", ROOT / "docs/examples/sweep/stability.plan.json", "--output", self.folder / "stability.csv", "--table", page,
                timeout=1800)

        def tables(text):
            return text[text.index("\n## "):]

        self.assertEqual(tables(page.read_text()), tables((ROOT / "docs/stability.md").read_text()))


if __name__ == "__main__":
    unittest.main()

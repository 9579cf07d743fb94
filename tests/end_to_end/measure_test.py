"""thimble-board --measure: what rendering takes on this computer, and the units of work that it proposes."""

import json
import re
import subprocess
import unittest
from pathlib import Path

from rig import BIN, Rig

DOCS = Path(__file__).parents[2] / "docs"


class Measure(Rig):
    def setUp(self):
        super().setUp()
        self.config = json.loads(re.search(r"```json\n(.*?)```", (DOCS / "board-linux.md").read_text(), re.S)[1])

    def board(self, *arguments):
        (self.folder / "board.json").write_text(json.dumps(self.config))
        return subprocess.run([BIN / "thimble-board", "--config", self.folder / "board.json", *arguments],
                              capture_output=True, text=True, timeout=120)

    def scene(self, name):
        return self.image(DOCS.parent / f"scenes/{name}/{name}.scene.json")

    def test_its_proposal_is_a_value_of_the_configuration(self):
        measured = self.board("--measure", self.scene("ring"), self.scene("walls"))
        self.assertEqual(measured.returncode, 0, measured.stderr)
        for scene in "ring", "walls":
            self.assertRegex(measured.stdout, rf"{scene}.scene.thim: the longest tick takes [0-9.]+ us, a unit [0-9.]+ ns")
        self.assertIn("the configuration has 4000 units", measured.stdout)
        self.config["work_units"] = int(re.search(r'"work_units": (\d+) would', measured.stdout)[1])
        again = self.board("--measure", self.scene("ring"))
        self.assertIn(f"the configuration has {self.config['work_units']} units", again.stdout)

    def test_what_cannot_be_measured(self):
        not_a_scene = self.folder / "board.json"
        measured = self.board("--measure", not_a_scene)
        self.assertEqual((measured.returncode, measured.stdout), (1, ""))
        self.assertIn("is no scene image with an object; make one with `thimble compile`", measured.stderr)
        measured = self.board("--measure", self.folder / "none.thimble")
        self.assertEqual((measured.returncode, measured.stdout), (1, ""))
        self.assertIn("none.thimble: No such file or directory", measured.stderr)
        measured = self.board("--measure", self.scene("stick-slip"))
        self.assertEqual(measured.returncode, 1)
        self.assertIn("too few to measure one; add a scene that takes more", measured.stderr)

    def test_units_that_are_too_few(self):
        self.config["work_units"] = 99
        measured = self.board("--check")
        self.assertEqual(measured.returncode, 10)
        self.assertIn("/work_units is 99, allowed is a whole number from 100 to 1000000", measured.stderr)


if __name__ == "__main__":
    unittest.main()

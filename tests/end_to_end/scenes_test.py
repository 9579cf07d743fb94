"""Every scene of the repository: listed in scenes/README.md, compiled, and simulated along its stroke; and every limit is shown."""

import csv
import os
import re
import unittest
from pathlib import Path

from rig import Rig

ROOT = Path(__file__).resolve().parents[2]
SCENES = ROOT / "scenes"
PLAYED_S = 0.2 if "THIMBLE_UNDER_SANITIZERS" in os.environ else 2.0


class Scenes(Rig):
    def test_the_table_has_a_row_for_each_folder(self):
        rows = re.findall(r"^\| `([\w-]+)` \|(.*)\|$", (SCENES / "README.md").read_text(encoding="utf-8"), re.MULTILINE)
        names = [name for name, _ in rows]
        self.assertEqual(sorted(names), sorted(folder.name for folder in SCENES.iterdir() if folder.is_dir()))
        tests = "\n".join(file.read_text(encoding="utf-8", errors="replace") for file in (ROOT / "tests").rglob("*_test.*"))
        for name, row in rows:
            cells = [cell.strip() for cell in row.split("|")]
            self.assertEqual(len(cells), 3, name)
            for cell in cells:
                self.assertTrue(cell, name)
            for test in re.findall(r"`(\w+)\.(\w+)`", cells[2]):  # the tests that it names exist
                self.assertRegex(tests, r"TEST(_F|_P)?\(%s, %s\)" % test, name)

    def test_each_plays_under_its_own_hand(self):
        for folder in sorted(folder for folder in SCENES.iterdir() if folder.is_dir()):
            with self.subTest(folder.name):
                scene, hand = folder / (folder.name + ".scene.json"), folder / "stroke.csv"
                image, path, log = (self.folder / name for name in ("scene.thim", "path.csv", "log.csv"))
                self.ok("compile", scene, "--output", image)
                with hand.open(newline="") as file:
                    rows = list(csv.DictReader(file))
                self.assertGreaterEqual(max(float(row["time_s"]) for row in rows), 4.0)
                # The whole firmware with its arm, until some time after the first touch.
                end = self.first_touch(image, hand, log) + PLAYED_S
                after = min((float(row["time_s"]) for row in rows if float(row["time_s"]) > end), default=end)
                kept = [row for row in rows if float(row["time_s"]) <= after]
                with path.open("w", newline="") as file:
                    writer = csv.DictWriter(file, rows[0].keys())
                    writer.writeheader()
                    writer.writerows(kept)
                self.ok("simulate", image, "--path", path, "--log", log)

    def first_touch(self, image, hand, log):
        self.ok("simulate", image, "--path", hand, "--ideal", "--rate", 500, "--log", log)
        with log.open(newline="") as file:
            for row in csv.DictReader(file):
                if max(abs(float(row[f"force_{axis}_N"])) for axis in "xyz") > 0.1:
                    return float(row["time_s"])
        self.fail("its hand feels nothing")

    def test_every_limit_is_shown(self):
        limits = self.ok_json("info", "--device", self.sim().pty)["limits"]
        text = self.ok("info").out
        constants = re.findall(r"inline constexpr (?:std::size_t|float) k(\w+) = ([^;]+);",
                               (ROOT / "control/scene/limits.h").read_text())
        self.assertGreater(len(constants), 15)
        for name, value in constants:
            camel, _, unit = name.partition("_")
            key = re.sub(r"(?<=[a-z])(?=[A-Z])", "_", camel).lower() + ("_" + unit if unit else "")
            number = eval(re.sub(r"std::size_t\{(\d+)\}", r"\1", value).replace("U", "").replace("F", ""))  # 1U << 20U, 1.0e5F
            self.assertEqual(limits[key], number, key)
            self.assertRegex(text, r"\n +%s +\S+" % key)


if __name__ == "__main__":
    unittest.main()

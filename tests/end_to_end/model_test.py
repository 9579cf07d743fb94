"""thimble model: arm files are checked, shown, listed, compiled, made from a URDF, and simulated."""

import csv
import json
import random
import re
import subprocess
import unittest
from pathlib import Path

from rig import BIN, Rig

ARMS = Path(__file__).parents[2] / "arms"
URDF = """<robot name="two"><link name="base"/><link name="a"/><link name="b"/>
<joint name="shoulder" type="revolute"><parent link="base"/><child link="a"/><origin xyz="0 0 0.1"/><axis xyz="0 0 1"/>
<limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
<joint name="elbow" type="revolute"><parent link="a"/><child link="b"/><origin xyz="0.2 0 0"/><axis xyz="0 0 1"/>
<limit lower="0.5" upper="2" effort="1" velocity="1"/></joint>
<link name="tip"/><joint name="end" type="fixed"><parent link="b"/><child link="tip"/><origin xyz="0.15 0 0"/></joint></robot>"""


class Model(Rig):
    def test_every_arm_that_comes_with_it(self):
        names = [path.name.removesuffix(".arm.json") for path in sorted(ARMS.glob("*.arm.json"))]
        models = self.ok_json("model", "list")["models"]
        self.assertEqual([model["name"] for model in models], names)
        text = self.ok("model", "list").out
        for model in models:
            self.assertIn(model["name"], text)
            by_name = self.ok_json("model", "show", model["name"])
            self.assertEqual(by_name, self.ok_json("model", "show", ARMS / f"{model['name']}.arm.json"))
            self.assertEqual((by_name["force_dof"], by_name["pose_dof"]), (model["force_dof"], model["pose_dof"]))
            self.assertEqual(by_name["warnings"], [])
            self.assertIn(by_name["source"], self.ok("model", "show", model["name"]).out)
        self.assertEqual(set(self.ok("__complete", "model", "show", "p").out.split()), {":files", "paddle", "pantograph", "premium-1.5"})

    def test_a_wrong_file_is_named_with_its_line(self):
        arm = json.loads((ARMS / "pantograph.arm.json").read_text())
        arm["axes"][0]["encoder"]["sign"] = 2
        wrong = self.folder / "mine.arm.json"
        wrong.write_text(json.dumps(arm, indent=1))
        for verb in "check", "show":
            error = self.fails(10, "bad-value", "model", verb, wrong)
            self.assertRegex(error["cause"], r"mine\.arm\.json:\d+: /axes/0/encoder/sign is 2, allowed is a number from -1.0 to 1.0")
        self.fails(10, "cannot-read", "model", "check", "no-such-arm")
        self.fails(2, "usage", "model")
        self.fails(2, "usage", "model", "chek", wrong)

    def test_warnings(self):
        arm = json.loads((ARMS / "pantograph.arm.json").read_text())
        arm["limits"]["max_force_N"] = 20
        arm["axes"][0]["encoder"]["counts_per_turn"] = 400
        weak = self.folder / "weak.arm.json"
        weak.write_text(json.dumps(arm))
        warnings = self.ok_json("model", "check", weak)["warnings"]
        self.assertEqual(len(warnings), 2)
        self.assertIn("less than half of max_force_N", warnings[0])
        self.assertIn("one count of axis first", warnings[1])

    def test_an_arm_from_a_urdf(self):
        urdf, made = self.folder / "two.urdf", self.folder / "mine.arm.json"
        urdf.write_text(URDF)
        self.assertEqual(self.ok_json("model", "import", "urdf", urdf, "--output", made)["axes"], ["shoulder", "elbow"])
        shown = self.ok_json("model", "show", made)
        self.assertEqual((shown["name"], shown["force_dof"]), ("mine", 2))
        self.assertEqual(shown["axes"][0]["home_rad"], 0)
        self.assertAlmostEqual(shown["axes"][1]["home_rad"], 1.25, places=9)  # the middle of its limits
        unlimited = self.folder / "unlimited.urdf"
        unlimited.write_text(re.sub(r' lower="[^"]*" upper="[^"]*"', "", URDF, count=1))
        result = self.ok("model", "import", "urdf", unlimited, "--output", self.folder / "unlimited.arm.json")
        self.assertRegex(result.err, "warning: as it is, `thimble model check` refuses it: empty-range: ")
        self.assertIsNone(self.ok_json("model", "import", "urdf", urdf, "--output", made)["refused"])
        self.fails(10, "unknown-link", "model", "import", "urdf", urdf, "--tip", "hand", "--output", made)
        self.fails(2, "bad-output", "model", "import", "urdf", urdf, "--output", self.folder / "mine.json")
        self.fails(2, "same-file", "model", "import", "urdf", made, "--output", made)
        broken = self.folder / "broken.urdf"
        broken.write_text(URDF[:100])
        before = made.read_bytes()
        self.fails(10, "not-a-urdf", "model", "import", "urdf", broken, "--output", made)
        broken.write_text(URDF.replace('"shoulder"', '"a_shoulder_with_a_name_beyond_31_bytes"'))
        error = self.fails(10, "bad-name", "model", "import", "urdf", broken, "--output", made)
        self.assertIn("a_shoulder_with_a_name_beyond_31_bytes", error["cause"])
        broken.write_text(URDF.replace('xyz="0.2 0 0"', 'xyz="3 0 0"'))
        error = self.fails(10, "bad-value", "model", "import", "urdf", broken, "--output", made)
        self.assertIn("broken.urdf as an arm file", error["cause"])
        self.assertEqual(made.read_bytes(), before)

    def own_arm(self, name, change):
        arm = json.loads((ARMS / "touch.arm.json").read_text())
        arm["name"] = name
        change(arm)
        file = self.folder / (name + ".arm.json")
        file.write_text(json.dumps(arm))
        return file

    def test_a_simulated_arm_of_ones_own(self):
        scene, path = self.plane_scene(stiffness=500), self.folder / "down.csv"
        path.write_text("time_s,x_m,y_m,z_m\n0,0,0,0.01\n1,0,0,0.01\n1.5,0,0,-0.02\n2,0,0,-0.02\n")

        def simulated(arm):
            log = self.folder / "own.csv"
            self.ok("simulate", scene, "--path", path, "--arm", arm, "--log", log)
            with open(log) as rows:
                return list(csv.DictReader(rows))

        def limited_to(force_N):
            return lambda arm: arm["limits"].update(max_force_N=force_N)

        published = simulated("touch")
        limit_N = self.ok_json("model", "show", "touch")["max_force_N"]
        self.assertEqual(simulated(self.own_arm("same", limited_to(limit_N))), published)
        for factor in 0.75, 0.25:
            rows = simulated(self.own_arm("weak", limited_to(factor * limit_N)))
            self.assertEqual(rows[0].keys(), published[0].keys())
            self.assertEqual({row["arm"] for row in rows}, {"0"})
            most_N = max(sum(float(row["force_%s_N" % axis]) ** 2 for axis in "xyz") ** 0.5 for row in rows)
            self.assertAlmostEqual(most_N, factor * limit_N, delta=0.01)
            self.assertNotEqual(rows, published)
        for arm in "chain-7", "pantograph":  # seven axes and two: a row has the tip, whatever the axes
            self.assertEqual(simulated(arm)[0].keys(), published[0].keys())
        arguments = ("simulate", scene, "--path", path, "--log", self.folder / "never.csv", "--arm")
        self.fails(2, "unknown-arm", *arguments, "no-such-arm")
        error = self.fails(10, "bad-value", *arguments, self.own_arm("wrong", limited_to(-1)))
        self.assertIn("/limits/max_force_N", error["cause"])
        self.assertFalse((self.folder / "never.csv").exists())

    def test_an_image_of_ones_own_arm(self):
        limited = self.own_arm("mine", lambda arm: arm["limits"].update(max_force_N=1.5))
        image = self.folder / "mine.tarm"
        compiled = self.ok_json("model", "compile", limited, "-o", image)
        self.assertEqual((compiled["name"], compiled["bytes"] + 8), ("mine", image.stat().st_size))
        sim = self.sim("--tcp", 0, "--arm", image)
        self.assertEqual(self.ok_json("info", "--device", sim.tcp)["arm"], "mine")
        self.assertEqual(sim.stop(), 0)

    def refused_image(self, bytes_):
        file = self.folder / "damaged.tarm"
        file.write_bytes(bytes_)
        result = subprocess.run([BIN / "thimble-sim", "--arm", file, "--no-pty", "--tcp", "0"], capture_output=True, text=True,
                                env=self.environment, timeout=20)
        self.assertEqual((result.returncode, result.stdout), (1, ""), result.stderr)
        self.assertIn("thimble-sim: bad-arm-image: %s: " % file, result.stderr)
        self.assertIn("remedy: make it anew with `thimble model compile", result.stderr)
        return result.stderr

    def test_damaged_images(self):
        image = self.folder / "sound.tarm"
        self.ok("model", "compile", "touch", "-o", image)
        sound = image.read_bytes()
        chance = random.Random(1)
        for i in range(200):  # a number with another bit is a number, too: only the CRC-32 tells
            place, bit, size = chance.randrange(len(sound)), chance.randrange(8), chance.randrange(1, len(sound))
            with self.subTest(i=i, place=place, bit=bit, size=size):
                if i % 4 == 3:
                    self.refused_image(sound[:size])
                else:
                    said = self.refused_image(sound[:place] + bytes([sound[place] ^ 1 << bit]) + sound[place + 1:])
                    self.assertIn("damaged" if place < len(sound) - 8 or place >= len(sound) - 4 else "CRC1", said)
        self.assertIn("empty", self.refused_image(b""))
        self.assertIn("CRC1", self.refused_image(sound[:-8]))  # an image without the trailer
        self.assertIn("CRC1", self.refused_image(b"\x7fELF" + 100 * b"foreign"))
        self.assertIn("larger", self.refused_image(bytes(100000)))
        scene = self.image(self.plane_scene())  # a sound trailer behind something else
        self.assertIn("not_an_arm", self.refused_image(scene.read_bytes()))


if __name__ == "__main__":
    unittest.main()

"""thimble model: arm files are checked, shown, listed, and made from a URDF."""

import json
import unittest
from pathlib import Path

from rig import Rig

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
        self.assertEqual(set(self.ok("__complete", "model", "show", "p").out.split()), {"paddle", "pantograph", "premium-1.5"})

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
        self.fails(10, "unknown-link", "model", "import", "urdf", urdf, "--tip", "hand", "--output", made)
        self.fails(2, "bad-output", "model", "import", "urdf", urdf, "--output", self.folder / "mine.json")
        self.fails(2, "same-file", "model", "import", "urdf", made, "--output", made)
        broken = self.folder / "broken.urdf"
        broken.write_text(URDF[:100])
        before = made.read_bytes()
        self.fails(10, "not-a-urdf", "model", "import", "urdf", broken, "--output", made)
        broken.write_text(URDF.replace('"shoulder"', '"a_shoulder_with_a_name_beyond_31_bytes"'))
        error = self.fails(10, "bad-value", "model", "import", "urdf", broken, "--output", made)
        self.assertIn("broken.urdf as an arm file", error["cause"])
        self.assertEqual(made.read_bytes(), before)


if __name__ == "__main__":
    unittest.main()

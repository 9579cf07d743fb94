"""What is not an error and has to be told: solids that a tip begins inside of, solids that an arm cannot hold still, and what a scene costs."""

import json
import random
import unittest
from pathlib import Path

from rig import Rig

SCENES = Path(__file__).resolve().parents[2] / "scenes"
ARMS = SCENES.parent / "arms"


class TooStiff(Rig):
    def test_what_is_too_stiff_is_a_warning(self):
        image = self.folder / "a.thim"
        scene = self.plane_scene(stiffness=12000)
        said = self.ok("compile", scene, "--output", image).err
        self.assertIn("warning: floor: 12000 N/m with a damping of 1 N s/m can oscillate; premium-1.5 at 4000 Hz holds up to "
                      "11000 N/m", said)
        self.assertEqual(self.ok_json("compile", scene, "--output", image, "--rate", "10000")["warnings"], [])
        self.assertEqual(len(self.ok_json("compile", scene, "--output", image, "--rate", "1000")["warnings"]), 1)
        self.assertEqual(self.ok_json("compile", scene, "--output", image, "--arm", "wooden")["warnings"], [])
        self.fails(2, "unknown-arm", "compile", scene, "--output", image, "--arm", "wodden")
        self.fails(2, "bad-rate", "compile", scene, "--output", image, "--rate", "50")


class OfAnArmFile(Rig):
    def own_arm(self, walls):
        """The paddle with another name and with the walls that a commissioning has found."""
        arm = json.loads((ARMS / "paddle.arm.json").read_text())
        arm["name"] = "own"
        arm["limits"]["largest_walls"] = [{"rate_Hz": rate, "damping_N_s_m": damping, "stiffness_N_m": {"value": stiffness, "by": "test"}}
                                          for rate, damping, stiffness in walls]
        file = self.folder / "own.arm.json"
        file.write_text(json.dumps(arm))
        return file

    def test_compile_warns_of_what_its_walls_do_not_allow(self):
        arm = self.own_arm([(4000, 0, 900), (4000, 2, 500), (1000, 0, 100), (1000, 2, 0)])
        scene, image = self.plane_scene(stiffness=800, damping=1), self.folder / "a.thim"
        told = ("floor: 800 N/m with a damping of 1 N s/m can oscillate; own at 4000 Hz holds up to 700 N/m "
                "(limits.largest_walls of own.arm.json)")
        for option in ("--model", "--arm"):
            self.assertEqual(self.ok_json("compile", scene, "--output", image, option, arm)["warnings"], [told])
        self.assertIn("own at 2000 Hz holds up to 260 N/m",
                      self.ok("compile", scene, "--output", image, "--model", arm, "--rate", "2000").err)
        self.assertEqual(self.ok_json("compile", self.plane_scene(stiffness=690, damping=1), "--output", image, "--model", arm)["warnings"], [])
        self.assertIn("floor: a damping of 3 N s/m can oscillate; own is known to hold up to 2 N s/m",
                      self.ok("compile", self.plane_scene(stiffness=400, damping=3), "--output", image, "--model", arm).err)

    def test_an_image_is_an_arm_too_and_a_damaged_one_is_refused(self):
        scene, image, arm = self.plane_scene(stiffness=12000), self.folder / "a.thim", self.folder / "p.tarm"
        self.ok("model", "compile", "premium-1.5", "--output", arm)
        self.assertIn("premium-1.5 at 4000 Hz holds up to 11000 N/m",
                      self.ok("compile", scene, "--output", image, "--model", arm).err)
        bytes_of_it = bytearray(arm.read_bytes())
        bytes_of_it[100] ^= 1
        arm.write_bytes(bytes_of_it)
        self.fails(10, "bad-arm-image", "compile", scene, "--output", image, "--model", arm)

    def test_upload_knows_the_walls_of_an_arm_that_was_uploaded_from_here(self):
        arm = self.own_arm([(4000, 0, 900), (4000, 2, 500)])
        scene = self.plane_scene(stiffness=800, damping=1)
        uri = self.sim("--no-pty", "--tcp", 0, "--store", self.folder / "walls.store").tcp
        self.assertEqual(self.ok_json("upload", scene, "--device", uri)["warnings"], [])
        self.assertEqual(self.ok_json("upload", scene, "--device", uri, "--model", "wooden")["warnings"],
                         ["--model names wooden, and the arm of the device is premium-1.5"])
        self.ok("model", "upload", arm, "--device", uri)
        told = self.ok_json("upload", scene, "--device", uri)["warnings"]
        self.assertEqual(len(told), 1, told)
        self.assertRegex(told[0], r"floor: 800 N/m with a damping of 1 N s/m can oscillate; own at \d+ Hz holds up to [67]\d0 N/m "
                                  r"\(limits.largest_walls of its arm file\)")
        kept = list((self.runtime / "data" / "thimble" / "arms").iterdir())
        self.assertEqual([file.read_text() for file in kept], [arm.read_text()])
        kept[0].unlink()
        self.assertEqual(self.ok_json("upload", scene, "--device", uri)["warnings"], [])
        self.assertIn("holds up to", self.ok("upload", scene, "--device", uri, "--model", arm).err)


class OutOfReach(Rig):
    def scene(self, **places):
        file = self.folder / "places.scene.json"
        file.write_text(json.dumps({"thimble_scene": 1, "name": "places", "materials": {"soft": {"stiffness_N_m": 300}},
                                    "objects": [{"name": name, "shape": {"sphere": {"radius_m": 0.01}}, "material": "soft",
                                                 "pose": {"position_m": place}} for name, place in places.items()]}))
        return file

    def test_what_the_arm_cannot_touch_is_a_warning(self):
        image = self.folder / "a.thim"
        scene = self.scene(near=[0, 0.02, 0], high=[0, 0, 0.06], far=[0, 0, -2])
        for model, unreached in (("premium-1.5", ["far"]), ("pantograph", ["high", "far"])):
            told = self.ok_json("compile", scene, "--output", image, "--model", model)["warnings"]
            self.assertEqual([text.split(":")[0] for text in told], unreached, told)
        self.assertIn("warning: high: out of reach; the tip of pantograph comes no nearer than 50 mm",
                      self.ok("compile", scene, "--output", image, "--model", "pantograph").err)


class Cost(Rig):
    def crossing_scene(self):
        """Heaps of tetrahedra, all through each other."""
        dice = random.Random(1)
        lines = []
        for solid in range(60):
            middle = [dice.uniform(-0.02, 0.02) for _ in range(3)]
            for signs in ((1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1)):
                lines.append("v {:.6f} {:.6f} {:.6f}".format(*(m + 0.02 * sign * dice.uniform(0.3, 1.0) for m, sign in zip(middle, signs))))
            lines += ["f {} {} {}".format(*(4 * solid + 1 + corner for corner in face)) for face in ((0, 1, 2), (0, 3, 1), (0, 2, 3), (1, 3, 2))]
        (self.folder / "heap.obj").write_text("\n".join(lines) + "\n")
        heaps = [{"name": f"heap {n}", "shape": {"mesh": {"file": "heap.obj"}}, "material": "hard",
                  "pose": {"position_m": [0.005 * n - 0.04, 0, 0], "rotation_deg": [20 * n, 0, 0]}} for n in range(16)]
        file = self.folder / "crossing.scene.json"
        file.write_text(json.dumps({"thimble_scene": 1, "name": "crossing", "objects": heaps, "materials": {"hard": {"stiffness_N_m": 1000}}}))
        return file

    def test_compile_tells_what_a_scene_takes_of_a_board(self):
        image = self.folder / "a.thim"
        scene = self.plane_scene()
        said = self.ok("compile", scene, "--output", image, "--board", "zynqmp")
        self.assertRegex(said.out, r"cost at 4000 Hz on zynqmp: typical [\d ]+, worst [\d ]+ of 125 000 instructions; no tick puts anything off")
        self.assertEqual(said.err, "")
        self.assertNotIn("cost", self.ok_json("compile", scene, "--output", image))
        for rate in (4000, 10000):
            cost = self.ok_json("compile", scene, "--output", image, "--board", "mps2-an500", "--rate", rate)["cost"]
            self.assertEqual((cost["board"], cost["rate_Hz"], cost["period_instructions"], cost["work_units"], cost["fits"]),
                             ("mps2-an500", rate, 480e6 / rate, 1.2e6 / rate, True))
            self.assertTrue(4000 < cost["typical_instructions"] < 10000 < cost["worst_instructions"] < 20000, cost)
        self.fails(2, "unknown-board", "compile", scene, "--output", image, "--board", "zinc")

    def test_what_does_not_fit_is_a_warning_with_a_rate_that_does(self):
        image = self.folder / "a.thim"
        scene = self.crossing_scene()
        compiled = self.ok_json("compile", scene, "--output", image, "--board", "mps2-an500")
        cost = compiled["cost"]
        self.assertEqual(self.ok_json("compile", scene, "--output", image, "--board", "mps2-an500")["cost"], cost)
        self.assertFalse(cost["fits"])
        self.assertGreater(cost["put_off"], 0.1)
        self.assertRegex(compiled["warnings"][-1], "heap [0-9]+: most ticks of a contact put something off at 4000 Hz on mps2-an500")
        # Eight objects that push each other fit at a lower rate.
        multy = SCENES / "multy3" / "multy3.scene.json"
        cost = self.ok_json("compile", multy, "--output", image, "--board", "zynqmp", "--rate", "10000")["cost"]
        self.assertFalse(cost["fits"])
        fits_Hz = cost["fits_Hz"]
        self.assertEqual(fits_Hz % 250, 0)
        self.assertTrue(250 <= fits_Hz < 10000)
        self.assertTrue(self.ok_json("compile", multy, "--output", image, "--board", "zynqmp", "--rate", fits_Hz)["cost"]["fits"])
        self.assertIn(f"lower the rate to {fits_Hz:.0f} Hz, or simplify it",
                      self.ok("compile", multy, "--output", image, "--board", "zynqmp", "--rate", "10000").err)

    def test_upload_asks_the_device_for_its_board(self):
        uri = self.sim("--tcp", 0, "--rate", "10000").tcp
        cost = self.ok_json("upload", self.plane_scene(), "--device", uri)["cost"]
        self.assertEqual((cost["board"], cost["work_units"], cost["fits"]), ("sim", 4000, True))
        self.assertNotIn("typical_instructions", cost)
        self.assertRegex(self.ok("upload", self.crossing_scene(), "--device", uri).out,
                         r"cost at \d+ Hz on sim: typical [\d ]+, worst [\d ]+ of 4000 units")


class Inside(Rig):
    def path(self, text):
        file = self.folder / "hand.csv"
        file.write_text(text)
        return file

    def test_a_path_that_begins_inside_is_told(self):
        scene = self.plane_scene(stiffness=1000)
        log = self.folder / "log.csv"
        rows = "0,-0.1,0,-0.004,0\n0.4,-0.1,0,0.004,0\n0.8,-0.1,0,-0.004,0\n0,0.1,0,-0.004,1\n0.8,0.1,0,-0.002,1\n"
        path = self.path("time_s,x_m,y_m,z_m,arm\n" + rows)
        for options in (("--ideal",), ()):
            result = self.ok_json("simulate", scene, "--path", path, "--log", log, *options)
            first, second = result["inside"]
            self.assertEqual([first["arm"], first["object"], first["from_s"]], [0, "floor", 0])
            self.assertAlmostEqual(first["until_s"], 0.2, delta=0.03)
            self.assertEqual([second["arm"], second["object"], second["until_s"]], [1, "floor", None])
            self.assertEqual(sum("move out" in warning for warning in result["warnings"]), 2)
            table = [line.split(",") for line in log.read_text().splitlines()[1:]]
            within = [row for row in table if row[1] == "1" or float(row[0]) < 0.15]
            self.assertEqual({row[11] for row in within}, {"0"})
            self.assertEqual(max(int(row[11]) for row in table if row[1] == "0"), 1, "felt once it has left")
            said = self.ok("simulate", scene, "--path", path, "--log", log, *options).err
            self.assertIn("warning: the tip of arm 1 is inside floor from 0 s to the end of the path: move out", said)
        # A step of 200 m/s is no move.
        path = self.path("time_s,x_m,y_m,z_m\n0,0,0,0.01\n0.1,0,0,0.01\n0.10025,0,0,-0.04\n0.2,0,0,-0.04\n")
        result = self.ok_json("simulate", scene, "--path", path, "--log", log, "--ideal")
        self.assertAlmostEqual(result["inside"][0]["from_s"], 0.10025, delta=3e-4)
        self.assertEqual(result["peak_force_N"], 0)

    def test_a_tip_armed_inside_a_solid_is_told(self):
        uri = self.sim("--tcp", 0).tcp
        uploaded = self.ok_json("upload", self.plane_scene(stiffness=12000, offset_m=0.02), "--device", uri)
        self.assertIn("floor: 12000 N/m", uploaded["warnings"][0])
        self.ok("home", "--device", uri)
        self.assertEqual(self.ok_json("info", "--device", uri)["inside"], [])
        self.ok("arm", "--device", uri)
        self.wait_for_mode(uri, "armed")  # info tells what the last telemetry record had
        self.assertEqual(self.ok_json("info", "--device", uri)["inside"], [{"arm": 0, "object": 0, "name": "floor"}])
        self.assertIn("inside     the tip of arm 0 is inside floor: move out", self.ok("info", "--device", uri).out)
        lines = [json.loads(line) for line in self.ok("monitor", "--json", "--seconds", "1", "--device", uri).out.splitlines()]
        inside = [line for line in lines if line["message"] == "Inside"]
        self.assertEqual((inside[0]["arm"], inside[0]["object"], inside[0]["name"]), (0, 0, "floor"))
        rows = self.ok("monitor", "--seconds", "1", "--device", uri)
        self.assertEqual(rows.err.count("the tip of arm 0 is inside floor: move out"), 1)
        # Moved away by a new scene.
        self.assertEqual(self.ok_json("upload", self.plane_scene(offset_m=-0.02), "--device", uri)["warnings"], [])
        self.assertEqual(self.ok_json("info", "--device", uri)["inside"], [])


if __name__ == "__main__":
    unittest.main()

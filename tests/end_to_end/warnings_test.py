"""What is not an error and has to be told: solids that a tip begins inside of, and solids that an arm cannot hold still."""

import json
import unittest

from rig import Rig


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

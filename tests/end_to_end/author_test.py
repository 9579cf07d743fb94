"""A scene's author: a scene to begin with, its overview, and a simulation that runs again on each save."""

import json
import signal
import subprocess
import unittest
from pathlib import Path

from rig import BIN, Rig

SCENES = Path(__file__).resolve().parents[2] / "scenes"


class Author(Rig):
    def test_a_new_scene(self):
        file = self.folder / "my first.scene.json"
        for name in (self.folder / "my first", file):
            self.assertEqual(self.ok_json("new", name)["scene"], str(file))
            self.assertIn('"name": "my first"', file.read_text())
            self.assertEqual(self.ok_json("compile", file, "--output", self.folder / "image")["warnings"], [])
            self.fails(1, "file-exists", "new", name)
            file.unlink()
        for name in ("", "a/", "x" * 32, "na\"me", "../.scene.json"):
            self.fails(2, "bad-name", "new", name)

    def test_a_drawer_of_the_new_scene_clicks(self):
        self.ok("new", self.folder / "mine")
        path = self.folder / "pull.csv"
        path.write_text("time_s,x_m,y_m,z_m\n0,0.04,0,0.02\n1,0.04,0,-0.008\n3,0.058,0,-0.008\n")
        run = self.ok_json("simulate", self.folder / "mine.scene.json", "--path", path, "--log", self.folder / "log.csv")
        self.assertGreater(run["contact_rows"], 1000)
        self.assertEqual(run["inside"], [])

    def test_scenes_are_shown(self):
        for name in ("walls", "buttons", "baboon", "needle", "deform", "textures"):  # every kind of object has its own size
            scene = SCENES / name / f"{name}.scene.json"
            shown, compiled = self.ok_json("show", scene), self.ok_json("compile", scene, "--output", self.folder / "image")
            self.assertEqual((shown["scene"], shown["bytes"]), (compiled["scene"], compiled["bytes"]))
            self.assertEqual([(it["name"], it["shape"]) for it in shown["objects"]],
                             [(it["name"], it["shape"]) for it in compiled["objects"]])
            self.assertEqual([it["triangles"] for it in shown["objects"]],
                             [it.get("mesh", {"triangles": 0})["triangles"] for it in compiled["objects"]])
            self.assertLess(sum(it["bytes"] for it in shown["objects"]), shown["bytes"])
            self.assertEqual([cost["board"] for cost in shown["costs"]], ["mps2-an500", "zynqmp", "linux", "sim"])
            text = self.ok("show", scene).out
            for it in shown["objects"]:
                self.assertIn(f" {it['name']}: {it['shape']}, ", text)

    def test_a_force_field_is_shown(self):
        scene = self.folder / "fields.scene.json"
        scene.write_text(json.dumps({"thimble_scene": 1, "name": "fields", "objects": [
            {"name": "wind", "shape": {"force_field": {"constant_N": [1, 0, 0], "curl_N_s_m": [0, 0, 9], "trial": 3}}},
            {"name": "cup", "shape": {"force_field": {"mass": {"mass_kg": 1, "stiffness_N_m": 9}, "size_m": [0.1, 0.2, 0.3]}}}]}))
        wind, cup = self.ok_json("show", scene)["objects"]
        self.assertEqual((wind["size_m"], wind["effects"], "material" in wind), (3 * [None], ["constant", "curl", "in trial 3"], False))
        self.assertEqual(([round(side, 6) for side in cup["size_m"]], cup["effects"]), ([0.1, 0.2, 0.3], ["mass"]))
        self.assertIn("acts: constant, curl, in trial 3", self.ok("show", scene).out)

    def test_the_field_of_a_trial_is_felt(self):
        scene, path = self.folder / "trials.scene.json", self.folder / "rest.csv"
        scene.write_text(json.dumps({"thimble_scene": 1, "name": "trials", "objects": [
            {"name": f"wind {trial}", "shape": {"force_field": {"constant_N": [trial, 0, 0], "trial": trial}}} for trial in (1, 2)]}))
        path.write_text("time_s,x_m,y_m,z_m\n0,0,0,0\n0.1,0,0,0\n")
        for options, peak_N in (((), 0), (("--trial", 1), 1), (("--trial", 2), 2), (("--trial", 3), 0)):
            for ideal in ((), ("--ideal",)):
                run = self.ok_json("simulate", scene, "--path", path, "--log", self.folder / "log.csv", *options, *ideal)
                self.assertAlmostEqual(run["peak_force_N"], peak_N, places=5)
        self.fails(2, "usage", "simulate", scene, "--path", path, "--log", self.folder / "log.csv", "--trial", 256)

    def test_what_is_shown(self):
        scene = self.folder / "box.scene.json"
        scene.write_text(json.dumps({
            "thimble_scene": 1, "name": "box", "objects": [
                {"name": "lid", "shape": {"box": {"size_m": [0.04, 0.03, 0.02]}}, "pose": {"position_m": [0.01, 0, -0.02]},
                 "material": {"stiffness_N_m": 700, "static_friction": 0.5, "dynamic_friction": 0.4,
                              "click": {"amplitude_N": 0.8, "frequency_Hz": 150, "decay_per_s": 90}},
                 "body": {"motion": "slide", "axis": [1, 0, 0], "mass_kg": 0.05, "control": {"friction_N": 0.2, "low_m": -0.02, "high_m": 0.02}}},
                {"name": "floor", "shape": {"plane": {"normal": [0, 0, 1], "offset_m": -0.1}}, "material": {"stiffness_N_m": 800}}]}))
        lid, floor = self.ok_json("show", scene)["objects"]
        for axis, side in enumerate((0.04, 0.03, 0.02)):
            self.assertAlmostEqual(lid["size_m"][axis], side, places=7)
        self.assertEqual((lid["effects"], lid["body"]["motion"], lid["body"]["control"]), (["click"], "slide", ["friction"]))
        self.assertAlmostEqual(lid["body"]["mass_kg"], 0.05)
        self.assertEqual((floor["size_m"], "body" in floor), ([None] * 3, False))
        self.assertAlmostEqual(floor["position_m"][2], -0.1)
        text = self.ok("show", scene).out
        self.assertIn("lid: box, 40 x 30 x 20 mm, at (10, 0, -20) mm", text)
        self.assertIn("moves: slide, 0.05 kg; friction", text)
        self.assertIn("floor: plane, without end, at (0, 0, -100) mm", text)
        scene.write_text("{")
        self.fails(10, "bad-json", "show", scene)
        self.fails(2, "usage", "show", scene, "--rate", 50)

    def test_watched(self):
        scene = self.plane_scene("watched", stiffness=400, offset_m=-0.01)
        path, log = self.folder / "hand.csv", self.folder / "log.csv"
        path.write_text("time_s,x_m,y_m,z_m\n0,0,0,0.01\n0.2,0,0,-0.02\n0.3,0,0,-0.02\n")
        watch = subprocess.Popen([BIN / "thimble", "simulate", scene, "--path", path, "--log", log, "--ideal", "--watch", "--json"],
                                 stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=self.environment)
        self.addCleanup(lambda: (watch.poll() is None and watch.kill(), watch.communicate()))
        decoder = json.JSONDecoder()

        def told(stream):
            text = ""
            while True:
                text += stream.readline()
                try:
                    return decoder.decode(text)
                except json.JSONDecodeError:
                    self.assertTrue(text.strip(), "it has ended")

        def save(file, text):  # as editors do
            draft = self.folder / "draft"
            draft.write_text(text)
            draft.rename(file)

        soft = told(watch.stdout)["peak_force_N"]
        good = scene.read_text()
        save(scene, good.replace("400", "800"))
        self.assertAlmostEqual(told(watch.stdout)["peak_force_N"], 2 * soft, delta=0.2)  # its damping stays
        before = log.read_bytes()
        save(scene, "{")  # the log of the last run stays
        self.assertEqual(told(watch.stderr)["error"]["name"], "bad-json")
        self.assertEqual(log.read_bytes(), before)
        save(scene, good)
        self.assertAlmostEqual(told(watch.stdout)["peak_force_N"], soft, delta=1e-3)
        save(path, path.read_text().replace("-0.02", "-0.03"))
        self.assertGreater(told(watch.stdout)["peak_force_N"], 1.8 * soft)
        # A file that the scene names is broken, and mended.
        save(path, "time_s,x_m,y_m,z_m\n0,0,0,0.1\n0.2,0,0,0.04\n")
        told(watch.stdout)
        save(scene, self.ball_scene(4, "ball").read_text())
        self.assertGreater(told(watch.stdout)["peak_force_N"], 1)
        mesh = self.folder / "ball.obj"
        whole = mesh.read_text()
        save(mesh, "nothing")
        self.assertEqual(told(watch.stderr)["error"]["exit_code"], 10)
        save(mesh, whole)
        self.assertGreater(told(watch.stdout)["peak_force_N"], 1)
        watch.send_signal(signal.SIGINT)
        self.assertEqual(watch.wait(timeout=20), 0)
        self.fails(2, "unknown-arm", "simulate", scene, "--path", path, "--log", log, "--watch", "--arm", "none")


if __name__ == "__main__":
    unittest.main()

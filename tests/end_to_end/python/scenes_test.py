"""Scenes as dicts: builder functions, compilation with all errors at once, and materials that change while the scene runs."""

import inspect
import json
import pickle
import sys
import types
import unittest
from pathlib import Path

import numpy as np
import thimble

ROOT = Path(__file__).resolve().parents[3]
sys.path.insert(0, str(ROOT / "tests/end_to_end"))
from rig import Rig  # noqa: E402

SCHEMA = json.loads((ROOT / "host-tools/compiler/scene.schema.json").read_text())["$defs"]


def bench(**material):
    return thimble.scene("bench", thimble.box("wall", size_m=[0.1, 0.1, 0.02], material=thimble.material(**{"stiffness_N_m": 600, **material})))


class Scenes(Rig):
    def test_a_dict_is_the_file(self):
        """Every demonstration as a dict, its files beside it: the same bytes as `thimble compile` writes."""
        for name in ("walls", "asteroid", "buttons"):
            file, image = ROOT / f"scenes/{name}/{name}.scene.json", self.folder / (name + ".thim")
            scene = json.loads(file.read_text())
            ours = thimble.compile(scene, folder=file.parent)
            self.assertEqual(ours, thimble.compile(file))
            self.ok("compile", file, "--output", image)
            self.assertEqual(ours, image.read_bytes()[:len(ours)])

    def test_builders_make_what_the_file_says(self):
        file = ROOT / "scenes/buttons/buttons.scene.json"
        button = json.loads(file.read_text())["objects"][1]
        curve = np.array(button["body"]["control"]["curve_m_N"])
        built = thimble.cylinder(
            "click button", radius_m=0.009, height_m=0.01, position_m=np.array([-0.095, 0.035, -0.036]), material="plastic",
            body=thimble.body(motion="slide", mass_kg=0.02, axis=[0, 0, -1], control=thimble.slide_control(
                damping_N_s_m=0.5, low_m=0, high_m=0.0035, curve_m_N=curve, switch=thimble.slide_switch(on_at_m=0.002, off_at_m=0.001))))
        materials = {"plastic": thimble.material(stiffness_N_m=900, texture=thimble.texture(
            kind="height", pattern="ridges", tile_m=[0.002, 0.002], height_m=0.0001))}
        same = {"thimble_scene": 1, "name": "one", "objects": [button], "materials": materials}
        self.assertEqual(thimble.compile(thimble.scene("one", built, materials=materials)), thimble.compile(same))

    def test_there_is_a_builder_for_each_shape_and_part(self):
        for kind, schema in SCHEMA.items():
            if kind in ("scene", "object", "shape", "solid", "pose"):
                continue
            keys = set(inspect.signature(getattr(thimble, kind)).parameters)
            self.assertLessEqual(set(schema["properties"]), keys, kind)
            self.assertEqual(kind in SCHEMA["shape"]["properties"], {"position_m", "rotation_deg", "body"} <= keys, kind)
            self.assertEqual("material" in keys, kind in SCHEMA["shape"]["properties"] and kind != "force_field", kind)

    def test_a_misspelt_property_is_refused(self):
        for build, meant in ((lambda: thimble.box("wall", size=[1, 1, 1], material="wood"), "size_m"),
                             (lambda: thimble.material(stifness_N_m=5), "stiffness_N_m"),
                             (lambda: thimble.scene("bench", gravity=[0, 0, -9.81]), "gravity_m_s2"),
                             (lambda: thimble.body(motion="free", mas_kg=1), "mass_kg")):
            with self.assertRaisesRegex(TypeError, f"did you mean '{meant}'"):
                build()
        with self.assertRaisesRegex(TypeError, "radius_m"):
            thimble.sphere("ball", material="wood")

    def test_all_errors_at_once(self):
        scene = thimble.scene("bad", thimble.sphere("one", radius_m=-1, material="gold"), thimble.box("two", size_m=[1, 2], material={}))
        scene["colour"] = "red"
        with self.assertRaises(thimble.Error) as caught:
            thimble.compile(scene)
        error = caught.exception
        pointers = {issue["pointer"] for issue in error.issues}
        self.assertLessEqual({"/colour", "/objects/0/shape/sphere/radius_m", "/objects/1/shape/box/size_m"}, pointers)
        self.assertEqual(error.exit_code, 10)
        for issue in error.issues:
            self.assertIn(issue["cause"], str(error))
            self.assertNotIn(":1:", issue["cause"], "a dict has no lines")
            self.assertTrue(issue["remedy"])
        again = pickle.loads(pickle.dumps(error))
        self.assertEqual((str(again), again.issues), (str(error), error.issues))
        file = self.folder / "bad.scene.json"
        file.write_text(json.dumps(scene, indent=1))
        with self.assertRaises(thimble.Error) as caught:
            thimble.compile(file)
        self.assertEqual({issue["pointer"] for issue in caught.exception.issues}, pointers)
        self.assertGreater(max(issue["line"] for issue in caught.exception.issues), 10)
        with self.assertRaises(thimble.Error) as caught:
            thimble.compile(self.folder / "none.scene.json")
        self.assertEqual(caught.exception.name, "missing-scene")
        for number in (float("nan"), np.float32("inf")):  # which no JSON can hold
            with self.assertRaises(thimble.Error) as caught:
                thimble.compile(thimble.scene("bad", thimble.sphere("one", radius_m=number, material={"stiffness_N_m": 1, "colour": "red"})))
            causes = {issue["pointer"]: issue["cause"] for issue in caught.exception.issues}
            self.assertEqual(set(causes), {"/objects/0/shape/sphere/radius_m", "/objects/0/material/colour"})
            self.assertIn(str(float(number)), causes["/objects/0/shape/sphere/radius_m"])

        wall = thimble.box("wall", size_m=[0.1, 0.1, 0.02], material={"stiffness_N_m": 600})
        with self.assertRaises(thimble.Error) as caught:  # the format has a text there
            thimble.compile({**thimble.scene("s", wall), "name": float("nan")})
        self.assertIn("/name is no finite number", caught.exception.cause)
        with self.assertRaisesRegex(TypeError, "/objects/0/material/stiffness_N_m is .*, which has no place in a scene"):
            thimble.compile(thimble.scene("s", {**wall, "material": {"stiffness_N_m": np.longdouble(600)}}))

    def test_any_mapping_is_a_dict(self):
        wall = thimble.box("wall", size_m=np.array([0.1, 0.1, 0.02]), material={"stiffness_N_m": np.int64(600)})
        scene = thimble.scene("s", wall)
        self.assertEqual(thimble.compile(types.MappingProxyType({**scene, "objects": (types.MappingProxyType(wall),)})), thimble.compile(scene))

    def test_simulate_takes_a_dict_and_an_image(self):
        path = [[0, 0, 0, 0.02], [0.2, 0, 0, 0.008]]
        felt = thimble.simulate(bench(), path, ideal=True, rate_Hz=1000)
        np.testing.assert_array_equal(felt, thimble.simulate(thimble.compile(bench()), path, ideal=True, rate_Hz=1000))
        self.assertAlmostEqual(felt["force_N"][-1, 2], 600 * 0.002, delta=0.1)


class Live(Rig):
    def test_a_dict_is_uploaded_and_its_material_changed_in_contact(self):
        hand = self.folder / "press.csv"
        hand.write_text("time_s,x_m,y_m,z_m\n0,0,0,0.02\n0.5,0,0,0.002\n")
        sim = self.sim("--tcp", 0, "--hand", hand)
        with thimble.connect(sim.tcp) as device:
            with self.assertRaisesRegex(ValueError, "upload the scene first"):
                device.set_material("wall", stiffness_N_m=100)
            done = device.upload(bench())
            self.assertEqual((device.info["scene"], done["bytes"]), ("bench", len(thimble.compile(bench()))))
            device.home()
            device.arm()
            device.telemetry(seconds=2.5)

            def depth_stiffness():
                rows = device.telemetry(seconds=0.5)
                self.assertTrue((rows["contacts"] > 0).all())
                return np.median(rows["force_N"][:, 2] / (0.01 - rows["tip_m"][:, 2]))

            self.assertAlmostEqual(depth_stiffness(), 600, delta=18)
            device.set_material("wall", stiffness_N_m=300)
            self.assertEqual(device.info["mode"], "armed")
            device.telemetry(seconds=0.2)
            self.assertAlmostEqual(depth_stiffness(), 300, delta=9)
            device.set_material("wall", damping_N_s_m=0.5)
            device.telemetry(seconds=0.2)
            self.assertAlmostEqual(depth_stiffness(), 300, delta=9)
            with self.assertRaisesRegex(TypeError, "did you mean 'stiffness_N_m'"):
                device.set_material("wall", stifness_N_m=1)
            with self.assertRaisesRegex(KeyError, "did you mean 'wall'"):
                device.set_material("wal", stiffness_N_m=1)
            with self.assertRaises(thimble.Error):
                device.set_material("wall", stiffness_N_m=-1)
            device.disarm()


if __name__ == "__main__":
    unittest.main()

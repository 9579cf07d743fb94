"""Files that nobody trusts, and what the command leaves: names with control characters, inputs without an end, interrupted outputs."""

import json
import os
import signal
import subprocess
import time
import unittest
from pathlib import Path

from rig import BIN, Rig

SCENES = Path(__file__).resolve().parents[2] / "scenes"
EVIL = "a\x1b]0;title\x07\x9b31m\x7fb"  # a title for the terminal, and a colour in either encoding
SHOWN = r"a\x1b]0;title\x07\x9b31m\x7fb"


class UntrustedFiles(Rig):
    def controls(self, text):
        return [c for c in text if c not in "\n\t" and (ord(c) < 32 or 127 <= ord(c) < 160)]

    def test_names_do_not_command_the_terminal(self):
        scene = self.folder / "evil.scene.json"
        scene.write_text(json.dumps({"thimble_scene": 1, "name": EVIL, "objects": [
            {"name": EVIL, "shape": {"plane": {"normal": [0, 0, 1], "offset_m": -0.01}},
             "material": {"stiffness_N_m": 800, "damping_N_s_m": 1, "static_friction": 0, "dynamic_friction": 0}}]}))
        sim = self.sim("--tcp", 0)
        said = self.ok("compile", scene, "--output", self.folder / "evil.thim")
        uploaded = self.ok("upload", scene, "--device", sim.tcp)
        info = self.ok("info", "--device", sim.tcp)
        for result in (said, uploaded, info):
            self.assertIn(SHOWN, result.out + result.err)
            self.assertEqual(self.controls(result.out + result.err), [])
        scene.write_text('{"thimble_scene": 1, "name": "x", "objects": [], "%s": 1}' % EVIL.replace("\x1b", "\\u001b").replace("\x07", "\\u0007"))
        self.assertEqual(self.controls(self.run_thimble("compile", scene, "--output", self.folder / "evil.thim").err), [])

    def test_an_input_without_an_end(self):
        scene = self.plane_scene()
        out = self.folder / "never"
        for arguments in (("compile", "/dev/zero", "--output", out), ("upload", "/dev/zero"), ("mesh", "/dev/zero", "--output", self.folder / "never.obj"),
                          ("simulate", scene, "--path", "/dev/zero", "--log", out), ("simulate", "/dev/zero", "--path", "/dev/zero", "--log", out),
                          ("scan", "/dev/zero", "--simulate", "--specimen", SCENES / "scan/specimen.json", "--log", out, "--output", self.folder / "never.json"),
                          ("import", "volume", "/dev/zero", "--from", "0,0,0", "--to", "1,1,1", "--output", out),
                          ("import", "devicelog", "/dev/zero", "--output", out), ("replay", "/dev/zero"), ("decode", "/dev/zero"),
                          ("plot", "/dev/zero", "--output", self.folder / "never.svg"), ("view", "--no-browser", "--scene", "/dev/zero")):
            with self.subTest(arguments=arguments):
                limit = lambda: __import__("resource").setrlimit(__import__("resource").RLIMIT_AS, (1 << 31, 1 << 31))
                result = subprocess.run([BIN / "thimble", *map(str, arguments)], capture_output=True, text=True, env=self.environment, timeout=20,
                                        preexec_fn=None if "THIMBLE_UNDER_SANITIZERS" in os.environ else limit)
                self.assertEqual(result.returncode, 10, result.stderr)
                self.assertIn("remedy: ", result.stderr)
        for option in ("--hand", "--specimen"):
            result = subprocess.run([BIN / "thimble-sim", option, "/dev/zero"], capture_output=True, text=True, env=self.environment, timeout=20)
            self.assertEqual(result.returncode, 1)
            self.assertIn("/dev/zero: Is a device, not a file", result.stderr)
        with open("/dev/zero") as zero:
            result = subprocess.run([BIN / "thimble", "decode", "-"], stdin=zero, capture_output=True, text=True, timeout=20)
        self.assertEqual(result.returncode, 10, result.stderr)
        self.assertEqual(list(self.folder.glob("never*")), [])

    def test_an_interrupted_output_leaves_nothing(self):
        """A path of an hour takes longer than the signal."""
        path = self.folder / "long.csv"
        path.write_text("time_s,x_m,y_m,z_m\n0,0,0,0\n3600,0,0,0.01\n")
        for how in 20 * (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            run = self.start("simulate", SCENES / "walls/walls.scene.json", "--path", path, "--log", self.folder / "cut.csv")
            draft = str(self.folder / f"cut.csv.part-{run.pid}")
            end = time.monotonic() + 20
            while not os.path.exists(draft):
                self.assertLess(time.monotonic(), end, "nothing is written")
            run.send_signal(how)  # within microseconds of the file's creation
            run.communicate(timeout=20)
            self.assertEqual(run.returncode, -how)
            self.assertEqual(list(self.folder.glob("cut.csv*")), [])

    def test_a_replaced_file_keeps_its_mode_and_its_link(self):
        scene, image, link = self.plane_scene(), self.folder / "private.thim", self.folder / "link.thim"
        image.write_bytes(b"")
        image.chmod(0o600)
        link.symlink_to(image)
        self.ok("compile", scene, "--output", link)
        self.assertTrue(link.is_symlink())
        self.assertEqual(image.stat().st_mode & 0o777, 0o600)
        self.assertGreater(image.stat().st_size, 0)

    def test_no_output_replaces_a_file_that_the_scene_names(self):
        texture = self.folder / "grain.csv"
        texture.write_text("0,1\n1,0\n")
        scene = self.ball_scene(8)
        document = json.loads(scene.read_text())
        document["objects"].append({
            "name": "floor", "shape": {"plane": {"normal": [0, 0, 1], "offset_m": -0.2}},
            "material": {"stiffness_N_m": 500, "damping_N_s_m": 1, "static_friction": 0.1, "dynamic_friction": 0.1,
                         "texture": {"kind": "height", "tile_m": [0.004, 0.004], "height_m": 0.0002, "file": "grain.csv"}}})
        scene.write_text(json.dumps(document))
        path = self.folder / "path.csv"
        path.write_text("time_s,x_m,y_m,z_m\n0,0,0,0.06\n0.1,0,0,0.061\n")
        self.image(scene)
        mesh = self.folder / "ball.obj"
        before = [file.read_bytes() for file in (mesh, texture)]
        for output in (mesh, texture):
            self.fails(2, "same-file", "compile", scene, "--output", output)
            self.fails(2, "same-file", "simulate", scene, "--path", path, "--ideal", "--log", output)
        self.assertEqual(before, [file.read_bytes() for file in (mesh, texture)])


if __name__ == "__main__":
    unittest.main()

"""thimble model upload: a device stores its arm, works with it after its restart, and does not arm with one that is damaged."""

import json
import re
import time
import unittest
import zlib
from pathlib import Path

from rig import LinkFaults, Rig, figure

ARMS = Path(__file__).parents[2] / "arms"
# The store of thimble-sim ends with two slots of 8 KiB for each of two arms. A slot begins with 64 bytes of header.
SLOT, SLOTS, HEADER = 8192, 4, 64
NONE = {"crc": [0] * 4, "next_crc": [0] * 4, "damaged": [False] * 4}


class ModelUpload(Rig):
    def setUp(self):
        super().setUp()
        self.store = self.folder / (self.id() + ".store")

    def own_arm(self, name, of, max_force_N, **more):
        arm = json.loads((ARMS / (of + ".arm.json")).read_text())
        arm["name"] = name
        arm["limits"]["max_force_N"] = max_force_N
        arm.update(more)
        file = self.folder / (name + ".arm.json")
        file.write_text(json.dumps(arm))
        return file

    def stored_sim(self, *arguments):
        return self.sim("--no-pty", "--tcp", 0, "--store", self.store, *arguments)

    def hand(self):
        path = self.folder / "press.csv"
        path.write_text("time_s,x_m,y_m,z_m\n0,0,0,0\n0.5,0,0,-0.015\n60,0,0,-0.015\n")
        return path

    def upload(self, uri, arm, *arguments):
        return self.ok_json("model", "upload", arm, "--device", uri, *arguments)

    def images(self, uri):
        return self.ok_json("info", "--device", uri)["arm_images"]

    def pressed(self, uri):
        """The most force of a second in contact with a stiff floor."""
        self.ok("upload", self.plane_scene(stiffness=800), "--device", uri)
        self.ok("home", "--device", uri)
        self.ok("param", "set", "allow_uncommissioned", 1, "--device", uri)
        self.ok("arm", "--device", uri)
        end = time.monotonic() + 60
        while (state := self.ok_json("info", "--device", uri)["state"])["contact_ticks"] < 6000:
            self.assertLess(time.monotonic(), end, "the hand does not touch: %s" % state)
            time.sleep(0.1)
        self.assertEqual((state["mode"], state["fault"]), ("armed", 0), state)
        self.ok("disarm", "--device", uri)
        self.wait_for_mode(uri, "ready")
        return state["peak_force_N"]

    def damage(self, slot, at):
        """A bit of a slot of an arm, counted from the first of them."""
        begin = self.store.stat().st_size - (SLOTS - slot) * SLOT
        with open(self.store, "r+b") as file:
            file.seek(begin)
            self.assertEqual(file.read(4), b"THIA")
            file.seek(begin + at)
            old = file.read(1)[0]
            file.seek(begin + at)
            file.write(bytes([old ^ 4]))

    def test_the_forces_are_those_of_the_stored_arm(self):
        falcon = self.folder / "plant.tarm"
        self.ok("model", "compile", self.own_arm("plant", "falcon", 5), "--output", falcon)
        for of, simulated in ("premium-1.5", "premium-1.5"), ("falcon", falcon):
            with self.subTest(of):
                self.store.unlink(missing_ok=True)
                sim = self.stored_sim("--arm", simulated, "--hand", self.hand())
                self.assertIn("arm 0      built in (no image is stored)\n", self.ok("info", "--device", sim.tcp).out)
                self.assertEqual(self.images(sim.tcp), NONE)
                before_N = self.pressed(sim.tcp)
                name = "weak-" + of
                uploaded = self.upload(sim.tcp, self.own_arm(name, of, 1.5))
                self.assertEqual((uploaded["name"], uploaded["arm"], uploaded["number"]), (name, name, 0))
                for restarted in False, True:
                    if restarted:
                        self.assertEqual(sim.stop(), 0)
                        sim = self.stored_sim("--arm", simulated, "--hand", self.hand())
                    info = self.ok_json("info", "--device", sim.tcp)
                    self.assertEqual((info["arm"], info["state"]["fault"]), (name, 0))
                    self.assertEqual(info["arm_images"]["crc"], [uploaded["crc"], 0, 0, 0])
                    self.assertEqual(info["arm_images"]["next_crc"], [uploaded["crc"], 0, 0, 0])
                    text = self.ok("info", "--device", sim.tcp).out
                    self.assertRegex(text, r"(?m)^arm +%s, 1 arm" % re.escape(name))
                    self.assertIn("arm 0      stored, CRC %08x\n" % uploaded["crc"], text)
                    after_N = self.pressed(sim.tcp)
                    figure("%s: %.2f N, with the stored arm %.2f N" % (of, before_N, after_N))
                    self.assertGreater(before_N, 3)
                    self.assertAlmostEqual(after_N, 1.5, delta=0.01)
                self.assertEqual(sim.stop(), 0)

    def test_it_is_in_the_audit_record(self):
        sim = self.stored_sim()
        uploaded = self.upload(sim.tcp, "wooden")
        entries = self.ok_json("audit", "--device", sim.tcp)["entries"]
        self.assertEqual([entry["event"] for entry in entries], ["start", "arm_image", "restart", "start"])
        self.assertEqual((entries[1]["about"], entries[1]["value"]), ("arm 0, CRC %08x" % uploaded["crc"], uploaded["crc"]))
        self.assertRegex(self.ok("audit", "--device", sim.tcp).out, r"arm_image +arm 0, CRC %08x +by host" % uploaded["crc"])

    def test_a_damaged_image_keeps_the_motors_off(self):
        for older, at in (False, HEADER + 40), (False, 9), (True, HEADER + 40), (True, 9):
            with self.subTest(older_one=older, at=at):
                self.store.unlink(missing_ok=True)
                sim = self.stored_sim("--hand", self.hand())
                if older:
                    self.upload(sim.tcp, self.own_arm("older", "premium-1.5", 2))
                mine = self.own_arm("mine", "premium-1.5", 1.5)
                self.upload(sim.tcp, mine)
                self.assertEqual(sim.stop(), 0)
                self.damage(1 if older else 0, at)

                sim = self.stored_sim("--hand", self.hand())
                device = "--device", sim.tcp
                info = self.ok_json("info", *device)
                self.assertEqual(info["arm_images"]["damaged"], [True, False, False, False])
                self.assertEqual(info["state"]["mode"], "faulted")
                text = self.ok("info", *device).out
                self.assertIn("arm 0      DAMAGED in the store: upload it again (`thimble model upload`)", text)
                self.assertIn("store_corrupt", text)
                self.ok("fault", "clear", *device)
                self.ok("upload", self.plane_scene(), *device)
                self.ok("home", *device)
                error = self.fails(1, "refused", "arm", *device)
                self.assertIn("board_lacks(sound_arm_image)", error["cause"])
                self.assertIn("thimble model upload", error["remedy"])
                state = self.ok_json("info", *device)["state"]
                self.assertEqual((state["mode"], state["peak_force_N"]), ("ready", 0))
                # Neither does another restart help, but the image does.
                self.ok("restart", *device)
                self.wait_for_mode(sim.tcp, "faulted")
                self.upload(sim.tcp, mine)
                self.assertEqual(self.images(sim.tcp)["damaged"], [False] * 4)
                self.assertAlmostEqual(self.pressed(sim.tcp), 1.5, delta=0.01)
                self.assertEqual(sim.stop(), 0)

    def test_what_is_refused(self):
        sim = self.stored_sim()
        device = "--device", sim.tcp
        self.ok("upload", self.plane_scene(offset_m=-0.02), *device)
        self.ok("home", *device)
        self.ok("arm", *device)
        error = self.fails(1, "refused", "model", "upload", "wooden", *device)
        self.assertIn("wrong_mode", error["cause"])
        self.assertIn("disarm", error["remedy"])
        self.assertEqual(self.ok_json("info", *device)["state"]["mode"], "armed")
        self.ok("disarm", *device)
        self.fails(2, "no-such-arm", "model", "upload", "wooden", "--number", 1, *device)
        self.fails(2, "usage", "model", "upload", "wooden", "--number", 2, *device)
        self.fails(10, "cannot-read", "model", "upload", "no-such-arm", *device)
        self.fails(10, "bad-value", "model", "upload", self.own_arm("wrong", "wooden", -1), *device)
        self.assertEqual(self.images(sim.tcp), NONE)
        self.assertEqual(self.ok_json("info", *device)["arm"], "premium-1.5")

    def test_one_that_has_not_passed_a_commissioning(self):
        def mark(file):
            """As docs/arm-format.md says."""
            arm = json.loads(file.read_text())
            proved = {key: value for key, value in arm.items() if key not in ("$schema", "description", "source", "commissioned")}
            return "%08x" % zlib.crc32(json.dumps(proved, sort_keys=True, separators=(",", ":"), ensure_ascii=False).encode())

        sim = self.stored_sim()
        device = "--device", sim.tcp
        self.ok("upload", self.plane_scene(offset_m=-0.02), *device)
        mine = self.own_arm("mine", "premium-1.5", 6)
        proved = {"on": "2026-12-01", "crc32": mark(mine)}
        for file, warning in (
            (mine, "has not passed `thimble commission`"),
            (self.own_arm("changed", "premium-1.5", 6.5, commissioned=proved), "changed since it passed `thimble commission` on 2026-12-01"),
        ):
            self.assertIn(warning, "".join(self.upload(sim.tcp, file)["warnings"]))
            self.ok("home", *device)
            error = self.fails(1, "refused", "arm", *device)
            self.assertIn("arm_not_commissioned", error["cause"])
            self.assertIn("thimble commission", error["remedy"])
            self.ok("param", "set", "max_force", 1, *device)
            self.ok("arm", *device)
            error = self.fails(1, "refused", "param", "set", "max_force", 1.1, *device)
            self.assertIn("arm_not_commissioned", error["cause"])
            self.assertEqual(self.ok_json("info", *device)["state"]["mode"], "armed")
            self.ok("disarm", *device)
            self.wait_for_mode(sim.tcp, "ready")
        # The words for people, and the order of the keys, may change.
        arm = json.loads(mine.read_text())
        mine.write_text(json.dumps({**dict(reversed(arm.items())), "description": "\u00fcber alles", "commissioned": proved}))
        self.assertEqual(self.ok_json("model", "check", mine)["commissioned"], "2026-12-01")
        self.assertEqual(self.upload(sim.tcp, mine)["warnings"], [])
        self.ok("home", *device)
        self.ok("param", "set", "max_force", 8, *device)
        self.ok("arm", *device)

    def test_the_second_of_two_arms(self):
        path = self.folder / "two.csv"
        path.write_text("time_s,x_m,y_m,z_m,arm\n" + "".join("%d,%g,0,0,%d\n" % (t, (arm - 0.5) * 0.2, arm) for arm in (0, 1) for t in (0, 1)))
        sim = self.stored_sim("--hand", path)
        uploaded = self.upload(sim.tcp, self.own_arm("right", "premium-1.5", 2), "--number", 1)
        self.assertEqual(uploaded["arm"], "premium-1.5,right")
        text = self.ok("info", "--device", sim.tcp).out
        self.assertIn("arm 0      built in (no image is stored)\narm 1      stored, CRC %08x\n" % uploaded["crc"], text)

    def test_over_a_link_that_loses_frames(self):
        sim = self.stored_sim()
        proxy = self.proxy(sim.port, LinkFaults(drop=0.05, repeat=0.02), seed=3)
        uploaded = self.upload(proxy.uri, "chain-7")
        figure("%(frames)d frames, %(dropped)d dropped, %(repeated)d repeated" % proxy.counts)
        self.assertGreater(proxy.counts["dropped"], 0)
        self.assertEqual(self.images(sim.tcp)["crc"][0], uploaded["crc"])
        self.assertEqual(self.ok_json("info", "--device", sim.tcp)["arm"], "chain-7")


if __name__ == "__main__":
    unittest.main()

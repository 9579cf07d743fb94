"""Who did what with a device: `thimble audit`, also after a restart and with a store of an older version."""

import os
import time
import unittest

from rig import Rig, figure

# Bytes at the end of the store of thimble-sim: four slots of the arms; from the key on; from the audit record on; from the journal on.
ARMS = 4 * 8192
SINCE = {"arms": ARMS, "key": ARMS + 2 * 4096, "audit": ARMS + 4 * 4096, "journal": ARMS + 6 * 4096}


class Audit(Rig):
    def setUp(self):
        super().setUp()
        self.environment["USER"] = "alice"
        self.store = self.folder / (self.id() + ".store")

    def entries(self, uri):
        return self.ok_json("audit", "--device", uri)["entries"]

    def test_who_armed_is_known_after_a_restart(self):
        sim = self.sim("--no-pty", "--tcp", 0, "--store", self.store)
        before_s = int(time.time())
        scene = self.plane_scene(offset_m=-0.01)
        uploaded = self.ok_json("upload", scene, "--device", sim.tcp)
        self.ok("home", "--device", sim.tcp)
        self.ok("arm", "--device", sim.tcp)
        self.ok("param", "set", "max_force", "3.5", "--device", sim.tcp)
        self.environment["USER"] = "bob"
        self.ok("disarm", "--device", sim.tcp)
        self.ok("param", "save", "--device", sim.tcp)
        self.environment["USER"] = "carol\x1b[2J"
        self.ok("stop", "--device", sim.tcp)
        self.ok("fault", "clear", "--device", sim.tcp)
        self.assertEqual(sim.stop(), 0)

        sim = self.sim("--no-pty", "--tcp", 0, "--store", self.store)
        entries = self.entries(sim.tcp)
        who = lambda verb, user="alice": (user + "@" + os.uname().nodename.split(".")[0])[: max(8, 23 - len("thimble " + verb))]
        named = [(entry["event"], entry["about"], entry["text"]) for entry in entries]
        self.assertEqual(named[0], ("start", "power_on", "power_on"))
        self.assertEqual([event for event, _, _ in named],
                         ["start", "scene", "homing", "armed", "parameter", "disarmed", "parameters_saved", "fault", "faults_cleared", "start"])
        self.assertEqual(entries[1]["value"], uploaded["crc"])
        self.assertEqual(named[3], ("armed", "", (who("arm") + " thimble arm")[:24]))
        self.assertEqual(named[4], ("parameter", "max_force 3.5", (who("param set") + " thimble param set")[:24]))
        self.assertEqual(named[5][:2], ("disarmed", "by host"))
        self.assertEqual(named[7], ("fault", "host_stop", ""))
        self.assertTrue(named[8][2].startswith("carol?[2"), named[8])
        self.assertEqual([entry["start"] for entry in entries], [1] * 9 + [2])
        self.assertEqual([entry["number"] for entry in entries], list(range(1, 11)))
        for entry in entries:
            self.assertTrue(before_s - 5 <= entry["utc_s"] <= time.time() + 1, entry)
            self.assertEqual(entry["time"], time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime(entry["utc_s"])))
            self.assertEqual(entry["host"] != 0, entry["event"] not in ("start", "fault"))
        text = self.ok("audit", "--device", sim.tcp).out.splitlines()
        self.assertEqual(len(text), 10)
        self.assertRegex(text[3], r"^\d{4}-\d\d-\d\dT\d\d:\d\d:\d\dZ +start 1, +\d+ s +armed +by host F\w, alice@")

    def test_a_flood_is_counted(self):
        sim = self.sim("--no-pty", "--tcp", 0)
        for i in range(30):
            self.ok("param", "set", "max_force" if i % 2 else "force_slew", str(1000 + i) if i % 2 == 0 else "%.1f" % (1 + i / 10), "--device", sim.tcp)
        entries = self.entries(sim.tcp)
        self.assertLess(len(entries), 16)
        self.ok("home", "--device", sim.tcp)
        last = self.entries(sim.tcp)[-1]
        self.assertEqual(last["event"], "homing")
        self.assertGreater(last["left_out"], 10)
        self.assertIn("%d more without an entry" % last["left_out"], self.ok("audit", "--device", sim.tcp).out)

    def test_restarts_in_a_flood(self):
        """Each is taken at once; when there is no room left, the board waits for it, and who wants to arm waits for the board."""
        sim = self.sim("--no-pty", "--tcp", 0)
        self.ok("upload", self.plane_scene(offset_m=-0.01), "--device", sim.tcp)
        for i in range(15):
            self.ok("param", "set", "force_slew", 1000 + i, "--device", sim.tcp)
            self.ok("restart", "--device", sim.tcp)
        self.ok("home", "--device", sim.tcp)
        began = time.monotonic()
        refused = self.run_thimble("arm", "--device", sim.tcp)
        took_s = time.monotonic() - began
        figure("an arming after 15 restarts waited %.1f s" % took_s)
        self.assertGreater(took_s, 1, "there was room")
        self.assertEqual(refused.code, 1)
        self.assertIn("the device has restarted", refused.err)
        self.assertGreaterEqual(sum(1 + entry["left_out"] for entry in self.entries(sim.tcp)), 2 * 15 + 2, "parameters, restarts, a scene, homing")

    def test_stores_of_older_versions(self):
        """They end before the arms, before the key, before the audit record, before the journal: what is in them is there."""
        sim = self.sim("--no-pty", "--tcp", 0, "--store", self.store)
        self.ok("upload", self.plane_scene(name="old"), "--device", sim.tcp)
        self.assertEqual(sim.stop(), 0)
        whole = self.store.stat().st_size
        for missing, size in SINCE.items():
            os.truncate(self.store, whole - size)
            sim = self.sim("--no-pty", "--tcp", 0, "--store", self.store)
            self.assertEqual(self.running(sim.tcp)[0], "old")
            self.assertEqual(self.entries(sim.tcp)[-1]["event"], "start")
            self.assertEqual(len(self.entries(sim.tcp)) == 1, missing in ("audit", "journal"))
            self.assertEqual(sim.stop(), 0)
            self.assertEqual(self.store.stat().st_size, whole)


if __name__ == "__main__":
    unittest.main()

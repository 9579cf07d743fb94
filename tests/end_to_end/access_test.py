"""Who commands: one program at a time, and with a key only who has it; anybody stops. With the tools, as a user runs them."""

import json
import socket
import subprocess
import threading
import time
import unittest
from pathlib import Path

from rig import BIN, LinkFaults, Proxy, Rig, figure


class LostAnswerToAKey(Proxy):
    """The link is lost with the answer of a board that has taken a key."""

    def __init__(self, port):
        super().__init__(port, LinkFaults())

    def treat(self, line, held):
        if b"7101020B" in line:
            self.faults.drop = 1
        return super().treat(line, held)


class Access(Rig):
    def setUp(self):
        super().setUp()
        self.device = self.sim("--tcp", 0)
        self.uri = self.device.tcp
        self.ok("upload", self.plane_scene(offset_m=-0.01), "--device", self.uri)
        self.place = Path(self.folder) / self.id()
        self.place.mkdir()
        self.key = self.place / "key"

    def has_armed(self):
        """A program that has armed the arm, and looks at it until told to end."""
        self.ok("home", "--device", self.uri)
        holder = self.start("record", str(self.place / "held.rec"), "--scene", self.plane_scene(offset_m=-0.01), "--arm",
                            "--device", self.uri)
        self.wait_for_mode(self.uri, "armed")
        return holder

    def test_one_program_commands_and_the_others_look(self):
        holder = self.has_armed()
        commander = self.ok_json("info", "--device", self.uri)["state"]["commander"]
        self.assertNotEqual(commander, 0)
        for verb in (("arm",), ("home",), ("upload", self.plane_scene("other")), ("param", "set", "max_force", "9"), ("fault", "clear"),
                     ("restart",), ("param", "save"), ("key", "set")):
            began = time.monotonic()
            error = self.fails(12, "other-program", *verb, "--device", self.uri)
            self.assertRegex(error["cause"], r"another program \(.*record\) has armed the device")
            self.assertLess(time.monotonic() - began, 8, "twice, for text and JSON")
        self.assertFalse(self.key.exists())
        state = self.ok_json("info", "--device", self.uri)["state"]
        self.assertEqual((state["mode"], state["commander"]), ("armed", commander))
        self.assertTrue(self.ok("monitor", "--count", "2", "--device", self.uri).out)
        self.assertEqual(self.ok("param", "set", "max_force", "3.5", "--device", self.uri).out.strip(), "3.5", "less force is anybody's")
        self.assertEqual(self.ok_json("disarm", "--device", self.uri)["mode"], "ready")
        holder.communicate(timeout=30)
        self.ok("upload", self.plane_scene("other"), "--device", self.uri)

    def test_arming_waits_for_another_program_and_then_shows_life(self):
        """What is told the board before the wait is too old after it, with supervision."""
        self.ok("home", "--device", self.uri)
        self.ok("param", "set", "host_supervision", 1, "--device", self.uri)
        with socket.create_connection(("127.0.0.1", self.device.port)) as bus:
            bus.sendall(b"S8\rO\rT18DA01F18021003CCCCCCCCCC\rT18DA01F18043101020CCCCCCC\r")  # takes command, and is silent
            time.sleep(0.1)
            self.ok("arm", "--device", self.uri)

    def test_a_killed_program_blocks_nobody_for_long(self):
        self.ok("home", "--device", self.uri)
        image = self.image(self.ball_scene(60))
        killed = self.start("upload", image, "--device", self.uri)
        time.sleep(0.3)
        killed.kill()
        killed.communicate()
        began = time.monotonic()
        self.ok("home", "--device", self.uri)
        figure("%.2f s after an upload was killed another program commands" % (time.monotonic() - began))
        self.assertLess(time.monotonic() - began, 8)

    def test_a_key_from_set_to_removed(self):
        self.assertEqual(self.ok_json("info", "--device", self.uri)["state"]["key"], "none")
        said = self.ok_json("key", "set", "--key", self.key, "--device", self.uri)
        self.assertEqual((said["key"], said["new_file"]), ("set", True))
        self.assertEqual(self.key.stat().st_mode & 0o777, 0o600)
        self.assertRegex(self.key.read_text(), r"^[0-9a-f]{64}\n$")
        self.assertNotIn(self.key.read_text().strip(), json.dumps(said))

        without = ("--key", self.place / "nothing", "--device", self.uri)
        for verb in (("arm",), ("home",), ("upload", self.plane_scene("other")), ("param", "set", "max_force", "9"), ("restart",),
                     ("key", "remove"), ("fault", "clear")):
            error = self.fails(5, "no-key", *verb, *without)
            self.assertIn("--key", error["remedy"])
        self.assertEqual(self.ok_json("info", *without)["state"]["key"], "set")
        self.ok("param", "set", "max_force", "3.5", *without)
        with_key = ("--key", self.key, "--device", self.uri)
        self.ok("home", *with_key)
        self.ok("arm", *with_key)
        self.ok("disarm", *without)
        self.ok("arm", *with_key)
        self.assertEqual(self.ok_json("stop", *without)["fault"], "host_stop", "a stop is anybody's")
        time.sleep(0.5)
        self.ok("fault", "clear", *with_key)
        self.ok("upload", self.plane_scene("second"), *with_key)
        self.assertEqual(self.ok_json("info", *without)["scene"], "second")
        self.assertEqual(subprocess.run([BIN / "thimble", "home", "--device", self.uri], env=dict(self.environment, THIMBLE_KEY=str(self.key)),
                                        capture_output=True, timeout=30).returncode, 0)

        # Another key, and none.
        second = self.place / "second"
        self.ok("key", "set", second, *with_key)
        self.fails(5, "wrong-key", "home", *with_key)
        self.fails(5, "wrong-key", "home", *with_key)  # and while it has to wait
        time.sleep(1.2)
        self.ok("home", "--key", second, "--device", self.uri)
        self.ok("restart", "--key", second, "--device", self.uri)
        self.assertEqual(self.ok_json("info", "--device", self.uri)["state"]["key"], "set")
        self.ok("key", "remove", "--key", second, "--device", self.uri)
        self.ok("home", *without)

    def test_a_key_whose_answer_is_lost_stays_on_the_disk(self):
        lost = LostAnswerToAKey(self.device.port)
        self.addCleanup(lost.close)
        failed = self.run_thimble("key", "set", "--key", self.key, "--device", lost.uri)
        self.assertEqual(failed.code, 6, failed.err)
        self.assertTrue(self.key.exists())
        self.assertIn(str(self.key), failed.err)
        self.fails(5, "no-key", "home", "--key", self.place / "nothing", "--device", self.uri)
        self.assertFalse(self.ok_json("key", "set", "--key", self.key, "--device", self.uri)["new_file"], "again, with the link back")
        self.ok("home", "--key", self.key, "--device", self.uri)

    def test_bad_key_files(self):
        self.ok("key", "set", "--key", self.key, "--device", self.uri)
        home = ("home", "--device", self.uri, "--key")
        self.key.chmod(0o640)
        error = self.fails(5, "key-not-private", *home, self.key)
        self.assertIn("chmod 600", error["remedy"])
        self.key.chmod(0o600)
        for text in ("", "12", self.key.read_text().strip() + "0", "g" * 64, self.key.read_text().strip()[:-1], "\0" * 64):
            bad = self.place / "bad"
            bad.write_text(text)
            bad.chmod(0o600)
            self.fails(10, "not-a-key", *home, bad)
            bad.unlink()
        self.ok(*home, self.key)

    def test_a_lossy_link_and_many_programs(self):
        """Each program proves on its own; frames that are lost on the way cost time only."""
        self.ok("key", "set", "--key", self.key, "--device", self.uri)
        lossy = self.proxy(self.device.port, LinkFaults(drop=0.05, repeat=0.05), 5)
        ends = []

        def command(i):
            for _ in range(3):
                ends.append(self.run_thimble("param", "set", "force_slew", str(5000 + i), "--key", self.key, "--device", lossy.uri))

        threads = [threading.Thread(target=command, args=(i,)) for i in range(3)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        figure("9 commands of 3 programs with a key over a link that loses frames: exit codes %s" % sorted(end.code for end in ends))
        self.assertEqual([end.err for end in ends if end.code != 0], [])


if __name__ == "__main__":
    unittest.main()

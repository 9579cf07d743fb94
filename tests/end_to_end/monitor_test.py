"""`thimble monitor`: a display that redraws itself in a terminal, and rows elsewhere."""

import fcntl
import json
import os
import pty
import re
import socket
import struct
import subprocess
import termios
import unittest

from rig import BIN, Rig


class Monitor(Rig):
    def in_terminal(self, *arguments, columns=80, **variables):
        """What is on the terminal in the end, by lines, and all that was written."""
        master, slave = pty.openpty()
        fcntl.ioctl(slave, termios.TIOCSWINSZ, struct.pack("HHHH", 24, columns, 0, 0))
        process = subprocess.Popen([BIN / "thimble", "monitor", *map(str, arguments)], stdout=slave, stderr=subprocess.DEVNULL,
                                   env={**self.environment, **variables})
        os.close(slave)
        written = b""
        while True:
            try:
                piece = os.read(master, 65536)
            except OSError:  # the other end is closed
                break
            if not piece:
                break
            written += piece
        os.close(master)
        self.assertEqual(process.wait(), 0)
        return written.decode()

    def test_a_picture_over_itself(self):
        sim = self.sim("--tcp", 0)
        written = self.in_terminal("--seconds", 1.5, "--device", sim.tcp, LC_ALL="C.UTF-8")
        pictures = re.split(r"\x1b\[\d+A", written)
        self.assertGreater(len(pictures), 5)
        self.assertEqual(len({picture.count("\n") for picture in pictures[1:]}), 1)
        for words in ("disarmed", "no fault", "arm 0", "Fz", "|F|"):
            self.assertIn(words, pictures[-1])
        for line in pictures[-1].replace("\x1b[K", "").replace("\x1b[J", "").splitlines():
            self.assertLessEqual(len(line), 80)

    def test_an_armed_arm_is_never_called_disarmed(self):
        sim = self.sim("--tcp", 0)
        self.ok("upload", self.plane_scene(offset_m=-0.02), "--device", sim.tcp)
        self.ok("home", "--device", sim.tcp)
        self.ok("arm", "--device", sim.tcp)
        for _ in range(3):
            rows = self.ok("monitor", "--rows", "--seconds", 1.2, "--device", sim.tcp).out.splitlines()[1:]
            modes = [row.split()[-1] for row in rows]
            self.assertLessEqual(set(modes), {"waiting", "armed"})
            self.assertEqual(modes[-1], "armed")
            written = self.in_terminal("--seconds", 1.2, "--device", sim.tcp)
            self.assertNotIn("disarmed", written)
            self.assertIn("armed", written)

    def test_the_dead_man_switch_is_named(self):
        faults = self.folder / "let_go.json"
        faults.write_text(json.dumps({"thimble_faults": 1, "faults": [{"fault": "dead-man", "after": "armed", "at_s": 2, "for_s": 1}]}))
        sim = self.sim("--tcp", 0, "--inject", faults)
        self.ok("upload", self.plane_scene(offset_m=-0.02), "--device", sim.tcp)
        self.ok("home", "--device", sim.tcp)
        self.ok("arm", "--device", sim.tcp)
        self.assertNotIn("last stop", self.ok("info", "--device", sim.tcp).out)
        watcher = self.start("monitor", "--json", "--seconds", 4, "--device", sim.tcp)
        said = self.ok("monitor", "--seconds", 4, "--device", sim.tcp).err
        self.assertIn("no longer armed: the dead-man switch was released", said)
        states = [json.loads(line) for line in watcher.communicate(timeout=30)[0].splitlines() if '"DeviceState"' in line]
        self.assertEqual([(state["mode"], state["stopped_by"]) for state in states], [("damping", "dead_man")])
        self.assertRegex(self.ok("info", "--device", sim.tcp).out, r"last stop +dead_man: the dead-man switch was released")

    def frames_of_the_arm(self, sim, count):
        """The next frames of telemetry, as SLCAN lines."""
        frames, rest = [], b""
        with socket.create_connection(("127.0.0.1", sim.port)) as link:
            link.settimeout(10)
            link.sendall(b"\rC\rS8\rO\r")
            while len(frames) < count:
                *lines, rest = (rest + link.recv(4096)).split(b"\r")
                frames += [line for line in lines if line[1:4] == b"181"]
        return frames

    def test_one_can_fd_frame_a_record(self):
        sim = self.sim("--no-pty", "--tcp", 0)
        self.assertEqual({frame[:5] for frame in self.frames_of_the_arm(sim, 6)}, {b"t1818"})
        self.ok("param", "set", "telemetry_fd", "1", "--device", sim.tcp)
        frames = self.frames_of_the_arm(sim, 6)
        self.assertEqual({frame[:5] for frame in frames}, {b"b181B"})  # 20 bytes
        sequence = [int(frame[7:8], 16) for frame in frames]
        self.assertTrue(all(a != b for a, b in zip(sequence, sequence[1:])), "one frame a record: %s" % sequence)
        self.ok("param", "set", "telemetry_content", "28", "--device", sim.tcp)
        self.assertEqual({frame[:5] for frame in self.frames_of_the_arm(sim, 6)}, {b"b181F"})  # 64 bytes
        lines = self.ok("monitor", "--json", "--seconds", "1", "--device", sim.tcp).out.splitlines()
        said = {json.loads(line)["message"] for line in lines}
        self.assertLessEqual({"Pose", "Force", "JointAngles", "MotorCurrents", "Temperatures"}, said)
        rows = self.ok("monitor", "--count", "3", "--device", sim.tcp).out.splitlines()
        self.assertEqual(len(rows), 4)

    def test_without_utf8_it_is_plain(self):
        sim = self.sim("--tcp", 0)
        self.in_terminal("--seconds", 0.5, "--device", sim.tcp, LC_ALL="C").encode("ascii")

    def test_rows_on_request(self):
        sim = self.sim("--tcp", 0)
        self.assertTrue(self.in_terminal("--rows", "--count", 2, "--device", sim.tcp).startswith("arm x_m y_m z_m"))

    def test_a_person_is_told_the_image(self):
        """Each verb that talks to a device, where stderr is a terminal."""
        sim = self.sim("--tcp", 0)
        master, slave = pty.openpty()
        subprocess.run([BIN / "thimble", "param", "get", "max_force", "--device", sim.tcp], stdout=subprocess.DEVNULL, stderr=slave, check=True, env=self.environment)
        os.close(slave)
        told = os.read(master, 4096).decode()
        os.close(master)
        self.assertRegex(told, r"^premium-1\.5 \d+\.\d+\.\d+ on board sim")


if __name__ == "__main__":
    unittest.main()

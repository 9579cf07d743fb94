"""thimble-sim-drive over a socketpair, with frames made and read here by the drives' own tables (struct can_frame and canfd_frame as bytes).

    python3 sim_drive_test.py build/release/bin/thimble-sim-drive
"""

import signal
import socket
import struct
import subprocess
import sys
import time
import unittest

PROGRAM = sys.argv.pop(1)
EXTENDED, REMOTE = 0x80000000, 0x40000000


class Drives:
    def __init__(self, *arguments):
        self.host, other = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        self.host.settimeout(5)
        self.process = subprocess.Popen([PROGRAM, "--socket", str(other.fileno()), *arguments], pass_fds=[other.fileno()],
                                        stdout=subprocess.PIPE, text=True)
        other.close()
        assert self.process.stdout.readline() == "ready\n"

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.send_signal(signal.SIGTERM)
        assert self.process.wait(timeout=10) == 0
        self.process.stdout.close()
        self.host.close()

    def send(self, can_id, data=b"", fd=False):
        self.host.send(struct.pack("<IBB2x64s", can_id, len(data), 1, data) if fd else struct.pack("<IB3x8s", can_id, len(data), data))

    def receive(self, can_id):
        """The next frame of this id: (data, fd)."""
        for _ in range(1000):
            raw = self.host.recv(72)
            found, size = struct.unpack_from("<IB", raw)
            if found == can_id:
                return raw[8:8 + size], len(raw) == 72
        raise AssertionError("it does not come")

    def ask(self, can_id, data, reply_id, fd=False):
        self.send(can_id, data, fd)
        return self.receive(reply_id)[0]


class Moteus(unittest.TestCase):
    COMMAND = bytes.fromhex("01000a 02208000 0d229a99193d 062300000040 05271400 1c0401 1100 130d 5050")

    def test_the_worked_frame(self):
        with Drives("--drive", "moteus:1") as drives:
            for _ in range(400):  # friction 1 mN m s/rad, kd .25 x .5 N m a turn/s; on a busy machine the emulator comes late
                reply = drives.ask(EXTENDED | 0x8001, self.COMMAND, 0x100, fd=True)
                self.assertEqual(len(reply), 32)
                self.assertEqual(reply[:3], bytes.fromhex("2c0401"))
                _, velocity, torque, _ = struct.unpack_from("<4f", reply, 3)
                if reply[19:22] == bytes.fromhex("21000b"):  # its watchdog, as this test came late
                    drives.send(EXTENDED | 1, bytes.fromhex("010000"), fd=True)
                elif velocity > .1:
                    break
                time.sleep(.005)
            self.assertGreater(velocity, .1)
            self.assertLess(torque, .0376)
            self.assertEqual(reply[19:22], bytes.fromhex("21000a"))
            self.assertEqual(reply[22:27], bytes.fromhex("230d301f00"))
            time.sleep(.05)  # its watchdog of 20 ms
            self.assertEqual(drives.ask(EXTENDED | 0x8001, b"\x11\x00", 0x100, fd=True)[:3], bytes.fromhex("21000b"))

    def test_ids_from_8_on(self):
        with Drives("--drive", "moteus:9") as drives:
            reply = drives.ask(EXTENDED | 0x8009, b"\x11\x00", EXTENDED | 0x900, fd=True)
            self.assertEqual(reply[:3], bytes.fromhex("210000"))

    def test_a_configuration_value(self):
        with Drives("--drive", "moteus:1") as drives:
            text = b"conf get servo.timeout_mode\n"
            question = b"\x40\x01" + bytes([len(text)]) + text + b"\x42\x01\x20"
            reply = drives.ask(EXTENDED | 0x8001, question.ljust(48, b"\x50"), 0x100, fd=True)
            self.assertEqual(reply[:7], b"\x41\x01\x0412\r\n")


class Odrive(unittest.TestCase):
    def test_version_zero_and_watchdog(self):
        with Drives("--drive", "odrive06:3") as drives:
            self.assertEqual(drives.ask(REMOTE | 0x060, b"", 0x060)[4:6], bytes([0, 6]))
            self.assertEqual(drives.ask(REMOTE | 0x069, b"", 0x069), bytes(8))
            error, state = struct.unpack_from("<IB", drives.receive(0x061)[0])
            for _ in range(3):  # nobody feeds it
                error, state = struct.unpack_from("<IB", drives.receive(0x061)[0])
            self.assertEqual((error, state), (0x01000000, 1))


class Damiao(unittest.TestCase):
    def test_enable_torque_and_loss(self):
        for kind, fd in (("damiao", False), ("damiao-fd", True)):
            with Drives("--drive", f"{kind}:1:17") as drives:
                self.assertEqual(drives.ask(1, b"\xff" * 7 + b"\xfd", 17, fd)[0], 0x01)
                self.assertEqual(drives.ask(1, b"\xff" * 7 + b"\xfc", 17, fd)[0], 0x11)
                for _ in range(200):  # its current rises; on a busy machine the emulator comes late
                    reply = drives.ask(1, bytes.fromhex("7fff7ff000001865"), 17, fd)
                    torque = (int.from_bytes(reply[4:6], "big") & 0xFFF) * 20 / 4095 - 10
                    if abs(torque - .5) < .02:
                        break
                    time.sleep(.001)
                self.assertAlmostEqual(torque, .5, delta=.02)
                time.sleep(.05)
                self.assertEqual(drives.ask(1, bytes.fromhex("7fff7ff000001865"), 17, fd)[0], 0xD1)
                value = drives.ask(0x7FF, bytes.fromhex("0100331700000000"), 17, fd)
                self.assertEqual(value, bytes.fromhex("01003317") + struct.pack("<f", 10))


class Program(unittest.TestCase):
    def test_injected_faults(self):
        with Drives("--drive", "damiao:1", "--drive", "damiao:2", "--inject", "0:1:fail=8", "--inject", "0:0:reply_id=85") as drives:
            time.sleep(.05)
            self.assertEqual(drives.ask(2, b"\xff" * 7 + b"\xfd", 18)[0], 0x82)
            self.assertEqual(drives.ask(1, b"\xff" * 7 + b"\xfd", 85)[0], 0x01)

    def test_usage(self):
        for arguments, code in ((["--help"], 0), ([], 2), (["can0"], 2), (["can0", "--drive", "stepper:1"], 2), (["can0", "--drive", "moteus"], 2),
                                (["can0", "--drive", "moteus:1", "--inject", "0:1:mute"], 2),
                                (["can0", "--drive", "moteus:1", "--inject", "0:0:melt"], 2),
                                (["can0", "--drive", "moteus:1", "--inject", "0:0:drop=-1"], 2), (["can0", "--drive", "moteus:1.5"], 2),
                                (["can0", "--drive", "odrive06:64"], 2), (["can0", "--drive", "moteus:1", "--step", "nan"], 2),
                                (["no-such-bus", "--drive", "moteus:1"], 1)):
            done = subprocess.run([PROGRAM, *arguments], capture_output=True, text=True)
            self.assertEqual(done.returncode, code, (arguments, done.stderr))


if __name__ == "__main__":
    unittest.main()

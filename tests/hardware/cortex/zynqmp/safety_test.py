"""What stops the emulated Cortex-R5F's arm."""

import socket
import subprocess
import time
import unittest

from zynqmp_rig import IMAGE, ZynqmpRig, tool


class Safety(ZynqmpRig):
    def test_the_e_stop_trips(self):
        board = self.board()
        self.ok("upload", self.plane_scene(), "--device", board.uri)
        self.touch(board)
        board.tell("line e_stop 1")
        self.wait_for_mode(board.uri, "faulted")
        self.wait_for(lambda: board.ask("state").split()[-1] == "0", "the drives to be off")
        self.assertEqual([f["name"] for f in self.ok_json("fault", "list", "--device", board.uri)["faults"]], ["e_stop"])
        self.fails(9, "device-faulted", "arm", "--device", board.uri)
        board.tell("line e_stop 0")
        self.ok("fault", "clear", "--device", board.uri)

    def test_a_restart_over_the_link(self):
        board = self.board()
        scene = self.ok_json("upload", self.plane_scene(), "--device", board.uri)
        self.touch(board)
        with socket.create_connection(("127.0.0.1", int(board.uri.rsplit(":", 1)[1]))) as bus:
            bus.sendall(b"S8\rO\rT18DA01F18021003CCCCCCCCCC\r")
            time.sleep(0.5)
            bus.sendall(b"T18DA01F18021101CCCCCCCCCC\r")
            board.wait_for_text("started: host")
        info = self.ok_json("info", "--device", board.uri)
        self.assertEqual((info["reset_reason"], info["state"]["mode"]), ("host", "disarmed"))
        self.assertEqual(self.running(board.uri), ("floor", scene["bytes"], scene["crc"]))
        self.assertEqual(board.ask("state").split()[-1], "0")

    def test_a_crash_turns_the_motors_off_and_starts_anew(self):
        board = self.board()
        scene = self.ok_json("upload", self.plane_scene(), "--device", board.uri)
        self.touch(board)
        names = subprocess.run([tool("arm-none-eabi-nm"), "-C", IMAGE], capture_output=True, text=True, check=True).stdout
        can = next(line.split()[0] for line in names.splitlines() if line.endswith("(anonymous namespace)::can"))
        board.ask(f"write {can} 50000000")  # a pointer to where nothing is allowed
        board.wait_for_text("started: crash near 0x")
        info = self.ok_json("info", "--device", board.uri)
        self.assertEqual((info["reset_reason"], info["state"]["mode"]), ("crash", "faulted"))
        self.assertEqual(self.running(board.uri), ("floor", scene["bytes"], scene["crc"]))
        self.assertEqual(board.ask("state").split()[-1], "0")


if __name__ == "__main__":
    unittest.main()

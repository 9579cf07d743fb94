"""The two links of the emulated Cortex-R5F."""

import unittest

from zynqmp_rig import ZynqmpRig

CAN0_SOFTWARE_RESET = "ff060000"


class Link(ZynqmpRig):
    def test_a_controller_that_fell_off_the_bus_comes_back(self):
        """QEMU's bus knows no errors; its controller can be put where a bus-off leaves it. can_test has the bus-off itself."""
        board = self.board()
        self.ok("info", "--device", board.uri)
        board.ask("write " + CAN0_SOFTWARE_RESET + " 1")
        self.ok("info", "--device", board.uri)

    def test_the_second_link(self):
        board = self.board()
        uploaded = self.ok_json("upload", self.plane_scene(), "--device", board.uart)
        self.assertEqual(self.running(board.uart), ("floor", uploaded["bytes"], uploaded["crc"]))
        self.touch(board, board.uart)
        # Whoever spoke last is answered, wherever.
        self.assertEqual(self.ok_json("info", "--device", board.uri)["state"]["mode"], "armed")
        # With its UART in use the board's time is six times slower, and the command may not wait for the end of the damping.
        self.run_thimble("disarm", "--device", board.uart)
        self.wait_for(lambda: self.ok_json("info", "--device", board.uart)["state"]["mode"] == "ready", "the end of the damping")


if __name__ == "__main__":
    unittest.main()

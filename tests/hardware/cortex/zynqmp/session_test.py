"""A session with the emulated Cortex-R5F: the real command over its CAN bus, the simulated arm at its register block."""

import unittest

from zynqmp_rig import ZynqmpRig, figure


class Session(ZynqmpRig):
    def test_a_session_with_a_wall(self):
        board = self.board()
        info = self.ok_json("info", "--device", board.uri)
        self.assertEqual((info["board"], info["link"]["frame_bytes"], info["state"]["mode"]), ("zynqmp", 8, "disarmed"))
        uploaded = self.ok_json("upload", self.plane_scene(), "--device", board.uri)
        self.assertEqual(self.running(board.uri), ("floor", uploaded["bytes"], uploaded["crc"]))
        self.touch(board)
        self.rest(board)
        # Floor and hand in balance: 800 N/m x depth = 500 N/m x (10 mm - depth), but for the joints' friction.
        self.assertAlmostEqual(float(board.ask("state").split()[2]), -0.00385, delta=0.001)
        lines = self.ok("monitor", "--count", "100", "--device", board.uri).out.splitlines()[-100:]
        rows = [[float(word) for word in line.split()[:7]] for line in lines]
        row = max(rows, key=lambda row: row[6])  # a hand that holds still is probed now and then: the force is less meanwhile
        self.assertAlmostEqual(row[6], -800 * row[3], delta=0.1)
        state = self.ok_json("info", "--device", board.uri)
        self.assertEqual(state["state"]["mode"], "armed")
        self.assertAlmostEqual(state["state"]["tick_rate_Hz"], 4000, delta=1)
        self.assertEqual(state["state"]["overruns"], 0)
        figure("worst tick %.0f us, worst lateness %.0f us of the board's time" %
               (state["state"]["worst_tick_s"] * 1e6, state["lateness"]["worst_s"] * 1e6))
        self.ok("disarm", "--device", board.uri)
        self.assertEqual(self.ok_json("fault", "list", "--device", board.uri)["faults"], [])

    def test_an_upload_while_armed_loses_no_tick(self):
        board = self.board()
        self.ok("upload", self.plane_scene(), "--device", board.uri)
        self.ok("param", "set", "lost_ticks", "1", "--device", board.uri)  # one lost period is a fault
        self.touch(board)
        before = self.ok_json("info", "--device", board.uri)["state"]["tick"]
        uploaded = self.ok_json("upload", self.ball_scene(16), "--device", board.uri, timeout=100)
        self.assertGreater(uploaded["bytes"], 30000)
        info = self.ok_json("info", "--device", board.uri)
        self.assertEqual((info["scene"], info["state"]["mode"], info["state"]["fault"]), ("ball", "armed", 0))
        self.assertLess(info["lateness"]["worst_s"], 250e-6)
        self.assertEqual(self.ok_json("fault", "list", "--device", board.uri)["faults"], [])
        figure("%d bytes uploaded while armed, %d ticks, none lost, the latest by %.0f us" %
               (uploaded["bytes"], info["state"]["tick"] - before, info["lateness"]["worst_s"] * 1e6))


if __name__ == "__main__":
    unittest.main()

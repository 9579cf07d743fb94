"""What the emulated Cortex-R5F keeps in its flash."""

import unittest

from zynqmp_rig import ZynqmpRig


class Store(ZynqmpRig):
    def test_the_flash_keeps_scene_and_parameters(self):
        flash = self.flash()
        board = self.board(flash)
        first = self.ok_json("upload", self.plane_scene(), "--device", board.uri)
        self.ok("param", "set", "max_force", "3", "--device", board.uri)
        self.ok("param", "save", "--device", board.uri)
        board.stop()
        board = self.board(flash)
        self.assertEqual(self.running(board.uri), ("floor", first["bytes"], first["crc"]))
        self.assertEqual(self.ok_json("param", "get", "max_force", "--device", board.uri)["value"], 3)
        entries = self.ok_json("audit", "--device", board.uri)["entries"]
        self.assertEqual([entry["event"] for entry in entries[:6]], ["start", "time_told", "scene", "parameter", "parameters_saved", "start"])
        self.assertIn("@", entries[3]["text"])
        second = self.ok_json("upload", self.plane_scene("other", stiffness=500), "--device", board.uri)
        board.stop()
        board = self.board(flash)
        self.assertEqual(self.running(board.uri), ("other", second["bytes"], second["crc"]))


if __name__ == "__main__":
    unittest.main()

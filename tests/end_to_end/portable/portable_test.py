"""The build with Clang and libc++: its simulator takes a scene from the client of the release build and has nothing of the other C++ library, and
docs/portability.md says of each module what the compiler finds. THIMBLE_WRITE_DOCS=1 writes the page."""

import os
import subprocess
import unittest
from pathlib import Path

import portability

CLIENT = Path(os.environ["THIMBLE_BIN"], "thimble")
SIMULATOR = portability.BUILD / "bin/thimble-sim"
SCENE = portability.ROOT / "scenes/walls/walls.scene.json"


def output(*command):
    return subprocess.run([*map(str, command)], check=True, capture_output=True, text=True, timeout=120).stdout


class Portable(unittest.TestCase):
    def test_the_simulator(self):
        self.assertNotIn("libstdc++", output("readelf", "--dynamic", SIMULATOR))
        self.assertIn("std::__1::", output("nm", "--demangle", SIMULATOR))
        # Not optimised, it takes milliseconds a tick.
        simulator = subprocess.Popen([SIMULATOR, "--tcp", "0", "--no-pty", "--name", "portable", "--rate", "100"], stdout=subprocess.PIPE, text=True)
        self.addCleanup(simulator.stdout.close)
        self.addCleanup(simulator.wait)
        self.addCleanup(simulator.terminate)
        address = simulator.stdout.readline().strip()
        self.assertEqual(simulator.stdout.readline(), "ready\n")
        self.assertIn("verified", output(CLIENT, "upload", SCENE, "--device", address))

    def test_the_page(self):
        text = portability.table()
        if "THIMBLE_WRITE_DOCS" in os.environ:
            portability.write(text)
        self.assertEqual(portability.in_page(), text)


if __name__ == "__main__":
    unittest.main()

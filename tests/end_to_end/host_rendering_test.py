"""The host renders: the example of docs/host-rendering.md against the simulated device, over TCP and a pty, and a host that dies."""

import re
import signal
import subprocess
import time
import unittest

from rig import BIN, Rig, figure

STILL_HERE_S = 20


class HostRendering(Rig):
    def pressed_sim(self, *arguments):
        """A hand that goes 20 mm down, 10 mm past the example's wall, and back."""
        hand = self.folder / "press.csv"
        hand.write_text("time_s,x_m,y_m,z_m\n0,0,0,0\n0.5,0,0,-0.02\n1.0,0,0,-0.02\n1.5,0,0,0\n")
        return self.sim("--tcp", 0, "--hand", hand, "--loop", *arguments)

    def start_host(self, uri, seconds):
        return subprocess.Popen([BIN / "host_wall", uri, str(seconds)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                                env=self.environment)

    def test_the_same_wall_on_the_host_and_on_the_board(self):
        sim = self.pressed_sim()
        for uri in (sim.tcp, sim.pty):
            with self.subTest(uri):
                host = self.start_host(uri, 4)
                out, err = host.communicate(timeout=120)
                self.assertEqual(host.returncode, 0, err)
                figure(out.strip().replace("\n", "; "))
                walls = re.findall(r"wall on the (host|board): (\d+) readings/s.* (\d+) of (\d+) in the wall, felt (\d+) N/m of (\d+)", out)
                self.assertEqual([wall[0] for wall in walls], ["host", "board"])
                for _, _, touching, _, felt, of in walls:
                    self.assertGreater(int(touching), 50)
                    self.assertAlmostEqual(int(felt), int(of), delta=0.05 * int(of))
                taken, rate, old = map(int, re.search(r"(\d+) orders taken in \d+ ticks, (\d+) a second, (\d+) old", out).groups())
                # A busy machine lets both programs wait: how many there are is a figure. Exactly 1 kHz is linked_wall_test's, in
                # simulated time.
                self.assertGreater(rate, 100)
                self.assertGreater(taken, 400)
                self.assertEqual(old, 0)
                state = self.ok_json("info", "--device", uri)
                self.assertEqual(state["state"]["mode"], "ready")
                self.assertFalse(state["state"]["flags"]["host_renders"], "it was handed back")
                self.assertEqual(state["host_orders"]["wrong"], 0)

    def test_a_host_that_is_killed(self):
        sim = self.pressed_sim()
        self.ok("param", "set", "link_timeout", "2", "--device", sim.tcp)
        host = self.start_host(sim.tcp, 60)
        end = time.monotonic() + STILL_HERE_S
        while (info := self.ok_json("info", "--device", sim.pty))["host_orders"]["taken"] < 200:
            self.assertLess(time.monotonic(), end, info)
            time.sleep(0.05)
        self.assertEqual(info["state"]["mode"], "armed")
        self.assertIn("armed,host_renders", self.ok("info", "--device", sim.pty).out)
        expired = info["host_orders"]["expired"]
        host.send_signal(signal.SIGKILL)
        host.communicate()
        time.sleep(0.2)
        info = self.ok_json("info", "--device", sim.pty)  # a sign of life of its own: the fault comes 2 s after it
        self.assertEqual(info["state"]["mode"], "armed", "first the tip is only damped")
        self.assertGreater(info["host_orders"]["expired"], expired)
        self.wait_for_fault(sim)
        self.assertEqual(self.ok_json("fault", "list", "--device", sim.pty)["faults"][0]["name"], "host_lost")

    def wait_for_fault(self, sim):
        """Without a question to the device, which would be a sign of life: the monitor only listens."""
        watcher = self.start("monitor", "--json", "--seconds", STILL_HERE_S, "--device", sim.tcp)
        self.addCleanup(watcher.kill)
        for line in watcher.stdout:
            if '"Emergency"' in line:
                break
        else:
            self.fail("no fault came")
        watcher.kill()
        watcher.communicate()

    def test_a_program_hears_that_it_is_not_armed_any_more(self):
        sim = self.pressed_sim()
        host = self.start_host(sim.tcp, 60)
        end = time.monotonic() + STILL_HERE_S
        while self.ok_json("info", "--device", sim.pty)["host_orders"]["taken"] < 50:
            self.assertLess(time.monotonic(), end)
            time.sleep(0.05)
        self.ok("disarm", "--device", sim.pty)
        out, err = host.communicate(timeout=STILL_HERE_S)
        self.assertEqual(host.returncode, 1, out)
        self.assertIn("not-armed", err)

    def test_without_the_mode_an_order_moves_nothing(self):
        sim = self.sim("--tcp", 0)
        self.ok("upload", self.plane_scene(offset_m=-0.1), "--device", sim.tcp)
        self.ok("home", "--device", sim.tcp)
        self.ok("arm", "--device", sim.tcp)
        with open(sim.pty.removeprefix("slcan:"), "wb", buffering=0) as bus:
            bus.write(b"\rC\rS8\rO\r")
            for sequence in range(50):
                bus.write(b"t10180000E803000000%02X\r" % sequence)
                time.sleep(0.005)
        info = self.ok_json("info", "--device", sim.tcp)
        self.assertEqual(info["host_orders"], {"taken": 0, "old": 0, "wrong": 0, "expired": 0})
        self.assertEqual(info["state"]["peak_force_N"], 0)


if __name__ == "__main__":
    unittest.main()

"""thimble-sim: it removes its files, reports why it cannot start, and keeps its store."""

import json
import os
import signal
import socket
import subprocess
import time
import unittest
from pathlib import Path

from rig import BIN, Rig

SCENES = Path(__file__).resolve().parents[2] / "scenes"


class Simulator(Rig):
    def start_fails(self, code, text, *arguments):
        result = subprocess.run([BIN / "thimble-sim", *map(str, arguments)], capture_output=True, text=True,
                                env=self.environment, timeout=20)
        self.assertEqual(result.returncode, code, result.stderr)
        self.assertIn(text, result.stderr)
        self.assertEqual(list(self.runtime.rglob("*.sim")), [])

    def test_signals_end_it_and_nothing_remains(self):
        for how in (signal.SIGTERM, signal.SIGINT):
            link = self.folder / "port"
            sim = self.sim("--tcp", 0, "--link", link)
            self.assertEqual(sim.pty, "slcan:%s" % link)
            self.assertTrue(link.is_symlink())
            self.ok("info", "--device", sim.pty)
            self.assertEqual(sim.stop(how), 0)
            self.assertFalse(link.is_symlink())
            self.assertEqual(list(self.runtime.iterdir()), [])

    def test_a_killed_one_is_not_listed_and_cleared_away(self):
        sim = self.sim("--tcp", 0)
        sim.stop(signal.SIGKILL)
        self.assertEqual(self.ok_json("list")["devices"], [])
        self.fails(3, "no-device", "info")
        self.sim("--tcp", 0)
        self.assertEqual([device["name"] for device in self.ok_json("list")["devices"]], ["arm-2"])
        self.assertEqual([file.name for file in self.runtime.rglob("*.sim")], ["arm-2.sim"])

    def test_a_port_in_use(self):
        with socket.create_server(("127.0.0.1", 0)) as taken:
            self.start_fails(1, "is in use: end the other program, or choose another port (0: any free port)", "--tcp", taken.getsockname()[1])

    def test_bad_options(self):
        self.start_fails(1, "elbow", "--arm", "elbow")
        self.start_fails(2, "--rate", "--rate", "1")
        self.start_fails(1, "the device has no connection: use the pty, --tcp, --can or --tty", "--no-pty")
        self.start_fails(1, "cannot use the CAN interface no-such-can", "--can", "no-such-can")
        self.start_fails(1, "cannot open the serial port /dev/no-such-port", "--tty", "/dev/no-such-port")

    def test_a_serial_port_that_goes_and_comes_back(self):
        port = self.folder / "tty"

        def plug_in():
            host, device = os.openpty()
            name = os.ttyname(device)
            (self.folder / "new").symlink_to(name)
            (self.folder / "new").rename(port)
            return host, device

        def link_info(host):
            os.write(host, b"\rC\rS8\rO\rT18DA01F180322F1A0CCCCCCCC\r")
            heard = b""
            end = time.monotonic() + 20
            while b"T18DAF1018" not in heard:
                self.assertLess(time.monotonic(), end, heard)
                heard += os.read(host, 4096)

        host, device = plug_in()
        sim = self.sim("--no-pty", "--tty", port)
        self.assertEqual(sim.uris, [])
        link_info(host)
        os.close(device)
        os.close(host)
        host, device = plug_in()
        time.sleep(1)  # it looks ten times a second
        link_info(host)
        sim.process.send_signal(signal.SIGTERM)
        said = sim.process.communicate(timeout=20)[1]
        self.assertIn("%s is gone" % port, said)
        self.assertIn("the link is whole again", said)
        os.close(device)
        os.close(host)

    def test_two_of_one_name(self):
        sim = self.sim()
        result = subprocess.run([BIN / "thimble-sim", "--name", "arm-1"], capture_output=True, text=True, env=self.environment,
                                timeout=20)
        self.assertEqual(result.returncode, 1)
        self.assertIn("another simulator is named 'arm-1'", result.stderr)
        self.ok("info", "--device", sim.pty)

    def test_a_bad_hand(self):
        hand = self.folder / "hand.csv"
        hand.write_text("time_s,x_m,y_m\n")
        self.start_fails(1, "hand.csv:1: column 'z_m' is missing", "--hand", hand)
        self.start_fails(1, f"{self.folder}: Is a directory", "--hand", self.folder)
        self.start_fails(1, f"{self.folder}: Is a directory", "--specimen", self.folder)
        self.start_fails(2, "--loop requires --hand", "--loop")

    def test_the_store_keeps_the_scene(self):
        store = self.folder / "store"
        sim = self.sim("--tcp", 0, "--store", store)
        uploaded = self.ok_json("upload", self.plane_scene("kept"), "--device", sim.tcp)
        sim.stop(signal.SIGKILL)
        again = self.sim("--tcp", 0, "--store", store)
        self.assertEqual(self.running(again.tcp), ("kept", uploaded["bytes"], uploaded["crc"]))
        self.start_fails_with_store(store)
        self.assertLess(os.stat(store).st_blocks * 512, 1 << 20, "a sparse file")

    def start_fails_with_store(self, store):
        result = subprocess.run([BIN / "thimble-sim", "--store", store], capture_output=True, text=True, env=self.environment,
                                timeout=20)
        self.assertEqual(result.returncode, 1)
        self.assertIn("in use by another simulator", result.stderr)

    def test_a_hand_presses_what_was_uploaded(self):
        hand = self.folder / "press.csv"
        hand.write_text("time_s,x_m,y_m,z_m\n0,0,0,0\n0.5,0,0,-0.01\n30,0,0,-0.01\n")
        sim = self.sim("--tcp", 0, "--hand", hand)
        self.ok("upload", self.plane_scene(stiffness=500, offset_m=-0.004), "--device", sim.tcp)
        self.ok("home", "--device", sim.tcp)
        self.ok("arm", "--device", sim.tcp)
        end = time.monotonic() + 60  # a machine that is busy simulates slower than real time
        while (state := self.ok_json("info", "--device", sim.tcp)["state"])["contact_ticks"] < 4000:
            self.assertLess(time.monotonic(), end, "the hand does not touch")
            time.sleep(0.1)
        self.assertGreater(state["peak_force_N"], 1.0)
        self.assertGreater(state["mean_force_N"], 0.5)
        self.assertLessEqual(state["mean_force_N"], state["peak_force_N"])
        print("    figure: peak %.2f N, mean %.2f N, %d ticks in contact, worst tick %.1f us" %
              (state["peak_force_N"], state["mean_force_N"], state["contact_ticks"], state["worst_tick_s"] * 1e6))

    def test_two_clients_share_the_bus(self):
        sim = self.sim("--tcp", 0)
        watcher = self.start("monitor", "--seconds", "3", "--json", "--device", sim.tcp)
        for _ in range(3):
            self.ok("info", "--device", sim.pty)
            self.ok("upload", self.plane_scene(), "--device", sim.tcp)
        out, err = watcher.communicate(timeout=20)
        self.assertEqual(watcher.returncode, 0, err)
        self.assertGreater(len(out.splitlines()), 50)

    def test_hosts_that_ask_at_once_all_get_their_answers(self):
        """An answer that another host's request cuts short is asked for again, and not by both at once."""
        sim = self.sim("--tcp", 0)
        for _ in range(60):
            hosts = [(self.start(*asked, "--device", sim.tcp), shown) for asked, shown in
                     ((("info",), "protocol"), (("param", "list"), "encoder_frozen"), (("info", "--json"), '"protocol"'))]
            for host, shown in hosts:
                out, err = host.communicate(timeout=20)
                self.assertEqual(host.returncode, 0, err)
                self.assertIn(shown, out)

    def test_a_web_page_commands_nothing(self):
        sim = self.sim("--tcp", 0)
        stop = b"t0010\r"
        for head in (b"POST / HTTP/1.1\r\nHost: 127.0.0.1\r\nContent-Type: text/plain\r\n\r\n", b"GET /x HTTP/1.1\r\n\r\n",
                     b"DELETE / HTTP/1.1\r\n\r\n", b"OPTIONS * HTTP/1.1\r\n\r\n", b"TRACE / HTTP/1.1\r\n\r\n", b"C /\r\n\r\n"):
            for parts in ([head + b"O\r" + stop], [head, b"O\r" + stop], [head[:3], head[3:], b"O\r", stop]):
                with socket.create_connection(("127.0.0.1", sim.port), timeout=5) as page:
                    try:
                        for part in parts:
                            page.sendall(part)
                            time.sleep(0.02)
                        while page.recv(1 << 16):
                            pass
                    except ConnectionError:
                        pass
        self.assertEqual(self.ok_json("fault", "list", "--device", sim.tcp)["faults"], [])
        with socket.create_connection(("127.0.0.1", sim.port)) as host:  # the same without the page
            host.sendall(stop)
            time.sleep(0.1)
        self.assertNotEqual(self.ok_json("fault", "list", "--device", sim.tcp)["faults"], [])

    def test_silent_and_deaf_hosts_take_nothing_from_others(self):
        sim = self.sim("--tcp", 0)
        silent = [socket.create_connection(("127.0.0.1", sim.port)) for _ in range(250)]
        self.ok("info", "--device", sim.tcp)
        for one in silent:
            one.close()
        with socket.create_connection(("127.0.0.1", sim.port)) as deaf:
            deaf.settimeout(2)
            with self.assertRaises(ConnectionError):  # dropped, before it takes the memory
                for _ in range(2000):
                    deaf.sendall(b"V\r" * 50_000)
        with open("/proc/%d/status" % sim.process.pid) as status:
            peak_kB = next(int(line.split()[1]) for line in status if line.startswith("VmHWM"))
        print("[ figure ] 250 silent hosts and one that reads no answers: the device took at most %d MB" % (peak_kB / 1000))
        self.assertLess(peak_kB, 150_000)
        self.ok("info", "--device", sim.tcp)

    def test_what_moves_is_told(self):
        """Each scene under its own hand, until its state frames say that something has happened."""
        first = {}

        def moved(m):
            return m["message"] == "BodyPosition" and abs(m["x_m"] - first.setdefault(m["object"], m["x_m"])) > 0.002

        for scene, happened in (
                ("needle", lambda m: m["message"] == "NeedleState" and m["inside"] and m["depth_m"] > 0.001),
                ("deform", lambda m: m["message"] == "TissueState" and m["pressed"] and m["depth_m"] > 0.0005),
                ("buttons", lambda m: m["message"] == "ControlElementState" and m["on"] and m["q"] != 0),
                ("multy3", moved),
                ("blocks-6dof", lambda m: m["message"] == "BodyRotation" and m["x"] ** 2 + m["y"] ** 2 + m["z"] ** 2 > 1e-4)):
            with self.subTest(scene):
                folder = SCENES / scene
                sim = self.sim("--tcp", 0, "--hand", folder / "stroke.csv")
                self.ok("upload", folder / (scene + ".scene.json"), "--device", sim.tcp)
                self.ok("home", "--device", sim.tcp)
                watcher = self.start("monitor", "--json", "--seconds", 60, "--device", sim.tcp)
                self.ok("arm", "--device", sim.tcp)
                told = any(happened(json.loads(line)) for line in watcher.stdout)
                watcher.kill()
                watcher.communicate()
                sim.stop()
                self.assertTrue(told)


if __name__ == "__main__":
    unittest.main()

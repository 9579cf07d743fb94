"""A session with a device: every verb, over pty and TCP, and the state after a killed upload."""

import json
import re
import signal
import socket
import time
import unittest

from rig import Rig, LinkFaults, figure


class Session(Rig):
    def whole_day(self, uri):
        scene = self.plane_scene(offset_m=-0.01)
        info = self.ok_json("info", "--device", uri)
        self.assertEqual(info["state"]["mode"], "disarmed")
        self.assertEqual(info["state"]["scene_bytes"], 0)
        self.assertEqual(info["limits"]["max_objects"], 64)
        self.assertRegex(self.ok("info", "--device", uri).out, r"limits +64 objects")

        uploaded = self.ok_json("upload", scene, "--device", uri)
        self.assertEqual(uploaded["scene"], "floor")
        self.assertTrue(uploaded["verified"])
        self.assertEqual(self.running(uri), ("floor", uploaded["bytes"], uploaded["crc"]))

        self.assertEqual(self.ok("home", "--device", uri).out.strip(), "ready")
        self.assertEqual(self.ok("arm", "--device", uri).out.strip(), "armed")
        self.assertEqual(self.ok_json("info", "--device", uri)["state"]["mode"], "armed")

        rows = self.ok("monitor", "--count", "3", "--device", uri).out.splitlines()
        self.assertEqual(rows[0], "arm x_m y_m z_m force_x_N force_y_N force_z_N contacts mode")
        self.assertEqual(len(rows), 4)
        lines = [json.loads(line) for line in self.ok("monitor", "--seconds", "3", "--json", "--device", uri).out.splitlines()]
        self.assertTrue(all(line["schema"] == 2 and line["node"] == 1 for line in lines))
        self.assertEqual({line["message"] for line in lines}, {"Pose", "Force", "Status", "Heartbeat"})
        poses = [line for line in lines if line["message"] == "Pose"]
        self.assertLess(max(abs(pose["z_m"]) for pose in poses), 0.02)
        figure("%s: %d poses in 3 s" % (uri.split(":")[0], len(poses)))

        # A parameter that may not change while armed; one that may.
        error = self.fails(1, "refused", "param", "set", "stop_time", "0.2", "--device", uri)
        self.assertIn("stop_time", error["cause"])
        self.assertEqual(self.ok("param", "set", "max_force", "3.5", "--device", uri).out.strip(), "3.5")
        self.assertEqual(self.ok_json("param", "get", "max_force", "--device", uri)["value"], 3.5)
        names = [param["name"] for param in self.ok_json("param", "list", "--device", uri)["params"]]
        self.assertIn("host_supervision", names)
        self.assertIn("max_force", self.ok("param", "list", "--device", uri).out)

        self.assertEqual(self.ok_json("disarm", "--device", uri)["mode"], "ready")
        self.assertEqual(self.ok_json("fault", "list", "--device", uri)["faults"], [])

    def test_over_the_pty(self):
        sim = self.sim()
        self.whole_day(sim.pty)

    def test_over_tcp(self):
        sim = self.sim("--no-pty", "--tcp", 0)
        self.whole_day(sim.tcp)

    def test_the_only_device_is_implicit_and_two_are_ambiguous(self):
        first = self.sim("--tcp", 0)
        self.assertEqual(self.ok_json("info")["state"]["mode"], "disarmed")
        self.assertEqual([d["name"] for d in self.ok_json("list")["devices"]], ["arm-1"])
        second = self.sim("--arm", "wooden")
        listed = self.ok_json("list")["devices"]
        self.assertEqual([(d["name"], d["arm"], d["uris"]) for d in listed],
                         [("arm-1", "premium-1.5", first.uris), ("arm-2", "wooden", second.uris)])
        self.assertEqual(len(self.ok("list").out.splitlines()), 2)
        error = self.fails(4, "several-devices", "info")
        self.assertIn("arm-1, arm-2", error["cause"])
        self.assertEqual(self.ok_json("info", "--device", "arm-2")["arm"], "wooden")

    def test_a_fault_from_trip_to_armed_again(self):
        sim = self.sim("--tcp", 0)
        uri = sim.tcp
        self.ok("upload", self.plane_scene(offset_m=-0.01), "--device", uri)
        self.ok("home", "--device", uri)
        self.ok("arm", "--device", uri)
        # Three commands can be over in less than the 16 ms that a freeze-frame holds.
        while self.ok_json("info", "--device", uri)["state"]["tick"] < 64:
            pass
        with self.sockets_to(sim) as bus:
            bus.sendall(b"S8\rO\rt0010\r")  # the e-stop frame, by hand
        self.wait_for_mode(uri, "faulted")
        # Keep commanding: nothing arms it.
        for _ in range(3):
            error = self.fails(9, "device-faulted", "arm", "--device", uri)
            self.assertIn("host_stop", error["cause"])
        listed = self.ok_json("fault", "list", "--device", uri)
        self.assertEqual([fault["name"] for fault in listed["faults"]], ["host_stop"])
        frames = listed["faults"][0]["freeze_frames"]
        self.assertEqual(len(frames), 64)
        ticks = [frame["tick"] for frame in frames]
        self.assertEqual(ticks, list(range(ticks[0], ticks[0] + 64)))
        self.assertIn("host_stop (latched)", self.ok("fault", "list", "--device", uri).out)
        self.ok("fault", "clear", "--device", uri)
        self.assertEqual(self.ok_json("fault", "list", "--device", uri)["faults"], [])
        if self.ok_json("info", "--device", uri)["state"]["mode"] == "disarmed":
            self.ok("home", "--device", uri)
        self.ok("arm", "--device", uri)

    def sockets_to(self, sim):
        return socket.create_connection(("127.0.0.1", sim.port))

    def test_host_supervision(self):
        """With it a host that falls silent is a fault; one that keeps alive is not. Without it the scene goes on."""
        sim = self.sim("--tcp", 0)
        uri = sim.tcp
        self.ok("upload", self.plane_scene(offset_m=-0.01), "--device", uri)
        self.ok("home", "--device", uri)
        self.ok("arm", "--device", uri)
        time.sleep(1.2)
        self.assertEqual(self.ok_json("info", "--device", uri)["state"]["mode"], "armed")
        self.ok("disarm", "--device", uri)
        self.ok("param", "set", "host_supervision", "1", "--device", uri)
        self.ok("param", "set", "link_timeout", "4", "--device", uri)
        feeder = self.start("monitor", "--keep-alive", "--seconds", "8", "--device", uri)
        time.sleep(1)
        self.ok("arm", "--device", uri)
        time.sleep(3)
        self.assertEqual(self.ok_json("info", "--device", uri)["state"]["mode"], "armed")
        feeder.communicate()
        with self.sockets_to(sim) as bus:  # only listens: a question would be a sign of life
            bus.settimeout(30)
            bus.sendall(b"S8\rO\r")
            heard = b""
            while b"\rt0818" not in heard:  # the emergency frame of node 1
                heard = heard[-8:] + bus.recv(4096)
        self.assertIn(self.ok_json("info", "--device", uri)["state"]["mode"], ("damping", "faulted"))
        self.assertEqual(self.ok_json("fault", "list", "--device", uri)["faults"][0]["name"], "host_lost")

    def test_a_restart_keeps_the_scene(self):
        sim = self.sim("--tcp", 0)
        before = self.ok_json("upload", self.plane_scene(), "--device", sim.tcp)
        self.ok("home", "--device", sim.tcp)
        with self.sockets_to(sim) as bus:
            bus.sendall(b"S8\rO\rT18DA01F18021003CCCCCCCCCC\r")
            time.sleep(0.2)
            bus.sendall(b"T18DA01F18021101CCCCCCCCCC\r")
            time.sleep(0.5)
            bus.settimeout(1)
            self.assertIn(b"T18DAF1018025101", bus.recv(65536))
        self.assertEqual(self.ok_json("info", "--device", sim.tcp)["state"]["mode"], "disarmed")
        self.assertEqual(self.running(sim.tcp), ("floor", before["bytes"], before["crc"]))

    def test_an_upload_that_is_killed_goes_on(self):
        sim = self.sim("--tcp", 0)
        image = self.image(self.ball_scene(60))
        size = image.stat().st_size - 8
        before = self.ok_json("upload", self.plane_scene(), "--device", sim.tcp)
        slow = self.proxy(sim.port, LinkFaults(delay_s=0.001))
        process = self.start("upload", image, "--device", slow.uri)
        for line in process.stderr:
            if int(line.split()[0]) >= 30:
                break
        process.send_signal(signal.SIGKILL)
        process.communicate()
        self.assertEqual(self.running(sim.tcp), ("floor", before["bytes"], before["crc"]), "the running scene is untouched")
        result = self.ok_json("upload", image, "--device", sim.tcp)
        self.assertGreaterEqual(result["resumed_from"], 0.25 * size)
        self.assertEqual(self.running(sim.tcp), ("ball", size, result["crc"]))
        figure("killed upload resumed at %d of %d bytes" % (result["resumed_from"], size))

    def test_rates(self):
        sim = self.sim("--tcp", 0)
        image = self.image(self.ball_scene(100))
        for uri in (sim.tcp, sim.pty):
            result = self.ok_json("upload", image, "--device", uri)
            self.assertEqual(result["retried_blocks"], 0)
            self.assertGreater(result["rate_bytes_s"], 100e3)
            figure("upload over %s: %d bytes at %.0f kB/s" % (uri.split(":")[0], result["bytes"], result["rate_bytes_s"] / 1e3))

    def test_progress_is_a_line_per_ten_percent(self):
        sim = self.sim("--tcp", 0)
        result = self.ok("upload", self.ball_scene(40), "--device", sim.tcp)
        lines = result.err.splitlines()
        self.assertTrue(lines and len(lines) <= 10)
        self.assertTrue(all(re.fullmatch(r"\d+0 %  \d+ kB/s  \d+\.\d s left", line) for line in lines), lines)
        self.assertTrue(lines[-1].startswith("100 %"))


if __name__ == "__main__":
    unittest.main()

"""Several programs on one device at the same time: each has an address of its own, and nobody's request is dropped for another's."""

import socket
import threading
import time
import unittest

from rig import LinkFaults, Rig, figure

PLACES = 4
PLACE_ENDS_S = 5  # after the last frame of a host


class RawHosts:
    """Hosts that only claim addresses, on one connection; they claim again every second until they vanish."""

    def __init__(self, port):
        self.socket = socket.create_connection(("127.0.0.1", port))
        self.socket.sendall(b"\rC\rS8\rO\r")
        self.rest = b""
        self.keys = set()
        self.stop = threading.Event()
        self.thread = threading.Thread(target=self.renew, daemon=True)
        self.thread.start()

    @staticmethod
    def line(key):
        return b"T1C%04X018" % (key & 0xFFFF) + key.to_bytes(6, "little").hex().upper().encode() + b"0100\r"

    def claim(self, *keys):
        """Claims all in one write; the address of each key."""
        self.keys.update(keys)
        self.socket.sendall(b"".join(self.line(key) for key in keys))
        granted = {}
        self.socket.settimeout(10)
        while not set(keys) <= set(granted):
            *lines, self.rest = (self.rest + self.socket.recv(65536)).split(b"\r")
            for line in lines:
                if line.startswith(b"T1D0000018"):
                    data = bytes.fromhex(line[10:].decode())
                    granted[int.from_bytes(data[:6], "little")] = data[6]
        return granted

    def renew(self):
        while not self.stop.wait(1):
            for key in list(self.keys):
                self.socket.sendall(self.line(key))

    def vanish(self):
        self.stop.set()
        self.thread.join()
        self.socket.close()


class Hosts(Rig):
    def setUp(self):
        super().setUp()
        self.device = self.sim("--no-pty", "--tcp", 0)
        self.ok("upload", self.plane_scene(offset_m=-0.01), "--device", self.device.tcp)

    def at_once(self, *works):
        """Runs the works in threads; the first failure of one is the test's."""
        failures = []

        def run(work):
            try:
                work()
            except BaseException as error:  # of whatever kind: the thread must tell it
                failures.append(error)

        threads = [threading.Thread(target=run, args=(work,)) for work in works]
        began = time.monotonic()
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        if failures:
            raise failures[0]
        return time.monotonic() - began

    def works(self, uris, rounds, armed_for_long=False):
        """Four programs after each other's heels: an upload, questions, parameters, arming. No pause, no second try; but where frames are lost
        the arm may be armed for longer than a command waits (2 s), and then who is told so tries again."""
        upload, ask, set_, arm = uris
        scenes = [self.image(self.ball_scene(8 + i, name="ball%d" % i)) for i in range(2)]

        def uploads():
            for i in range(rounds):
                self.ok_json("upload", scenes[i % 2], "--device", upload)

        def questions():
            for _ in range(3 * rounds):
                self.assertEqual(self.ok_json("info", "--device", ask)["link"]["node"], 1)

        def set_max_force(newton):
            give_up = time.monotonic() + 30
            while True:
                result = self.run_thimble("param", "set", "max_force", str(newton), "--device", set_)
                if not (armed_for_long and result.code == 12 and "has armed the device" in result.err and time.monotonic() < give_up):
                    return result

        def parameters():
            for i in range(2 * rounds):
                result = set_max_force(2 + i)
                self.assertEqual(result.code, 0, result.err)
                self.assertEqual(float(result.out), 2 + i)

        def arming():
            self.ok("home", "--device", arm)
            for _ in range(rounds):
                self.ok("arm", "--device", arm)
                self.ok("disarm", "--device", arm)

        return uploads, questions, parameters, arming

    def test_four_at_once_without_a_pause(self):
        took = self.at_once(*self.works([self.device.tcp] * PLACES, rounds=4))
        figure("4 uploads, 12 questions, 8 parameters, 4 times armed by four programs at once: %.1f s" % took)

    def test_four_at_once_on_a_link_that_loses_frames(self):
        proxies = [self.proxy(self.device.port, LinkFaults(drop=0.005, repeat=0.005, truncate=0.005), seed) for seed in range(PLACES)]
        took = self.at_once(*self.works([proxy.uri for proxy in proxies], rounds=2, armed_for_long=True))
        lost = sum(proxy.counts["dropped"] + proxy.counts["truncated"] for proxy in proxies)
        self.assertGreater(lost, 0)
        figure("the same twice, with %d frames lost: %.1f s" % (lost, took))

    def test_claims_in_the_same_write_get_different_addresses(self):
        hosts = RawHosts(self.device.port)
        self.addCleanup(hosts.vanish)
        granted = hosts.claim(*range(0x111111, 0x111111 + PLACES))
        self.assertEqual(len(set(granted.values())), PLACES)
        self.assertTrue(all(0xF2 <= address <= 0xFD for address in granted.values()), granted)
        self.assertEqual(hosts.claim(*granted), granted, "the same keys have the same addresses")

    def test_a_fifth_is_told_so_and_a_host_that_vanished_makes_room(self):
        hosts = RawHosts(self.device.port)
        hosts.claim(*range(1, PLACES + 1))
        began = time.monotonic()
        error = self.fails(1, "hosts-full", "info", "--device", self.device.tcp)  # asks twice, for text and JSON
        figure("told after %.1f s: %s" % ((time.monotonic() - began) / 2, error["cause"]))
        self.assertGreater((time.monotonic() - began) / 2, PLACE_ENDS_S, "it waits for places of hosts that are gone")
        hosts.vanish()
        began = time.monotonic()
        self.ok("info", "--device", self.device.tcp)
        figure("a place was free %.1f s after its host vanished" % (time.monotonic() - began))

    def test_disarming_needs_no_place(self):
        self.ok("home", "--device", self.device.tcp)
        self.ok("arm", "--device", self.device.tcp)
        hosts = RawHosts(self.device.port)
        self.addCleanup(hosts.vanish)
        keys = range(1, PLACES + 1)
        granted = hosts.claim(*keys)
        began = time.monotonic()
        self.assertEqual(self.ok("disarm", "--device", self.device.tcp).out.strip(), "ready")
        took = time.monotonic() - began
        figure("disarmed after %.2f s, with all places taken" % took)
        self.assertLess(took, 3)
        self.assertEqual(self.ok_json("disarm", "--device", self.device.tcp)["mode"], "ready")
        again = hosts.claim(*keys)  # and refusals of the verb's own claims
        self.assertEqual({key: again[key] for key in keys}, granted, "nobody lost its place")

    def test_disarming_without_a_place_while_others_use_its_address(self):
        """They ask, too, and each hears the answers to all, whole and in pieces: none of them is taken for the answer to the disarm."""
        self.ok("home", "--device", self.device.tcp)
        self.ok("arm", "--device", self.device.tcp)
        hosts = RawHosts(self.device.port)
        self.addCleanup(hosts.vanish)
        ends = []
        with socket.create_connection(("127.0.0.1", self.device.port)) as bus:
            bus.sendall(b"S8\rO\rT18DA01F18023E00CCCCCCCCCC\r")  # the fourth place
            hosts.claim(*range(1, PLACES))
            talking = threading.Event()

            def talk():
                while not talking.is_set():
                    bus.sendall(50 * b"T18DA01F180722F1A1F1A3F1A4\rT18DA01F18043101020FCCCCCC\r")
                    bus.recv(1 << 20)

            talker = threading.Thread(target=talk, daemon=True)
            talker.start()
            time.sleep(0.2)
            for _ in range(5):
                ends.append(self.run_thimble("disarm", "--device", self.device.tcp))
            talking.set()
            talker.join()
        figure("exit codes of 5 disarms: %s" % [end.code for end in ends])
        self.assertEqual([(end.code, end.out.strip(), end.err) for end in ends], [(0, "ready", "")] * 5)

    def test_a_stop_needs_nobody(self):
        """While all places are taken, an upload runs, and another host holds the arm in contact."""
        self.ok("home", "--device", self.device.tcp)
        self.ok("arm", "--device", self.device.tcp)
        hosts = RawHosts(self.device.port)
        self.addCleanup(hosts.vanish)
        hosts.claim(*range(1, PLACES + 1))
        began = time.monotonic()
        said = self.ok_json("stop", "--device", self.device.tcp)
        took = time.monotonic() - began
        figure("stopped after %.3f s of the command's %.2f s, with all places taken" % (said["after_s"], took))
        self.assertEqual(said["fault"], "host_stop")
        self.assertIn(said["mode"], ("damping", "faulted"))
        self.assertLess(said["after_s"], 0.3)
        hosts.vanish()
        time.sleep(0.5)
        self.assertEqual(self.ok_json("info", "--device", self.device.tcp)["state"]["mode"], "faulted")
        self.ok("fault", "clear", "--device", self.device.tcp)

    def test_a_stop_that_nobody_confirms(self):
        with socket.create_server(("127.0.0.1", 0)) as silent:
            port = silent.getsockname()[1]
            began = time.monotonic()
            self.fails(11, "not-stopped", "stop", "--timeout", "0.5", "--device", "tcp:127.0.0.1:%d" % port)
            self.assertLess(time.monotonic() - began, 3)

    def test_one_upload_at_a_time(self):
        slow = self.proxy(self.device.port, LinkFaults(delay_s=0.002), 3)
        first = self.start("upload", self.image(self.ball_scene(80, name="first")), "--device", slow.uri)
        for line in first.stderr:
            if int(line.split()[0]) >= 10:
                break
        second = self.image(self.ball_scene(8, name="second"))
        self.fails(12, "other-program", "upload", second, "--device", self.device.tcp)
        self.assertEqual(self.running(self.device.tcp)[0], "floor")
        slow.faults = LinkFaults()
        out, err = first.communicate(timeout=100)
        self.assertEqual(first.returncode, 0, err)
        self.assertEqual(self.running(self.device.tcp)[0], "first")
        self.ok("upload", second, "--device", self.device.tcp)

    def test_an_upload_goes_on_where_a_killed_one_ended(self):
        image = self.image(self.ball_scene(60, name="again"))
        slow = self.proxy(self.device.port, LinkFaults(delay_s=0.002), 4)
        killed = self.start("upload", image, "--device", slow.uri)
        for line in killed.stderr:
            if int(line.split()[0]) >= 10:
                break
        killed.kill()
        killed.communicate()
        began = time.monotonic()
        self.assertGreater(self.ok_json("upload", image, "--device", self.device.tcp)["resumed_from"], 0)
        took = time.monotonic() - began
        figure("the upload after a killed one took %.1f s" % took)
        self.assertLess(took, PLACE_ENDS_S, "it waited until the killed host's place ended")


if __name__ == "__main__":
    unittest.main()

"""`thimble view` among clients that want to keep its owner out or use up its memory, on this machine and with --listen."""

import re
import socket
import time
import unittest

from rig import Rig, figure
from view_test import SCENES, SLOW, View
from web_client import Page, http

CROWD = 40


class HostileClients(Rig):
    def on_each_view(self, attack):
        for listen in ((), ("--listen", "127.0.0.1")):
            with self.subTest(listen=listen):
                view = View(self, "--scene", SCENES / "walls" / "walls.scene.json", *listen)
                self.owner_gets_in(view)
                attack(view)
                self.owner_gets_in(view)
                view.stop()

    def crowd(self, view, *sent):
        """Connections that each send something and say no more."""
        ends = []
        for _ in range(CROWD):
            end = socket.create_connection(("127.0.0.1", view.port), timeout=20)
            self.addCleanup(end.close)
            try:
                for part in sent:
                    end.sendall(part)
            except OSError:
                pass  # dropped for a later one
            ends.append(end)
        return ends

    def upgrade(self, view, token=""):
        return ("GET /live%s HTTP/1.1\r\nHost: 127.0.0.1:%d\r\nUpgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
                "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n" % (token, view.port)).encode()

    def owner_gets_in(self, view):
        """The page, what it loads with its cookie, and its WebSocket; seconds until the last has a state and may control."""
        began = time.monotonic()
        status, headers, page = http(view.port, "/?token=" + view.token)
        self.assertEqual(status, 200)
        self.assertNotIn(view.token, headers["set-cookie"], "browsers send it to every port of this machine")
        cookie = "Cookie: " + headers["set-cookie"].split(";")[0]
        for path in re.findall(rb'(?:src|href)="(/assets/[^"]+)"', page):
            self.assertEqual(http(view.port, path.decode(), headers=[cookie])[0], 200)
        socket_ = Page(view.port, view.token)
        self.addCleanup(socket_.close)
        self.assertTrue(socket_.receive()["may_control"])
        socket_.state()
        took = time.monotonic() - began
        self.assertLess(took, 3 * SLOW)
        return took

    def rss_kB(self, view):
        with open("/proc/%d/status" % view.process.pid) as status:
            return next(int(line.split()[1]) for line in status if line.startswith("VmRSS"))

    def test_half_requests(self):
        def attack(view):
            self.crowd(view, b"GET / HTTP/1.1\r\nHost: 127")
            figure("beside %d half requests the owner is in after %.2f s" % (CROWD, self.owner_gets_in(view)))

        self.on_each_view(attack)

    def test_slow_headers(self):
        """A byte now and then does not keep a connection."""
        def attack(view):
            end = self.crowd(view, b"GET / HTTP/1.1\r\n")[-1]
            end.settimeout(0.3)
            began = time.monotonic()
            with self.assertRaises(ConnectionError):
                while time.monotonic() - began < 12 * SLOW:
                    end.sendall(b"X")
                    try:
                        if end.recv(1) == b"":
                            raise ConnectionError
                    except TimeoutError:
                        pass
            figure("slow headers end after %.1f s" % (time.monotonic() - began))

        self.on_each_view(attack)

    def test_idle_pages_without_the_token(self):
        def attack(view):
            self.crowd(view, self.upgrade(view))

        self.on_each_view(attack)

    def test_idle_connections_with_the_token(self):
        def attack(view):
            self.crowd(view, ("GET /?token=%s HTTP/1.1\r\nHost: 127.0.0.1:%d\r\n\r\n" % (view.token, view.port)).encode())

        self.on_each_view(attack)

    def test_half_and_huge_messages(self):
        def attack(view):
            for token in ("", "?token=" + view.token):
                # The head of a message of 60 kB and no more; the beginning of one of 2^62 bytes; and one in endless parts.
                self.crowd(view, self.upgrade(view, token), b"\x81\xfe\xea\x60abcd")
                self.owner_gets_in(view)
                huge = b"\x81\xff\x3f" + b"\xff" * 7 + b"abcd" + b" " * 70_000
                # An owner's page may send the text of a scene.
                parts = b"\x01\x80abcd" + (b"\x00\xfe\x40\x00abcd" + b" " * 16384) * (160 if token else 8)
                for message in (huge, parts):
                    end = self.crowd(view, self.upgrade(view, token), message)[-1]
                    end.settimeout(5 * SLOW)
                    try:
                        while end.recv(65536):  # a TimeoutError: it was not closed
                            pass
                    except ConnectionError:
                        pass

        self.on_each_view(attack)

    def test_memory_stays_flat(self):
        """Clients that ask and read nothing, and floods of every kind."""
        def attack(view):
            token = "?token=" + view.token
            ask = ("GET /assets/none%s HTTP/1.1\r\nHost: 127.0.0.1:%d\r\n\r\n" % (token, view.port)).encode()
            before_kB = self.rss_kB(view)
            most_kB = before_kB
            for _ in range(3):
                for sent in ([ask * 400] * 4, [self.upgrade(view, token), b"\x89\x80abcd" * 20_000], [b"x" * 300_000],
                             [self.upgrade(view, token), (b"\x81\xfe\x10\x00abcd" + b"[" * 4096) * 60]):
                    for end in self.crowd_of_deaf(view, sent):
                        most_kB = max(most_kB, self.rss_kB(view))
                        end.close()
            figure("memory: %.1f MB before, %.1f MB at most" % (before_kB / 1000, most_kB / 1000))
            self.assertLess(most_kB - before_kB, 16_000 * SLOW)

        self.on_each_view(attack)

    def crowd_of_deaf(self, view, sent):
        ends = []
        for _ in range(CROWD):
            end = socket.create_connection(("127.0.0.1", view.port), timeout=20)
            end.setblocking(False)
            ends.append(end)
            try:
                for part in sent:
                    end.sendall(part)
            except OSError:
                pass
        time.sleep(0.2)
        return ends


if __name__ == "__main__":
    unittest.main()

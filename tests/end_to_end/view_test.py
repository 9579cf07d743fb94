"""`thimble view`: the server, tested through its WebSocket and HTTP interface."""

import json
import os
import signal
import socket
import subprocess
import time
import unittest
from pathlib import Path

from rig import BIN, LinkFaults, Proxy, Rig, figure
from web_client import Page, Refused, http

SCENES = Path(__file__).resolve().parents[2] / "scenes"
SLOW = 4 if "THIMBLE_UNDER_SANITIZERS" in os.environ else 1


class View:
    """A running `thimble view --no-browser`."""

    def __init__(self, rig, *arguments):
        self.process = subprocess.Popen([BIN / "thimble", "view", "--no-browser", *map(str, arguments)], stdout=subprocess.PIPE,
                                        stderr=subprocess.PIPE, text=True, env=rig.environment)
        rig.addCleanup(self.stop)
        self.url = self.process.stdout.readline().strip()
        if not self.url:
            raise AssertionError("thimble view did not start: " + self.process.stderr.read())
        self.port = int(self.url.split("/")[2].rsplit(":", 1)[1])
        self.token = self.url.partition("?token=")[2]

    def stop(self, how=signal.SIGTERM):
        if self.process.poll() is None:
            self.process.send_signal(how)
        self.process.communicate(timeout=20)
        return self.process.returncode


class SlowSessions(Proxy):
    def treat(self, line, held):
        if line[10:16] == b"021003":
            time.sleep(0.5)
        return super().treat(line, held)


def force(state, arm=0):
    return sum(f * f for f in state["arms"][arm]["force_N"]) ** 0.5


class Viewer(Rig):
    def view(self, *arguments):
        return View(self, *arguments)

    def page(self, view, token=True, **options):
        page = Page(view.port, view.token if token else None, **options)
        self.addCleanup(page.close)
        return page

    def blocks(self):
        return self.view("--scene", SCENES / "blocks" / "blocks.scene.json")

    def steady(self, page, seconds=0.8):
        """The mean force of the states that come in so long."""
        end = time.monotonic() + seconds
        forces = []
        while time.monotonic() < end:
            forces.append(force(page.state()))
        return sum(forces[len(forces) // 2:]) / len(forces[len(forces) // 2:])

    def test_a_page_that_feels_a_block(self):
        view = self.blocks()
        page = self.page(view)
        hello = page.receive()
        self.assertEqual(hello["type"], "hello")
        self.assertTrue(hello["simulated"] and hello["may_control"])
        self.assertEqual(hello["arms"], 1)
        self.assertEqual((hello["device"]["board"], hello["device"]["arm"]), ("sim", "premium-1.5"))
        self.assertIn("max_force", [parameter["name"] for parameter in hello["parameters"]])
        scene = page.until(lambda m: m["type"] == "scene" and m["objects"], what="the scene")
        self.assertEqual(scene["name"], "blocks")
        self.assertEqual([o["name"] for o in scene["objects"]], ["table", "near block", "far block"])
        self.assertEqual(scene["objects"][1]["material"],
                         {"stiffness": 1000, "damping": 2, "static_friction": 0.8, "dynamic_friction": 0.6})
        status, headers, image = http(view.port, "/scene.thim")
        self.assertEqual((status, image[4:8]), (200, b"THI2"))
        self.assertEqual(headers["content-type"], "application/octet-stream")

        free = page.state(lambda s: s.get("mode") == "armed")
        self.assertEqual(free["arms"][0]["contacts"], 0)
        self.assertEqual(free["arms"][0]["planes"], [])
        self.assertEqual(free["arms"][0]["god_m"], free["arms"][0]["tip_m"])
        for key in ("time_s", "tick", "fault", "fault_name", "limiters", "tick_rate_Hz", "worst_tick_s", "bodies", "controls", "tissues", "needles"):
            self.assertIn(key, free)

        # On to the near block, and 6 mm into it.
        page.send(type="hand", arm=0, position_m=[0, -0.03, -0.01])
        page.state(lambda s: abs(s["arms"][0]["tip_m"][1] + 0.03) < 0.003)
        page.send(type="hand", arm=0, position_m=[0, -0.03, -0.026])
        page.state(lambda s: s["arms"][0]["contacts"] == 1, what="a contact")
        felt = self.steady(page)
        state = page.state(lambda s: s["arms"][0]["planes"])
        arm = state["arms"][0]
        figure("6 mm into the block: %.2f N, hand %.1f mm from the tip" % (felt, 1e3 * abs(arm["tip_m"][2] - arm["hand_m"][2])))
        self.assertGreater(felt, 1.5)
        self.assertLess(abs(arm["god_m"][2] + 0.02), 0.001, "the god object stays on the block")
        self.assertLess(arm["tip_m"][2], arm["god_m"][2] - 0.001)
        self.assertGreater(arm["planes"][0]["normal"][2], 0.99)
        self.assertEqual({body["object"] for body in state["bodies"]}, {1, 2})
        self.assertLess(arm["energy_J"], 0, "the hand has done work on the block")

        # Softer, under the finger.
        page.send(type="material", object=1, key="stiffness", value=200)
        changed = page.until(lambda m: m["type"] == "scene", what="the changed scene")
        self.assertEqual(changed["objects"][1]["material"]["stiffness"], 200)
        self.assertEqual(changed["objects"][2]["material"]["stiffness"], 1000, "of one block only, though they share a material")
        self.assertNotEqual(changed["crc"], scene["crc"])
        self.steady(page)
        softer = self.steady(page)
        figure("1000 N/m: %.2f N, 200 N/m: %.2f N" % (felt, softer))
        self.assertLess(softer, 0.75 * felt)
        self.assertGreater(softer, 0.3 * felt)

        # A parameter, and a value beyond its limits.
        page.send(type="parameter", name="max_force", value=0.5)
        hello = page.until(lambda m: m["type"] == "hello")
        self.assertEqual(next(p for p in hello["parameters"] if p["name"] == "max_force")["value"], 0.5)
        self.assertLess(self.steady(page), 0.55)
        page.send(type="parameter", name="max_force", value=500)
        self.assertIn("max_force", page.event("bad-value")["cause"])

        page.send(type="command", verb="disarm")
        page.state(lambda s: s["mode"] == "ready")
        page.send(type="command", verb="arm")
        page.state(lambda s: s["mode"] == "armed")

        # Homing takes where the arm is held for its home: the hand goes there first.
        page.send(type="hand", arm=0, position_m=[0.03, 0.01, 0.01])
        page.state(lambda s: s["arms"][0]["hand_m"][0] > 0.029)
        page.send(type="command", verb="home")
        page.event("homed")
        state = page.state(lambda s: s["mode"] == "armed")
        self.assertLess(max(map(abs, state["arms"][0]["hand_m"])), 1e-4)
        self.assertLess(max(map(abs, state["arms"][0]["tip_m"])), 5e-4)

        page.send(type="pick", scene="ring")
        scene = page.until(lambda m: m["type"] == "scene", what="the picked scene")
        self.assertEqual(scene["name"], json.loads((SCENES / "ring/ring.scene.json").read_text())["name"])
        self.assertEqual(scene["pick"], "ring")
        page.send(type="pick", scene="../../etc/passwd")
        page.event("no-such-scene")
        self.assertEqual(view.stop(), 0)

    def test_how_late_a_state_is(self):
        view = self.blocks()
        page = self.page(view)
        page.state(lambda s: s["mode"] == "armed")
        late_ms, begun = [], time.monotonic()
        while time.monotonic() - begun < 3:
            state = page.state()
            late_ms.append(time.monotonic_ns() * 1e-6 - state["since_us"] * 1e-3)
        late_ms.sort()
        rate = len(late_ms) / 3
        figure("from the tick to the socket's reader: median %.2f ms, 95 %% %.2f ms, worst %.2f ms; %.0f states a second"
               % (late_ms[len(late_ms) // 2], late_ms[len(late_ms) * 95 // 100], late_ms[-1], rate))
        self.assertGreater(late_ms[0], 0)
        self.assertLess(late_ms[len(late_ms) // 2], 50 * SLOW)
        self.assertLess(rate, 63)

    def test_who_may_what(self):
        view = self.blocks()
        looker = self.page(view, token=False)
        self.assertFalse(looker.receive()["may_control"])
        looker.state(lambda s: s["mode"] == "armed")
        for message in ({"type": "command", "verb": "disarm"}, {"type": "hand", "arm": 0, "position_m": [0, 0, -0.03]},
                        {"type": "parameter", "name": "max_force", "value": 1}, {"type": "pick", "scene": "ring"},
                        {"type": "material", "object": 1, "key": "stiffness", "value": 200}, {"type": "save"}):
            looker.send(**message)
            looker.event("read-only")
        state = looker.state()
        self.assertEqual(state["mode"], "armed")
        self.assertEqual(state["arms"][0]["hand_m"], [0, 0, 0])
        stranger = Page(view.port, "0" * 32)
        self.addCleanup(stranger.close)
        self.assertFalse(stranger.receive()["may_control"])

        own = "http://127.0.0.1:%d" % view.port
        self.assertTrue(self.page(view, origin=own).receive()["may_control"])
        self.assertTrue(self.page(view, host="localhost:%d" % view.port, origin="http://localhost:%d" % view.port).receive()["may_control"])
        for origin in ("http://example.org", "null", "https://127.0.0.1:%d" % view.port, "http://127.0.0.1:%d" % (view.port - 1)):
            with self.assertRaises(Refused) as refused:
                Page(view.port, view.token, origin=origin)
            self.assertEqual(refused.exception.status, 403)
            self.assertEqual(http(view.port, "/", headers=["Origin: " + origin])[0], 403)
        # A name that somebody's DNS turns into this machine.
        for host in ("example.org:%d" % view.port, "127.0.0.1:1", "127.0.0.1.example.org:%d" % view.port, ""):
            self.assertEqual(http(view.port, "/", host=host or "x")[0], 403)
            with self.assertRaises(Refused):
                Page(view.port, view.token, host=host or "x")

        status, headers, body = http(view.port, "/")
        self.assertEqual((status, headers["content-type"]), (200, "text/html; charset=utf-8"))
        self.assertEqual(headers["cache-control"], "no-store")
        self.assertIn("default-src 'none'", headers["content-security-policy"])
        self.assertEqual((headers["x-content-type-options"], headers["referrer-policy"]), ("nosniff", "no-referrer"))
        self.assertNotIn(view.token.encode(), body)
        self.assertNotIn("set-cookie", headers)
        self.assertEqual(http(view.port, "/", method="HEAD")[::2], (200, b""))
        self.assertEqual(http(view.port, "/", method="POST")[0], 405)
        for path in ("/nothing", "/../../../etc/passwd", "/assets/../index.html", "/%2e%2e/etc/passwd"):
            self.assertEqual(http(view.port, path)[0], 404, path)
        scenes = json.loads(http(view.port, "/scenes.json")[2])
        self.assertLessEqual({"asteroid", "blocks", "buttons", "ring"}, set(scenes))

    def test_the_simulated_device_has_no_port(self):
        """The page's is the only one; another program of this user finds the device by its pty."""
        view = self.blocks()
        sockets = {os.readlink(fd) for fd in Path("/proc/%d/fd" % view.process.pid).iterdir()}
        listening = [line.split()[1] for table in ("tcp", "tcp6") for line in open("/proc/net/" + table)
                     if line.split()[3] == "0A" and "socket:[%s]" % line.split()[9] in sockets]
        self.assertEqual(listening, ["0100007F:%04X" % view.port])
        device, = self.ok_json("list")["devices"]
        self.assertEqual([uri.split(":")[0] for uri in device["uris"]], ["slcan"])
        self.page(view).state(lambda s: s["mode"] == "armed")
        self.assertEqual(self.ok_json("info")["state"]["mode"], "armed")
        self.assertEqual(os.stat(device["uris"][0].partition(":")[2]).st_mode & 0o777, 0o600)

    def test_listening_takes_the_token_for_everything(self):
        view = self.view("--scene", SCENES / "walls" / "walls.scene.json", "--listen", "127.0.0.1")
        for path in ("/", "/scene.thim", "/scenes.json", "/?token=" + "0" * 32):
            self.assertEqual(http(view.port, path)[0], 401, path)
        with self.assertRaises(Refused) as refused:
            Page(view.port)
        self.assertEqual(refused.exception.status, 401)
        status, headers, _ = http(view.port, "/?token=" + view.token)
        self.assertEqual(status, 200)
        cookie = headers["set-cookie"]
        self.assertIn("httponly; samesite=strict", cookie)
        # Header values were lowered; a token is hexadecimal.
        self.assertEqual(http(view.port, "/scenes.json", headers=["Cookie: a=b; " + cookie.split(";")[0]])[0], 200)
        self.assertTrue(self.page(view).receive()["may_control"])
        # Those that say nothing do not keep out the one that has the token, and are let go.
        mute = [socket.create_connection(("127.0.0.1", view.port), timeout=20) for _ in range(40)]
        for one in mute:
            self.addCleanup(one.close)
        self.assertTrue(self.page(view).receive()["may_control"])
        began = time.monotonic()
        for one in mute:
            self.assertEqual(one.recv(1), b"")
        self.assertLess(time.monotonic() - began, 8 * SLOW)

    def test_nonsense_is_answered_and_does_nothing(self):
        view = self.blocks()
        page = self.page(view)
        page.state(lambda s: s["mode"] == "armed")
        for text in ("", "{", "[]", "3", "null", "{}", '{"type": 3}', '{"type": "fly"}', '{"type": "hand"}', '{"type": "hand", "arm": 0}',
                     '{"type": "hand", "arm": 0, "position_m": [1, 2]}', '{"type": "hand", "arm": 0, "position_m": [1, 2, "3"]}',
                     '{"type": "hand", "arm": -1, "position_m": [0, 0, 0]}', '{"type": "hand", "arm": 0, "position_m": [0, 0, 1e999]}',
                     '{"type": "command", "verb": "explode"}', '{"type": "parameter", "name": "max_force"}', '{"type": "pick", "scene": 1}',
                     '{"type": "material", "object": 1, "key": "mass", "value": 1}', '{"type": "material", "object": 1.5, "key": "stiffness", "value": 1}',
                     "[" * 4000, "x" * 5000, '{"type": "command", "verb": "disarm"'):
            page.send_text(text)
            event = page.event("bad-message")
            self.assertEqual(event["level"], "error")
            self.assertTrue(event["cause"] and event["remedy"])
        page.frame(2, b"\x00\x01")
        page.event("bad-message")
        page.send(type="parameter", name="no_such", value=1)
        page.event("unknown-parameter")
        page.send(type="hand", arm=1, position_m=[0, 0, 0])
        page.event("no-such-arm")
        page.send(type="material", object=9, key="stiffness", value=200)
        page.event("no-such-object")
        page.send(type="material", object=1, key="stiffness", value=-5)
        self.assertIn("stiffness_N_m", page.event("bad-value")["cause"])
        page.send(type="save")
        page.event("nothing-to-save")
        state = page.state()
        self.assertEqual((state["mode"], state["arms"][0]["hand_m"]), ("armed", [0, 0, 0]))
        # Far out of reach: the hand stops where the arm does.
        page.send(type="hand", arm=0, position_m=[0, 0, 1e6])
        time.sleep(1)
        far = page.state(lambda s: s["arms"][0]["hand_m"][2] > 0.02)
        for _ in range(60):
            far = page.state()
        self.assertLess(far["arms"][0]["hand_m"][2], 1)
        self.assertEqual(far["fault"], 0)
        # More than anyone needs.
        for _ in range(600):
            page.send(type="hand", arm=0, position_m=[0, 0, 0.01])
        page.event("too-many-messages")
        # Not text at all: the connection ends, and nothing else.
        page.frame(1, b"\xff\xfe")
        with self.assertRaises(ConnectionError):
            while True:
                page.receive()
        with socket.create_connection(("127.0.0.1", view.port)) as raw:
            raw.sendall(b"\x16\x03\x01" + os.urandom(200))
        self.page(view).state(lambda s: s["mode"] == "armed")

    def test_two_pages_and_a_slow_one(self):
        view = self.blocks()
        page, other = self.page(view), self.page(view)
        slow = self.page(view, receive_buffer=2048)
        page.state(lambda s: s["mode"] == "armed")

        def rate(of, seconds):
            end, count = time.monotonic() + seconds, 0
            while time.monotonic() < end:
                of.state()
                count += 1
            return count / seconds

        page.send(type="hand", arm=0, position_m=[0.01, 0, 0])
        other.state(lambda s: s["arms"][0]["hand_m"][0] > 0.009, what="the other page's hand")
        alone = rate(page, 2)
        with_slow = rate(page, 4)  # by now nothing more goes into the slow one's buffers
        figure("states a second: %.0f, and %.0f after six seconds beside a page that does not read" % (alone, with_slow))
        self.assertGreater(with_slow, 0.7 * alone)
        page.send(type="hand", arm=0, position_m=[-0.01, 0, 0])
        page.state(lambda s: s["arms"][0]["hand_m"][0] < -0.009)
        behind = 0
        while slow.state()["arms"][0]["hand_m"][0] > -0.009:
            behind += 1
        figure("the slow page had %d states to read before the newest" % behind)
        self.assertLess(behind, 250)

    def test_saving(self):
        scene = self.plane_scene("saved", offset_m=-0.01)
        view = self.view("--scene", scene)
        page = self.page(view)
        page.state(lambda s: s["mode"] == "armed")
        for value in (500, 450, 400):
            page.send(type="material", object=0, key="stiffness", value=value)
        page.until(lambda m: m["type"] == "scene" and m["objects"][0]["material"]["stiffness"] == 400)
        page.send(type="save")
        self.assertIn(str(scene), page.event("saved")["cause"])
        document = json.loads(scene.read_text())
        self.assertEqual(document["objects"][0]["material"]["stiffness_N_m"], 400)
        self.assertEqual(list(document), ["thimble_scene", "name", "objects"])
        self.assertEqual([f.name for f in self.folder.glob("saved*")], ["saved.scene.json"])
        self.image(scene)
        page.send(type="material", object=0, key="stiffness", value=300)
        page.until(lambda m: m["type"] == "scene" and m["objects"][0]["material"]["stiffness"] == 300)
        scene.write_text("{")  # with an error, so that it will not run
        page.send(type="save")
        page.event("scene-changed")
        self.assertEqual(scene.read_text(), "{")

    def test_an_editor_writes_the_file(self):
        scene = self.plane_scene("edited", offset_m=-0.01)
        view = self.view("--scene", scene)
        page = self.page(view)
        page.state(lambda s: s["mode"] == "armed")

        def runs(key, value):
            page.until(lambda m: m["type"] == "scene" and m["objects"][0]["material"][key] == value, what=f"{key} {value}")

        document = json.loads(scene.read_text())
        document["objects"][0]["material"] = {"stiffness_N_m": 410}
        draft = self.folder / "draft"
        draft.write_text("// by an editor\n" + json.dumps(document, indent=1))
        draft.rename(scene)
        self.assertIn(str(scene), page.event("scene-reloaded")["cause"])
        runs("stiffness", 410)
        # What is not saved stays; what the editor wrote does too.
        page.send(type="material", object=0, key="stiffness", value=320)
        runs("stiffness", 320)
        text = scene.read_text().replace("410", "410, /* N s/m */ \"damping_N_s_m\": 1.5")
        scene.write_text(text)
        page.event("scene-reloaded")
        runs("damping", 1.5)
        page.send(type="save")
        page.event("saved")
        self.assertEqual(scene.read_text(), text.replace("410", "320"))
        # Every error is told, and the scene goes on as it was.
        scene.write_text(text.replace("410", "-1").replace("1.5", "-2"))
        errors = [page.event("bad-value"), page.event("bad-value")]
        self.assertEqual({e["pointer"].split("/")[-1] for e in errors}, {"stiffness_N_m", "damping_N_s_m"})
        self.assertTrue(all(e["line"] > 1 and e["column"] > 1 for e in errors))
        page.event("old-scene-runs")
        page.state(lambda s: s["mode"] == "armed")
        scene.write_text(text.replace("410", "330"))
        runs("stiffness", 330)

    def test_a_page_edits_the_text(self):
        scene = self.plane_scene("text", offset_m=-0.01)
        text = "// by hand\n" + scene.read_text()
        scene.write_text(text)
        view = self.view("--scene", scene)
        page, looker = self.page(view), self.page(view, token=False)
        page.state(lambda s: s["mode"] == "armed")
        for message in ({"type": "text"}, {"type": "draft", "number": 1, "text": text}):
            looker.send(**message)
            looker.event("read-only")

        def text_of():
            page.send(type="text")
            return page.until(lambda m: m["type"] == "text")

        def draft(number, text):
            page.send(type="draft", number=number, text=text)
            return page.until(lambda m: m["type"] == "checked" and m["number"] == number)

        first = text_of()
        self.assertEqual((first["text"], first["file"], first["unsaved"]), (text, "text.scene.json", False))
        stiffer = text.replace("800", "640") if "800" in text else text.replace('"stiffness_N_m": ', '"stiffness_N_m": 1')
        self.assertNotEqual(stiffer, text)
        checked = draft(7, stiffer)
        self.assertEqual(checked["issues"], [])
        runs = page.until(lambda m: m["type"] == "scene" and m.get("text_crc") == checked["crc"])
        self.assertTrue(runs["unsaved"])
        self.assertEqual(scene.read_text(), text)
        # All errors at once; what runs goes on, and is what the next one who asks gets.
        bad = draft(8, stiffer.replace('"offset_m"', '"offset"').replace('"stiffness_N_m"', '"stiffness"'))
        self.assertGreater(len(bad["issues"]), 1)
        self.assertTrue(all(issue["line"] > 1 and issue["cause"] and issue["remedy"] for issue in bad["issues"]))
        page.send(type="save")
        page.event("not-saved")
        self.assertEqual(scene.read_text(), text)
        self.assertEqual(text_of()["text"], stiffer)
        self.assertEqual(page.state()["mode"], "armed")
        # Only the last of many is compiled in the end, and what is saved is what was sent, to the byte.
        for number in range(10, 40):
            page.send(type="draft", number=number, text=stiffer + " " * number)
        answered = set()
        while 39 not in answered:  # those that were not compiled, too
            answered.add(page.until(lambda m: m["type"] == "checked")["number"])
        self.assertEqual(answered, set(range(10, 40)))
        page.send(type="save")
        page.event("saved")
        self.assertEqual(scene.read_text(), stiffer + " " * 39)
        # The file is written elsewhere while a draft runs: neither is lost.
        mine, theirs = stiffer + "// mine\n", stiffer + "// theirs\n"
        draft(50, mine)
        scene.write_text(theirs)
        page.event("file-changed")
        page.send(type="save")
        page.event("scene-changed")
        self.assertEqual((scene.read_text(), text_of()["text"]), (theirs, mine))
        page.send(type="save", replaces=True)
        page.event("saved")
        self.assertEqual(scene.read_text(), mine)
        draft(51, mine + "// more\n")
        scene.write_text(theirs)
        page.event("file-changed")
        page.send(type="pick", scene="text")
        page.until(lambda m: m["type"] == "scene" and not m["unsaved"])
        self.assertEqual(text_of()["text"], theirs)
        # A pick drops a draft; its page is told.
        page.send(type="draft", number=60, text=text)  # another image, whose upload waits
        page.send(type="pick", scene="text")
        dropped = page.until(lambda m: m["type"] == "checked" and m["number"] == 60 and m["issues"])
        self.assertEqual([issue["name"] for issue in dropped["issues"]], ["draft-dropped"])

    def test_a_page_adds_a_file(self):
        scene = self.plane_scene("added", offset_m=-0.01)
        view = self.view("--scene", scene)
        page = self.page(view)
        page.state(lambda s: s["mode"] == "armed")

        def put(name, data, token=view.token, origin=None):
            headers = ["Content-Length: %d" % len(data)] + (["Origin: " + origin] if origin else [])
            return http(view.port, "/files/%s?token=%s" % (name, token), method="PUT", headers=headers, body=data)[0]

        tetrahedron = b"v 0 0 0\nv 9 0 0\nv 0 9 0\nv 0 0 9\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n"
        self.assertEqual(put("part.obj", tetrahedron, token="0" * 32), 405)
        self.assertEqual(put("part.obj", tetrahedron, origin="http://example.org"), 403)
        self.assertEqual(put("..%2fpart.obj", tetrahedron), 400)
        self.assertEqual(put("added.scene.json", tetrahedron), 400)
        self.assertEqual([f.name for f in self.folder.glob("*.obj")], [])
        with self.assertRaises((OSError, IndexError)):  # nobody without the token sends so much
            put("part.obj", b"x" * 4000, token="0" * 32)
        self.assertEqual(put("part.obj", tetrahedron), 200)
        document = json.loads(scene.read_text())
        document["objects"].append({"name": "part", "shape": {"mesh": {"file": "part.obj", "scale": 0.001}}, "material": {"stiffness_N_m": 500}})
        page.send(type="draft", number=1, text=json.dumps(document))
        self.assertEqual(page.until(lambda m: m["type"] == "checked")["issues"], [])
        page.until(lambda m: m["type"] == "scene" and len(m["objects"]) == 2)
        self.assertEqual((self.folder / "part.obj").read_bytes(), tetrahedron)
        put("part.obj", b"v 0 0 0\n")
        page.event("file-exists")
        self.assertEqual((self.folder / "part.obj").read_bytes(), tetrahedron)

    def test_a_save_waits_for_the_change(self):
        """A save right behind a change, alone and behind others that compile and go up meanwhile."""
        scene = self.plane_scene("eager", offset_m=-0.01)
        link = self.folder / "link.scene.json"
        link.symlink_to(scene)
        scene.chmod(0o640)
        view = self.view("--scene", link)
        page = self.page(view)
        page.state(lambda s: s["mode"] == "armed")

        def saved():
            page.event("saved")
            return json.loads(scene.read_text())["objects"][0]["material"]["stiffness_N_m"]

        page.send(type="material", object=0, key="stiffness", value=310)
        page.send(type="save")
        self.assertEqual(saved(), 310)
        for value in range(320, 420, 10):
            page.send(type="material", object=0, key="stiffness", value=value)
            time.sleep(0.02)
        page.send(type="save")
        self.assertEqual(saved(), 410)
        page.send(type="material", object=0, key="stiffness", value=500)
        page.send(type="save")
        page.send(type="pick", scene="ring")
        self.assertIn("picked", page.event("not-saved")["cause"])
        self.assertEqual(json.loads(scene.read_text())["objects"][0]["material"]["stiffness_N_m"], 410)
        self.assertTrue(link.is_symlink())
        self.assertEqual(scene.stat().st_mode & 0o777, 0o640)

    def test_what_is_picked_last_runs(self):
        (self.folder / "folder.scene.json").mkdir()
        os.mkfifo(self.folder / "pipe.scene.json")
        view = self.view("--scene", SCENES / "blocks" / "blocks.scene.json", "--scenes", self.folder)
        page = self.page(view)
        page.state(lambda s: s["mode"] == "armed")
        names = json.loads(http(view.port, "/scenes.json")[2])
        self.assertFalse({"folder", "pipe"} & set(names))
        for name in ("baboon", "walls", "asteroid", "ring"):
            page.send(type="pick", scene=name)
        page.send(type="material", object=0, key="stiffness", value=200)  # of the scene that runs yet: given up with it
        page.until(lambda m: m["type"] == "scene" and m.get("pick") == "ring", what="the last pick")
        page.send(type="save")
        page.until(lambda m: self.assertNotEqual(m["type"], "scene") or m.get("name") == "nothing-to-save", what="nothing to save")
        # A material that does not compile: the pages are told what runs.
        page.send(type="material", object=0, key="stiffness", value=-5)
        page.event("bad-value")
        self.assertEqual(page.until(lambda m: m["type"] == "scene")["pick"], "ring")

    def page_while_homing(self):
        """A page that has asked for homing, which takes seconds and ends armed."""
        page = self.page(self.blocks())
        page.state(lambda s: s["mode"] == "armed")
        page.send(type="hand", arm=0, position_m=[0.03, 0.01, 0.01])
        page.state(lambda s: s["arms"][0]["hand_m"][0] > 0.029)
        page.send(type="command", verb="home")
        return page

    def test_a_stop_waits_for_nothing(self):
        page = self.page_while_homing()
        for _ in range(300):
            page.send(type="command", verb="clear")  # more than a page may send
        began = time.monotonic()
        page.send(type="command", verb="stop")
        page.state(lambda s: s["fault_name"] == "host_stop")
        figure("stopped after %.3f s, while homing goes on" % (time.monotonic() - began))
        self.assertLess(time.monotonic() - began, 0.5)
        self.steady(page, 1.5)
        self.assertEqual(page.state()["mode"], "faulted")

    def test_a_stop_overtakes_a_clear_on_its_way(self):
        """What goes before the clear is slow, so the stop, too, leaves before it."""
        sim = self.sim("--no-pty", "--tcp", 0)
        slow = SlowSessions(sim.port, LinkFaults())
        self.addCleanup(slow.close)
        view = self.view("--device", slow.uri)
        owner, looker = self.page(view), self.page(view, token=False)
        looker.send(type="command", verb="stop")
        owner.state(lambda s: s["fault_name"] == "host_stop")
        for _ in range(3):
            owner.send(type="command", verb="clear")
            time.sleep(0.2)
            looker.send(type="command", verb="stop")
            owner.event("refused")
            self.assertEqual(self.ok_json("info", "--device", sim.tcp)["state"]["mode"], "faulted")

    def test_a_page_without_the_token_may_stop(self):
        view = self.blocks()
        page = self.page(view, token=False)
        page.state(lambda s: s["mode"] == "armed")
        page.send(type="command", verb="stop")
        self.assertEqual(page.state(lambda s: s["fault"] != 0)["fault_name"], "host_stop")

    def test_a_disarm_always_has_a_place(self):
        page = self.page_while_homing()
        for _ in range(80):
            page.send(type="command", verb="clear")
        page.event("busy")
        page.send(type="command", verb="disarm")
        page.event("homed")
        self.steady(page, 1.5)  # it is armed again, and then disarmed
        self.assertEqual(page.state()["mode"], "ready")
        # A slider's many values are one that waits.
        page.send(type="command", verb="home")
        for value in range(110, 200):
            page.send(type="material", object=1, key="stiffness", value=value)
            page.send(type="material", object=1, key="damping", value=value / 100)
        material = page.until(lambda m: self.assertNotEqual(m.get("name"), "busy") or
                              m["type"] == "scene" and m["objects"][1]["material"]["stiffness"] == 199)["objects"][1]["material"]
        self.assertEqual(material["damping"], 1.99)

    def test_two_views_of_one_device(self):
        sim = self.sim("--tcp", 0)
        self.ok("upload", SCENES / "blocks/blocks.scene.json", "--device", sim.tcp)
        page, other = (self.page(self.view("--device", sim.tcp)) for _ in range(2))
        for one in (page, other):
            one.until(lambda m: m["type"] == "scene" and m["objects"])
        page.send(type="material", object=1, key="stiffness", value=200)
        page.until(lambda m: m["type"] == "scene" and m["objects"][1]["material"]["stiffness"] == 200)
        scene = other.until(lambda m: m["type"] == "scene", what="the scene that the other one changed")
        self.assertEqual([o["name"] for o in scene["objects"]], ["table", "near block", "far block"])
        other.event("other-host")

    def test_a_disarm_does_not_wait_behind_another_program(self):
        sim = self.sim("--tcp", 0)
        scene = self.plane_scene(offset_m=-0.01)
        self.ok("upload", scene, "--device", sim.tcp)
        page = self.page(self.view("--device", sim.tcp))
        other = self.start("record", self.folder / "other.rec", "--scene", scene, "--home", "--arm", "--device", sim.tcp)
        self.addCleanup(other.communicate)
        self.addCleanup(other.kill)
        page.state(lambda s: s["mode"] == "armed")
        for _ in range(8):
            page.send(type="command", verb="arm")  # each would wait 2 s for the other program
        page.send(type="command", verb="disarm")
        began = time.monotonic()
        page.state(lambda s: s["mode"] == "ready")
        figure("disarmed after %.2f s, behind eight commands that another program keeps from the page" % (time.monotonic() - began))
        self.assertLess(time.monotonic() - began, 8 * SLOW)

    def test_a_signal_while_it_connects(self):
        with socket.create_server(("127.0.0.1", 0)) as mute:
            process = subprocess.Popen([BIN / "thimble", "view", "--no-browser", "--device", "tcp:127.0.0.1:%d" % mute.getsockname()[1], "--timeout", "30"],
                                       stdout=subprocess.PIPE, stderr=subprocess.PIPE, env=self.environment)
            end = mute.accept()[0]
            self.addCleanup(end.close)
            process.send_signal(signal.SIGTERM)
            process.communicate(timeout=5)
            self.assertEqual(process.returncode, -signal.SIGTERM)

    def test_a_device_that_vanishes_and_comes_back(self):
        sim = self.sim("--tcp", 0)
        port = sim.port
        self.ok("upload", SCENES / "blocks/blocks.scene.json", "--device", sim.tcp)
        view = self.view("--device", sim.tcp)
        page = self.page(view)
        hello = page.receive()
        self.assertFalse(hello["simulated"])
        self.assertEqual(hello["device"]["address"], sim.tcp)
        scene = page.until(lambda m: m["type"] == "scene")
        self.assertEqual([o["name"] for o in scene["objects"]], ["table", "near block", "far block"], "found by its CRC among Thimble's own")
        self.assertEqual(http(view.port, "/scene.thim")[0], 200)
        state = page.state()
        self.assertNotIn("hand_m", state["arms"][0])
        page.send(type="hand", arm=0, position_m=[0, 0, 0])
        page.event("not-simulated")
        page.send(type="command", verb="arm")
        self.assertIn("not_homed", page.event("refused")["cause"])
        page.send(type="command", verb="home")
        page.state(lambda s: s["mode"] == "ready")
        page.send(type="command", verb="arm")
        page.state(lambda s: s["mode"] == "armed")
        # Another host sends a scene whose file is not known, once the page's arm is not armed.
        self.fails(12, "other-program", "upload", self.plane_scene("elsewhere"), "--device", sim.tcp)
        page.send(type="command", verb="disarm")
        page.state(lambda s: s["mode"] == "ready")
        self.ok("upload", self.plane_scene("elsewhere"), "--device", sim.tcp)
        scene = page.until(lambda m: m["type"] == "scene")
        self.assertEqual((scene["name"], scene["objects"]), ("elsewhere", []))
        page.event("scene-unknown")
        self.assertEqual(http(view.port, "/scene.thim")[0], 404)
        page.send(type="material", object=0, key="stiffness", value=300)
        page.event("no-scene-file")

        sim.stop(signal.SIGKILL)
        began = time.monotonic()
        event = page.event("link-lost")
        self.assertTrue(event["cause"] and event["remedy"])
        page.until(lambda m: m == {"type": "link", "up": False})
        figure("a killed controller is told after %.2f s" % (time.monotonic() - began))
        late = self.page(view)
        late.until(lambda m: m == {"type": "link", "up": False}, what="what a new page is told")
        page.send(type="command", verb="arm")
        page.event("no-device")
        self.sim("--tcp", port)
        began = time.monotonic()
        page.until(lambda m: m == {"type": "link", "up": True}, what="the link")
        page.event("link-back")
        figure("and its return after %.2f s" % (time.monotonic() - began))
        self.assertEqual(page.state(lambda s: s.get("mode"))["mode"], "disarmed")
        self.assertEqual(view.stop(signal.SIGINT), 0)

    def test_a_clear_word(self):
        scene = SCENES / "walls" / "walls.scene.json"
        with socket.create_server(("127.0.0.1", 0)) as taken:
            self.fails(1, "port-in-use", "view", "--no-browser", "--scene", scene, "--port", taken.getsockname()[1])
        self.fails(2, "bad-address", "view", "--no-browser", "--scene", scene, "--listen", "nowhere")
        self.fails(2, "cannot-listen", "view", "--no-browser", "--scene", scene, "--listen", "192.0.2.1")
        self.fails(2, "usage", "view", "--no-browser", "--scene", scene, "--device", "arm-1")
        self.fails(3, "no-device", "view", "--no-browser")
        self.fails(3, "no-device", "view", "--no-browser", "--device", "tcp:127.0.0.1:1")
        self.fails(10, "missing-scene", "view", "--no-browser", "--scene", "nowhere.scene.json")
        self.fails(10, "no-folder", "view", "--no-browser", "--scene", scene, "--scenes", "nowhere")
        broken = self.folder / "broken.scene.json"
        broken.write_text('{"thimble_scene": 1, "name": "x", "objects": [{"name": "y", "shape": {"cube": 1}}]}')
        error = self.fails(10, "unknown-key", "view", "--no-browser", "--scene", broken)
        self.assertIn("broken.scene.json:1: /objects/0/shape/cube", error["cause"])

    def test_a_browser_and_none(self):
        """With a browser it gets the address; without one the address is printed, and that is said."""
        opened = self.folder / "opened"
        browser = self.folder / "browser.sh"
        # As one that stays: what it has from the command must not end it, nor keep the port.
        browser.write_text('#!/bin/sh\nps -o sid= -p $$ > %s.sid\nls -l /proc/$$/fd > %s.fds\ngrep SigIgn /proc/$$/status > %s.ignored\necho "$1" > %s\n'
                           % (opened, opened, opened, opened))
        browser.chmod(0o755)
        for program, said in ((browser, ""), (self.folder / "none", "no browser was opened")):
            process = subprocess.Popen([BIN / "thimble", "view", "--scene", SCENES / "walls/walls.scene.json"], text=True,
                                       stdout=subprocess.PIPE, stderr=subprocess.PIPE, env=dict(self.environment, BROWSER=str(program)))
            url = process.stdout.readline().strip()
            end = time.monotonic() + (1.5 if said else 20)  # on a busy machine the browser takes its time
            while time.monotonic() < end and (said or not opened.exists() or not opened.read_text()):
                time.sleep(0.1)
            process.send_signal(signal.SIGTERM)
            err = process.communicate(timeout=20)[1]
            self.assertEqual(process.returncode, 0)
            self.assertIn(said, err)
            if not said:
                self.assertEqual(opened.read_text().strip(), url)
                self.assertEqual(err, "")
                self.assertNotEqual(int((self.folder / "opened.sid").read_text()), os.getsid(0))
                descriptors = (self.folder / "opened.fds").read_text()
                self.assertNotIn("socket:", descriptors)
                self.assertIn(" 0 -> /dev/null", descriptors)
                self.assertFalse(int((self.folder / "opened.ignored").read_text().split()[1], 16) & 1 << (signal.SIGPIPE - 1))

    def test_two_arms_in_one_scene(self):
        view = self.view("--scene", SCENES / "blocks" / "blocks.scene.json", "--arms", 2)
        page = self.page(view)
        self.assertEqual(page.receive()["arms"], 2)
        state = page.state(lambda s: s["mode"] == "armed" and all(s["arms"]))
        self.assertEqual(len(state["arms"]), 2)
        self.assertAlmostEqual(state["arms"][1]["tip_m"][0] - state["arms"][0]["tip_m"][0], 0.2, delta=0.01)
        page.send(type="hand", arm=1, position_m=[0.1, 0, -0.06])
        page.state(lambda s: s["arms"][1]["contacts"] == 1 and s["arms"][0]["contacts"] == 0, what="the second arm on the table")
        self.assertEqual(page.state(lambda s: s["arms"][1]["planes"], what="its plane")["arms"][1]["planes"], [{"normal": [0, 0, 1]}])


if __name__ == "__main__":
    unittest.main()

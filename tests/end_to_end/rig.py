"""What the end-to-end tests share: simulators, the command, scenes, and a proxy that causes faults on the link."""

import json
import math
import os
import random
import shutil
import signal
import socket
import subprocess
import tempfile
import threading
import time
import unittest
from pathlib import Path

BIN = Path(os.environ["THIMBLE_BIN"])
PATIENCE_S = 240  # with a command that ends: other tests may leave a long one a small part of a processor


class Result:
    def __init__(self, process):
        self.code = process.returncode
        self.out = process.stdout
        self.err = process.stderr

    @property
    def json(self):
        return json.loads(self.out)


class Sim:
    """A running thimble-sim."""

    def __init__(self, rig, *arguments):
        self.rig = rig
        self.process = subprocess.Popen([BIN / "thimble-sim", "--name", rig.next_name(), *map(str, arguments)],
                                        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=rig.environment)
        self.uris = []
        for line in self.process.stdout:
            if line.strip() == "ready":
                break
            self.uris.append(line.strip())
        else:
            raise AssertionError("thimble-sim did not start: " + self.process.stderr.read())

    @property
    def tcp(self):
        return next(uri for uri in self.uris if uri.startswith("tcp:"))

    @property
    def pty(self):
        return next(uri for uri in self.uris if uri.startswith("slcan:"))

    @property
    def port(self):
        return int(self.tcp.rsplit(":", 1)[1])

    def stop(self, how=signal.SIGTERM):
        if self.process.poll() is None:
            self.process.send_signal(how)
        self.process.communicate(timeout=20)
        return self.process.returncode


class LinkFaults:
    """Chances a frame, each way."""

    def __init__(self, drop=0.0, repeat=0.0, reorder=0.0, truncate=0.0, stall=0.0, stall_s=0.3, delay_s=0.0):
        self.drop, self.repeat, self.reorder, self.truncate = drop, repeat, reorder, truncate
        self.stall, self.stall_s, self.delay_s = stall, stall_s, delay_s


class Proxy:
    """A TCP relay that applies link faults to SLCAN frames; commands (O, C, S8) pass."""

    def __init__(self, port, faults, seed=1):
        self.faults = faults
        self.target = port
        self.random = random.Random(seed)
        self.counts = dict(frames=0, dropped=0, repeated=0, reordered=0, truncated=0, stalled=0)
        self.lock = threading.Lock()
        self.listener = socket.create_server(("127.0.0.1", 0))
        self.uri = "tcp:127.0.0.1:%d" % self.listener.getsockname()[1]
        self.sockets = []
        threading.Thread(target=self.accept, daemon=True).start()

    def accept(self):
        while True:
            try:
                near, _ = self.listener.accept()
            except OSError:
                return
            far = socket.create_connection(("127.0.0.1", self.target))
            for end in (near, far):
                end.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            self.sockets += [near, far]
            threading.Thread(target=self.relay, args=(near, far), daemon=True).start()
            threading.Thread(target=self.relay, args=(far, near), daemon=True).start()

    def relay(self, source, sink):
        held = b""
        rest = b""
        try:
            while True:
                data = source.recv(65536)
                if not data:
                    break
                *lines, rest = (rest + data).split(b"\r")
                out = b""
                for line in lines:
                    line += b"\r"
                    if line[:1] not in (b"T", b"D", b"B"):
                        out += line
                        continue
                    treated, held = self.treat(line, held)
                    if self.faults.delay_s:
                        time.sleep(self.faults.delay_s)
                    if treated is None:  # stalled: what is ready goes out first
                        sink.sendall(out)
                        out = b""
                        time.sleep(self.faults.stall_s)
                        treated = line
                    out += treated
                sink.sendall(out)
        except OSError:
            pass
        for end in (source, sink):
            try:
                end.shutdown(socket.SHUT_RDWR)
            except OSError:
                pass

    def treat(self, line, held):
        """The bytes to send instead of the line, and a line to be sent after the next one."""
        faults = self.faults
        with self.lock:
            self.counts["frames"] += 1
            if self.random.random() < faults.drop:
                self.counts["dropped"] += 1
                return held, b""
            if self.random.random() < faults.truncate:
                self.counts["truncated"] += 1
                return line[: self.random.randrange(len(line) - 1)] + b"\r" + held, b""
            if self.random.random() < faults.repeat:
                self.counts["repeated"] += 1
                return line + line + held, b""
            if not held and self.random.random() < faults.reorder:
                self.counts["reordered"] += 1
                return b"", line
            if self.random.random() < faults.stall:
                self.counts["stalled"] += 1
                return None, held
        return line + held, b""

    def close(self):
        self.listener.close()
        for end in self.sockets:
            end.close()


class Rig(unittest.TestCase):
    """A test with a runtime directory and a working folder of its own."""

    @classmethod
    def setUpClass(cls):
        cls.folder = Path(tempfile.mkdtemp(prefix="thimble-e2e-"))
        cls.addClassCleanup(shutil.rmtree, cls.folder, ignore_errors=True)

    def setUp(self):
        self.runtime = Path(tempfile.mkdtemp(prefix="thimble-run-"))
        self.addCleanup(shutil.rmtree, self.runtime, ignore_errors=True)
        self.environment = dict(os.environ, XDG_RUNTIME_DIR=str(self.runtime), XDG_CACHE_HOME=str(self.runtime / "cache"),
                                XDG_DATA_HOME=str(self.runtime / "data"))
        self.names = 0

    def next_name(self):
        self.names += 1
        return "arm-%d" % self.names

    def sim(self, *arguments):
        sim = Sim(self, *arguments)
        self.addCleanup(sim.stop)
        return sim

    def proxy(self, port, faults, seed=1):
        proxy = Proxy(port, faults, seed)
        self.addCleanup(proxy.close)
        return proxy

    def start(self, *arguments):
        return subprocess.Popen([BIN / "thimble", *map(str, arguments)], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                                text=True, env=self.environment)

    def run_thimble(self, *arguments, timeout=PATIENCE_S):
        return Result(subprocess.run([BIN / "thimble", *map(str, arguments)], capture_output=True, text=True,
                                     env=self.environment, timeout=timeout))

    def ok(self, *arguments, timeout=PATIENCE_S):
        result = self.run_thimble(*arguments, timeout=timeout)
        self.assertEqual(result.code, 0, f"thimble {' '.join(map(str, arguments))}: {result.err}")
        return result

    def on_terminal(self, *arguments):
        """What a command that ends well writes to a terminal on stderr."""
        terminal, end = os.openpty()
        with subprocess.Popen([BIN / "thimble", *map(str, arguments)], stdout=subprocess.DEVNULL, stderr=end, env=self.environment) as command:
            os.close(end)
            text = b""
            try:
                while chunk := os.read(terminal, 4096):
                    text += chunk
            except OSError:  # the other end is closed
                pass
            os.close(terminal)
        self.assertEqual(command.returncode, 0, text)
        return text.decode()

    def ok_json(self, *arguments, timeout=PATIENCE_S):
        document = self.ok(*arguments, "--json", timeout=timeout).json
        self.assertEqual(document["schema"], 2)
        return document

    def fails(self, code, name, *arguments, timeout=PATIENCE_S):
        """Fails with this exit code and error name, in text and in JSON, with cause and remedy and nothing on stdout."""
        text = self.run_thimble(*arguments, timeout=timeout)
        self.assertEqual(text.code, code, text.err)
        self.assertEqual(text.out, "")
        self.assertIn("thimble: " + name + ": ", text.err)
        self.assertIn("remedy: ", text.err)
        machine = self.run_thimble(*arguments, "--json", timeout=timeout)
        self.assertEqual(machine.code, code, machine.err)
        error = json.loads(machine.err)
        self.assertEqual(error["schema"], 2)
        self.assertEqual(error["error"]["name"], name)
        self.assertEqual(error["error"]["exit_code"], code)
        self.assertTrue(error["error"]["cause"] and error["error"]["remedy"])
        return error["error"]

    def plane_scene(self, name="floor", stiffness=800, offset_m=0.0, damping=1):
        file = self.folder / (name + ".scene.json")
        file.write_text(json.dumps({
            "thimble_scene": 1, "name": name,
            "objects": [{"name": "floor", "shape": {"plane": {"normal": [0, 0, 1], "offset_m": offset_m}},
                         "material": {"stiffness_N_m": stiffness, "damping_N_s_m": damping, "static_friction": 0.5,
                                      "dynamic_friction": 0.3}}]}))
        return file

    def ball_scene(self, rings, name="ball"):
        """A scene with a mesh: a sphere of 5 cm with about 2 rings^2 * 2 triangles."""
        sectors = 2 * rings
        lines = ["v 0 0 0.05"]
        for ring in range(1, rings):
            for sector in range(sectors):
                polar, around = math.pi * ring / rings, 2 * math.pi * sector / sectors
                lines.append("v %.9f %.9f %.9f" % (0.05 * math.sin(polar) * math.cos(around),
                                                   0.05 * math.sin(polar) * math.sin(around), 0.05 * math.cos(polar)))
        lines.append("v 0 0 -0.05")
        last = 2 + (rings - 1) * sectors
        at = lambda ring, sector: 2 + (ring - 1) * sectors + sector % sectors
        for sector in range(sectors):
            lines.append("f 1 %d %d" % (at(1, sector), at(1, sector + 1)))
            lines.append("f %d %d %d" % (last, at(rings - 1, sector + 1), at(rings - 1, sector)))
            for ring in range(1, rings - 1):
                lines.append("f %d %d %d" % (at(ring, sector), at(ring + 1, sector), at(ring + 1, sector + 1)))
                lines.append("f %d %d %d" % (at(ring, sector), at(ring + 1, sector + 1), at(ring, sector + 1)))
        (self.folder / (name + ".obj")).write_text("\n".join(lines) + "\n")
        file = self.folder / (name + ".scene.json")
        file.write_text(json.dumps({
            "thimble_scene": 1, "name": name,
            "objects": [{"name": "ball", "shape": {"mesh": {"file": name + ".obj", "scale": 1, "side": "outside"}},
                         "material": {"stiffness_N_m": 500, "damping_N_s_m": 1, "static_friction": 0.4,
                                      "dynamic_friction": 0.3}}]}))
        return file

    def image(self, scene):
        file = self.folder / (scene.stem + ".thim")
        self.ok("compile", scene, "--output", file)
        return file

    def wait_for_mode(self, uri, mode, seconds=30):
        end = time.monotonic() + seconds
        while (now := self.ok_json("info", "--device", uri)["state"]["mode"]) != mode:
            self.assertLess(time.monotonic(), end, "still %s, not %s" % (now, mode))
            time.sleep(0.05)

    def running(self, uri):
        """Name, bytes and CRC of the scene that the device runs."""
        info = self.ok_json("info", "--device", uri)
        return info["scene"], info["state"]["scene_bytes"], info["state"]["scene_crc"]


def figure(text):
    print("    figure: " + text, flush=True)

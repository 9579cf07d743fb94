"""The drives' codecs against decoders that share nothing with them: Debian's canmatrix with a DBC of ODrive's messages, and Python's struct and
integers for the others. The ends of every field and 10 000 random values in both directions; each within half a step of the wire's format.

    python3 codec_sweep.py build/release/bin/drive_frames
"""

import json
import math
import os
import pathlib
import random
import struct
import subprocess
import sys
import unittest

with open(os.devnull, "w") as nowhere:  # it names the formats that it lacks
    out, err = os.dup(1), os.dup(2)
    os.dup2(nowhere.fileno(), 1), os.dup2(nowhere.fileno(), 2)
    import canmatrix.formats
    os.dup2(out, 1), os.dup2(err, 2)

FILTER = sys.argv.pop(1)
HERE = pathlib.Path(__file__).parent
COUNT = 10_000
TURN = 2 * math.pi
EPSILON = 2 ** -22  # of a float, with one rounding of the conversion to radians
FLOATS = [0.0, -0.0, 1.0, -1.0, 1e-30, -1e-30, 1e6, -1e6, 0.25, 3.4e38 / 7, -3.4e38 / 7]
OTHER, MALFORMED, MOTION, TELEMETRY = range(4)


def through(lines):
    text = "\n".join(map(json.dumps, lines)) + "\n"
    out = subprocess.run([FILTER], input=text, capture_output=True, text=True, check=True).stdout
    answers = [json.loads(line) for line in out.splitlines()]
    assert len(answers) == len(lines)
    return zip(lines, answers)


def f32(value):
    return struct.unpack("<f", struct.pack("<f", value))[0]


def values(count, lo, hi, ends=()):
    return [*ends, *(f32(random.uniform(lo, hi)) for _ in range(count))]


class Sweep(unittest.TestCase):
    def setUp(self):
        random.seed(7)

    def same(self, found, meant, step=0.0):
        self.assertLessEqual(abs(found - meant), 0.5 * step * (1 + 1e-3) + EPSILON * abs(meant) + 1e-37, (found, meant))


class Moteus(Sweep):
    SIZES = {0: (1, "b"), 1: (2, "h"), 2: (4, "i"), 3: (4, "f")}
    UNITS = {"torque": {3: 1}, "scale": {1: 1 / 32767}, "time": {1: 0.001}}

    def decode(self, data):
        """{register: (type, raw value)} of what is written, [(type, first register, count)] of what is read."""
        written, read, at = {}, [], 0
        while at < len(data):
            byte = data[at]
            at += 1
            if byte == 0x50:
                continue
            self.assertLess(byte, 0x20)
            kind, count = byte >> 2 & 3, byte & 3
            if count == 0:
                count, at = data[at], at + 1
            first, at = data[at], at + 1
            if byte >= 0x10:
                read.append((kind, first, count))
                continue
            size, code = self.SIZES[kind]
            for i in range(count):
                written[first + i] = (kind, struct.unpack_from("<" + code, data, at)[0])
                at += size
        return written, read

    def test_commands(self):
        torques = values(COUNT, -100, 100, FLOATS)
        lines = [{"pack": "moteus", "id": random.randint(1, 127), "torque": t,
                  "kd_scale": random.choice([0, 1, -1, 2, random.random(), random.random()]),
                  "timeout_ms": random.choice([0, 1, 32767, 65535, random.randint(1, 1000)]), "query": random.randint(0, 3)} for t in torques]
        for line, frame in through(lines):
            self.assertEqual(frame["id"], 0x8000 | line["id"])
            self.assertTrue(frame["fd"] and frame["extended"])
            data = bytes.fromhex(frame["data"])
            self.assertIn(len(data), (0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 16, 20, 24, 32, 48, 64))
            written, read = self.decode(data)
            self.assertEqual(written[0], (0, 10))
            self.assertEqual(written[0x20], (0, -128))  # NaN
            self.assertEqual(written[0x21], (0, 0))
            self.assertEqual(written[0x23], (1, 0))
            self.assertEqual(written[0x22][0], 3)
            self.assertEqual(written[0x22][1], f32(line["torque"]))
            self.same(written[0x24][1] / 32767, min(max(line["kd_scale"], 0), 1), 1 / 32767)
            if line["timeout_ms"]:
                self.assertEqual(written[0x27], (1, min(line["timeout_ms"], 32767)))
            else:
                self.assertNotIn(0x27, written)
            wanted = [[], [(3, 1, 2)], [(3, 1, 4), (0, 0, 1), (0, 13, 3)], [(3, 1, 4), (0, 0, 1), (0, 13, 3), (1, 0x70, 1)]]
            self.assertEqual(read, wanted[line["query"]])

    REGISTERS = {1: ("position_rad", TURN, (.01, .0001, .00001)), 2: ("velocity_rad_s", TURN, (.1, .00025, .00001)),
                 3: ("torque_N_m", 1, (.5, .01, .001)), 4: ("current_A", 1, (1, .1, .001)), 13: ("supply_V", 1, (.5, .1, .001)),
                 14: ("drive_C", 1, (1, .1, .001)), 10: ("motor_C", 1, (1, .1, .001))}

    def test_replies(self):
        lines, meanings = [], []
        for i in range(COUNT):
            drive, data, meant = random.randint(1, 127), b"", {}
            for first, count in random.sample([(1, 4), (10, 1), (13, 2)], random.randint(1, 3)):
                kind = random.randint(0, 3)
                size, code = self.SIZES[kind]
                raws = []
                for register in range(first, first + count):
                    name, factor, units = self.REGISTERS[register]
                    if kind == 3:
                        raw = random.choice([*FLOATS, *values(20, -50, 50)])
                        meant[name] = f32(raw) * factor
                    else:
                        top = 2 ** (8 * size - 1)
                        raw = random.choice([-top, -top + 1, top - 1, 0, 1, -1, *(random.randint(-top, top - 1) for _ in range(6))])
                        meant[name] = None if raw == -top else raw * units[kind] * factor
                    raws.append(raw)
                head = [0x20 | kind << 2 | (count if count < 4 else 0), *([count] if count > 3 else []), first]
                data += bytes(head) + b"".join(struct.pack("<" + code, raw) for raw in raws)
            size = next(n for n in (0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 16, 20, 24, 32, 48, 64) if n >= len(data))
            data = data.ljust(size, b"\x50")
            lines.append({"unpack": "moteus", "id": drive, "frame_id": drive << 8, "fd": True, "data": data.hex()})
            meanings.append(meant)
        for (_, sample), meant in zip(through(lines), meanings):
            self.assertEqual(sample["reply"], MOTION if "position_rad" in meant else TELEMETRY)
            for name, value in meant.items():
                if value is None:
                    self.assertIsNone(sample[name])
                else:
                    self.same(sample[name], value)


class Odrive(Sweep):
    def setUp(self):
        super().setUp()
        self.matrix = canmatrix.formats.loadp_flat(str(HERE / "odrive.dbc"))

    def test_commands(self):
        lines, wanted = [], []

        def add(message, signals, **line):
            lines.append({"id": 3, **line})
            wanted.append((message, signals))
        for a in values(COUNT, -100, 100, FLOATS):
            b = abs(f32(random.uniform(0, 100)))
            which = random.randint(0, 3)
            if which == 0:
                add("InputTorque", {"torque": a}, pack="torque", torque=a)
            elif which == 1:
                add("InputVelocity", {"velocity": 0, "torque": a}, pack="damped_torque", torque=a)
            elif which == 2:
                a = f32(a / 10)
                add("VelocityGains", {"gain": a * TURN, "integrator": 0}, pack="damping", damping=a)
            else:
                add("Limits", {"velocity": a / TURN, "current": b}, pack="limits", velocity=a, current=b)
        for state in (1, 8):
            add("SetAxisState", {"requested_state": state}, pack="state", state=state)
        for mode in (1, 2):
            add("ControllerModes", {"control_mode": mode, "input_mode": 1}, pack="modes", mode=mode)
        for (_, frame), (name, signals) in zip(through(lines), wanted):
            message = self.matrix.frame_by_id(canmatrix.ArbitrationId(frame["id"], extended=False))
            self.assertEqual(message.name, name)
            self.assertFalse(frame["fd"] or frame["extended"] or frame["remote"])
            decoded = message.decode(bytes.fromhex(frame["data"]).ljust(8, b"\0"))
            for signal, value in signals.items():
                self.same(float(decoded[signal].phys_value), value)

    CYCLIC = {"Estimates": {"position": ("position_rad", TURN), "velocity": ("velocity_rad_s", TURN)}, "Iq": {"measured": ("current_A", 1)},
              "Supply": {"voltage": ("supply_V", 1)}, "Temperature06": {"fet": ("drive_C", 1), "motor": ("motor_C", 1)},
              "Torques06": {"estimate": ("torque_N_m", 1)}}

    def test_messages(self):
        lines, wanted = [], []
        for _ in range(COUNT):
            name = random.choice(list(self.CYCLIC))
            message = self.matrix.frame_by_name(name)
            raw = {signal.name: f32(random.choice([*FLOATS, *values(20, -100, 100)])) for signal in message.signals}
            new = name.endswith("06") or random.random() < .5
            lines.append({"unpack": "odrive", "id": 3, "frame_id": message.arbitration_id.id, "fd": False, "firmware06": new, "kt": .25,
                          "data": bytes(message.encode(raw)).hex()})
            wanted.append((name, new, raw))
        for (_, sample), (name, new, raw) in zip(through(lines), wanted):
            self.assertEqual(sample["reply"], MOTION if name == "Estimates" else TELEMETRY)
            for signal, (field, factor) in self.CYCLIC[name].items():
                self.same(sample[field], raw[signal] * factor)
            if name == "Iq" and not new:
                self.same(sample["torque_N_m"], raw["measured"] * .25)

    def test_heartbeats(self):
        message = self.matrix.frame_by_name("Heartbeat")
        lines, wanted = [], []
        for _ in range(2000):
            raw = {"axis_error": random.choice([0, 0, 0x800, 0x40, 0x4000]), "axis_state": random.choice([0, 1, 3, 8]),
                   "motor_error": random.randint(0, 1), "encoder_error": 0, "controller_error": random.randint(0, 1),
                   "trajectory_done": random.randint(0, 1)}
            lines.append({"unpack": "odrive", "id": 3, "frame_id": message.arbitration_id.id, "fd": False, "firmware06": False, "kt": 1,
                          "data": bytes(message.encode(raw)).hex()})
            wanted.append(raw)
        unknown, off, starting, on, timed_out, faulted = range(6)
        for (_, sample), raw in zip(through(lines), wanted):
            parts = raw["motor_error"] or raw["controller_error"]
            self.assertEqual(sample["fault"], raw["axis_error"] or (2 ** 31 if parts else 0))
            stage = {0: unknown, 1: off, 3: starting, 8: on}[raw["axis_state"]]
            if raw["axis_error"] or parts:
                stage = timed_out if raw["axis_error"] == 0x800 else faulted
            self.assertEqual(sample["stage"], stage)


class Mit(Sweep):
    RANGES = [(12.5, 65, 40), (12.5, 50, 5), (12.5, 30, 10), (12.5, 8, 28), (12.5, 280, 1), (12.5, 25, 200), (12.5, 76, 12)]

    @staticmethod
    def bits(data):
        """p, v, kp, kd, t from 8 bytes, as one big-endian integer."""
        number = int.from_bytes(data, "big")
        return number >> 48, number >> 36 & 0xFFF, number >> 24 & 0xFFF, number >> 12 & 0xFFF, number & 0xFFF

    def test_commands(self):
        lines = []
        for _ in range(COUNT):
            ranges = random.choice(self.RANGES)
            p, v, t = (f32(random.choice([-hi, hi, 0, 2 * hi, -2 * hi, *(random.uniform(-hi, hi) for _ in range(8))])) for hi in ranges)
            kp, kd = (f32(random.choice([0, hi, random.uniform(0, hi), random.uniform(0, hi)])) for hi in (500, 5))
            lines.append({"pack": "mit", "id": random.randint(1, 127), "fd": random.random() < .5, "ranges": ranges,
                          "p": p, "v": v, "kp": kp, "kd": kd, "t": t})
        for line, frame in through(lines):
            self.assertEqual((frame["id"], frame["fd"], frame["extended"]), (line["id"], line["fd"], False))
            codes = self.bits(bytes.fromhex(frame["data"]))
            p_max, v_max, t_max = line["ranges"]
            for name, code, lo, hi, n in zip(("p", "v", "kp", "kd", "t"), codes, (-p_max, -v_max, 0, 0, -t_max), (p_max, v_max, 500, 5, t_max),
                                             (16, 12, 12, 12, 12)):
                step = (hi - lo) / (2 ** n - 1)
                meant = min(max(line[name], lo), hi)
                if name == "kp":
                    meant = min(meant, hi - step)
                self.assertLessEqual(abs(lo + code * step - meant), .5 * step * 1.01 + 4 * EPSILON * hi, (name, line))

    def test_replies(self):
        lines, wanted = [], []
        for _ in range(COUNT):
            ranges, drive, kind = random.choice(self.RANGES), random.randint(1, 15), random.choice([3, 4, 5, 6])
            raw = [random.choice([0, 2 ** n - 1, *(random.randrange(2 ** n) for _ in range(8))]) for n in (16, 12, 12)]
            body = (raw[0] << 24 | raw[1] << 12 | raw[2]).to_bytes(5, "big")
            byte6, byte7 = random.randrange(256), random.randrange(256)
            error = random.randrange(16)
            data = {3: bytes([drive]) + body + bytes([byte6]), 4: bytes([drive]) + body + bytes([byte6, byte7])}.get(
                kind, bytes([error << 4 | drive]) + body + bytes([byte6, byte7]))
            lines.append({"unpack": "mit", "kind": kind, "id": drive, "frame_id": drive + 16, "fd": kind == 6, "ranges": ranges, "data": data.hex()})
            wanted.append((raw, kind, byte6, byte7, error))
        for (line, sample), (raw, kind, byte6, byte7, error) in zip(through(lines), wanted):
            self.assertEqual(sample["reply"], MOTION)
            for name, code, hi, n in zip(("position_rad", "velocity_rad_s", "torque_N_m"), raw, line["ranges"], (16, 12, 12)):
                self.same(sample[name], -hi + code * 2 * hi / (2 ** n - 1), 0.02 * 2 * hi / (2 ** n - 1))
            if kind == 3:
                self.same(sample["supply_V"], byte6 * 40 / 255)
            elif kind == 4:
                self.assertEqual((sample["motor_C"], sample["fault"]), (byte6 - 40, byte7))
            else:
                self.assertEqual((sample["drive_C"], sample["motor_C"], sample["fault"]), (byte6, byte7, error if error > 1 else 0))


if __name__ == "__main__":
    unittest.main()

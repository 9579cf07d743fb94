#!/usr/bin/env python3
"""The image of board/mps2-an500 in QEMU, as its user meets it: `thimble` over SLCAN on a pty, the simulated arm behind the register block.

Time is counted in instructions (-icount), so a busy machine slows the board down and loses no tick.
"""
import json
import os
import pathlib
import re
import signal
import socket
import subprocess
import sys
import tempfile
import time
import unittest

BIN = pathlib.Path(os.environ["THIMBLE_BIN"])
PEER = os.environ["THIMBLE_PEER"]
ROOT = pathlib.Path(__file__).resolve().parent.parent.parent.parent
IMAGES = {4000: "thimble-mps2-an500", 20000: "thimble-mps2-an500-20kHz"}  # by ticks a second
MEMORY_BYTES = 16 << 20  # the PSRAM: the slots' copies at its beginning, the register block in its last page
CHIPS = 8


def figure(text):
    print("[ figure ] " + text, flush=True)


class Board:
    """QEMU with the image of a rate, the EEPROMs of `folder`, and the arm beside it. An instruction takes 2^shift ns."""

    def __init__(self, folder, chips=CHIPS, rate_Hz=4000, shift=2):
        self.folder = folder
        self.elf = ROOT / f"build/mps2-an500/bin/{IMAGES[rate_Hz]}.elf"
        memory = folder / "memory"
        with open(memory, "wb") as file:
            file.truncate(MEMORY_BYTES)
        self.peer = subprocess.Popen([PEER, memory, str(rate_Hz)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        assert self.peer.stdout.readline().strip() == "arm"
        eeproms = []
        for i in range(chips):
            file = folder / f"eeprom{i}"
            if not file.exists():
                file.write_bytes(b"\xff" * 65536)
            eeproms += ["-drive", f"if=none,id=chip{i},file={file},format=raw",
                        "-device", f"at24c-eeprom,bus=i2c,address={0x50 + i},rom-size=65536,drive=chip{i}"]
        self.gdb = folder / "gdb"
        self.qemu = subprocess.Popen(
            ["qemu-system-arm", "-M", "mps2-an500,memory-backend=psram", "-object",
             f"memory-backend-file,id=psram,mem-path={memory},size={MEMORY_BYTES},share=on", "-kernel", self.elf, *eeproms,
             "-icount", f"shift={shift},sleep=off", "-display", "none", "-monitor", "none", "-nodefaults", "-chardev", "pty,id=uart",
             "-serial", "chardev:uart", "-chardev", f"socket,id=gdb,path={self.gdb},server=on,wait=off", "-gdb", "chardev:gdb"],
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        for line in self.qemu.stdout:
            found = re.search(r"(/dev/pts/\d+)", line)
            if found:
                self.uri = "slcan:" + found[1]
                break
        else:
            raise AssertionError("QEMU did not start: " + str(self.qemu.wait()))

    def stop(self):
        self.qemu.send_signal(signal.SIGTERM)
        self.qemu.communicate(timeout=20)
        self.peer.communicate(timeout=20)

    def tell(self, line):
        self.peer.stdin.write(line + "\n")
        self.peer.stdin.flush()
        return self.peer.stdout.readline().strip()

    def hand(self, x_m, y_m, z_m):
        self.tell(f"hand {x_m} {y_m} {z_m}")

    def enabled(self):
        return self.tell("state").split()[-1] == "1"

    def thimble(self, *words):
        return subprocess.run([BIN / "thimble", *map(str, words), "--device", self.uri, "--timeout", "20"], capture_output=True, text=True, timeout=120)

    def json(self, *words):
        result = self.thimble(*words, "--json")
        assert result.returncode == 0, result.stderr
        return json.loads(result.stdout)

    def force_z(self, count=40):
        """The force of the last of some telemetry frames, N."""
        lines = self.thimble("monitor", "--count", count, "--json").stdout.splitlines()
        return [frame["z_N"] for frame in map(json.loads, lines) if frame["message"] == "Force"][-1]

    def address(self, symbol):
        symbols = subprocess.run(["arm-none-eabi-nm", "-C", self.elf], capture_output=True, text=True, check=True).stdout
        return int(re.search(r"^([0-9a-f]+) \w " + re.escape(symbol) + r"(?:\(.*)?$", symbols, re.M)[1], 16)

    def gdb_session(self, *commands):
        """Sends commands to QEMU's GDB port, which stops the board, and returns the answers; the last command has it go on."""
        answers = []
        with socket.socket(socket.AF_UNIX) as gdb:
            gdb.connect(str(self.gdb))
            gdb.settimeout(60)
            for command in commands:
                gdb.sendall(b"$%s#%02x" % (command.encode(), sum(command.encode()) % 256))
                answer = b""
                # QEMU may tell of the stop at the connection, T02, before the first answer.
                while not (packet := re.search(rb"\$(?!T02)([^#]*)#..", answer)):
                    answer += gdb.recv(4096)
                gdb.sendall(b"+")
                answers.append(packet[1].decode())
        return answers

    def patch(self, symbol, code):
        """Writes instructions over a function, through QEMU's GDB port: what a bug or a cosmic ray would do."""
        self.assert_ok(self.gdb_session(f"M{self.address(symbol):x},{len(code):x}:{code.hex()}", "D"))

    @staticmethod
    def assert_ok(answers):
        assert all(answer == "OK" for answer in answers), answers


FLOOR = {"thimble_scene": 1, "name": "floor", "objects": [
    {"name": "floor", "shape": {"plane": {"normal": [0, 0, 1], "offset_m": 0}},
     "material": {"stiffness_N_m": 500, "damping_N_s_m": 2, "static_friction": 0, "dynamic_friction": 0}}]}
HANG = bytes.fromhex("fee7")  # b .
UNDEFINED = bytes.fromhex("00de")  # udf #0


class Mps2(unittest.TestCase):
    OPTIONS = {}  # of each Board

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.board = None

    def start(self, **options):
        board = Board(self.folder, **{**self.OPTIONS, **options})
        self.addCleanup(lambda: board.qemu.poll() is None and board.stop())
        return board

    def armed(self, scene="walls"):
        board = self.start()
        board.json("upload", ROOT / f"scenes/{scene}/{scene}.scene.json")
        board.json("home")
        board.hand(0, 0, 0.03)
        board.json("param", "set", "link_timeout", 10)  # on a busy machine a second can pass between two requests of `arm`
        board.json("arm")
        return board

    def wait_for_restart(self, board, reason):
        end = time.monotonic() + 60
        while time.monotonic() < end:
            result = board.thimble("info", "--json")
            if result.returncode == 0 and json.loads(result.stdout)["reset_reason"] == reason:
                return json.loads(result.stdout)
        self.fail(f"it did not start again because of {reason}: {result.stdout}{result.stderr}")

    def test_full_life(self):
        board = self.start()
        info = board.json("info")
        self.assertEqual((info["board"], info["reset_reason"], info["arm"]), ("mps2-an500", "power_on", "premium-1.5"))
        scene = self.folder / "floor.scene.json"
        scene.write_text(json.dumps(FLOOR))
        board.json("upload", scene)
        self.assertIn("not_homed", board.thimble("arm").stderr)
        board.json("home")
        board.hand(0, 0, 0.03)
        board.json("arm")
        self.assertTrue(board.enabled())
        self.assertAlmostEqual(board.force_z(), 0, delta=0.05)
        board.hand(0, 0, -0.006)
        board.force_z(300)  # until it rests
        frames = [json.loads(line) for line in board.thimble("monitor", "--count", 120, "--json").stdout.splitlines()]
        depths_m = [-frame["z_m"] for frame in frames if frame["message"] == "Pose"]
        forces_N = [frame["z_N"] for frame in frames if frame["message"] == "Force"]
        # A hand that holds still is probed now and then: the force is less meanwhile.
        depth_m, force_N = max(zip(depths_m, forces_N), key=lambda pair: pair[1] / pair[0])
        figure(f"{depth_m * 1e3:.2f} mm deep in a floor of 500 N/m: {force_N:.3f} N")
        self.assertGreater(depth_m, 1e-3)
        self.assertAlmostEqual(force_N, 500 * depth_m, delta=0.01 + 0.02 * force_N)
        board.tell("line e_stop 1")
        end = time.monotonic() + 30
        while board.enabled() and time.monotonic() < end:
            pass
        self.assertFalse(board.enabled())
        self.assertEqual(board.json("fault", "list")["faults"][0]["name"], "e_stop")
        board.tell("line e_stop 0")
        board.json("fault", "clear")
        board.json("arm")
        self.assertEqual(board.json("disarm")["mode"], "ready")
        info = board.json("info")
        self.assertEqual(info["state"]["overruns"], 0)
        figure("ticks by lateness: " + ", ".join(f"{k} {v}" for k, v in info["lateness"].items() if v))

    def test_scene_and_parameters_are_kept(self):
        board = self.start()
        board.json("upload", ROOT / "scenes/textures/textures.scene.json")
        board.json("param", "set", "max_force", 2.5)
        board.json("param", "save")
        crc = board.json("info")["state"]["scene_crc"]
        board.stop()
        board = self.start()
        self.assertEqual(board.json("info")["state"]["scene_crc"], crc)
        self.assertEqual(board.json("param", "get", "max_force")["value"], 2.5)
        entries = board.json("audit")["entries"]
        self.assertEqual([entry["event"] for entry in entries[:6]], ["start", "time_told", "scene", "parameter", "parameters_saved", "start"])
        self.assertIn("@", entries[3]["text"])

    def test_an_upload_that_breaks_off_goes_on(self):
        board = self.start()
        image = self.folder / "image.thim"
        subprocess.run([BIN / "thimble", "compile", ROOT / "scenes/textures/textures.scene.json", "--output", image], check=True,
                       stdout=subprocess.DEVNULL)
        upload = subprocess.Popen([BIN / "thimble", "upload", image, "--device", board.uri], stdout=subprocess.DEVNULL,
                                  stderr=subprocess.PIPE, text=True)
        for line in upload.stderr:
            if line.startswith(("30", "40")):
                break
        upload.kill()
        upload.communicate()
        self.assertEqual(board.json("info")["scene"], "")
        self.assertGreater(board.json("upload", image)["resumed_from"], 4000)
        self.assertEqual(board.json("info")["scene"], "textures")

    def test_a_scene_that_the_eeproms_cannot_hold_is_refused(self):
        board = self.start(chips=1)
        board.json("upload", ROOT / "scenes/smooth/faceted.scene.json")
        refused = board.thimble("upload", ROOT / "scenes/ring/ring.scene.json")
        self.assertNotEqual(refused.returncode, 0)
        self.assertIn("too_large", refused.stderr)
        self.assertEqual(board.json("info")["scene"], "smooth, faceted")

    def test_without_eeprom_it_is_not_armed(self):
        board = self.start(chips=0)
        board.json("home")
        refused = board.thimble("arm")
        self.assertIn("board_lacks(no_eeprom)", refused.stderr)

    def test_the_host_starts_it_again(self):
        board = self.armed()
        board.json("restart")
        info = self.wait_for_restart(board, "host")
        self.assertEqual(info["state"]["mode"], "disarmed")
        self.assertFalse(board.enabled())
        self.assertEqual(info["scene"], "walls")

    def test_a_hanging_background_starts_it_again(self):
        board = self.armed()
        board.patch("thimble::firmware::Controller::poll", HANG)
        self.wait_for_restart(board, "watchdog")
        self.assertFalse(board.enabled())

    def test_a_hanging_tick_loses_its_motors_in_2_ms(self):
        """From the begin of the tick that hangs to the stop path's interrupt, by the board's own timer (25 MHz)."""
        board = self.armed()
        self.assertTrue(board.enabled())
        tick, stop = board.address("thimble::firmware::Core::tick"), board.address("on_watchdog")
        last, timer = board.address("thimble::board::clock::(anonymous namespace)::at_last"), 0x40002004
        answers = board.gdb_session(f"M{tick:x},2:{HANG.hex()}", f"Z0,{stop & ~1:x},2", "c", f"m{timer:x},4", f"m{last:x},4",
                                    f"z0,{stop & ~1:x},2", "D")
        self.assertTrue(answers[2].startswith("T05"), answers)
        now, begin = (int.from_bytes(bytes.fromhex(word), "little") for word in answers[3:5])
        elapsed_us = (~now - begin) % 2**32 / 25
        figure(f"the interrupt came {elapsed_us:.0f} us after the begin of the tick")
        self.assertGreater(elapsed_us, 1500)  # fed at the end of the tick before
        self.assertLess(elapsed_us, 2100)
        end = time.monotonic() + 30
        while board.enabled() and time.monotonic() < end:
            pass
        self.assertFalse(board.enabled())
        self.wait_for_restart(board, "watchdog")

    def test_lost_ticks_above_5_ms_are_refused(self):
        board = self.start()
        self.assertIn("lost_ticks_above_5_ms", board.thimble("param", "set", "lost_ticks", 20).stderr)

    def test_it_has_no_faults_to_inject(self):
        board = self.start()
        program = "import sys, thimble\nwith thimble.connect(sys.argv[1], timeout_s=10) as device: device.inject('encoder-dead')"
        ended = subprocess.run(["/usr/bin/python3", "-c", program, board.uri], capture_output=True, text=True, timeout=120,
                               env={**os.environ, "PYTHONPATH": str(BIN.parents[1] / "python/python")})
        self.assertIn("not-simulated: breaking the simulated hardware was refused: board mps2-an500 has real hardware", ended.stderr)

    def test_a_hanging_tick_starts_it_again(self):
        board = self.armed()
        board.patch("thimble::firmware::Core::tick", HANG)
        self.wait_for_restart(board, "watchdog")
        self.assertFalse(board.enabled())

    def test_a_crash_turns_the_motors_off_and_starts_it_again(self):
        board = self.armed()
        board.patch("thimble::firmware::Controller::poll", UNDEFINED)
        self.wait_for_restart(board, "crash")
        self.assertFalse(board.enabled())


class Mps2At20kHz(Mps2):
    """500 million instructions a second: a core with 500 MHz and one instruction a cycle."""
    OPTIONS = {"rate_Hz": 20000, "shift": 1}

    def start(self, **options):
        board = super().start(**options)
        board.json("param", "set", "telemetry_decimation", 200)  # 100 records a second, as at 4 kHz
        return board

    def test_scenes(self):
        board = self.armed("asteroid")
        for scene, press in (("asteroid", (0, 0, -0.036)), ("blocks", (0, 0.03, -0.024))):
            if scene == "blocks":
                board.json("disarm")
                board.json("upload", ROOT / "scenes/blocks/blocks.scene.json")
                board.hand(0, 0, 0)
                board.json("arm")
            before = board.json("info")["state"]
            board.hand(*press)
            board.force_z(200)  # until it rests
            self.assertGreater(board.force_z(), 1)
            state = board.json("info")["state"]
            overruns, ticks = (state[name] - before[name] for name in ("overruns", "tick"))
            figure(f"{scene}: {overruns} of {ticks} ticks took longer than a period, the longest {state['worst_tick_s'] * 1e6:.0f} us")
            self.assertEqual((state["mode"], round(state["tick_rate_Hz"])), ("armed", 20000))
            self.assertLess(overruns, 0.02 * ticks)

    def fields(self, count):
        field = {"shape": {"vector_field": {"box": {"size_m": [0.3, 0.3, 0.3]}}}, "material": {"stiffness_N_m": 0.1, "damping_N_s_m": 0.01}}
        objects = [{"name": str(i), "pose": {"position_m": [0, 0, 0], "rotation_deg": [i, 2 * i, 0]}, **field} for i in range(count)]
        file = pathlib.Path(self.folder) / "fields.scene.json"
        file.write_text(json.dumps({"thimble_scene": 1, "name": "fields", "objects": objects}))
        return file

    def test_a_scene_that_is_too_much_is_a_fault(self):
        """At half the instructions a second no tick in sixteen fields ends in time: fields are never put off."""
        board = self.start(shift=2)
        board.json("upload", self.fields(16))
        board.json("home")
        board.hand(0, 0, 0.03)
        board.json("param", "set", "link_timeout", 10)
        board.thimble("arm")
        end = time.monotonic() + 30
        while board.json("info")["state"]["mode"] != "faulted" and time.monotonic() < end:
            pass
        self.assertFalse(board.enabled())
        self.assertEqual(board.json("fault", "list")["faults"][0]["name"], "tick_lost")
        self.assertEqual(board.json("info")["reset_reason"], "power_on")
        overruns = board.json("info")["state"]["overruns"]
        figure(f"{overruns} ticks took longer than a period until the fault")
        self.assertLess(overruns, 4000)  # 0.2 s: the stop path would act after 1 s
        board.json("fault", "clear")
        board.json("upload", ROOT / "scenes/walls/walls.scene.json")
        board.json("arm")
        self.assertTrue(board.enabled())


if __name__ == "__main__":
    unittest.main(argv=sys.argv)

"""Exit codes 0 to 10 (11: hosts_test, 12: access_test), one by one, each with its error in text and JSON; and general behaviour of the command."""

import json
import os
import re
import shlex
import shutil
import socket
import struct
import subprocess
import tempfile
import threading
import time
import unittest
from pathlib import Path

from rig import BIN, Rig

CLI = Path(__file__).resolve().parents[2] / "host-tools" / "cli"


class FakeDevice:
    """Speaks SLCAN and answers the first question with a version of its own, or never."""

    def __init__(self, protocol=None):
        self.listener = socket.create_server(("127.0.0.1", 0))
        self.uri = "tcp:127.0.0.1:%d" % self.listener.getsockname()[1]
        self.protocol = protocol
        self.ends = []
        threading.Thread(target=self.serve, daemon=True).start()

    def serve(self):
        while True:
            try:
                end, _ = self.listener.accept()
            except OSError:
                return
            self.ends.append(end)
            threading.Thread(target=self.talk, args=(end,), daemon=True).start()

    def talk(self, end):
        buffer = b""
        while data := end.recv(4096):
            buffer += data
            *lines, buffer = buffer.split(b"\r")
            for line in lines:
                if self.protocol is None:
                    continue
                if line.startswith(b"T18DA01F1") and line[10:18] == b"0322F1A0":
                    record = b"62F1A0%02X%02X01004001" % (self.protocol & 255, self.protocol >> 8)
                    end.sendall(b"T18DAF1018100A" + record[:12] + b"\r")
                    self.rest = record[12:] + b"01"
                elif line.startswith(b"T18DA01F1") and line[10:12] == b"30":
                    end.sendall(b"T18DAF10182" b"1" + self.rest + b"CC" * (7 - len(self.rest) // 2) + b"\r")

    def close(self):
        self.listener.close()
        for end in self.ends:
            end.close()


def cr_lines(link):
    rest = b""
    while data := link.recv(4096):
        *lines, rest = (rest + data).split(b"\r")
        yield from lines


class ExitCodes(Rig):
    def test_0_ok(self):
        self.ok("list")
        self.ok("--help")
        self.ok("simulate", "--help")
        self.assertRegex(self.ok("--version").out, r"^thimble \d+\.\d+\.\d+$")

    def test_1_refused(self):
        sim = self.sim("--tcp", 0)
        error = self.fails(1, "refused", "arm", "--device", sim.tcp)
        self.assertIn("not_homed,no_scene", error["cause"])
        self.assertIn("thimble home", error["remedy"])

    def test_2_usage(self):
        nothing = self.run_thimble()
        self.assertEqual(nothing.code, 2)
        self.assertEqual(nothing.out, "")
        self.assertIn("upload", nothing.err)
        self.fails(2, "usage", "dance")
        self.fails(2, "usage", "compile")
        self.fails(2, "usage", "mesh", "ball.obj", "--output", "fixed.obj", "--max-hole", "nan")
        self.fails(2, "bad-output", "mesh", "ball.obj", "--output", "fixed.stl")
        self.fails(2, "usage", "list", "--no-such-option")
        self.fails(2, "usage", "param")
        self.assertEqual(self.fails(2, "usage", "nix")["cause"], "'nix' is no verb of thimble")
        self.assertEqual(self.fails(2, "usage", "param", "nix")["cause"], "'nix' is no verb of thimble param")
        slip = self.fails(2, "usage", "simulate", "scene.json", "--lgo", "log.csv")  # and not that --path is missing
        self.assertEqual(slip["cause"], "'--lgo' is no option of thimble simulate")
        self.assertIn("did you mean `--log`?", slip["remedy"])
        self.assertEqual(self.fails(2, "usage", "simulate", "scene.json")["cause"], "thimble simulate: --path is required")
        self.fails(2, "usage", "help", "nix")
        self.fails(2, "usage", "help", "list", "nix")
        for number in ("nan", "-1", "inf"):
            self.fails(2, "usage", "info", "--timeout", number)
            error = self.fails(2, "usage", "monitor", "--seconds", number)
            self.assertIn(f"'{number}' is not a number from 0.001 to ", error["cause"])
        for address in ("ftp:there", "tcp:here:99999", "tcp:here:0", "tcp:here:http", "tcp::1", "slcan:"):
            self.fails(2, "bad-uri", "info", "--device", address)
        self.fails(2, "unknown-arm", "view", "--scene", self.plane_scene(), "--arm", "left", "--no-browser")
        self.fails(2, "unknown-parameter", "param", "get", "colour")
        self.fails(2, "bad-value", "param", "set", "max_force", "-1")
        self.fails(2, "bad-value", "param", "set", "max_force", "much")
        self.fails(2, "bad-value", "param", "set", "host_supervision", "0.5")
        self.fails(2, "unknown-fault", "fault", "explain", "200")

    def test_3_not_found(self):
        self.fails(3, "no-device", "info")
        self.fails(3, "no-device", "info", "--device", "arm-9")
        self.fails(3, "no-device", "info", "--device", "slcan:/dev/no-such-port")
        self.fails(3, "no-interface", "info", "--device", "can:no-such-can")
        self.fails(3, "no-interface", "info", "--device", "canfd:lo")
        with socket.create_server(("127.0.0.1", 0)) as closed:
            port = closed.getsockname()[1]
        self.fails(3, "no-device", "info", "--device", "tcp:127.0.0.1:%d" % port)

    def test_4_ambiguous(self):
        self.sim()
        self.sim()
        self.fails(4, "several-devices", "arm")

    def test_5_permission(self):
        # Root may do everything, so the command runs as nobody, from a place that nobody can reach.
        place = Path(tempfile.mkdtemp(prefix="thimble-nobody-", dir="/tmp"))
        self.addCleanup(shutil.rmtree, place, ignore_errors=True)
        place.chmod(0o755)
        shutil.copy(BIN / "thimble", place / "thimble")
        (place / "port").write_text("")
        (place / "port").chmod(0)
        (place / "locked").mkdir(mode=0o555)
        scene = place / "floor.scene.json"
        scene.write_text(self.plane_scene().read_text())
        scene.chmod(0o644)
        become = (lambda: os.setuid(65534)) if os.getuid() == 0 else None

        def run(*arguments):
            return subprocess.run([place / "thimble", *map(str, arguments)], capture_output=True, text=True,
                                  preexec_fn=become, env=self.environment)

        opened = run("info", "--device", "slcan:%s" % (place / "port"))
        self.assertEqual(opened.returncode, 5, opened.stderr)
        self.assertIn("thimble: permission: ", opened.stderr)
        examined = run("doctor", "--device", "slcan:%s" % (place / "port"))
        self.assertEqual(examined.returncode, 5, examined.stderr)
        self.assertIn("failure  permission", examined.stdout)
        written = run("compile", scene, "--output", place / "locked" / "floor.thim", "--json")
        self.assertEqual(written.returncode, 5, written.stderr)
        self.assertEqual(json.loads(written.stderr)["error"]["name"], "permission")

    def test_6_link_lost(self):
        silent = FakeDevice()
        self.addCleanup(silent.close)
        self.fails(6, "no-answer", "info", "--device", silent.uri, "--timeout", "0.5")

    def test_7_version_mismatch(self):
        for protocol, older in ((2, "the device is older"), (4, "this thimble is older")):
            other = FakeDevice(protocol=protocol)
            self.addCleanup(other.close)
            error = self.fails(7, "version-mismatch", "info", "--device", other.uri)
            self.assertIn(f"protocol {protocol}", error["cause"])
            self.assertIn(older, error["remedy"])

    def test_7_a_host_of_protocol_1_learns_the_version(self):
        """It claims no address, and reads LinkInfo in classic frames as it always did; the layout is that of protocol 1."""
        sim = self.sim("--no-pty", "--tcp", 0)
        with socket.create_connection(("127.0.0.1", sim.port)) as link:
            link.settimeout(10)
            answers = (line[10:] for line in cr_lines(link) if line.startswith(b"T18DAF1018"))
            link.sendall(b"\rC\rS8\rO\rT18DA01F180322F1A000000000\r")
            first = next(answers)
            link.sendall(b"T18DA01F183000000000000000\r")
            answer = bytes.fromhex((first[4:16] + next(answers)[2:]).decode())[:10]
        self.assertEqual(answer[:3], bytes.fromhex("62F1A0"))
        protocol, image, frame_bytes, node, arms = struct.unpack("<HHBBB", answer[3:])
        self.assertEqual((protocol, image, frame_bytes, node, arms), (3, 1, 64, 1, 1))

    def test_8_verification(self):
        sim = self.sim("--tcp", 0)
        image = self.image(self.plane_scene())
        data = bytearray(image.read_bytes())
        data[20] ^= 1
        image.write_bytes(data)
        self.fails(8, "wrong-crc", "upload", image, "--device", sim.tcp)

    def test_9_faulted(self):
        sim = self.sim("--tcp", 0)
        with socket.create_connection(("127.0.0.1", sim.port)) as bus:
            bus.sendall(b"S8\rO\rt0010\r")
            bus.settimeout(10)
            heard = b""
            deadline = time.monotonic() + 10
            while b"t081" not in heard and time.monotonic() < deadline:  # the emergency frame
                heard += bus.recv(4096)
            self.assertIn(b"t081", heard)
        error = self.fails(9, "device-faulted", "arm", "--device", sim.tcp)
        self.assertIn("host_stop", error["cause"])
        self.assertIn("fault clear", error["remedy"])

    def test_10_bad_input(self):
        output = self.folder / "never.thim"
        for name, text in {"broken": '{"thimble_scene": 1,', "unknown": '{"thimble_scene": 1, "name": "x", "objets": []}'}.items():
            scene = self.folder / (name + ".scene.json")
            scene.write_text(text)
            result = self.run_thimble("compile", scene, "--output", output)
            self.assertEqual(result.code, 10, result.err)
            self.assertIn(str(scene), result.err)
        self.assertEqual(self.run_thimble("compile", self.folder / "absent.scene.json", "--output", output).code, 10)
        self.assertEqual(self.run_thimble("upload", self.folder / "absent.thim", "--device", "tcp:127.0.0.1:1").code, 10)
        self.assertFalse(output.exists(), "nothing is written when it fails")
        self.assertEqual(list(self.folder.glob("*.part-*")), [])

    def test_a_failed_compile_keeps_the_old_image(self):
        output = self.folder / "kept.thim"
        self.ok("compile", self.plane_scene("kept"), "--output", output)
        before = output.read_bytes()
        scene = self.folder / "kept.scene.json"
        scene.write_text("{")
        self.assertEqual(self.run_thimble("compile", scene, "--output", output).code, 10)
        self.assertEqual(output.read_bytes(), before)


class Import(Rig):
    NEEDLE = Path(__file__).resolve().parents[2] / "scenes" / "needle"
    LINE = ("--from", "4,-3,46", "--to", "-2,3,2")

    def test_the_needle_scene_is_what_its_volume_gives(self):
        output = self.folder / "needle.scene.json"
        report = self.ok_json("import", "volume", self.NEEDLE / "phantom.nii.gz", *self.LINE,
                              "--layers", self.NEEDLE / "tissues.csv", "--output", output)
        self.assertEqual([layer["name"] for layer in report["layers"]],
                         ["skin or capsule", "fat", "muscle", "skin or capsule", "gland"])
        self.assertEqual(output.read_text(), (self.NEEDLE / "needle.scene.json").read_text())
        self.ok("compile", output, "--output", self.folder / "needle.thim")
        made_up = self.ok("import", "volume", self.NEEDLE / "phantom.nii.gz", *self.LINE, "--classes", 5, "--output", output)
        self.assertIn("uint8 voxels, placed by sform; 5 layers", made_up.out)

    def test_what_fails_writes_nothing(self):
        output = self.folder / "never.scene.json"
        volume = self.NEEDLE / "phantom.nii.gz"

        def fails(code, name, *arguments):
            return self.fails(code, name, "import", "volume", *arguments, "--output", output)

        fails(2, "bad-point", volume, "--from", "1,2", "--to", "1,2,3")
        fails(2, "bad-point", volume, "--from", "1,2,3", "--to", "1,2,x")
        fails(2, "usage", volume, "--from", "1,2,3")
        fails(2, "usage", volume, *self.LINE, "--classes", 1)
        fails(10, "missing-volume", self.folder / "absent.nii", *self.LINE)
        fails(10, "not-nifti", self.NEEDLE / "tissues.csv", *self.LINE)
        fails(10, "outside-volume", volume, "--from", "0,0,46", "--to", "0,0,-90")
        fails(10, "bad-layers", volume, *self.LINE, "--layers", self.folder / "absent.csv")
        self.assertFalse(output.exists())


class Manners(Rig):
    def test_explain_needs_no_device(self):
        self.assertEqual(self.ok_json("fault", "explain", "1")["name"], "e_stop")
        self.assertEqual(self.ok_json("fault", "explain", "e_stop")["number"], 1)
        self.assertIn("remedy: ", self.ok("fault", "explain", "9").out)

    def test_help(self):
        for words in ((), ("simulate",), ("param",), ("param", "get"), ("model", "import", "urdf")):
            self.assertEqual(self.ok("help", *words).out, self.ok(*words, "--help").out)
        self.ok("--help", "simulate")

    def test_completion(self):
        def candidates(*words):
            return self.ok("__complete", *words).out.split()

        self.assertEqual(set(candidates("")), {"help", "new", "show", "list", "info", "doctor", "dbc", "decode", "compile", "upload", "arm", "disarm", "stop", "restart", "home", "monitor", "publish", "view", "param",
                                               "fault", "key", "audit", "simulate", "sweep", "mesh", "model", "commission", "import", "scan", "record", "replay", "plot"})
        self.assertEqual(candidates("up"), ["upload"])
        self.assertEqual(candidates("param", "g"), ["get"])
        self.assertEqual(candidates("param", "get", "max_f"), ["max_force"])
        self.assertEqual(candidates("fault", "explain", "e_"), ["e_stop"])
        self.assertIn("--ideal", candidates("simulate", "--"))
        self.assertEqual(candidates("simulate", "--arm", "w"), ["wooden", ":files"])
        self.assertEqual(candidates("compile", "--arm", "w"), ["wooden", ":files"])
        self.assertEqual(candidates("simulate", "scene.json", "--path", ""), [":files"])
        self.assertEqual(candidates("simulate", "--rate", "4000", ""), [":files"])  # the scene
        self.assertEqual(candidates("simulate", "--seed", ""), [])
        self.assertEqual(candidates("plot", "--kind", "sp"), ["spectrum"])
        self.assertEqual(candidates("param", "set", "max_force", ""), [])
        self.assertEqual(candidates("help", "param", "s"), ["save", "set"])
        self.assertIn("falcon", candidates("model", "show", ""))
        self.sim()
        self.assertEqual(candidates("info", "--device", ""), ["arm-1"])

    def test_shells(self):
        """The completions of bash, zsh and fish, in a folder with files."""
        (self.folder / "my scene.json").touch()
        (self.folder / "mine").mkdir()
        environment = {**self.environment, "PATH": f"{BIN}:{os.environ['PATH']}"}
        completions = CLI / "completion"

        def completed(shell, *words):
            quoted = " ".join(shlex.quote(word) for word in words)
            script = {
                "bash": f". {completions}.bash; COMP_WORDS=(thimble {quoted}) COMP_CWORD={len(words)}; _thimble; printf '%s\\n' \"${{COMPREPLY[@]}}\"",
                "zsh": f"compdef() {{ }}; compadd() {{ shift; print -l -- $@ }}; _files() {{ print -l -- ${{words[CURRENT]}}*(N) }}; "
                       f". {completions}.zsh; words=(thimble {quoted}) CURRENT={len(words) + 1}; _thimble",
                "fish": f"source {completions}.fish; complete -C 'thimble {' '.join(words)}'",
            }[shell]
            ran = subprocess.run([shell, "-c", script], cwd=self.folder, env=environment, capture_output=True, text=True, check=True)
            self.assertEqual(ran.stderr, "")
            return {line.split("\t")[0].rstrip("/").replace("\\ ", " ") for line in ran.stdout.splitlines()} - {""}

        for shell in ("bash", "zsh", "fish"):
            self.assertEqual(completed(shell, "doc"), {"doctor"}, shell)
            self.assertEqual(completed(shell, "param", "get", "max_fo"), {"max_force"}, shell)
            self.assertEqual(completed(shell, "compile", "m"), {"my scene.json", "mine"}, shell)
            self.assertEqual(completed(shell, "plot", "x.rec", "--kind", "t"), {"time"}, shell)

    def test_doctor(self):
        report = self.ok_json("doctor")
        self.assertEqual(report["failures"], 0)
        self.assertEqual(report["warnings"], sum(finding["state"] == "warning" for finding in report["findings"]))
        names = {finding["name"] for finding in report["findings"]}
        self.assertLessEqual({"rtprio", "memlock"}, names)
        for finding in report["findings"]:
            self.assertEqual(list(finding), ["name", "subject", "state", "cause", "remedy"])
            self.assertEqual(finding["state"] == "ok", finding["remedy"] == "", finding)
        self.assertIn("rtprio: ", self.ok("doctor", "--board").out)

        port = self.sim().pty
        report = self.ok_json("doctor", "--device", port)
        self.assertEqual(report["findings"][0], {"name": "serial-port", "subject": port.removeprefix("slcan:"), "state": "ok",
                                                 "cause": "may be read and written", "remedy": ""})
        self.ok("doctor", "--device", "arm-1")

        for code, name, device in ((2, "bad-uri", "tcp:127.0.0.1:1"), (2, "bad-uri", "can:"), (3, "no-interface", "can:no-such-can"),
                                   (3, "no-interface", "lo"), (3, "no-device", "arm-9"), (3, "no-device", "slcan:/dev/no-such-port")):
            result = self.run_thimble("doctor", "--device", device, "--json")
            self.assertEqual(result.code, code, result.err)
            error = json.loads(result.err)["error"]
            self.assertEqual((error["name"], error["exit_code"]), (name, code))
            if result.out:  # the report is there all the same
                self.assertEqual(result.json["failures"], 1)
            self.assertIn("remedy: ", self.run_thimble("doctor", "--device", device).err)

    def test_no_output_replaces_its_input(self):
        scene, path, model, log = (self.folder / name for name in ("a.scene.json", "path.csv", "a.obj", "log.csv"))
        scene.write_text((Path(__file__).resolve().parents[2] / "scenes" / "walls" / "walls.scene.json").read_text())
        path.write_text("time_s,x_m,y_m,z_m\n0,0,0,0\n1,0,0,0.01\n")
        model.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
        log.write_text("time_s\n")
        (self.folder / "link.csv").symlink_to(path)
        before = [file.read_bytes() for file in (scene, path, model, log)]
        self.fails(2, "same-file", "compile", scene, "--output", scene)
        self.fails(2, "same-file", "simulate", scene, "--path", path, "--log", scene)
        self.fails(2, "same-file", "simulate", scene, "--path", path, "--log", self.folder / "link.csv")
        self.fails(2, "same-file", "mesh", model, "--output", model)
        self.fails(2, "same-file", "import", "devicelog", log, "--output", log)
        self.fails(2, "same-file", "scan", path, "--log", self.folder / "new.csv", "--output", path)
        self.assertEqual(before, [file.read_bytes() for file in (scene, path, model, log)])

    def test_mesh_repairs_and_says_so(self):
        whole = self.folder / "whole.obj"
        # A cube of 2 mm without one triangle, one face turned, one vertex twice.
        whole.write_text("".join(f"v {x} {y} {z}\n" for z in (0, 2) for y in (0, 2) for x in (0, 2)) + "v 0 0 0\n"
                         + "f 1 3 4\nf 1 4 2\nf 5 6 8\nf 5 7 8\nf 1 2 6\nf 9 6 5\nf 3 7 8\nf 3 8 4\nf 1 5 7\nf 1 7 3\nf 2 4 8\n")
        fixed = self.folder / "fixed.obj"
        left = self.ok_json("mesh", whole, "--scale", "0.001", "--output", fixed)
        self.assertEqual((left["before"]["open_edges"], left["after"]["open_edges"], left["holes_closed"]), (3, 3, 0))
        self.assertIn("1 holes are larger than --max-hole, and stay open", left["warnings"])
        report = self.ok_json("mesh", whole, "--scale", "0.001", "--max-hole", "0.003", "--output", fixed)
        self.assertEqual((report["after"]["open_edges"], report["holes_closed"], report["reversed_triangles"]), (0, 1, 1))
        self.assertEqual((report["input_vertices"], report["vertices"], report["after"]["triangles"]), (11 * 3, 8, 12))
        self.assertEqual(report["crossings"], "nothing to do")
        again = self.folder / "again.obj"
        text = self.ok("mesh", fixed, "--max-hole", "0.003", "--output", again).out
        self.assertIn("open edges          0 -> 0", text)
        self.assertEqual(again.read_bytes(), fixed.read_bytes(), "a repair of a repaired mesh changes nothing")
        self.assertEqual(self.run_thimble("mesh", self.folder / "absent.obj", "--output", again).code, 10)

    def potential_scene(self, side_m):
        file = self.folder / "potential.scene.json"
        file.write_text(json.dumps({
            "thimble_scene": 1, "name": "potential",
            "objects": [{"name": "jelly", "material": {"stiffness_N_m": 300, "damping_N_s_m": 1},
                         "shape": {"potential_field": {"shape": {"box": {"size_m": [side_m] * 3}}, "step_m": 0.001,
                                                       "source_per_m": 50}}}]}))
        return file

    def test_a_solved_potential_is_kept(self):
        scene, image = self.potential_scene(0.02), self.folder / "potential.thim"
        kept = Path(self.environment["XDG_CACHE_HOME"]) / "thimble"
        self.assertEqual(self.ok("compile", scene, "--output", image).err, "")
        first = image.read_bytes()
        entries = list(kept.iterdir())
        self.assertEqual(len(entries), 1)
        written = entries[0].stat().st_ino
        self.ok("compile", scene, "--output", image)
        self.assertEqual(image.read_bytes(), first)
        self.assertEqual(entries[0].stat().st_ino, written, "it was found")
        entries[0].write_bytes(b"")
        self.ok("compile", scene, "--output", image)
        self.assertEqual(image.read_bytes(), first)
        self.assertGreater(entries[0].stat().st_size, 0)
        for nowhere in ["/proc/none", "relative", str(scene)]:
            self.environment["XDG_CACHE_HOME"] = nowhere
            self.environment["HOME"] = nowhere
            self.assertEqual(self.ok("compile", scene, "--output", image).err, "")
            self.assertEqual(image.read_bytes(), first)

    def test_a_long_compile_shows_progress_on_a_terminal_only(self):
        scene = self.potential_scene(0.12)  # more than a second on any machine
        for options, shown in [([], True), (["--json"], False)]:
            shutil.rmtree(self.environment["XDG_CACHE_HOME"], ignore_errors=True)
            text = self.on_terminal("compile", scene, "--output", self.folder / "long.thim", *options)
            if shown:
                self.assertRegex(text, r"compiling jelly: \d+ %.*\r\x1b\[K$")
            else:
                self.assertEqual(text, "")

    def test_long_work_shows_progress_on_a_terminal_only(self):
        """What is shown is removed at the end; another test has `sweep`, another one `compile`."""
        path = self.folder / "long.csv"
        path.write_text("time_s,x_m,y_m,z_m\n0,0,0,0.004\n50,0,0,-0.004\n")
        sim = self.sim("--tcp", 0)
        scene = self.plane_scene()
        self.ok("upload", scene, "--device", sim.tcp)
        self.ball_scene(150)
        for pattern, command in [
                (r"\r\x1b\[K\d+ %  simulating, \d+ s left", ("simulate", scene, "--path", path, "--log", "/dev/null", "--ideal", "--rate", 20000)),
                (r"\r\x1b\[K\d+ %  recorded, \d s left", ("record", self.folder / "long.rec", "--scene", scene, "--device", sim.tcp, "--seconds", 2.5, "--force")),
                (r"\r\x1b\[Krepairing the mesh: \d+ s", ("mesh", self.folder / "ball.obj", "--output", self.folder / "fixed.obj"))]:
            text = self.on_terminal(*command)
            self.assertRegex(text, pattern)
            self.assertGreater(text.rindex("\r\x1b[K"), max(found.start() for found in re.finditer(pattern, text)), "it is removed")
            if command[0] == "simulate":
                self.assertEqual(self.on_terminal(*command, "--json"), "")

    def test_a_result_that_cannot_be_printed_is_an_error(self):
        with open("/dev/full", "w") as full:
            result = subprocess.run([BIN / "thimble", "model", "show", "premium-1.5", "--json"], stdout=full, stderr=subprocess.PIPE,
                                    env=self.environment)
        self.assertEqual(result.returncode, 1)
        self.assertEqual(json.loads(result.stderr)["error"]["name"], "cannot-write")

    def test_compile_reports_the_mesh(self):
        scene = self.ball_scene(10)
        image = self.folder / "ball.thim"
        report = self.ok_json("compile", scene, "--output", image)
        mesh = report["objects"][0]["mesh"]
        self.assertEqual(mesh["triangles"], 360)
        self.assertEqual(mesh["open_edges"], 0)
        self.assertGreater(mesh["depth"], 0)
        self.assertEqual(image.stat().st_size, report["bytes"] + 8)
        self.assertRegex(self.ok("compile", scene, "--output", image).out, r"360 triangles.*0 open edges.*depth")
        self.assertRegex(self.ok("compile", scene, "--output", image, "--report").out, r"fins_cancelled +0\n")
        first = image.read_bytes()
        self.ok("compile", scene, "--output", image)
        self.assertEqual(image.read_bytes(), first, "the same input gives the same bytes")


class Simulate(Rig):
    COLUMNS = "time_s,arm,tip_x_m,tip_y_m,tip_z_m,proxy_x_m,proxy_y_m,proxy_z_m,force_x_N,force_y_N,force_z_N,contacts,sweep_bound,slide_bound,contact_bound,put_off"

    def path(self, text):
        file = self.folder / "hand.csv"
        file.write_text(text)
        return file

    def test_a_path_is_checked_before_and_after(self):
        scene = self.plane_scene(offset_m=-0.02)
        log = self.folder / "log.csv"
        error = self.fails(10, "out-of-reach", "simulate", scene, "--log", log, "--path",
                           self.path("time_s,x_m,y_m,z_m\n0,0,0,0\n0.2,0,0,0.01\n0.4,0,0,2\n0.6,0,0,0\n"))
        self.assertIn("the path's point at 0.4 s, (0, 0, 2) m, is outside the workspace of arm 0", error["cause"])
        self.assertFalse(log.exists())
        for down, touches in (("0.01", False), ("-0.03", True)):
            path = self.path(f"time_s,x_m,y_m,z_m\n0,0,0,0\n0.2,0,0,{down}\n")
            result = self.ok_json("simulate", scene, "--path", path, "--log", log)
            said = self.ok("simulate", scene, "--path", path, "--log", log).err
            self.assertEqual(any("touches nothing" in warning for warning in result["warnings"]), not touches)
            self.assertEqual("warning: the path touches nothing" in said, not touches)

    def test_every_point_of_both_arms_is_checked(self):
        scene = self.plane_scene(offset_m=-0.02)
        log = self.folder / "log.csv"
        head = "time_s,x_m,y_m,z_m,arm\n0,-0.1,0,0,0\n0.2,-0.1,0,0.01,0\n"
        path = self.path(head + "0,0.1,0,0,1\n0.1,0.1,0,2,1\n0.2,0.1,0,0,1\n")
        error = self.fails(10, "out-of-reach", "simulate", scene, "--log", log, "--path", path)
        self.assertIn("the path's point at 0.1 s, (0.1, 0, 2) m, is outside the workspace of arm 1", error["cause"])
        # An ideal run has no arm. It says the same of a path that touches nothing, and says nothing if one arm does.
        for down, touches in (("0.01", False), ("-0.03", True)):
            path = self.path(head + f"0,0.1,0,2,1\n0.2,0.1,0,{down},1\n")
            result = self.ok_json("simulate", scene, "--path", path, "--log", log, "--ideal")
            self.assertEqual(any("touches nothing" in warning for warning in result["warnings"]), not touches)

    def test_ideal_press(self):
        scene = self.plane_scene(stiffness=1000)
        path = self.path("time_s,x_m,y_m,z_m\n0,0,0,0.001\n0.5,0,0,-0.002\n1,0,0,-0.002\n")
        log = self.folder / "log.csv"
        result = self.ok_json("simulate", scene, "--path", path, "--ideal", "--rate", "1000", "--log", log)
        lines = log.read_text().splitlines()
        self.assertEqual(lines[0], self.COLUMNS)
        self.assertEqual(len(lines), 1002)
        self.assertEqual(result["ticks"], 1001)
        last = [float(cell) for cell in lines[-1].split(",")]
        self.assertAlmostEqual(last[0], 1.0)
        self.assertAlmostEqual(last[4], -0.002, places=8)
        self.assertAlmostEqual(last[10], 2.0, places=4)
        self.assertEqual(last[11], 1)

    def test_the_same_run_gives_the_same_bytes(self):
        scene = self.plane_scene(stiffness=500, offset_m=-0.005)
        path = self.path("time_s,x_m,y_m,z_m\n0,0,0,0\n0.2,0,0,-0.008\n0.4,0.01,0,-0.008\n")
        logs = []
        for name in ("one.csv", "two.csv"):
            self.ok("simulate", scene, "--path", path, "--log", self.folder / name)
            logs.append((self.folder / name).read_bytes())
        self.assertEqual(logs[0], logs[1])
        self.assertEqual(logs[0].split(b"\n")[0].decode(), self.COLUMNS)

    def test_bad_paths_are_named_by_line(self):
        scene = self.plane_scene()
        log = self.folder / "bad.csv"
        cases = {
            "": "the file is empty",
            "time_s,x_m,y_m\n": "column 'z_m' is missing",
            "time_s,x_m,y_m,z_m,speed\n": "unknown column 'speed'",
            "time_s,x_m,y_m,z_m\n": "no row follows",
            "time_s,x_m,y_m,z_m\n0,0,0\n": "hand.csv:2: 3 cells where the header has 4",
            "time_s,x_m,y_m,z_m\n0,0,0,zero\n": "hand.csv:2: z_m is 'zero'",
            "time_s,x_m,y_m,z_m\n0,0,0,nan\n": "hand.csv:2: z_m is 'nan'",
            "time_s,x_m,y_m,z_m\n1,0,0,0\n1,0,0,0\n": "hand.csv:3: time_s does not rise",
            "time_s,x_m,y_m,z_m\n0,0,0,0\n1e-320,0,0,0\n": "hand.csv:3: time_s rises by less than 1 ns",
            "time_s,x_m,y_m,z_m\n-1e308,0,0,0\n1e308,0,0,0\n": "hand.csv:2: time_s is not within 1000000 of 0",
            "time_s,x_m,y_m,z_m\n0,0,1e308,0\n": "hand.csv:2: y_m is not within 1000 of 0",
            "time_s,x_m,y_m,z_m,arm\n1,0,0,0,2\n": "hand.csv:2: arm is neither 0 nor 1",
        }
        for text, cause in cases.items():
            error = self.fails(10, "bad-path", "simulate", scene, "--path", self.path(text), "--log", log)
            self.assertIn(cause, error["cause"])
        for path, cause in ((self.folder / "absent.csv", "No such file"), (self.folder, "Is a directory")):
            error = self.fails(10, "bad-path", "simulate", scene, "--path", path, "--log", log)
            self.assertIn(cause, error["cause"])
        good = self.path("time_s,x_m,y_m,z_m\n0,0,0,0\n1,0,0,0\n")
        self.fails(2, "unknown-arm", "simulate", scene, "--path", good, "--log", log, "--arm", "left")
        self.fails(2, "bad-rate", "simulate", scene, "--path", good, "--log", log, "--rate", "7")
        self.assertFalse(log.exists(), "nothing is written when it fails")

    def test_all_errors_of_a_scene(self):
        scene = self.folder / "wrong.scene.json"
        ball = '\n{"name": "%d", "shape": {"sphere": {"radius_m": 0}}, "material": {"stiffness_N_m": 1}}'
        scene.write_text('{"thimble_scene": 1, "name": "wrong", // all of them\n"objects": [%s]}' % ",".join(ball % i for i in range(23)))
        command = ["compile", scene, "--output", self.folder / "wrong.thim"]
        plain = self.run_thimble(*command)
        self.assertEqual((plain.code, plain.err.count("thimble: bad-value: "), plain.err.splitlines()[-1]), (10, 20, "and 3 more"))
        self.assertIn(f"{scene}:22: /objects/19/shape/sphere/radius_m is 0", plain.err)
        document = json.loads(self.run_thimble(*command, "--json").err)
        self.assertEqual((len(document["errors"]), document["more_errors"]), (20, 3))
        self.assertEqual(document["errors"][0]["cause"], document["error"]["cause"])
        self.assertEqual([document["errors"][1][key] for key in ("pointer", "line", "column")], ["/objects/1/shape/sphere/radius_m", 4, 48])


if __name__ == "__main__":
    unittest.main()

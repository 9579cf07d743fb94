"""The Debian packages of a build: made by CPack, read, unpacked into a fresh root, and run there."""

import json
import os
import pty
import re
import shutil
import signal
import subprocess
import tempfile
import unittest
from pathlib import Path

import links

BUILD = Path(os.environ["THIMBLE_BUILD"])
BOARD_FILES = {"usr/bin/thimble-board", "usr/lib/systemd/system/thimble-board.service", "usr/lib/sysusers.d/thimble-board.conf",
               "usr/lib/udev/rules.d/60-thimble-board.rules", "usr/share/doc/thimble-board/board-linux.md",
               "usr/share/doc/thimble-board/changelog.gz", "usr/share/doc/thimble-board/copyright",
               "usr/share/doc/thimble-board/examples/board.json",
               *(f"usr/share/doc/thimble-board/examples/five-bar/{name}" for name in ("board.json", "five-bar-odrive.arm.json", "wall.scene.json"))}


def output(*command, **options):
    done = subprocess.run([*map(str, command)], capture_output=True, text=True, **options)
    if done.returncode:
        raise AssertionError(f"{' '.join(map(str, command))} ended with {done.returncode}:\n{done.stdout}{done.stderr}")
    return done.stdout


class Packages(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = Path(tempfile.mkdtemp(prefix="thimble-packages-"))
        cls.addClassCleanup(shutil.rmtree, cls.folder, ignore_errors=True)
        cls.cross = BUILD.name.removeprefix("linux-") if BUILD.name.startswith("linux-") else None
        cls.arch = cls.cross or output("dpkg", "--print-architecture").strip()
        output(os.environ["CPACK"], "--config", BUILD / "CPackConfig.cmake", "-B", cls.folder)
        cls.packages = {file.name.split("_")[0]: file for file in cls.folder.glob("*.deb")}
        for name, file in cls.packages.items():
            output("dpkg-deb", "-x", file, cls.folder / name)
            output("dpkg-deb", "-e", file, cls.folder / name / "DEBIAN")

    def field(self, package, name):
        return output("dpkg-deb", "--field", self.packages[package], name).strip()

    def files(self, package):
        """Path to mode and owner of every file that is no link."""
        rows = [line.split(None, 5) for line in output("dpkg-deb", "--contents", self.packages[package]).splitlines()]
        return {row[5].removeprefix("./"): (row[0], row[1]) for row in rows if row[0].startswith("-")}

    def test_which_there_are(self):
        host = {"thimble", "libthimble-dev", *os.environ.get("THIMBLE_MORE_PACKAGES", "").split()}
        self.assertEqual(set(self.packages), {"thimble-board"} | (set() if self.cross else host))
        for name, file in self.packages.items():
            arch = "all" if name == "thimble-doc" else self.arch
            self.assertRegex(file.name, rf"^{name}_\d+\.\d+\.\d+_{arch}\.deb$")
            self.assertEqual(self.field(name, "Architecture"), arch)
            self.assertIn("@", self.field(name, "Maintainer"))
            self.assertEqual(self.field(name, "Description").splitlines()[0].split(":")[0], "force-feedback arm")
            for path, (mode, owner) in self.files(name).items():
                self.assertEqual(mode, "-rwxr-xr-x" if path.startswith("usr/bin/") else "-rw-r--r--", path)
                self.assertEqual(owner, "root/root", path)

    def test_the_board(self):
        man_pages = set() if self.cross else {"usr/share/man/man1/thimble-board.1.gz"}
        self.assertEqual(set(self.files("thimble-board")), BOARD_FILES | man_pages)
        depends = self.field("thimble-board", "Depends")
        for library in ("libc6 (>= ", "libgcc-s1 (>= ", "libgpiod2 (>= ", "libstdc++6 (>= ", "systemd"):
            self.assertIn(library, depends)
        self.assertNotIn("cross", depends)  # the compiler's own packages are not the board's
        root = self.folder / "thimble-board"
        for script in ("postinst", "prerm", "postrm"):
            output("sh", "-n", root / "DEBIAN" / script)
            self.assertEqual((root / "DEBIAN" / script).stat().st_mode & 0o777, 0o755)
        self.assertEqual(json.loads((root / "usr/share/doc/thimble-board/examples/board.json").read_text())["thimble_board"], 1)
        unit = (root / "usr/lib/systemd/system/thimble-board.service").read_text()
        self.assertIn("ExecStart=/usr/bin/thimble-board\n", unit)

    def test_man_pages(self):
        if self.cross:
            self.skipTest("the programs of another architecture are not asked")
        for package, programs in (("thimble", ("thimble", "thimble-sim")), ("thimble-board", ("thimble-board",))):
            folder = self.folder / package / "usr/share/man/man1"
            names = {page.name.removesuffix(".1.gz") for page in folder.iterdir()}
            for program in programs:
                self.assertIn(program, names)
            for name in names:
                page = subprocess.run(["man", "--warnings", "-l", folder / f"{name}.1.gz"], capture_output=True, text=True, check=True,
                                      env={**os.environ, "MANWIDTH": "200", "LC_ALL": "C.UTF-8"})
                self.assertEqual(page.stderr, "", name)
                self.assertRegex(page.stdout.splitlines()[0], rf"^{name.upper()}\(1\) ")
                self.assertRegex(page.stdout, rf"\nNAME\n +{name} - \w")
                self.assertNotIn(str(BUILD), page.stdout)
            if package == "thimble":  # every verb has one, at every level
                def verbs(*words):
                    text = output(BUILD / "bin/thimble", *words, "--help")
                    below = [line.split()[0] for line in text.partition("Subcommands:\n")[2].splitlines() if line[2:3].strip()]
                    return [(*words, verb) for verb in below] + [more for verb in below for more in verbs(*words, verb)]
                self.assertLessEqual({"-".join(("thimble", *words)) for words in verbs()}, names)
                self.assertIn("thimble-model-import-urdf", names)

    def test_the_unit_is_confined(self):
        unit = self.folder / "thimble-board/usr/lib/systemd/system/thimble-board.service"
        told = output("systemd-analyze", "security", "--offline=true", "--threshold=30", "--no-pager", unit)  # fails above 3.0
        print("[ figure ] " + re.search(r"Overall exposure level.*?: [0-9.]+", told)[0], flush=True)

    def test_the_unit_allows_what_the_board_calls(self):
        if self.cross:
            self.skipTest("strace does not trace a program of another architecture")

        def expand(words):
            for word in words:
                if word.startswith("@"):
                    lines = output("systemd-analyze", "syscall-filter", "--no-pager", word).split("\n")[1:]
                    yield from expand(line.strip() for line in lines if line.strip() and not line.strip().startswith("#"))
                else:
                    yield word

        root = self.folder / "thimble-board"
        allowed = set(expand(["@default"]))
        unit = (root / "usr/lib/systemd/system/thimble-board.service").read_text()
        for words in re.findall(r"^SystemCallFilter=(.*)$", unit, re.M):
            if words.startswith("~"):
                allowed -= set(expand(words[1:].split()))
            else:
                allowed |= set(expand(words.split()))
        config = json.loads((root / "usr/share/doc/thimble-board/examples/board.json").read_text())
        ours, theirs = pty.openpty()
        config["links"] = [{"slcan": os.ttyname(theirs)}]
        config["store"] = str(self.folder)
        file, trace = self.folder / "board.json", self.folder / "trace"
        file.write_text(json.dumps(config))
        board = subprocess.Popen(["strace", "-f", "-o", trace, root / "usr/bin/thimble-board", "--config", file],
                                 stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
        while (line := board.stdout.readline()) not in ("ready\n", ""):
            pass
        self.assertEqual(line, "ready\n")
        pid = int(trace.read_text().split()[0])
        os.kill(pid, signal.SIGTERM)
        board.communicate(timeout=60)
        os.close(ours), os.close(theirs)
        called = set(re.findall(r"^\d+ +([a-z0-9_]+)\(", trace.read_text(), re.M))
        self.assertLessEqual({"mlockall", "sched_setscheduler", "ppoll", "execve"}, called)
        self.assertEqual(called - allowed, set())

    def test_the_board_runs(self):
        root = self.folder / "thimble-board"
        # The example is a configuration that is taken; its devices are not there (3), or it may not have them (5).
        done = subprocess.run([root / "usr/bin/thimble-board", "--config", root / "usr/share/doc/thimble-board/examples/board.json",
                               "--check"], capture_output=True, text=True, timeout=60)
        self.assertIn(done.returncode, (3, 5), done.stderr)

    def test_the_host(self):
        files = set(self.files("thimble"))
        self.assertLessEqual({"usr/bin/thimble", "usr/bin/thimble-sim", "usr/lib/udev/rules.d/70-thimble.rules",
                              "usr/share/bash-completion/completions/thimble", "usr/share/zsh/vendor-completions/_thimble",
                              "usr/share/fish/vendor_completions.d/thimble.fish", "usr/share/doc/thimble/cli.md",
                              "usr/share/thimble/scene.schema.json", "usr/share/thimble/scenes/asteroid/asteroid.scene.json"}, files)
        depends = self.field("thimble", "Depends")
        for library in ("libassimp5 ", "libc6 (>= ", "libfmt9 ", "libmnl0 ", "libpng16-16 ", "libqhull-r8.0 ", "libstdc++6 (>= ", "zlib1g "):
            self.assertIn(library, depends)
        self.assertNotIn("libgpiod", depends)

    def test_links(self):
        count, dead = links.dead_links(*(self.folder / name for name in self.packages))
        self.assertEqual(dead, [])
        self.assertGreater(count, 250)
        _, alone = links.dead_links(self.folder / "thimble-board")  # which does not depend on the others
        self.assertEqual(alone, [])

    def test_the_library(self):
        """A project outside finds it in the place that the package was unpacked to."""
        root, build = self.folder / "libthimble-dev/usr", self.folder / "outside"
        output("cmake", "-S", Path(__file__).parent / "outside", "-B", build, "-G", "Ninja", f"-DCMAKE_PREFIX_PATH={root}")
        output("cmake", "--build", build)
        scene = self.folder / "floor.scene.json"
        scene.write_text(json.dumps({"thimble_scene": 1, "name": "floor", "objects": [
            {"name": "floor", "shape": {"plane": {"normal": [0, 0, 1]}}, "material": {"stiffness_N_m": 500}}]}))
        told = json.loads(output(build / "outside", scene, self.folder / "thimble/usr/share/thimble/arms/falcon.arm.json"))
        self.assertAlmostEqual(told["rendered_N"], 500 * 0.002, places=5)
        self.assertAlmostEqual(told["simulated_N"], 500 * 0.002, places=5)
        self.assertLess(told["missed_m"], 1e-6)
        headers = root / "include/thimble"
        missing = [(file.name, name) for file in headers.rglob("*.h") for name in re.findall(r'^#include "(.*)"', file.read_text(), re.M)
                   if not (headers / name).is_file() and not name.startswith("flatbuffers/")]
        self.assertEqual(missing, [])
        for file in (self.folder / "libthimble-dev").rglob("*.cmake"):  # it may be moved
            self.assertNotIn(str(BUILD.parent), file.read_text())

    def imported_from(self, folder):
        """Strongest force of a run on the simulated arm, by the Python package in the folder."""
        scenes = self.folder / "thimble/usr/share/thimble/scenes"
        return float(output("/usr/bin/python3", "-B", "-c", f"""if True:
            import numpy, pathlib, thimble
            assert pathlib.Path(thimble.__file__).is_relative_to("{folder}"), thimble.__file__
            felt = thimble.simulate("{scenes}/ring/ring.scene.json", "{scenes}/probe.csv", ideal=True, rate_Hz=1000)
            print(numpy.linalg.norm(felt["force_N"], axis=1).max())""", env={**os.environ, "PYTHONPATH": str(folder)}))

    def test_python(self):
        if "python3-thimble" not in self.packages:
            self.skipTest("built without THIMBLE_PYTHON")
        place = self.folder / "python3-thimble/usr/lib/python3/dist-packages"
        self.assertGreater(self.imported_from(place), 0.1)
        wheels, unpacked = self.folder / "wheels", self.folder / "wheel"
        output("/usr/bin/python3", "-m", "pip", "wheel", Path(__file__).parents[3], "--no-deps", "--no-index", "--config-settings",
               f"build={BUILD}", "-w", wheels)
        output("/usr/bin/python3", "-m", "pip", "install", "--no-deps", "--no-index", "--target", unpacked, *wheels.iterdir())
        self.assertGreater(self.imported_from(unpacked), 0.1)

        # Its types: the stubs say what there is, and a script is checked by them.
        types = {**os.environ, "PYTHONPATH": str(place), "MYPY_CACHE_DIR": str(self.folder / "mypy")}
        # The binding is this package's alone, thimble.experiment has its types in the sources; mypy 1.0 takes a cached_property of the running
        # module for no property.
        unlike = self.folder / "allowlist"
        unlike.write_text("thimble\\.(_thimble|experiment)\\..*\nthimble\\.(_recording\\.)?Recording\\.(counts|ticks|_replayed)\n")
        output("/usr/bin/python3", "-B", "-m", "mypy.stubtest", "--allowlist", unlike, "thimble", env=types, cwd=place)
        script = Path(__file__).with_name("typed_script.py")
        mypy = ("/usr/bin/python3", "-B", "-m", "mypy", "--strict")
        output(*mypy, script, env=types, cwd=place)
        wrong = self.folder / "wrong.py"
        wrong.write_text(script.read_text().replace("seconds=1.0", 'seconds="1"'))
        told = subprocess.run([*mypy, wrong], env=types, cwd=place, capture_output=True, text=True).stdout
        self.assertIn('Argument "seconds" to "render" of "Device" has incompatible type "str"; expected "float"', told)

    def test_the_same_bytes(self):
        """Those of a second run, of what is quick."""
        again = self.folder / "again"
        components = {"thimble-board": "board", "python3-thimble": "python"}
        wanted = [name for name in self.packages if name in components]
        output(os.environ["CPACK"], "--config", BUILD / "CPackConfig.cmake", "-B", again, "-D",
               "CPACK_COMPONENTS_ALL=" + ";".join(components[name] for name in wanted))
        for name in wanted:
            self.assertEqual((again / self.packages[name].name).read_bytes(), self.packages[name].read_bytes(), name)

    def test_the_host_runs(self):
        root = self.folder / "thimble/usr"
        self.assertIn(self.field("thimble", "Version"), output(root / "bin/thimble", "--version"))
        scenes = sorted((root / "share/thimble/scenes").glob("*/*.scene.json"))
        self.assertGreater(len(scenes), 15)
        for scene in scenes[:3]:
            output(root / "bin/thimble", "compile", scene, "--output", self.folder / "scene.thim")
        log = self.folder / "felt.csv"
        output(root / "bin/thimble", "simulate", root / "share/thimble/scenes/ring/ring.scene.json", "--path",
               root / "share/thimble/scenes/probe.csv", "--ideal", "--rate", "1000", "--log", log)
        self.assertGreater(len(log.read_text().splitlines()), 100)
        completed = output("bash", "-c", f"PATH={root}/bin:$PATH; . {root}/share/bash-completion/completions/thimble; "
                           "COMP_WORDS=(thimble doc) COMP_CWORD=1; _thimble; echo ${COMPREPLY[@]}")
        self.assertEqual(completed.strip(), "doctor")


if __name__ == "__main__":
    unittest.main()

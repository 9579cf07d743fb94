"""Every block of code in README.md and docs/ is true: `sh` and `python` blocks run against the simulator, `cpp` blocks compile, `json` blocks are
read by the program that they are for. The blocks of a page run one behind the other in one folder, as a reader goes.

A comment above a block says what the reader does besides:
    <!-- not run: REASON -->         it needs what is not here: hardware, root, an installation, hours. Its commands are still looked up
    <!-- file: NAME -->              the reader saves the block under this name
    <!-- part of: NAME -->           a key and its value, which take the place of those in that file
    <!-- ends with: CODE -->         the exit code of the block's last command, if it is not 0
    <!-- with: FILE... -->           files of the project that the block needs in the folder
"""

import csv
import json
import os
import re
import shlex
import shutil
import signal
import subprocess
import unittest
from pathlib import Path

from rig import BIN, PATIENCE_S, Rig

ROOT = Path(__file__).resolve().parents[2]
PAGES = [ROOT / "README.md", ROOT / "board/README.md", *sorted((ROOT / "docs").glob("*.md"))]
BLOCK = re.compile(r"((?:^<!-- [^>]* -->\n+)*)^```(\w+)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
TESTED = ("sh", "json", "cpp", "python")

# What the reader has and does without being told: a simulator that is ready before the next command, and Ctrl-C after a look.
SHELL = r"""
set -e -o pipefail
shopt -s expand_aliases
ready() { local pid=$!; for _ in $(seq 600); do command thimble list --json | grep -q '"uris"' && return; kill -0 $pid || return 1; sleep 0.1; done; return 1; }
look() { local out; out=$(mktemp); "$@" >"$out" 2>&1 & local pid=$!
  for _ in $(seq 600); do [ -s "$out" ] && break; kill -0 $pid 2>/dev/null || break; sleep 0.1; done
  kill -INT $pid || { cat "$out"; return 1; }; local code=0; wait $pid || code=$?; cat "$out"; [ $code -eq 0 ] || [ $code -eq 130 ]; }
thimble() {
  case " $* " in
    *' --help '*) command thimble "$@" ;;
    ' view '*) look env "$THIMBLE_BIN/thimble" "$@" --no-browser ;;
    *' --watch '*) look env "$THIMBLE_BIN/thimble" "$@" ;;
    *) command thimble "$@" ;;
  esac
}
"""


class Block:
    def __init__(self, page, found):
        self.page, self.language, self.text = page, found[2], found[3]
        self.line = page.read_text()[:found.start(2)].count("\n") + 1
        self.notes = dict(re.findall(r"<!-- ([\w ]+): (.*?) -->", found[1]))

    def __str__(self):
        return f"{self.page.relative_to(ROOT)}:{self.line}"


def blocks_of(page):
    return [Block(page, found) for found in BLOCK.finditer(page.read_text())]


def without_comments(text):
    """JSON as the project reads it: `//` comments, and none in strings."""
    return re.sub(r'("(?:\\.|[^"\\])*")|//[^\n]*', lambda it: it[1] or "", text)


def documents(text):
    """The JSON documents of a block: one or several, or the keys of an object without its braces."""
    text = without_comments(text).strip()
    if text.startswith('"'):
        text = "{" + text.rstrip(",") + "}"
    found, at = [], 0
    while at < len(text):
        document, at = json.JSONDecoder().raw_decode(text, at)
        found.append(document)
        at += len(text[at:]) - len(text[at:].lstrip())
    return found


def scene_with(document):
    """A whole scene around a part of one; nothing if it is no part of a scene."""
    ball = {"name": "it", "shape": {"box": {"size_m": [0.02, 0.02, 0.02]}}, "material": {"stiffness_N_m": 800}}
    if "thimble_scene" in document:
        return document
    if "shape" in document:
        ball = document
    elif "motion" in document:
        ball["body"] = document
    elif "stiffness_N_m" in document:
        ball["material"] = document
    elif set(document) <= {"plane", "sphere", "box", "cylinder", "capsule", "cone", "mesh", "height_field", "vector_field", "potential_field",
                           "force_field"}:
        ball["shape"] = document
    else:
        return None
    return {"thimble_scene": 1, "name": "part", "objects": [ball], "materials": {"ice": {"stiffness_N_m": 1000}}}


class Docs(Rig):
    def run_page(self, page):
        """A folder with what a clone has, in which the page's blocks run."""
        work = self.folder / "_".join(page.relative_to(ROOT).with_suffix("").parts)
        work.mkdir()
        for name in ("scenes", "arms", "docs", "host-tools"):
            (work / name).symlink_to(ROOT / name)
        python = os.environ.get("THIMBLE_PYTHON", "")
        self.environment |= {"PATH": f"{BIN}:{os.environ['PATH']}", "THIMBLE_BIN": str(BIN), "PYTHONPATH": python, "HOME": str(work), "BROWSER": "true"}
        python_text = ""
        for block in blocks_of(page):
            if block.language not in TESTED and "file" not in block.notes:
                continue
            with self.subTest(str(block)):
                if "file" in block.notes:
                    (work / block.notes["file"]).write_text(block.text)
                if "part of" in block.notes:
                    self.replace(work / block.notes["part of"], block)
                elif block.language == "sh":
                    self.run_shell(block, work)
                elif block.language == "json":
                    self.read_json(block, work)
                elif block.language == "cpp":
                    self.compile(block, work)
                elif block.language == "python":
                    compile(block.text, str(block), "exec")
                    python_text += "" if "not run" in block.notes else f"# {block}\n{block.text}"
        if python and python_text:
            with self.subTest(str(page)):
                self.run_python(python_text, work)

        return work

    def test_docs_first_scene(self):
        """And its drawer clicks: four times the force rises to 1 N and falls at once, and each click leaves it 5 mm further, up to the stop."""
        work = self.run_page(ROOT / "docs/first-scene.md")
        with open(work / "felt.csv") as file:
            rows = [(float(row["force_x_N"]), float(row["drawer.q_m"])) for row in csv.DictReader(file)]
        clicks, pressed = [], False
        for force_N, at_m in rows:
            if force_N < 0.1 and pressed:
                clicks.append(at_m)
            pressed = force_N > 0.9 or pressed and force_N > 0.1
        self.assertEqual(len(clicks), 5)  # the fifth: the hand goes back
        for number, at_m in enumerate(clicks[:4], 1):
            self.assertLess(abs(at_m + 0.005 * number), 0.0025)
        self.assertAlmostEqual(rows[-1][1], -0.02, 4)

    def replace(self, file, block):
        (part,) = documents(block.text)
        scene = json.loads(without_comments(file.read_text()))
        (place,) = [it for it in scene["objects"] if set(part) <= set(it)]
        place.update(part)
        file.write_text(json.dumps(scene, indent=2))

    def run_shell(self, block, work):
        self.known_commands(block)
        if "not run" in block.notes:
            return
        for name in block.notes.get("with", "").split():
            shutil.copy(ROOT / name, work)
        text = block.text.replace("/usr/share/thimble/", "")  # what is installed there is in the clone
        lines = re.sub(r"&( *(#.*)?)$", r"& ready\1", text, flags=re.MULTILINE)
        lines = lines.replace("kill %1", "kill %1; wait %1 || true")
        process = subprocess.Popen(["bash", "-m", "-c", SHELL + lines], cwd=work, env=self.environment, text=True, stdin=subprocess.DEVNULL,
                                   stdout=subprocess.PIPE, stderr=subprocess.STDOUT, start_new_session=True)
        try:
            out, _ = process.communicate(timeout=PATIENCE_S)
        finally:
            self.end_session(process.pid)
        self.assertEqual(process.returncode, int(block.notes.get("ends with", 0)), out)

    @staticmethod
    def end_session(session):
        """What a block has left running, as the simulator of the next blocks would be in the way of other pages."""
        for process in Path("/proc").glob("[0-9]*"):
            try:
                if int((process / "stat").read_text().rsplit(")", 1)[1].split()[3]) == session:
                    os.kill(int(process.name), signal.SIGKILL)
            except (OSError, ProcessLookupError):
                pass

    def known_commands(self, block):
        """Every `thimble VERB` and its options are known, also of blocks that are not run."""
        for line in block.text.replace("\\\n", " ").splitlines():
            for command in re.findall(r"(?:^|&& |sudo |\| )thimble [^#|&;]*", line):
                words = shlex.split(command[command.index("thimble "):])
                self.assert_known(words[1:], f"{block}: {line}")

    def assert_known(self, words, where):
        help_text = self.help_of(words[0])
        self.assertIsNotNone(help_text, f"{where}: no such verb")
        if len(words) > 1 and re.fullmatch(r"[a-z]+", words[1]) and "\n  " + words[1] in help_text:
            help_text += self.help_of(*words[:2])
        for word in words[1:]:
            if word.startswith("--") and word != "--help":
                self.assertRegex(help_text, rf"[ ,]{re.escape(word)}\b", f"{where}: no such option")

    helps = {}

    def help_of(self, *verb):
        if verb not in self.helps:
            done = subprocess.run([BIN / "thimble", *verb, "--help"], capture_output=True, text=True, timeout=PATIENCE_S)
            self.helps[verb] = done.stdout if done.returncode == 0 else None
        return self.helps[verb]

    def read_json(self, block, work):
        for document in documents(block.text):
            scene = scene_with(document)
            if "thimble_arm" in document:
                (work / "block.arm.json").write_text(json.dumps(document))
                self.ok("model", "check", work / "block.arm.json")
            elif "thimble_sweep" in document:
                self.ok("sweep", work / block.notes["file"], "--dry-run")
            elif scene is not None:
                for name in ("ring/ring.obj", "asteroid/asteroid.plg", "baboon/baboon.png", "spline-tissue/stiffness.csv"):
                    if (ROOT / "scenes" / name).exists():
                        shutil.copy(ROOT / "scenes" / name, work)
                for name in re.findall(r'"(?:file)": "([^"]+)"', block.text):
                    if not (work / name).exists():
                        shutil.copy(next((ROOT / "scenes").rglob("*" + Path(name).suffix)), work / name)
                (work / "block.scene.json").write_text(json.dumps(scene))
                self.ok("compile", work / "block.scene.json", "--output", work / "block.thim")

    def compile(self, block, work):
        """As it stands, or inside of a function where it has statements at its top."""
        includes = "".join(re.findall(r"^#include.*\n", block.text, re.MULTILINE))
        rest = re.sub(r"^#include.*\n", "", block.text, flags=re.MULTILINE)
        inside = re.search(r"^(while|if|device\.)", rest, re.MULTILINE)
        source = f"{includes}#include <algorithm>\nvoid block();\nvoid block() {{\n{rest}}}\n" if inside else block.text
        (work / "block.cpp").write_text(source)
        commands = json.loads((BIN.parent / "compile_commands.json").read_text())
        example = next(it["command"] for it in commands if "/host_wall.dir/" in it["command"])  # docs/examples/host_wall.cpp
        compiler, *words = shlex.split(example)
        flags = [word for i, word in enumerate(words) if re.match("-(I|D|isystem|std=)", word) or words[i - 1] == "-isystem"]
        done = subprocess.run([compiler, *flags, "-Wall", "-Wextra", "-Werror", "-fsyntax-only", work / "block.cpp"], capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)

    def run_python(self, text, work):
        """All blocks of a page, with a simulated device that is ready. What goes on for seconds goes on for one."""
        text = text if "import thimble" in text else "import thimble\n" + text
        text = re.sub(r"seconds=\d+(\.\d+)?\b", lambda it: "seconds=1" if float(it[0][8:]) > 1 else it[0], text)
        (work / "block.py").write_text(text)
        simulator = self.sim()
        done = subprocess.run(["/usr/bin/python3", "block.py"], cwd=work, env=self.environment, stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=PATIENCE_S)
        simulator.stop()
        self.assertEqual(done.returncode, 0, done.stderr)

    def test_indented_commands_are_known(self):
        for page in PAGES:
            for line in re.findall(r"^    thimble [^\[|<>\n]*$", page.read_text(), re.MULTILINE):
                words = line.split("#")[0].split("&&")[0].rstrip(" &").split()
                if re.fullmatch(r"[a-z]+", words[1]):
                    self.assert_known(words[1:], f"{page.name}: {line}")


for each in PAGES:
    if each.stem != "first-scene" and any(block.language in TESTED for block in blocks_of(each)):
        def test(self, page=each):
            self.run_page(page)
        setattr(Docs, "test_" + re.sub(r"\W", "_", str(each.relative_to(ROOT).with_suffix(""))), test)


if __name__ == "__main__":
    unittest.main()

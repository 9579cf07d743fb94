"""Run in the clean root: the three tutorials of the installed manual, as a student does them who has the packages alone. The blocks of each page are
copied from its HTML in the page's order: commands are typed in a terminal, Python is pasted into the interpreter, files are saved. What the page
shows below a block is compared with what the block printed.

Comments of the page say what the reader knows from the text: file, part of, ends with, not run (tests/end_to_end/docs_test.py).
"""

import html.parser
import json
import os
import pty
import re
import select
import signal
import sys
import time
import unittest
from pathlib import Path

MANUAL = Path("/usr/share/doc/thimble-doc/html/docs")
PATIENCE_S = 300
PAGES = {"first-scene": ("sh", "json"), "first-experiment": ("python",), "first-arm": ("sh",)}


class Blocks(html.parser.HTMLParser):
    """[(language, text, {note: value})] of a page."""

    def __init__(self, page):
        super().__init__()
        self.found, self.notes, self.language, self.text = [], {}, None, None
        self.feed((MANUAL / f"{page}.html").read_text())

    def handle_comment(self, data):
        self.notes |= dict(re.findall(r"^ ([\w ]+): (.*) $", data))

    def handle_starttag(self, tag, attrs):
        language = re.match("highlight-([a-z]+) ", dict(attrs).get("class") or "")
        if tag == "div" and language:
            self.language = language[1]
        elif tag == "pre" and self.language:
            self.text = ""

    def handle_data(self, data):
        if self.text is not None:
            self.text += data

    def handle_endtag(self, tag):
        if tag == "pre" and self.text is not None:
            self.found.append((self.language, self.text, self.notes))
            self.language, self.text, self.notes = None, None, {}


class Terminal:
    """A program in a terminal of its own."""

    def __init__(self, *command):
        self.output = ""
        self.pid, self.terminal = pty.fork()
        if self.pid == 0:
            os.execvp(command[0], command)

    def read_until(self, condition):
        """Reads until the condition holds of what is there; false at the end of the program."""
        deadline = time.monotonic() + PATIENCE_S
        while not condition():
            if not select.select([self.terminal], [], [], max(0.0, deadline - time.monotonic()))[0]:
                raise AssertionError(f"nothing more in {PATIENCE_S} s:\n{self.output}")
            try:
                data = os.read(self.terminal, 65536)
            except OSError:  # its end
                return False
            self.output += data.decode(errors="replace").replace("\r\n", "\n")
        return True

    def type(self, text):
        os.write(self.terminal, text.encode())

    def end(self):
        """The exit code."""
        self.read_until(lambda: False)
        status = os.waitpid(self.pid, 0)[1]
        os.close(self.terminal)
        return os.waitstatus_to_exitcode(status)


def comparable(text):
    """Lines without what differs in each run: the time of day, and how wide the spaces are."""
    text = re.sub(r'"utc_s":[0-9.]+', '"utc_s":T', text)
    return [" ".join(line.split()) for line in text.splitlines() if line.strip()]


class Student(unittest.TestCase):
    def setUp(self):
        self.printed, self.running = "", None

    def tearDown(self):
        if self.running:
            os.kill(self.running.pid, signal.SIGKILL)

    def go_through(self, page):
        """A folder with all that the page makes."""
        work = Path(os.environ["HOME"], page)
        work.mkdir()
        os.chdir(work)
        done = 0
        for language, text, notes in Blocks(page).found:
            with self.subTest(f"{page}: {text.splitlines()[0]}"):
                if "file" in notes:
                    Path(notes["file"]).write_text(text)
                elif "part of" in notes:
                    self.replace_body(Path(notes["part of"]), text)
                elif language == "none":
                    shown = comparable(self.printed)
                    self.assertEqual([line for line in comparable(text) if line not in shown], [], self.printed)
                elif "not run" in notes:
                    continue
                elif language == "sh":
                    self.type_commands(text, int(notes.get("ends with", 0)))
                elif language == "python":
                    self.paste(text)
                done += language in PAGES[page]
        self.look_no_longer("\x04" if "python" in PAGES[page] else "\x03")
        self.assertGreater(done, 3)
        return work

    def replace_body(self, file, text):
        """The line of "body", as the text says; what runs with --watch runs the scene again."""
        lines = file.read_text().splitlines(keepends=True)
        (at,) = [i for i, line in enumerate(lines) if line.strip().startswith('"body"')]
        before = len(self.running.output) if self.running else 0
        file.write_text("".join([*lines[:at], text, *lines[at + 1:]]))
        json.loads(file.read_text())
        if self.running:
            self.assertTrue(self.running.read_until(lambda: len(self.running.output) > before))

    def type_commands(self, text, last_code):
        lines = [line for line in text.splitlines() if line.strip()]
        self.printed = ""
        for number, line in enumerate(lines):
            self.look_no_longer()
            print(f"$ {line}", flush=True)
            terminal = Terminal("bash", "-c", line)
            if re.search(r"^thimble view | --watch", line):  # until Ctrl-C, and there may be no browser
                self.running = terminal
                self.assertTrue(terminal.read_until(lambda: re.search(r"^(http|\d+ ticks|thimble: )", terminal.output, re.M)), terminal.output)
                continue
            code = terminal.end()
            self.printed += terminal.output
            self.assertEqual(code, last_code if number == len(lines) - 1 else 0, terminal.output)

    def look_no_longer(self, key="\x03"):
        if self.running:
            running, self.running = self.running, None
            running.type(key)
            self.assertIn(running.end(), (0, 130), running.output)

    def paste(self, text):
        """Into one interpreter for the page: line by line, each when it asks for it."""
        asked = re.compile(r"(^|\n)(>>> |\.\.\. )(thimble-sim: [^\n]*\n)?$")  # which says how it was when it ends
        if not self.running:
            self.running = Terminal("env", "PYTHON_BASIC_REPL=1", "/usr/bin/python3", "-q")  # from 3.13 on it draws its prompts in colours
            self.assertTrue(self.running.read_until(lambda: asked.search(self.running.output)))
        python = self.running
        begin = len(python.output)
        for line in [*text.splitlines(), ""]:
            sent = len(python.output)
            python.type(line + "\n")
            self.assertTrue(python.read_until(lambda: asked.search(python.output[sent:])), python.output[begin:])
        self.printed = python.output[begin:]
        self.assertNotRegex(self.printed, r"\n(\w+Error|Traceback|\w+\.Error)\b")

    def test_first_scene(self):
        work = self.go_through("first-scene")
        self.assertIn("<svg", (work / "felt.svg").read_text())

    def test_first_experiment(self):
        work = self.go_through("first-experiment")
        self.assertIn("<svg", (work / "curve.svg").read_text())

    def test_first_arm(self):
        work = self.go_through("first-arm")
        self.assertGreater(json.loads((work / "mine.commissioned.arm.json").read_text())["thimble_arm"], 0)


if __name__ == "__main__":
    sys.exit(unittest.main(verbosity=2))

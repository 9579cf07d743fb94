"""docs/troubleshooting.md has every error of the programs, with its cause and the way out: its table is the one that scripts/error_names makes, and
that table has every name that a test expects of a program, and every name that documentation calls an error.

With THIMBLE_WRITE_DOCS set the table is written anew."""

import os
import re
import subprocess
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
SCRIPT = ROOT / "scripts/error_names"


class ErrorNames(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.table = subprocess.run([SCRIPT], capture_output=True, text=True, check=True).stdout.strip()
        cls.names = set(re.findall(r"^\| `([^`]+)` \|", cls.table, re.MULTILINE))

    def test_the_page_has_the_table(self):
        if "THIMBLE_WRITE_DOCS" in os.environ:
            subprocess.run([SCRIPT, "--write"], check=True)
        page = (ROOT / "docs/troubleshooting.md").read_text()
        self.assertIn(f"<!-- errors begin -->\n{self.table}\n<!-- errors end -->", page,
                      "write it anew: THIMBLE_WRITE_DOCS=1, or scripts/error_names --write")

    def test_what_tests_expect_of_a_program_is_there(self):
        expected = set()
        for file in (ROOT / "tests").rglob("*.py"):
            expected |= set(re.findall(r'\.fails\(\s*\d+, "([\w-]+)"', file.read_text()))
        self.assertGreater(len(expected), 40)
        self.assertEqual(expected - self.names, set())

    def test_what_unit_tests_expect_of_the_compiler_is_there(self):
        expected = set()
        for folder in ("compiler", "lab", "arms"):
            for file in (ROOT / "tests/unit" / folder).rglob("*.cpp"):
                expected |= set(re.findall(r'\bname, "([a-z]+(?:-[a-z0-9]+)+)"', file.read_text()))
        self.assertGreater(len(expected), 5)
        self.assertEqual(expected - self.names, set())

    def test_every_row_says_what_to_do(self):
        for row in self.table.splitlines()[2:]:
            cells = [cell.strip() for cell in re.split(r"(?<!\\)\|", row)[1:-1]]
            self.assertEqual(len(cells), 4, row)
            self.assertTrue(all(cells), row)


if __name__ == "__main__":
    unittest.main()

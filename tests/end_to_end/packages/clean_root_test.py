"""The packages of a clean clone, built by README's line: the same bytes as those of this build, without a complaint of lintian, and they work in a
clean Debian, where the tutorials of their manual are done with nothing else.

THIMBLE_PACKAGES=FOLDER takes the packages of this folder instead of a new build, to try one of the tests by hand.
"""

import os
import re
import shutil
import subprocess
import tempfile
import unittest
from pathlib import Path

BUILD = Path(os.environ["THIMBLE_BUILD"])
HERE = Path(__file__).resolve().parent
SOURCE = HERE.parent.parent.parent


def run(*command, **options):
    print("+", *command, flush=True)
    subprocess.run([*map(str, command)], check=True, **options)


def output(*command):
    return subprocess.run([*map(str, command)], check=True, capture_output=True, text=True).stdout


def fields(file, name):
    return [word.strip() for word in output("dpkg-deb", "--field", file, name).split(",") if word.strip()]


class CleanRoot(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = Path(tempfile.mkdtemp(prefix="thimble-clean-"))
        cls.addClassCleanup(shutil.rmtree, cls.folder, ignore_errors=True)
        cls.folder.chmod(0o755)  # a root without root's rights is made by another user
        given = os.environ.get("THIMBLE_PACKAGES")
        cls.made = sorted(Path(given or cls.build_a_clone()).glob("*.deb"))

    @classmethod
    def build_a_clone(cls):
        """The tracked files as they are now, with the time that this build gives its packages."""
        clone = cls.folder / "clone"
        clone.mkdir()
        names = [name for name in output("git", "-C", SOURCE, "ls-files", "-z").split("\0") if name and (SOURCE / name).exists()]
        archive = subprocess.run(["tar", "-C", SOURCE, "--null", "-T", "-", "-cf", "-"], check=True, input="\0".join(names).encode(), capture_output=True)
        subprocess.run(["tar", "-C", clone, "-xf", "-"], check=True, input=archive.stdout)
        epoch = re.search(r'CPACK_THIMBLE_EPOCH "(\d+)"', (BUILD / "CPackConfig.cmake").read_text())[1]
        line = re.search(r"`(scripts/make_packages) && sudo apt install (\S+)`", (clone / "README.md").read_text())
        run(clone / line[1], cwd=clone, env={**os.environ, "SOURCE_DATE_EPOCH": epoch, "CCACHE_DISABLE": "1"}, stdout=subprocess.DEVNULL)
        return (clone / line[2]).parent

    def test_which_there_are(self):
        self.assertEqual({fields(file, "Package")[0] for file in self.made}, {"libthimble-dev", "python3-thimble", "thimble", "thimble-board", "thimble-doc"})

    def test_lintian(self):
        run("lintian", "--allow-root", "--fail-on", "error,warning", *self.made)

    def test_the_same_bytes(self):
        debs = self.folder / "debs"
        run(os.environ["CPACK"], "--config", BUILD / "CPackConfig.cmake", "-B", debs, stdout=subprocess.DEVNULL)
        made = {file.name: file.read_bytes() for file in self.made}
        here = {file.name: file.read_bytes() for file in debs.glob("*.deb")}
        self.assertGreaterEqual(len(here), 4)  # thimble-doc too, if this build has it
        self.assertEqual([name for name in here if made.get(name) != here[name]], [])

    def test_a_clean_root(self):
        ours = {fields(file, "Package")[0] for file in self.made}
        needed = {entry for file in self.made for name in ("Depends", "Recommends") for entry in fields(file, name)}
        wanted = {entry.split("|")[0].split("(")[0].strip() for entry in needed} - ours
        trial = self.folder / "trial"
        trial.mkdir()
        for file in (*self.made, HERE / "in_clean_root.sh", HERE / "tutorials.py"):
            shutil.copy(file, trial)
        shutil.copytree(HERE / "outside", trial / "outside")
        sources = next(file for file in (Path("/etc/apt/sources.list"), Path("/etc/apt/sources.list.d/debian.sources"))
                       if file.exists() and file.stat().st_size)
        run("mmdebstrap", "--variant=apt", "--format=null",
            "--include=" + ",".join(sorted(wanted | {"cmake", "g++", "man-db", "ninja-build"})),
            f"--customize-hook=copy-in {trial} /tmp", '--customize-hook=chroot "$1" env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin LANG=C.UTF-8 TERM=xterm sh /tmp/trial/in_clean_root.sh',
            "bookworm", "-", sources)


if __name__ == "__main__":
    unittest.main()

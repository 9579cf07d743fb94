"""The packages of a clean copy of the sources, built by README's line, are those of this build to the byte, and work in a clean Debian."""

import os
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


def fields(file, name):
    told = subprocess.run(["dpkg-deb", "--field", file, name], check=True, capture_output=True, text=True).stdout
    return [word.strip() for word in told.split(",") if word.strip()]


class CleanRoot(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = Path(tempfile.mkdtemp(prefix="thimble-clean-"))
        cls.addClassCleanup(shutil.rmtree, cls.folder, ignore_errors=True)
        cls.folder.chmod(0o755)  # a root without root's rights is made by another user
        cls.debs = cls.folder / "debs"
        run(os.environ["CPACK"], "--config", BUILD / "CPackConfig.cmake", "-B", cls.debs, stdout=subprocess.DEVNULL)

    def test_a_clean_copy_gives_the_same_bytes(self):
        clone = self.folder / "clone"
        clone.mkdir()
        tracked = subprocess.run(["git", "-C", SOURCE, "ls-files", "-z"], check=True, capture_output=True).stdout
        present = b"\0".join(name for name in tracked.split(b"\0") if name and (SOURCE / name.decode()).exists())
        archive = subprocess.run(["tar", "-C", SOURCE, "--null", "-T", "-", "-cf", "-"], check=True, input=present, capture_output=True).stdout
        subprocess.run(["tar", "-C", clone, "-xf", "-"], check=True, input=archive)
        epoch = subprocess.run(["git", "-C", SOURCE, "log", "-1", "--format=%ct"], check=True, capture_output=True, text=True).stdout.strip()
        run(clone / "scripts/make_packages", env={**os.environ, "SOURCE_DATE_EPOCH": epoch, "CCACHE_DISABLE": "1"}, stdout=subprocess.DEVNULL)
        made = {file.name: file.read_bytes() for file in (clone / "build/packages").glob("*.deb")}
        here = {file.name: file.read_bytes() for file in self.debs.glob("*.deb")}
        self.assertGreaterEqual(len(here), 4)
        self.assertLessEqual(set(here), set(made))  # thimble-doc is in one of them
        self.assertEqual([name for name in here if made[name] != here[name]], [])
        run("lintian", "--allow-root", "--fail-on", "error,warning", *sorted((clone / "build/packages").glob("*.deb")))

    def test_a_clean_root(self):
        ours = {fields(file, "Package")[0] for file in self.debs.glob("*.deb")}
        depends = {entry for file in self.debs.glob("*.deb") for entry in fields(file, "Depends")}
        wanted = {entry.split("|")[0].split("(")[0].strip() for entry in depends} - ours
        trial = self.folder / "trial"
        trial.mkdir()
        for file in (*self.debs.glob("*.deb"), HERE / "in_clean_root.sh"):
            shutil.copy(file, trial)
        shutil.copytree(HERE / "outside", trial / "outside")
        sources = next(file for file in (Path("/etc/apt/sources.list"), Path("/etc/apt/sources.list.d/debian.sources"))
                       if file.exists() and file.stat().st_size)
        run("mmdebstrap", "--variant=apt", "--format=null",
            "--include=" + ",".join(sorted(wanted | {"cmake", "g++", "man-db", "ninja-build"})),
            f"--customize-hook=copy-in {trial} /tmp", '--customize-hook=chroot "$1" sh /tmp/trial/in_clean_root.sh',
            "bookworm", "-", sources)


if __name__ == "__main__":
    unittest.main()

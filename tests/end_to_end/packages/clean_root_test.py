"""The packages of a clean clone, built by README's line in a clean Debian: without a complaint of lintian, for this machine's release the same bytes
as those of this build, and they work in another clean root, where the tutorials of their manual are done with nothing else. `./demo` too runs in
the root in which they are built, first.

THIMBLE_RELEASE: of Debian; this machine's if it is not given. THIMBLE_PACKAGES=FOLDER takes the packages of this folder instead of a new build, to
try one of the tests by hand.
"""

import os
import platform
import re
import shlex
import shutil
import subprocess
import tempfile
import unittest
from pathlib import Path

BUILD = Path(os.environ["THIMBLE_BUILD"])
HERE = Path(__file__).resolve().parent
SOURCE = HERE.parent.parent.parent
HOSTS = platform.freedesktop_os_release()["VERSION_CODENAME"]
RELEASE = os.environ.get("THIMBLE_RELEASE", HOSTS)
CLONE = Path("/srv/clone")  # in the root
CERTIFICATES = "/etc/ssl/certs/ca-certificates.crt"  # npm asks its registry; what this machine trusts may be more than Debian's


def run(*command, **options):
    print("+", *command, flush=True)
    subprocess.run([*map(str, command)], check=True, **options)


def output(*command):
    return subprocess.run([*map(str, command)], check=True, capture_output=True, text=True).stdout


def in_a_root(folder, packages, *steps):
    """A root with Debian's essential packages and these, in which the steps (hooks of mmdebstrap) are done. It is removed. folder: for its sources."""
    source = next(file for file in (Path("/etc/apt/sources.list"), Path("/etc/apt/sources.list.d/debian.sources")) if file.exists() and file.stat().st_size)
    sources = folder / source.name
    sources.write_text(re.sub(rf"\b{HOSTS}\b", RELEASE, source.read_text()))
    run("mmdebstrap", "--variant=apt", "--format=null", f"--include={','.join(sorted(packages))}", *[f"--customize-hook={step}" for step in steps],
        RELEASE, "-", sources)


def chroot(command, **variables):
    """A step: the command, with nothing of this machine's environment."""
    variables = {"PATH": "/usr/sbin:/usr/bin:/sbin:/bin", "HOME": "/root", "LANG": "C.UTF-8", "TERM": "xterm", "NODE_EXTRA_CA_CERTS": CERTIFICATES, **variables}
    return f'chroot "$1" env -i {shlex.join(f"{name}={value}" for name, value in variables.items())} {command}'


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
        made = cls.folder / "made"
        made.mkdir()
        names = [name for name in output("git", "-C", SOURCE, "ls-files", "-z").split("\0") if name and (SOURCE / name).exists()]
        archive = subprocess.run(["tar", "-C", SOURCE, "--null", "-T", "-", "-cf", "-"], check=True, input="\0".join(names).encode(), capture_output=True)
        subprocess.run(["tar", "-C", clone, "-xf", "-"], check=True, input=archive.stdout)
        epoch = re.search(r'CPACK_THIMBLE_EPOCH "(\d+)"', (BUILD / "CPackConfig.cmake").read_text())[1]
        line = re.search(r"`(scripts/make_packages) && sudo apt install (\S+)`", (clone / "README.md").read_text())
        steps = [f"copy-in {clone} {CLONE.parent}", f"copy-in {CERTIFICATES} {Path(CERTIFICATES).parent}"]
        if RELEASE == HOSTS:  # it configures the tests too, and those need the libraries of one release
            steps.append(chroot(CLONE / "demo"))
        built = (CLONE / line[2]).parent
        steps += [chroot(CLONE / line[1], SOURCE_DATE_EPOCH=epoch), f"copy-out {built} {made}",
                  chroot("apt-get --quiet install --no-install-recommends --yes lintian"),
                  chroot(f"sh -c 'lintian --allow-root --fail-on error,warning {built}/*.deb'")]
        in_a_root(cls.folder, {"ca-certificates"}, *steps)
        return made / built.name

    def test_which_there_are(self):
        self.assertEqual({fields(file, "Package")[0] for file in self.made}, {"libthimble-dev", "python3-thimble", "thimble", "thimble-board", "thimble-doc"})

    @unittest.skipUnless(RELEASE == HOSTS, "the packages of another release")
    def test_the_same_bytes(self):
        debs = self.folder / "debs"
        run(os.environ["CPACK"], "--config", BUILD / "CPackConfig.cmake", "-B", debs, stdout=subprocess.DEVNULL)
        made = {file.name: file.read_bytes() for file in self.made}
        here = {file.name: file.read_bytes() for file in debs.glob("*.deb")}
        self.assertGreaterEqual(len(here), 4)  # thimble-doc too, if this build has it
        self.assertEqual([name for name in here if made.get(name) != here[name]], [])

    def compile_and_simulate(self, folder):
        """What in_clean_root.sh does too."""
        folder.mkdir()
        thimble, scenes = BUILD / "bin/thimble", SOURCE / "scenes"
        for scene in scenes.glob("*/*.scene.json"):
            output(thimble, "compile", scene, "--output", folder / f"{scene.name.removesuffix('.scene.json')}.thim")
        for name in ("blocks", "ice"):
            output(thimble, "simulate", scenes / name / f"{name}.scene.json", "--path", scenes / name / "stroke.csv", "--log", folder / f"{name}.csv")

    def test_a_clean_root(self):
        ours = {fields(file, "Package")[0] for file in self.made}
        needed = {entry for file in self.made for name in ("Depends", "Recommends") for entry in fields(file, name)}
        wanted = {entry.split("|")[0].split("(")[0].strip() for entry in needed} - ours
        trial = self.folder / "trial"
        trial.mkdir()
        for file in (*self.made, HERE / "in_clean_root.sh", HERE / "tutorials.py"):
            shutil.copy(file, trial)
        shutil.copytree(HERE / "outside", trial / "outside")
        self.compile_and_simulate(trial / "here")
        in_a_root(self.folder, wanted | {"cmake", "g++", "man-db", "ninja-build"}, f"copy-in {trial} /tmp", chroot("sh /tmp/trial/in_clean_root.sh"))


if __name__ == "__main__":
    unittest.main()

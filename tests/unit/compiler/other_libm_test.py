#!/usr/bin/env python3
"""The image of a scene does not depend on the machine's libm: every demonstration compiled with a libm that rounds otherwise
(other_libm.cpp) gives the usual bytes.

other_libm_test.py THIMBLE LIBRARY
"""
import os
import pathlib
import subprocess
import sys
import tempfile

SCENES = pathlib.Path(__file__).resolve().parents[3] / "scenes"


def images(thimble, folder, **more):
    """By scene. The cache of solved potentials is the folder's own."""
    folder.mkdir()
    found = {}
    for scene in sorted(SCENES.glob("*/*.scene.json")):
        image = folder / "scene.thim"
        done = subprocess.run([thimble, "compile", scene, "--output", image], capture_output=True, text=True,
                              env=dict(os.environ, XDG_CACHE_HOME=str(folder / "cache"), **more))
        if done.returncode != 0:
            sys.exit(f"{scene}: {done.stderr}")
        if "LD_PRELOAD" in more and "other libm:" not in done.stderr:
            sys.exit(f"the other libm was not loaded: {done.stderr}")
        found[scene.name] = image.read_bytes()
    return found


def main():
    thimble, library = sys.argv[1:]
    with tempfile.TemporaryDirectory() as folder:
        usual = images(thimble, pathlib.Path(folder, "usual"))
        for phase in "01":
            other = images(thimble, pathlib.Path(folder, phase), LD_PRELOAD=library, OTHER_LIBM_PHASE=phase)
            differing = [name for name in usual if usual[name] != other[name]]
            if differing:
                sys.exit(f"with another libm these images differ: {', '.join(differing)}")
    print(f"{len(usual)} scenes, the same bytes with two other libms")


main()

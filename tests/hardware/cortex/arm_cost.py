#!/usr/bin/env python3
"""What the kinematics of each arm that comes with Thimble cost on the emulated Cortex-M7, in instructions: the table of docs/arm-format.md.

  arm_cost.py THIMBLE PLUGIN             prints the table; fails where the page has counts that are more than a hundredth off, in either direction
  arm_cost.py THIMBLE PLUGIN --update    writes it into the page

After cortex.build.mps2-an500. The counts are exact and the same on every machine; arm_cost_image.cpp has what is counted.
"""
import json
import pathlib
import re
import struct
import subprocess
import sys
import tempfile

import replays

BOARD = "mps2-an500"
PAGE = replays.HERE.parents[2] / "docs/arm-format.md"
BEGIN, END = "<!-- cost begin -->\n", "<!-- cost end -->\n"
TOLERANCE = 0.01
ENDS = {40: "the image crashed", 42: "the image of the arm was refused", 43: "a posture has no tip"}
HEAD = ("| arm | family | axes | position, Jacobian, weight: mean | most | torques of a force | together at most |\n"
        "|---|---|---|---|---|---|---|\n")


def instructions(thimble, plugin, model, folder):
    """Of each tick of the path: [of the pose], [of the torques]."""
    tarm, memory, counts = folder / "arm.tarm", folder / "arm.bin", folder / "counts"
    size = json.loads(subprocess.run([thimble, "model", "compile", model, "--output", tarm, "--json"],
                                     check=True, capture_output=True, text=True).stdout)["bytes"]
    memory.write_bytes(struct.pack("<II", size, 0) + tarm.read_bytes())
    elf = replays.BUILD / BOARD / "bin" / f"arms-{BOARD}.elf"
    command = [part.format(elf=elf, recording=memory) for part in replays.QEMU[BOARD]]
    command += ["-display", "none", "-monitor", "none", "-serial", "none", "-nodefaults", "-semihosting-config", "enable=on,target=native", "-plugin",
                f"file={plugin.absolute()},begin={replays.address_of(elf, 'tick_begin')},end={replays.address_of(elf, 'tick_end')},csv={counts}"]
    run = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=120)
    if run.returncode != 0:
        raise replays.Failed(f"{model}: {ENDS.get(run.returncode, 'QEMU failed')} (exit code {run.returncode})\n{run.stderr}")
    nothing, *passages = (int(line) for line in counts.read_text().split())
    return [count - nothing for count in passages[::2]], [count - nothing for count in passages[1::2]]


def row(thimble, plugin, model, folder):
    told = json.loads(subprocess.run([thimble, "model", "show", model, "--json"], check=True, capture_output=True, text=True).stdout)
    pose, torques = instructions(thimble, plugin, model, folder)
    return "| `%s` | %s | %d | %d | %d | %d | %d |\n" % (told["name"], told["family"], len(told["axes"]), round(sum(pose) / len(pose)), max(pose),
                                                        max(torques), max(a + b for a, b in zip(pose, torques)))


def numbers(line):
    return [int(word) for word in re.findall(r"\| (\d+)(?= \|)", line)]


def main():
    thimble, plugin = sys.argv[1], pathlib.Path(sys.argv[2])
    models = json.loads(subprocess.run([thimble, "model", "list", "--json"], check=True, capture_output=True, text=True).stdout)["models"]
    with tempfile.TemporaryDirectory() as folder:
        rows = [row(thimble, plugin, model["file"], pathlib.Path(folder)) for model in models]
    print(HEAD + "".join(rows), end="")
    before, rest = PAGE.read_text().split(BEGIN)
    old, after = rest.split(END)
    if "--update" in sys.argv:
        PAGE.write_text(before + BEGIN + HEAD + "".join(rows) + END + after)
        return
    lines = old.removeprefix(HEAD).splitlines(keepends=True)
    for ours, theirs in zip(rows, lines):
        a, b = numbers(ours), numbers(theirs)
        if ours.split("|")[1:3] != theirs.split("|")[1:3] or len(a) != len(b) or any(abs(x - y) > TOLERANCE * y for x, y in zip(a, b)):
            raise replays.Failed(f"{PAGE} has\n{theirs}the count is\n{ours}If that is meant, repeat this with --update.")
    if len(rows) != len(lines):
        raise replays.Failed(f"{PAGE} has {len(lines)} arms, and {len(rows)} come with Thimble: repeat this with --update")


if __name__ == "__main__":
    try:
        main()
    except replays.Failed as failure:
        sys.exit(f"arm_cost: {failure}")

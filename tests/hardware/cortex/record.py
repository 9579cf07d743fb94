#!/usr/bin/env python3
"""Records a scene for the replays: under its own hand, and along the path that find_worst found.

  record.py SCENE RECORDER OUT
"""
import pathlib
import sys

import replays


def seed_of(name):
    for line in (replays.HERE / "worst.seeds").read_text().splitlines():
        if line.split()[:1] == [name]:
            return line.split()[1]
    sys.exit(f"record: {name} has no row in worst.seeds: run tests/hardware/cortex/find_worst")


def main():
    name, recorder, out = sys.argv[1:4]
    pathlib.Path(out).mkdir(exist_ok=True)
    scene_file, stroke = replays.scenes()[name]
    try:
        print(replays.record(recorder, scene_file, stroke, replays.TICKS, f"{out}/{name}.stroke"))
        print(replays.record(recorder, scene_file, f"wander:{seed_of(name)}", replays.WORST_TICKS, f"{out}/{name}.worst"))
    except replays.Failed as failure:
        sys.exit(f"record: {name}: {failure}")


if __name__ == "__main__":
    main()

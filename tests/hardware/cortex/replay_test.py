#!/usr/bin/env python3
"""A recorded run on an emulated board: the forces are those of this machine, byte for byte, the instructions a tick are those of
ticks.baseline within a hundredth, in both directions, and the estimates of board/sim/tick_cost.h are within what docs/time.md says.

  replay_test.py BOARD SCENE RECORDINGS PLUGIN [--update]
  replay_test.py BOARD --fast RECORDER PLUGIN               some scenes at 20 kHz, without a baseline

--update writes the rows seen into ticks.baseline instead of comparing them.
"""
import fcntl
import pathlib
import sys
import tempfile

import replays

BASELINE = replays.HERE / "ticks.baseline"
BUDGET = 40_000  # instructions a tick: 10 kHz on a core of 480 MHz, half of the time spare
TOLERANCE = 0.01
MEAN_FACTOR = 1.3  # of the estimate, both ways
WORST_FACTORS = (0.95, 2.0)  # of the estimate of the worst tick over the count


def rows():
    return {tuple(line.split()[:3]): [int(word) for word in line.split()[3:]]
            for line in BASELINE.read_text().splitlines() if line and not line.startswith("#")}


def write_rows(new):
    with open(BASELINE, "r+") as file:
        fcntl.flock(file, fcntl.LOCK_EX)  # the tests of other scenes write beside us
        comments = [line for line in file if line.startswith("#")]
        all_rows = rows() | new
        file.seek(0)
        file.truncate()
        file.writelines(comments)
        for key in sorted(all_rows):
            file.write("%-11s %-18s %-7s %6d %6d %6d\n" % (*key, *all_rows[key]))


def check_estimates(board, recording, counts):
    column = list(replays.QEMU).index(board)
    both = [(count, row[column]) for count, row in zip(counts, replays.cost_rows(recording)) if row]
    mean = sum(estimate for _, estimate in both) / sum(count for count, _ in both)
    worst = replays.worst(max(estimate for _, estimate in both)) / max(count for count, _ in both)
    print("[ figure ] %s %s: estimate over count: mean %.2f (%.2f to %.2f), worst tick %.2f (%.2f to %.2f)" % (
        board, recording.stem, mean, 1 / MEAN_FACTOR, MEAN_FACTOR, worst, *WORST_FACTORS))
    if not 1 / MEAN_FACTOR <= mean <= MEAN_FACTOR or not WORST_FACTORS[0] <= worst <= WORST_FACTORS[1]:
        raise replays.Failed(f"{board} {recording.stem}: the estimates are off. If the tick has changed, run fit_cost and take its constants.")


def checked(board, recording, plugin):
    """Its instructions a tick: least, mean, most."""
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        counts = replays.replay(board, recording, plugin, folder)
        ours, theirs = recording.with_suffix(".forces").read_bytes(), (folder / "forces.bin").read_bytes()
    if ours != theirs:
        at = next((i for i, (a, b) in enumerate(zip(ours, theirs)) if a != b), min(len(ours), len(theirs)))
        raise replays.Failed(f"{recording.stem}: the forces differ from byte {at} on ({len(ours)} and {len(theirs)} bytes)")
    check_estimates(board, recording, counts)
    found = [min(counts), round(sum(counts) / len(counts)), max(counts)]
    print("[ figure ] %s %s: %d ticks alike byte for byte; instructions a tick: min %d, mean %d, max %d%s" % (
        board, recording.stem, len(counts), *found, "" if max(counts) <= BUDGET else " (over the budget of %d)" % BUDGET))
    return found


def seen(board, name, recordings, plugin):
    return {(board, name, run): checked(board, recordings / f"{name}.{run}.rec", plugin) for run in ("stroke", "worst")}


def fast(board, recorder, plugin):
    for name in replays.FAST:
        with tempfile.TemporaryDirectory() as folder:
            out = pathlib.Path(folder) / f"{name}.{replays.FAST_HZ}"
            replays.record(recorder, *replays.scenes()[name], replays.FAST_TICKS, out, replays.FAST_HZ)
            checked(board, pathlib.Path(f"{out}.rec"), plugin)


def compare(found):
    known = rows()
    for key, now in found.items():
        before = known.get(key)
        if before is None:
            raise replays.Failed(f"{' '.join(key)} is not in {BASELINE.name}: run with --update")
        for what, a, b in zip(("min", "mean", "max"), before, now):
            if abs(b - a) > TOLERANCE * a:
                raise replays.Failed(f"{' '.join(key)}: {what} is {b} instructions a tick, the baseline says {a}. "
                                     "If the change is meant, run with --update and commit the rows.")


def main():
    board, name, recordings, plugin = sys.argv[1:5]
    try:
        if name == "--fast":
            return fast(board, recordings, plugin)
        found = seen(board, name, pathlib.Path(recordings), plugin)
        if "--update" in sys.argv:
            write_rows(found)
        else:
            compare(found)
    except replays.Failed as failure:
        sys.exit(f"replay_test: {failure}")


if __name__ == "__main__":
    main()

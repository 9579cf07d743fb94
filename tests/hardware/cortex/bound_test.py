#!/usr/bin/env python3
"""No accepted scene and no motion makes a tick longer than docs/time.md says: scenes that are made to cost much, each a random composition
of solids that cross each other, under a fingertip that darts about in them, on an emulated board.

  bound_test.py BOARD SCENES FIRST_SEED RECORDER PLUGIN
"""
import json
import math
import pathlib
import random
import sys
import tempfile

import replays

# Instructions a tick: what docs/time.md sums up.
BOUND = 120_000
TICKS = 6000


def soup(path, dice, solids, size_m):
    """Closed tetrahedra that cross each other, in one mesh."""
    with open(path, "w") as file:
        for solid in range(solids):
            middle = [dice.uniform(-1.0, 1.0) * size_m for _ in range(3)]
            corners = [[middle[axis] + size_m * dice.uniform(0.3, 1.0) * sign for axis, sign in enumerate(signs)]
                       for signs in ((1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1))]
            for corner in corners:
                file.write("v {:.6f} {:.6f} {:.6f}\n".format(*corner))
            first = 4 * solid + 1
            for a, b, c in ((0, 1, 2), (0, 3, 1), (0, 2, 3), (1, 3, 2)):
                file.write(f"f {first + a} {first + b} {first + c}\n")


def balls(path, dice, count, radius_m):
    """Balls of 98 corners apart from each other, in one mesh: each is a convex piece of a body."""
    rings, around = 9, 12
    with open(path, "w") as file:
        for ball in range(count):
            middle = [3 * radius_m * (ball % 3), 3 * radius_m * (ball // 3 % 3), 3 * radius_m * (ball // 9)]
            turn = dice.uniform(0, math.pi)
            places = [(0, 0, 1)] + [(math.sin(math.pi * ring / rings) * math.cos(turn + 2 * math.pi * i / around),
                                     math.sin(math.pi * ring / rings) * math.sin(turn + 2 * math.pi * i / around), math.cos(math.pi * ring / rings))
                                    for ring in range(1, rings) for i in range(around)] + [(0, 0, -1)]
            for place in places:
                file.write("v {:.6f} {:.6f} {:.6f}\n".format(*(m + radius_m * p for m, p in zip(middle, place))))
            first, last = 98 * ball + 1, 98 * ball + 98
            at = lambda ring, i: first + 1 + around * ring + i % around
            for i in range(around):
                file.write(f"f {first} {at(0, i)} {at(0, i + 1)}\nf {last} {at(rings - 2, i + 1)} {at(rings - 2, i)}\n")
                for ring in range(rings - 2):
                    file.write(f"f {at(ring, i)} {at(ring + 1, i)} {at(ring + 1, i + 1)}\nf {at(ring, i)} {at(ring + 1, i + 1)} {at(ring, i + 1)}\n")


def on_tissue(folder, dice):
    """Bodies of many corners, sunk into pads of tissue that cross each other."""
    objects = []
    for n in range(4):
        balls(folder / f"balls{n}.obj", dice, dice.randint(4, 10), 0.004)
    for n in range(6):
        objects.append({"name": f"pad {n}", "shape": {"tissue": {"size_m": [0.4, 0.4], "contact_radius_m": 0.01, "relaxed_stiffness_N_m": 40,
                                                                 "recovery_s": 0.2}},
                        "pose": {"position_m": [0, 0, dice.uniform(0, 0.03)], "rotation_deg": [dice.uniform(-10, 10), dice.uniform(-10, 10), 0]}, "material": "soft"})
    for n in range(16):
        objects.append({"name": f"solid {n}", "shape": {"mesh": {"file": f"balls{n % 4}.obj"}}, "material": dice.choice(("hard", "soft", "ice")),
                        "pose": {"position_m": [0.05 * (n % 4) - 0.1, 0.05 * (n // 4) - 0.1, dice.uniform(-0.02, 0.02)],
                                 "rotation_deg": [dice.uniform(-180, 180) for _ in range(3)]},
                        "body": {"motion": "free", "mass_kg": dice.uniform(0.05, 0.3)}})
    return objects


def crossing(folder, dice, kind):
    objects = [{"name": "floor", "shape": {"plane": {"normal": [0, 0, 1], "offset_m": -0.05}}, "material": "hard"}]
    for n in range(dice.randint(3, 6)):
        soup(folder / f"soup{n}.obj", dice, dice.randint(5, 60), dice.choice((0.01, 0.02, 0.04)))
    meshes = sorted(folder.glob("soup*.obj"))
    shapes = [lambda: {"mesh": {"file": dice.choice(meshes).name, **({"crease_deg": 40} if kind == "everything" and dice.random() < 0.5 else {})}},
              lambda: {"box": {"size_m": [dice.uniform(0.01, 0.06) for _ in range(3)]}},
              lambda: {"sphere": {"radius_m": dice.uniform(0.005, 0.03)}},
              lambda: {"cylinder": {"radius_m": dice.uniform(0.005, 0.03), "height_m": dice.uniform(0.01, 0.06)}}]
    for n in range({"meshes": 24, "bodies": 16, "everything": 20}[kind]):
        one = {"name": f"solid {n}", "shape": (shapes[0] if kind == "meshes" else dice.choice(shapes))(),
               "pose": {"position_m": [dice.uniform(-0.03, 0.03) for _ in range(3)], "rotation_deg": [dice.uniform(-180, 180) for _ in range(3)]},
               "material": dice.choice(("hard", "soft", "ice"))}
        if kind == "bodies" or (kind == "everything" and n < 8):
            one["body"] = {"motion": dice.choice(("free", "free", "translate")), "mass_kg": dice.uniform(0.02, 0.3), "restitution": dice.uniform(0.0, 0.8)}
        objects.append(one)
    return objects


def composition(folder, seed):
    """A scene of one of four kinds, in turn: crossing meshes, bodies in a heap, everything, bodies on tissue."""
    dice = random.Random(seed)
    kind = ("meshes", "bodies", "everything", "tissue")[seed % 4]
    objects = on_tissue(folder, dice) if kind == "tissue" else crossing(folder, dice, kind)
    scene = {"thimble_scene": 1, "name": f"hostile {seed}", "gravity_m_s2": [0, 0, -9.81], "objects": objects,
             "materials": {"hard": {"stiffness_N_m": 2000, "damping_N_s_m": 2, "static_friction": 0.8, "dynamic_friction": 0.3},
                           "soft": {"stiffness_N_m": 300, "damping_N_s_m": 1, "static_friction": 0.4, "dynamic_friction": 0.4},
                           "ice": {"stiffness_N_m": 1000, "static_friction": 0, "dynamic_friction": 0}}}
    file = folder / "hostile.scene.json"
    file.write_text(json.dumps(scene))
    return kind, file


def main():
    board, scenes, first, recorder, plugin = sys.argv[1], int(sys.argv[2]), int(sys.argv[3]), sys.argv[4], sys.argv[5]
    failed = []
    for seed in range(first, first + scenes):
        with tempfile.TemporaryDirectory() as folder:
            folder = pathlib.Path(folder)
            kind, file = composition(folder, seed)
            replays.record(recorder, file, f"wander:{seed}", TICKS, folder / "run")
            counts = replays.replay(board, folder / "run.rec", plugin, folder)
            alike = (folder / "forces.bin").read_bytes() == (folder / "run.forces").read_bytes()
        print(f"[ figure   ] {board}, {kind}, seed {seed}: mean {sum(counts) // len(counts)}, max {max(counts)} instructions a tick"
              f"   (at most {BOUND}){'' if alike else ', other forces than on this machine'}", flush=True)
        if max(counts) > BOUND or not alike:
            failed.append(seed)
    if failed:
        sys.exit(f"over the bound, or other forces: seeds {failed}")


if __name__ == "__main__":
    main()

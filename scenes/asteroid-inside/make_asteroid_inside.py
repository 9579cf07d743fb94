#!/usr/bin/env python3
"""Makes stroke.csv beside this script. Python 3, standard library only; the same bytes each time.

The cave is the asteroid of scenes/asteroid, half as large again and touched from inside. The stroke goes round its wall on a
rising and falling way, with its target 4 mm behind the wall.
"""

import math
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
from strokes import load_asteroid, write_stroke  # noqa: E402

FOLDER = pathlib.Path(__file__).resolve().parent
SCALE = 1.5  # of asteroid-inside.scene.json, against the asteroid's own
DEEPER_M = 0.004


def wall_m(asteroid, points, faces, direction):
    """How far the wall is from the middle, in a direction."""
    for face in faces:
        a, b, c = ([SCALE * asteroid.UNIT_M * v for v in points[i]] for i in face)
        normal = asteroid.cross(asteroid.subtract(b, a), asteroid.subtract(c, a))
        along = asteroid.dot(normal, direction)
        if along <= 0.0:
            continue
        far = asteroid.dot(normal, a) / along
        at = [far * d for d in direction]
        if all(asteroid.dot(asteroid.cross(asteroid.subtract(q, p), asteroid.subtract(at, p)), normal) >= -1e-18
               for p, q in ((a, b), (b, c), (c, a))):
            return far
    raise ValueError("the asteroid is open")


def main():
    asteroid = load_asteroid()
    directions, faces = asteroid.icosphere(2)
    points = [asteroid.surface(d) for d in directions]
    rows = [(0.0, 0.0, 0.0, 0.0)]
    count = 120
    for i in range(count + 1):
        turn = 4.0 * math.pi * i / count
        height = 0.75 * math.sin(2.0 * math.pi * i / count)
        level = math.sqrt(1.0 - height * height)
        direction = (level * math.cos(turn), level * math.sin(turn), height)
        wall = wall_m(asteroid, points, faces, direction)
        if i == 0:
            rows.append((0.6, *((wall - 0.005) * d for d in direction)))
        rows.append((1.0 + 0.07 * i, *((wall + DEEPER_M) * d for d in direction)))
    rows.append((rows[-1][0] + 0.6, 0.0, 0.0, 0.0))
    write_stroke(FOLDER / "stroke.csv", rows)


if __name__ == "__main__":
    main()

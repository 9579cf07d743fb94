#!/usr/bin/env python3
"""Makes ball.obj and stroke.csv, the files beside this script. Python 3, standard library only; the same bytes each time.

The ball is an icosphere of 80 triangles with a radius of 30 mm: with its normals interpolated it feels round. The asteroid
is that of scenes/asteroid. The stroke goes to and fro over the asteroid, which stands on the left, then round on the ball.
"""

import math
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
from strokes import load_asteroid, write_stroke  # noqa: E402

FOLDER = pathlib.Path(__file__).resolve().parent
ASTEROID_M = (-0.045, 0.0, -0.055)  # where smooth.scene.json puts them
BALL_M = (0.045, 0.0, -0.055)
RADIUS_M = 0.03


def stroke(asteroid):
    directions, faces = asteroid.icosphere(2)
    points = [asteroid.surface(d) for d in directions]
    rows = [(0.0, 0.0, 0.0, 0.0), (0.4, ASTEROID_M[0], 0.0, 0.0)]
    begin, step = 1.2, 0.05
    for i in range(81):
        x = 0.020 * math.sin(2.0 * math.pi * i * step / 4.0)
        y = 0.010 * math.sin(2.0 * math.pi * i * step / 2.5)
        z = asteroid.height_m(points, faces, x, y) - 0.004
        if i == 0:
            rows.append((begin - 0.4, ASTEROID_M[0], 0.0, z + 0.008))
        rows.append((begin + i * step, x + ASTEROID_M[0], y, z))
    time = rows[-1][0]
    rows += [(time + 0.3, rows[-1][1], rows[-1][2], 0.0), (time + 0.8, BALL_M[0] + 0.012, 0.0, 0.0)]
    begin = time + 1.4
    for i in range(81):
        lean = 0.35 + 0.35 * i / 80  # from the top outwards, twice round
        turn = 4.0 * math.pi * i / 80
        direction = (math.sin(lean) * math.cos(turn), math.sin(lean) * math.sin(turn), math.cos(lean))
        if i == 0:
            rows.append((begin - 0.3, *(m + (RADIUS_M + 0.005) * d for m, d in zip(BALL_M, direction))))
        rows.append((begin + i * step, *(m + (RADIUS_M - 0.004) * d for m, d in zip(BALL_M, direction))))
    rows += [(rows[-1][0] + 0.3, rows[-1][1], rows[-1][2], 0.0), (rows[-1][0] + 0.7, 0.0, 0.0, 0.0)]
    return rows


def main():
    asteroid = load_asteroid()
    points, faces = asteroid.icosphere(1)
    lines = ["# An icosphere of 80 triangles, radius 30 mm; one unit is 1 mm. Made by make_smooth.py"]
    lines += ["v %.6f %.6f %.6f" % tuple(1000.0 * RADIUS_M * c for c in p) for p in points]
    lines += ["f %d %d %d" % tuple(i + 1 for i in face) for face in faces]
    (FOLDER / "ball.obj").write_text("\n".join(lines) + "\n", encoding="ascii")
    write_stroke(FOLDER / "stroke.csv", stroke(asteroid))


if __name__ == "__main__":
    main()

#!/usr/bin/env python3
"""Makes asteroid.plg and stroke.csv, the files beside this script. Python 3, standard library only; the same bytes each time.

The asteroid is a lumpy body of 320 facets, about 73 x 60 x 54 mm, with craters: a REND386 polygon file in units of
10 micrometres, left-handed (its z is ours negated), as the paper's asteroid came. The stroke is a hand that comes down on
its upper side, strokes it to and fro with its target 5 mm below the surface, and lifts off again.
"""

import math
import pathlib

UNIT_M = 1.0e-5
AXES_M = (0.036, 0.029, 0.026)
CENTRE_M = (0.0, 0.0, -0.055)  # where asteroid.scene.json puts it
# direction, angular width in radians, depth (below zero: a lump) as a share of the radius
DENTS = (
    ((0.25, -0.35, 0.90), 0.55, 0.22),
    ((-0.70, 0.20, 0.65), 0.45, 0.17),
    ((0.80, 0.50, 0.30), 0.50, 0.20),
    ((-0.20, 0.90, -0.10), 0.60, 0.24),
    ((0.10, -0.90, -0.40), 0.45, 0.18),
    ((-0.60, -0.50, -0.60), 0.55, 0.20),
    ((0.50, 0.20, -0.80), 0.50, 0.22),
    ((-0.25, -0.55, 0.75), 0.40, -0.16),
    ((0.75, -0.45, 0.35), 0.45, -0.15),
    ((0.05, 0.60, 0.75), 0.45, -0.14),
)


def normalized(v):
    length = math.sqrt(sum(x * x for x in v))
    return tuple(x / length for x in v)


def subtract(a, b):
    return tuple(x - y for x, y in zip(a, b))


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def icosphere(subdivisions):
    g = (1.0 + math.sqrt(5.0)) / 2.0
    points = [(-1, g, 0), (1, g, 0), (-1, -g, 0), (1, -g, 0), (0, -1, g), (0, 1, g),
              (0, -1, -g), (0, 1, -g), (g, 0, -1), (g, 0, 1), (-g, 0, -1), (-g, 0, 1)]
    faces = [(0, 11, 5), (0, 5, 1), (0, 1, 7), (0, 7, 10), (0, 10, 11), (1, 5, 9), (5, 11, 4),
             (11, 10, 2), (10, 7, 6), (7, 1, 8), (3, 9, 4), (3, 4, 2), (3, 2, 6), (3, 6, 8),
             (3, 8, 9), (4, 9, 5), (2, 4, 11), (6, 2, 10), (8, 6, 7), (9, 8, 1)]
    points = [normalized(p) for p in points]
    for _ in range(subdivisions):
        middle = {}

        def split(a, b):
            key = (min(a, b), max(a, b))
            if key not in middle:
                middle[key] = len(points)
                points.append(normalized(tuple(x + y for x, y in zip(points[a], points[b]))))
            return middle[key]

        finer = []
        for a, b, c in faces:
            ab, bc, ca = split(a, b), split(b, c), split(c, a)
            finer += [(a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca)]
        faces = finer
    return points, faces


def surface(direction):
    """The asteroid's surface in a direction, in whole units."""
    share = 1.0
    for where, width, depth in DENTS:
        angle = math.acos(max(-1.0, min(1.0, dot(direction, normalized(where)))))
        if angle < width:
            share -= depth * 0.5 * (1.0 + math.cos(math.pi * angle / width))
    x, y, z = direction
    share += 0.05 * math.sin(5.0 * x + 1.0) * math.sin(6.0 * y + 2.0) + 0.04 * math.sin(7.0 * z - 3.0 * x)
    return tuple(round(share * axis * d / UNIT_M) for axis, d in zip(AXES_M, direction))


def height_m(points, faces, x, y):
    """The world's z of the upper side below (x, y)."""
    top = None
    for face in faces:
        a, b, c = (tuple(v * UNIT_M + o for v, o in zip(points[i], CENTRE_M)) for i in face)
        normal = cross(subtract(b, a), subtract(c, a))
        if abs(normal[2]) < 1e-12:
            continue
        inside = all(
            cross(subtract(q, p), (x - p[0], y - p[1], 0.0))[2] * normal[2] >= 0.0 for p, q in ((a, b), (b, c), (c, a)))
        if inside:
            z = a[2] - (normal[0] * (x - a[0]) + normal[1] * (y - a[1])) / normal[2]
            top = z if top is None else max(top, z)
    return top


def stroke(points, faces):
    """Rows of time and place: home, down, to and fro over the upper side, up, home."""
    rows = [(0.0, 0.0, 0.0, 0.0), (0.5, 0.0, 0.0, 0.0)]
    begin, length, step = 1.4, 4.0, 0.05
    for i in range(int(length / step) + 1):
        t = i * step
        x = 0.020 * math.sin(2.0 * math.pi * t / 4.0)
        y = 0.010 * math.sin(2.0 * math.pi * t / 2.5)
        z = height_m(points, faces, x, y) - 0.005
        if i == 0:
            rows.append((begin - 0.4, x, y, z + 0.008))
        rows.append((begin + t, x, y, z))
    rows.append((begin + length + 0.3, rows[-1][1], rows[-1][2], 0.0))
    rows.append((begin + length + 0.8, 0.0, 0.0, 0.0))
    return rows


def main():
    folder = pathlib.Path(__file__).resolve().parent
    directions, faces = icosphere(2)
    points = [surface(d) for d in directions]
    lines = ["# An asteroid for REND386, made by make_asteroid.py. One unit is 10 micrometres.",
             f"asteroid {len(points)} {len(faces)}",
             "# vertices: left-handed, z into the screen"]
    lines += [f"{x} {y} {-z}" for x, y, z in points]
    lines.append("# facets: colour, number of points, points counter-clockwise as seen from outside")
    lines += [f"{0x1100 + 17 * (i % 8):#06x} 3 {a} {b} {c}" for i, (a, b, c) in enumerate(faces)]
    (folder / "asteroid.plg").write_text("\n".join(lines) + "\n", encoding="ascii")
    rows = ["time_s,x_m,y_m,z_m"] + ["%.2f,%.6f,%.6f,%.6f" % row for row in stroke(points, faces)]
    (folder / "stroke.csv").write_text("\n".join(rows).replace("-0.000000", "0.000000") + "\n", encoding="ascii")


if __name__ == "__main__":
    main()

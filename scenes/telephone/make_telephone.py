#!/usr/bin/env python3
"""Makes heights_mm.csv and stroke.csv, the files beside this script. Python 3, standard library only; the same bytes each time.

Heights of a desk telephone above the table, in tenths of a millimetre on a grid of 2 mm, as one would measure them with a
gauge: a body that rises to the back, twelve keys, and the handset across its back with its two round cups. The first line is
the back. The stroke runs along a row of keys, down a column of them, up the body and along the handset.
"""

import math
import pathlib

STEP_MM = 2.0
SIDE = 76  # points along x and y: 150 mm
TOP_M = -0.070  # where telephone.scene.json puts the table
KEYS_X_MM = (-28.0, -8.0, 12.0)
KEYS_Y_MM = (-58.0, -42.0, -26.0, -10.0)
KEY_MM = (12.0, 9.0, 4.0)  # width, depth, rise
HANDSET_Y_MM = 38.0


def smooth(low, high, value):
    """0 below low, 1 above high, and a smooth step between."""
    t = max(0.0, min(1.0, (value - low) / (high - low)))
    return t * t * (3.0 - 2.0 * t)


def body(x, y):
    """A wedge with rounded rims, 16 mm high in front and 32 mm at the back."""
    rim = min(75.0 - abs(x), 75.0 - abs(y))
    return (16.0 + 16.0 * smooth(-60.0, 60.0, y)) * (0.35 + 0.65 * smooth(0.0, 6.0, rim))


def keys(x, y):
    width, depth, rise = KEY_MM
    dx = min(abs(x - key) for key in KEYS_X_MM)
    dy = min(abs(y - key) for key in KEYS_Y_MM)
    top = rise - 0.6 * max(0.0, 1.0 - math.hypot(dx / 5.0, dy / 4.0))  # a dish for the fingertip
    return top * (1.0 - smooth(width / 2 - 1.0, width / 2 + 1.0, dx)) * (1.0 - smooth(depth / 2 - 1.0, depth / 2 + 1.0, dy))


def handset(x, y):
    """Above the table: a round bar, thicker where the cups are."""
    dy = y - HANDSET_Y_MM
    bar = 50.0 - 22.0 * (dy / 16.0)**2 if abs(x) < 66.0 and abs(dy) < 16.0 else 0.0
    cup = 0.0
    for middle in (-48.0, 48.0):
        r = math.hypot(x - middle, dy)
        if r < 23.0:
            cup = 57.0 - 20.0 * (r / 23.0)**4 - 2.5 * (1.0 - smooth(6.0, 10.0, r))  # with a hollow in the middle
    return max(bar, cup)


def height_mm(x, y):
    return round(max(body(x, y) + keys(x, y), handset(x, y)), 1)


def surface_m(x_mm, y_mm):
    """The world's z of the grid there, linear between its points as far as a stroke needs it."""
    i, j = (min(int((v + 75.0) / STEP_MM), SIDE - 2) for v in (x_mm, y_mm))
    u, v = (x_mm + 75.0) / STEP_MM - i, (y_mm + 75.0) / STEP_MM - j
    at = lambda a, b: height_mm(STEP_MM * a - 75.0, STEP_MM * b - 75.0)
    z = (1 - v) * ((1 - u) * at(i, j) + u * at(i + 1, j)) + v * ((1 - u) * at(i, j + 1) + u * at(i + 1, j + 1))
    return TOP_M + 0.001 * z


def stroke():
    """Rows of time and place: over the keys, up the body, along the handset; the target 3 mm below the surface."""
    legs = (((-38.0, -42.0), (24.0, -42.0), 2.0), ((12.0, -64.0), (12.0, -2.0), 2.0), ((12.0, -2.0), (-60.0, 38.0), 1.4),
            ((-60.0, 38.0), (60.0, 38.0), 2.2))
    rows = [(0.0, 0.0, 0.0, 0.0)]
    time = 0.8
    for leg, (start, end, seconds) in enumerate(legs):
        if leg in (0, 1):  # these begin with a landing
            rows.append((time, 0.001 * start[0], 0.001 * start[1], surface_m(*start) + 0.008))
            time += 0.4
        steps = int(seconds / 0.02)
        for i in range(steps + 1):
            part = i / steps
            x, y = (a + part * (b - a) for a, b in zip(start, end))
            if not (leg > 1 and i == 0):  # the leg before ends there
                rows.append((time, 0.001 * x, 0.001 * y, surface_m(x, y) - 0.003))
            time += 0.02
        if leg != 1:
            time -= 0.02
        if leg == 0:
            rows.append((time + 0.3, 0.001 * end[0], 0.001 * end[1], surface_m(*end) + 0.01))
            time += 0.7
    rows.append((time + 0.4, rows[-1][1], rows[-1][2], 0.0))
    rows.append((time + 0.8, 0.0, 0.0, 0.0))
    return rows


def main():
    folder = pathlib.Path(__file__).resolve().parent
    at = [STEP_MM * i - 75.0 for i in range(SIDE)]
    lines = ["# A desk telephone: mm above the table, every 2 mm; the first line is the back. Made by make_telephone.py"]
    lines += [",".join("%.1f" % height_mm(x, y) for x in at) for y in reversed(at)]
    (folder / "heights_mm.csv").write_text("\n".join(lines) + "\n", encoding="ascii")
    rows = ["time_s,x_m,y_m,z_m"] + ["%.2f,%.6f,%.6f,%.6f" % row for row in stroke()]
    (folder / "stroke.csv").write_text("\n".join(rows).replace("-0.000000", "0.000000") + "\n", encoding="ascii")


if __name__ == "__main__":
    main()

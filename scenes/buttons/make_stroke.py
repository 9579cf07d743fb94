#!/usr/bin/env python3
"""Makes stroke.csv beside this script: a hand that operates every control of buttons.scene.json. Python 3, standard library
only; the same bytes each time."""

import math
import pathlib

OVER_M = -0.005  # above everything on the panel
HANDLE_Z_M = -0.035

path = []


def go(seconds, x, y, z):
    path.append((path[-1][0] + seconds if path else 0.0, x, y, z))


def press(x, y, aim_z):
    go(0.22, x, y, OVER_M)
    go(0.12, x, y, -0.029)
    go(0.30, x, y, aim_z)
    go(0.25, x, y, -0.029)
    go(0.10, x, y, OVER_M)


def turn(centre, radius, behind, begin_deg, end_deg, seconds):
    """Along an arc about the axis, `behind` the middle of a handle that points along x at 0 degrees."""
    cx, cy = centre

    def at(degrees):
        a = math.radians(degrees)
        return cx + radius * math.cos(a) + behind * math.sin(a), cy + radius * math.sin(a) - behind * math.cos(a)

    x, y = at(begin_deg)
    go(0.25, x, y, OVER_M)
    go(0.15, x, y, HANDLE_Z_M)
    steps = 24
    for i in range(1, steps + 1):
        x, y = at(begin_deg + (end_deg - begin_deg) * i / steps)
        go(seconds / steps, x, y, HANDLE_Z_M)
    go(0.12, x, y, OVER_M)


go(0.0, 0.0, 0.0, OVER_M)
go(0.1, -0.06, 0.02, OVER_M)
# The push buttons: their tops are at -31 mm; hand and surface give way by some 4 mm a newton together.
press(-0.095, 0.035, -0.043)
press(-0.065, 0.035, -0.0435)
press(-0.035, 0.035, -0.043)
# The toggle: over, and back.
go(0.20, 0.0, 0.035, OVER_M)
go(0.12, 0.0, 0.035, -0.022)
go(0.45, 0.029, 0.035, -0.022)
go(0.12, 0.042, 0.035, OVER_M)
go(0.10, 0.042, 0.035, -0.022)
go(0.45, 0.011, 0.035, -0.022)
go(0.12, -0.002, 0.035, OVER_M)
# The rotary switch, three notches on; the knob, six; both pushed near the end of the handle.
turn((0.081, 0.03), 0.020, 0.010, -25.0, 103.0, 0.9)
turn((-0.07, -0.04), 0.018, 0.010, -25.0, 103.0, 1.2)
# The dial: a fingertip pressed on its top, 13 mm from the middle, takes it round by friction.
go(0.25, 0.013, -0.04, OVER_M)
go(0.15, 0.013, -0.04, -0.031)
go(0.15, 0.013, -0.04, -0.038)
for step in range(1, 25):
    angle = math.radians(120.0 * step / 24)
    go(0.04, 0.013 * math.cos(angle), -0.04 + 0.013 * math.sin(angle), -0.038)
go(0.12, -0.0065, -0.0287, OVER_M)
# The fader: from notch to notch to the right.
go(0.25, 0.045, -0.04, OVER_M)
go(0.15, 0.045, -0.04, HANDLE_Z_M)
go(0.90, 0.088, -0.04, HANDLE_Z_M)
go(0.15, 0.080, -0.04, OVER_M)
go(0.30, 0.0, 0.0, OVER_M)

lines = ["time_s,x_m,y_m,z_m"] + ["%.3f,%.6f,%.6f,%.6f" % point for point in path]
(pathlib.Path(__file__).parent / "stroke.csv").write_text("\n".join(lines) + "\n")

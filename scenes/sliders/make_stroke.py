#!/usr/bin/env python3
"""Makes stroke.csv beside this script: a hand that pushes each slider of sliders.scene.json aside and lets it go. Python 3,
standard library only; the same bytes each time."""

import pathlib

HANDLE_Z_M = -0.032
OVER_M = 0.0  # above the handles
ROWS_Y_M = (-0.048, -0.016, 0.016, 0.048)
AIMS_M = (0.028, 0.026, 0.020, 0.022)  # where the hand wants to push to: the stiffer, the less far

path = []


def go(seconds, x, y, z):
    path.append((path[-1][0] + seconds if path else 0.0, x, y, z))


go(0.0, 0.0, 0.0, OVER_M)
for y, aim in zip(ROWS_Y_M, AIMS_M):
    go(0.35, -0.025, y, OVER_M)  # beside the handle,
    go(0.25, -0.025, y, HANDLE_Z_M)  # down to it,
    go(0.60, aim, y, HANDLE_Z_M)  # push,
    go(0.30, aim, y, HANDLE_Z_M)  # hold,
    go(0.06, aim, y, OVER_M)  # and off over its top
    go(0.55, aim, y, OVER_M)  # while it swings
go(0.40, 0.0, 0.0, OVER_M)
go(0.20, 0.0, 0.0, OVER_M)

lines = ["time_s,x_m,y_m,z_m"] + ["%.3f,%.6f,%.6f,%.6f" % point for point in path]
(pathlib.Path(__file__).parent / "stroke.csv").write_text("\n".join(lines) + "\n")

#!/usr/bin/env python3
"""Makes stroke.csv beside this script: a hand that pushes the pucks of multy3.scene.json about. Python 3, standard library only; the same bytes
each time."""

import pathlib

Z_M = -0.03  # the middle of the pucks

path = []


def go(seconds, x, y, z=Z_M):
    path.append((path[-1][0] + seconds if path else 0.0, x, y, z))


go(0.0, 0.0, 0.0, 0.0)
for y, side in ((0.0, -1.0), (0.01, -1.0), (-0.01, 1.0)):
    go(0.6, 0.082 * side, y, 0.0)  # over the pucks to a board,
    go(0.3, 0.082 * side, y)  # down,
    go(0.7, -0.02 * side, y)  # push across, and stop: what was pushed goes on
    go(0.5, -0.02 * side, y)
    go(0.2, -0.02 * side, y, 0.0)
    go(0.4, 0.0, 0.0, 0.0)

lines = ["time_s,x_m,y_m,z_m"] + ["%.3f,%.6f,%.6f,%.6f" % point for point in path]
(pathlib.Path(__file__).parent / "stroke.csv").write_text("\n".join(lines) + "\n")

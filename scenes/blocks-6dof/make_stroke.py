#!/usr/bin/env python3
"""Makes stroke.csv beside this script: two hands that turn the block of blocks-6dof.scene.json and push the tall one over. Python 3, standard library only; the same bytes
each time."""

import math
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
from strokes import Grasp  # noqa: E402

NEAR_M = -0.03  # along y
LOW_M, HIGH_M = -0.035, 0.0  # of the block's middle: on the table, carried
OPEN_M, SHUT_M = 0.035, 0.010  # half of the gap between the fingertips; a block's is 0.015

hands = Grasp()
go = hands.go

go(0.0, 0.1, 0.0, 0.0)
go(0.5, 0.1, 0.0, 0.0)
go(0.6, OPEN_M, NEAR_M, LOW_M)
go(0.4, SHUT_M, NEAR_M, LOW_M)  # take the block,
go(0.6, SHUT_M, NEAR_M, HIGH_M)  # lift,
for part in range(1, 9):  # turn it by 40 degrees,
    go(0.1, SHUT_M, NEAR_M, HIGH_M, math.radians(40.0 * part / 8))
go(0.6, SHUT_M, NEAR_M, LOW_M, math.radians(40.0))  # put it down,
go(0.4, OPEN_M, NEAR_M, LOW_M, math.radians(40.0))  # and let go
go(0.4, OPEN_M, NEAR_M, 0.02, math.radians(40.0))
go(0.6, 0.1, 0.0, 0.02)
# The left hand goes in front of the tall block, and pushes near its top.
right = hands.rows[-1][4:7]
for seconds, x, y, z in ((0.6, 0.0, 0.015, 0.03), (0.3, 0.0, 0.015, 0.002), (0.6, 0.0, 0.055, 0.002), (0.3, 0.0, 0.02, 0.03), (0.6, -0.1, 0.0, 0.0)):
    hands.rows.append((hands.rows[-1][0] + seconds, x, y, z) + right)
hands.rows.append((hands.rows[-1][0] + 0.3, -0.1, 0.0, 0.0, 0.1, 0.0, 0.0))

hands.write(pathlib.Path(__file__).resolve().with_name("stroke.csv"))

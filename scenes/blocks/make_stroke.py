#!/usr/bin/env python3
"""Makes stroke.csv beside this script, two hands that stack the near block of blocks.scene.json on the far one, take it back and throw
it; and dribble.stroke.csv, two that let the block of dribble.scene.json fall, of which one dribbles it. Python 3, standard library only; the
same bytes each time."""

import math
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
from strokes import Grasp  # noqa: E402

NEAR_M, FAR_M = -0.03, 0.03  # along y
LOW_M, HIGH_M, TOP_M = -0.035, 0.02, -0.005  # of a block's middle: on the table, carried, on the other block
OPEN_M, SHUT_M = 0.035, 0.009  # half of the gap between the fingertips; a block's is 0.015

hands = Grasp()
go = hands.go

go(0.0, 0.1, 0.0, 0.0)
go(0.5, 0.1, 0.0, 0.0)
go(0.6, OPEN_M, NEAR_M, LOW_M)
go(0.4, SHUT_M, NEAR_M, LOW_M)  # take it,
go(0.6, SHUT_M, NEAR_M, HIGH_M)  # lift,
go(0.6, SHUT_M, FAR_M, HIGH_M)  # carry,
go(0.5, SHUT_M, FAR_M, TOP_M)  # put it on the other one,
go(0.3, OPEN_M, FAR_M, TOP_M)  # let go
go(0.6, OPEN_M, FAR_M, TOP_M)
go(0.4, SHUT_M, FAR_M, TOP_M)  # take it back
go(0.5, SHUT_M, FAR_M, HIGH_M)
go(0.6, SHUT_M, NEAR_M, HIGH_M)
go(0.4, SHUT_M, NEAR_M, -0.02)
go(0.10, SHUT_M, NEAR_M, 0.03)  # throw it
go(0.05, OPEN_M, NEAR_M, 0.05)
go(0.6, 0.06, NEAR_M, 0.05)  # it falls, and bounces
go(0.6, 0.1, 0.0, 0.0)
go(0.3, 0.1, 0.0, 0.0)

hands.write(pathlib.Path(__file__).resolve().with_name("stroke.csv"))

PERIOD_S, STEP_S, MIDDLE_M, SWING_M = 0.14, 0.01, 0.011, 0.01  # of the finger that dribbles; the block at rest ends at -0.02

hands = Grasp()
go = hands.go
go(0.0, 0.1, 0.0, 0.0)
go(0.5, 0.1, 0.0, 0.0)
go(0.6, OPEN_M, 0.0, LOW_M + 0.01)  # high on the block: it is soon out from between them
go(0.4, SHUT_M, 0.0, LOW_M + 0.01)
go(0.6, SHUT_M, 0.0, 0.03)
go(0.3, SHUT_M, 0.0, 0.03)
go(0.05, 0.025, 0.0, 0.04)
start_s = hands.rows[-1][0] + 0.14  # until it is over the block
for n in range(int(2.4 / STEP_S)):
    hands.rows.append((start_s + n * STEP_S, 0.0, 0.0, MIDDLE_M + SWING_M * math.cos(2.0 * math.pi * n * STEP_S / PERIOD_S), 0.1, 0.0, 0.05))
go(0.3, 0.06, 0.0, 0.05)
go(0.8, 0.1, 0.0, 0.0)
hands.write(pathlib.Path(__file__).resolve().with_name("dribble.stroke.csv"))

"""A wall that this program renders, felt by whoever holds the arm. With a simulated hand that presses it:

    build/release/bin/thimble-sim --tcp 0 --hand press.csv --loop &
    PYTHONPATH=build/python/python python3 docs/examples/host_wall.py [DEVICE [SECONDS]]
"""

import sys

import numpy as np
import thimble

FLOOR_M = -0.01  # below the tip's home position
STIFFNESS_N_M = 300.0


def wall(tip):
    return np.array([0.0, 0.0, STIFFNESS_N_M * max(FLOOR_M - tip.tip_m[2], 0.0)])


seconds = float(sys.argv[2]) if len(sys.argv) > 2 else 5.0
with thimble.connect(sys.argv[1] if len(sys.argv) > 1 else "") as device:
    device.home()
    device.take_over()
    before = device.orders
    sent = device.render(wall, seconds)
    missed = device.orders["expired"] - before["expired"]
    device.hand_back()
print("%.0f orders/s, %d times none in time" % (sent / seconds, missed))

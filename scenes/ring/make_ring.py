#!/usr/bin/env python3
"""Makes ring.obj beside this script: a ring of 64 x 32 quads in mm, axis z, lying on z = 0. The same bytes each time."""

import math
import pathlib

RING_MM, TUBE_MM = 24.0, 6.0
AROUND, ACROSS = 64, 32


def main():
    lines = ["# A ring in mm, made by make_ring.py", "o ring"]
    for i in range(AROUND):
        a = 2.0 * math.pi * i / AROUND
        for j in range(ACROSS):
            b = 2.0 * math.pi * j / ACROSS
            out = RING_MM + TUBE_MM * math.cos(b)
            lines.append("v %.5f %.5f %.5f" % (out * math.cos(a), out * math.sin(a), TUBE_MM + TUBE_MM * math.sin(b)))
    for i in range(AROUND):
        for j in range(ACROSS):
            here, there = i * ACROSS, (i + 1) % AROUND * ACROSS
            k = (j + 1) % ACROSS
            lines.append("f %d %d %d %d" % (here + j + 1, there + j + 1, there + k + 1, here + k + 1))
    pathlib.Path(__file__).resolve().with_name("ring.obj").write_text(
        "\n".join(lines).replace("-0.00000", "0.00000") + "\n", encoding="ascii")


if __name__ == "__main__":
    main()

#!/usr/bin/env python3
"""Writes stroke.csv beside it: a hand that skates in loops over the floor and the dome of ice. Standard library only."""
import math
import pathlib


def main():
    rows = [(0.0, 0.0, 0.0, 0.0), (0.4, 0.0, 0.0, 0.0), (0.8, 0.0, -0.03, -0.02), (1.0, 0.0, -0.03, -0.033)]
    step, length = 0.02, 7.0
    for i in range(1, int(length / step) + 1):
        t = i * step
        x = 0.04 * math.sin(2.0 * math.pi * t / 3.5)
        y = -0.03 * math.cos(2.0 * math.pi * t / 2.8)
        r2 = (x - 0.03) ** 2 + (y - 0.02) ** 2
        dome = -0.055 + math.sqrt(0.04**2 - r2) if r2 < 0.04**2 else -1.0
        rows.append((1.0 + t, x, y, max(-0.03, dome) - 0.003))
    rows += [(8.4, rows[-1][1], rows[-1][2], 0.0), (9.0, 0.0, 0.0, 0.0)]
    lines = ["time_s,x_m,y_m,z_m"] + ["%.2f,%.6f,%.6f,%.6f" % row for row in rows]
    path = pathlib.Path(__file__).resolve().parent / "stroke.csv"
    path.write_text("\n".join(lines).replace("-0.000000", "0.000000") + "\n", encoding="ascii")


if __name__ == "__main__":
    main()

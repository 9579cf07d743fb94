#!/usr/bin/env python3
"""Writes the tissue's grids and the hand beside it: stiffness.csv (N/m), damping.csv (N s/m), stroke.csv. Standard library only.

A lump of 1000 N/m under (0.01, 0.005) m in a tissue of 250 N/m that stiffens to 500 N/m on the left."""
import math
import pathlib

COLUMNS, ROWS, CELL_M = 17, 13, 0.005
LEFT_M, NEAR_M = -0.04, -0.03


def stiffness_N_m(x, y):
    lump = 750.0 * math.exp(-((x - 0.01) ** 2 + (y - 0.005) ** 2) / (2.0 * 0.006**2))
    return 250.0 + lump + 250.0 / (1.0 + math.exp((x + 0.028) / 0.003))


def stroke():
    rows = [(0.0, 0.0, 0.0, 0.0), (0.3, -0.03, 0.005, -0.02)]
    t = 0.3
    for i in range(7):  # dabs along a line over the lump
        x = -0.03 + 0.01 * i
        rows += [(t + 0.2, x, 0.005, -0.028), (t + 0.4, x, 0.005, -0.034), (t + 0.6, x, 0.005, -0.028)]
        t += 0.6
    rows += [(t + 0.3, 0.03, 0.005, -0.034)]  # then back over it without letting go, and once round
    rows += [(t + 2.3, -0.03, 0.005, -0.034)]
    t += 2.3
    for i in range(1, 41):
        a = 2.0 * math.pi * i / 40.0
        rows.append((t + 0.05 * i, -0.01 - 0.02 * math.cos(a), 0.005 + 0.02 * math.sin(a), -0.034))
    t += 2.0
    return rows + [(t + 0.3, -0.03, 0.005, -0.02), (t + 0.8, 0.0, 0.0, 0.0)]


def main():
    folder = pathlib.Path(__file__).resolve().parent
    k = [[stiffness_N_m(LEFT_M + CELL_M * i, NEAR_M + CELL_M * j) for i in range(COLUMNS)] for j in range(ROWS)]
    far_first = list(reversed(k))  # a file's last row is the nearest
    for name, scale in (("stiffness", 1.0), ("damping", 1.0 / 400.0)):
        lines = [",".join("%.3f" % (scale * value) for value in row) for row in far_first]
        (folder / f"{name}.csv").write_text("\n".join(lines) + "\n", encoding="ascii")
    lines = ["time_s,x_m,y_m,z_m"] + ["%.2f,%.6f,%.6f,%.6f" % row for row in stroke()]
    (folder / "stroke.csv").write_text("\n".join(lines) + "\n", encoding="ascii")


if __name__ == "__main__":
    main()

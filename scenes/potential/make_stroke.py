#!/usr/bin/env python3
"""Writes stroke.csv: the tissue pressed beside and above its lump and stroked over it, the jelly and the skin pressed."""
import math
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
from strokes import Stroke, write_stroke  # noqa: E402

stroke = Stroke()
go = stroke.go


def main():
    top = -0.025
    for x in (-0.025, 0.020):  # beside, above
        go(0.5, x, 0.0, top + 0.004)
        go(0.4, x, 0.0, top - 0.005)
        go(0.3, x, 0.0, top - 0.005)
        go(0.3, x, 0.0, top + 0.004)
    go(0.5, -0.035, 0.0, top + 0.004)
    go(0.3, -0.035, 0.0, top - 0.004)
    go(1.6, 0.040, 0.0, top - 0.004)
    go(0.3, 0.040, 0.0, top + 0.006)
    go(0.9, -0.100, 0.0, -0.015)
    for i in range(21):  # round the jelly, 5 mm deep
        angle = 2.0 * math.pi * i / 20
        z = -0.045 + math.sqrt(0.020**2 - 0.010**2)
        go(0.4 if i == 0 else 0.07, -0.100 + 0.010 * math.cos(angle), 0.010 * math.sin(angle), z)
    go(0.3, -0.100, 0.0, -0.010)
    go(1.0, 0.100, 0.0, -0.015)
    go(0.3, 0.100, 0.0, -0.031)
    go(0.5, 0.100, 0.010, -0.031)
    go(0.3, 0.100, 0.010, -0.015)
    go(0.6, 0.0, 0.0, 0.0)
    write_stroke(pathlib.Path(__file__).resolve().with_name("stroke.csv"), stroke.rows)


if __name__ == "__main__":
    main()

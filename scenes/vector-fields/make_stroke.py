#!/usr/bin/env python3
"""Writes stroke.csv: both cubes pressed and stroked towards an edge, the ball stroked, both plates pressed."""
import math
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
from strokes import Stroke, write_stroke  # noqa: E402

stroke = Stroke()
go = stroke.go


def main():
    go(0.6, -0.110, 0.0, 0.005)
    for cube in (-0.110, -0.055):
        go(0.3, cube, 0.0, -0.018)
        go(0.3, cube, 0.0, -0.026)  # 6 mm into the top
        go(0.7, cube + 0.019, 0.0, -0.026)  # towards the right edge: the field turns over at 14 mm
        go(0.4, cube + 0.019, 0.0, 0.005)
    go(0.2, -0.014, 0.0, -0.010)
    for i in range(21):  # over the ball, 4 mm deep
        angle = math.radians(-45.0 + 90.0 * i / 20)
        go(0.05 if i else 0.2, 0.016 * math.sin(angle), 0.0, -0.040 + 0.016 * math.cos(angle))
    go(0.4, 0.040, 0.0, 0.0)
    for plate in (0.055, 0.110):
        go(0.4, plate, 0.0, -0.020)
        go(0.8, plate, 0.0, -0.038)  # the field's plate is behind the tip now
        go(0.3, plate, 0.0, -0.038)
        if plate > 0.1:
            go(0.6, plate, 0.0, -0.005)
        else:  # out from under it
            go(0.4, plate, 0.040, -0.038)
            go(0.3, plate, 0.040, -0.005)
    go(0.6, 0.0, 0.0, 0.0)
    write_stroke(pathlib.Path(__file__).resolve().with_name("stroke.csv"), stroke.rows)


if __name__ == "__main__":
    main()

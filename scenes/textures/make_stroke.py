#!/usr/bin/env python3
"""Writes stroke.csv beside it: a hand that strokes the six patches to and fro. Standard library only."""
import pathlib


def main():
    rows = [(0.0, 0.0, 0.0, 0.0), (0.3, 0.0, 0.0, 0.0)]
    t = 0.3
    for y in (0.025, -0.025):
        for x in (-0.035, 0.0, 0.035):
            rows += [(t + 0.3, x - 0.012, y, -0.022), (t + 0.5, x - 0.012, y, -0.033), (t + 0.9, x + 0.012, y, -0.033),
                     (t + 1.3, x - 0.012, y + 0.002, -0.033), (t + 1.4, x - 0.012, y + 0.002, -0.022)]
            t += 1.4
    rows.append((t + 0.4, 0.0, 0.0, 0.0))
    lines = ["time_s,x_m,y_m,z_m"] + ["%.2f,%.6f,%.6f,%.6f" % row for row in rows]
    (pathlib.Path(__file__).resolve().parent / "stroke.csv").write_text("\n".join(lines) + "\n", encoding="ascii")


if __name__ == "__main__":
    main()

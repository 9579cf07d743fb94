#!/usr/bin/env python3
"""Writes specimen.json and stroke.csv, and with the command's path as argument lets it scan: scan.scene.json.

    scenes/scan/make_scan.py build/release/bin/thimble

The specimen is a soft pad, 100 x 68 mm, 20 mm below the arm's home: 250 N/m, with a firm lump of 500 N/m (12 mm wide) and a
firm ridge across it of 120 N/m more. The renderer knows nothing of this formula; scan.plan.json says where to probe.
"""

import json
import math
import os
import subprocess
import sys
import tempfile
from pathlib import Path

HERE = Path(__file__).resolve().parent
CELL_M, COLUMNS, ROWS = 0.002, 51, 35
SURFACE_M = -0.02


def stiffness(x, y):
    lump = 250 * math.exp(-((x - 0.02) ** 2 + (y - 0.005) ** 2) / (2 * 0.012 ** 2))
    ridge = 120 * math.exp(-((x + 0.025 + 0.3 * y) ** 2) / (2 * 0.01 ** 2))
    return 250 + lump + ridge


def specimen():
    origin = (-CELL_M * (COLUMNS - 1) / 2, -CELL_M * (ROWS - 1) / 2, SURFACE_M)
    values = [round(stiffness(origin[0] + CELL_M * i, origin[1] + CELL_M * j), 2)
              for j in range(ROWS) for i in range(COLUMNS)]
    head = json.dumps({
        "thimble_specimen": 1,
        "description": "A soft pad with a firm lump and a firm ridge. Written by make_scan.py.",
        "origin_m": origin, "u": [1, 0, 0], "v": [0, 1, 0],
        "cell_m": CELL_M, "columns": COLUMNS, "rows": ROWS, "damping_N_s_m": 1}, indent=2)
    rows = ",\n    ".join(", ".join("%g" % k for k in values[j * COLUMNS:(j + 1) * COLUMNS]) for j in range(ROWS))
    (HERE / "specimen.json").write_text(head[:-2] + ',\n  "stiffness_N_m": [\n    ' + rows + "]\n}\n")


def stroke():
    """Down, four strokes over the pad at even depth, up: 10 s."""
    points = [(0.0, -0.036, -0.021, -0.01), (0.5, -0.036, -0.021, SURFACE_M - 0.004)]
    lanes = (-0.021, -0.007, 0.005, 0.021)
    time, x = 0.5, -0.036
    for number, y in enumerate(lanes):
        if number > 0:
            time += 0.3
            points.append((time, x, y, SURFACE_M - 0.004))
        x = -x
        time += 1.9
        points.append((time, x, y, SURFACE_M - 0.004))
    points.append((time + 0.5, x, lanes[-1], -0.01))
    rows = ["time_s,x_m,y_m,z_m"] + ["%.4g,%.4g,%.4g,%.4g" % p for p in points]
    (HERE / "stroke.csv").write_text("\n".join(rows) + "\n")


specimen()
stroke()
if len(sys.argv) > 1:
    with tempfile.TemporaryDirectory() as work:
        subprocess.run([os.path.abspath(sys.argv[1]), "scan", HERE / "scan.plan.json", "--simulate", "--specimen",
                        HERE / "specimen.json", "--log", os.path.join(work, "scan.csv"), "--output",
                        HERE / "scan.scene.json"], check=True)

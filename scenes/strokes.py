"""What the scripts that make the hands' paths of scenes/ share. Python 3, standard library only; the same bytes each time."""

import importlib.util
import math
import pathlib

SCENES = pathlib.Path(__file__).resolve().parent


def write_stroke(file, rows):
    """rows: (time_s, x_m, y_m, z_m) of one hand."""
    lines = ["time_s,x_m,y_m,z_m"] + ["%.2f,%.6f,%.6f,%.6f" % row for row in rows]
    file.write_text("\n".join(lines).replace("-0.000000", "0.000000") + "\n", encoding="ascii")


class Stroke:
    """The path of one hand, from the origin on."""

    def __init__(self):
        self.rows = [(0.0, 0.0, 0.0, 0.0)]

    def go(self, seconds, x, y, z):
        self.rows.append((self.rows[-1][0] + seconds, x, y, z))


class Grasp:
    """The path of two hands with an object between their fingertips."""

    def __init__(self):
        self.rows = []  # time_s, then x, y, z in m of both fingertips

    def go(self, seconds, half_gap, y, z, turn=0.0):
        """The fingertips half_gap to the left and to the right of x = 0, turned about it by `turn` in radians."""
        now = self.rows[-1][0] + seconds if self.rows else 0.0
        across, along = half_gap * math.cos(turn), half_gap * math.sin(turn)
        self.rows.append((now, -across, y - along, z, across, y + along, z))

    def write(self, file):
        lines = ["time_s,x_m,y_m,z_m,arm"]
        for time, *places in self.rows:
            lines += ["%.3f,%.6f,%.6f,%.6f,%d" % (time, *places[3 * arm:3 * arm + 3], arm) for arm in (0, 1)]
        file.write_text("\n".join(lines) + "\n", encoding="ascii")


def load_asteroid():
    """The module that makes the asteroid's mesh."""
    spec = importlib.util.spec_from_file_location("make_asteroid", SCENES / "asteroid" / "make_asteroid.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module

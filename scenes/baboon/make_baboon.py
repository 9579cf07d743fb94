#!/usr/bin/env python3
"""Makes face.png and stroke.csv, the files beside this script. Python 3, standard library only; the same bytes each time.

An ape's face as a grey picture of 97 x 97 pixels, drawn here from soft spots: a long bright muzzle with its furrows, dark
eyes below a heavy brow, cheeks and a mane. Its brightness is taken for height, as the paper took the baboon's. The stroke
runs down the nose, to and fro over the muzzle, and along the brow.
"""

import math
import pathlib
import struct
import zlib

SIDE = 97
SIZE_M = 0.12
HEIGHT_M = 0.016  # what baboon.scene.json gives to white
LOW_M = -0.045  # where it puts black
# middle (x, y), half widths, brightness; x to the right, y up, the picture reaches from -1 to 1
SPOTS = (
    ((0.0, 0.0), (0.85, 0.95), 0.30),  # the head
    ((0.0, -0.25), (0.26, 0.62), 0.34),  # the muzzle
    ((0.0, -0.62), (0.33, 0.20), 0.22),  # the nose
    ((-0.13, -0.66), (0.07, 0.06), -0.42),  # nostrils
    ((0.13, -0.66), (0.07, 0.06), -0.42),
    ((0.0, -0.88), (0.30, 0.035), -0.30),  # the mouth
    ((-0.30, 0.28), (0.13, 0.08), -0.34),  # eyes, and the balls in them
    ((0.30, 0.28), (0.13, 0.08), -0.34),
    ((-0.30, 0.28), (0.06, 0.05), 0.24),
    ((0.30, 0.28), (0.06, 0.05), 0.24),
    ((-0.28, 0.48), (0.26, 0.09), 0.30),  # the brow
    ((0.28, 0.48), (0.26, 0.09), 0.30),
    ((-0.52, -0.10), (0.20, 0.34), 0.14),  # cheeks
    ((0.52, -0.10), (0.20, 0.34), 0.14),
)


def brightness(x, y):
    value = 0.10 + sum(bright * math.exp(-0.5 * (((x - mx) / (0.6 * wx))**2 + ((y - my) / (0.6 * wy))**2)**1.5)
                       for (mx, my), (wx, wy), bright in SPOTS)
    side = abs(x) - 0.18 - 0.10 * (y + 0.25)  # furrows along the muzzle
    if -0.55 < y < 0.15:
        value += 0.07 * math.cos(2.0 * math.pi * side / 0.13) * math.exp(-(side / 0.16)**2) * (1.0 - ((y + 0.2) / 0.36)**2)
    r = math.hypot(x, y)
    value += 0.04 * math.sin(24.0 * math.atan2(y, x)) * max(0.0, min(1.0, 4.0 * (r - 0.7)))  # the mane
    return max(0, min(255, round(255 * value)))


def chunk(kind, data):
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


def png(rows):
    data = b"".join(b"\0" + bytes(row) for row in rows)
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", SIDE, SIDE, 8, 0, 0, 0, 0)) +
            chunk(b"IDAT", zlib.compress(data, 0)) + chunk(b"IEND", b""))  # stored: no zlib's choice in the bytes


def surface_m(x, y):
    return LOW_M + HEIGHT_M * brightness(x, y) / 255.0


def stroke():
    """Rows of time and place, the target 3 mm below the surface: down the nose, zigzag over the muzzle, along the brow."""
    ways = (
        (2.2, lambda t: (0.0, 0.75 - 1.55 * t)),
        (2.4, lambda t: (0.45 * math.sin(6.0 * math.pi * t), -0.55 + 0.6 * t)),
        (2.0, lambda t: (-0.6 + 1.2 * t, 0.48 - 0.2 * math.sin(math.pi * t)**8)),
    )
    rows = [(0.0, 0.0, 0.0, 0.0)]
    time = 0.0
    for seconds, way in ways:
        for part, lift in ((0.0, 0.010), (0.0, -0.003)):
            time += 0.4
            x, y = way(part)
            rows.append((time, 0.5 * SIZE_M * x, 0.5 * SIZE_M * y, surface_m(x, y) + lift))
        steps = int(seconds / 0.025)
        for i in range(1, steps + 1):
            x, y = way(i / steps)
            rows.append((time + 0.025 * i, 0.5 * SIZE_M * x, 0.5 * SIZE_M * y, surface_m(x, y) - 0.003))
        time += 0.025 * steps + 0.3
        rows.append((time, rows[-1][1], rows[-1][2], rows[-1][3] + 0.012))
    rows.append((time + 0.5, 0.0, 0.0, 0.0))
    return rows


def main():
    folder = pathlib.Path(__file__).resolve().parent
    at = [2.0 * i / (SIDE - 1) - 1.0 for i in range(SIDE)]
    (folder / "face.png").write_bytes(png([[brightness(x, y) for x in at] for y in reversed(at)]))
    rows = ["time_s,x_m,y_m,z_m"] + ["%.3f,%.6f,%.6f,%.6f" % row for row in stroke()]
    (folder / "stroke.csv").write_text("\n".join(rows).replace("-0.000000", "0.000000") + "\n", encoding="ascii")


if __name__ == "__main__":
    main()

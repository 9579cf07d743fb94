#!/usr/bin/env python3
"""Writes phantom.nii.gz, a made-up block of tissue as an MRI would see it, and stroke.csv, the hand that pricks it.

    python3 make_phantom.py
    thimble import volume phantom.nii.gz --from 4,-3,46 --to -2,3,2 --layers tissues.csv --output needle.scene.json

The layers are waves, no two alike; the noise is a fixed one.
"""

import gzip
import math
import random
import struct

SIZE, EDGE = (24, 24, 48), 1.0  # voxels, mm
# From the bottom up: name, mean intensity, height of its upper side in mm at the origin.
LAYERS = [("gland", 150, 17), ("capsule", 60, 19), ("muscle", 100, 28), ("fat", 215, 39), ("skin", 60, 42.5), ("air", 4, 1e9)]


def intensity(x, y, z, noise):
    wave = 0.8 * math.sin(x / 5) + 0.6 * math.cos(y / 4)
    for _, mean, top in LAYERS:
        if z < top + wave:
            return max(0, min(255, round(noise.gauss(mean, 4 if mean < 10 else 5))))


def volume():
    noise = random.Random(1995)
    header = bytearray(352)
    struct.pack_into("<i", header, 0, 348)
    struct.pack_into("<8h", header, 40, 3, *SIZE, 1, 1, 1, 1)
    struct.pack_into("<2h", header, 70, 2, 8)  # uint8
    struct.pack_into("<8f", header, 76, 1, EDGE, EDGE, EDGE, 0, 0, 0, 0)
    struct.pack_into("<3f", header, 108, 352, 1, 0)
    header[123] = 2  # mm
    struct.pack_into("<2h", header, 252, 0, 2)
    origin = (-EDGE * (SIZE[0] - 1) / 2, -EDGE * (SIZE[1] - 1) / 2, 0)
    for row in range(3):
        struct.pack_into("<4f", header, 280 + 16 * row, *(EDGE if column == row else 0 for column in range(3)), origin[row])
    header[344:347] = b"n+1"
    voxels = bytes(intensity(origin[0] + i * EDGE, origin[1] + j * EDGE, k * EDGE, noise)
                   for k in range(SIZE[2]) for j in range(SIZE[1]) for i in range(SIZE[0]))
    return bytes(header) + voxels


def stroke():
    """In and out, in again through the same hole, then beside it. The hand aims deeper than the needle comes."""
    rows, t = [], 0.0

    def to(x, z, seconds):
        nonlocal t
        t += seconds
        rows.append((t, x, 0.0, z))

    to(0, 0, 0.0)
    to(0, -0.018, 0.4)
    to(0, -0.062, 2.6)  # the first time: four layers tear
    to(0, -0.018, 0.9)
    to(0, -0.058, 1.2)  # the same hole: only the shaft rubs
    to(0, -0.012, 0.9)
    to(0.015, -0.012, 0.4)
    to(0.015, -0.062, 2.6)  # beside it the tissue is whole
    to(0.015, -0.012, 0.7)
    to(0, 0, 0.3)
    return "time_s,x_m,y_m,z_m\n" + "".join("%.2f,%.6f,%.6f,%.6f\n" % row for row in rows)


if __name__ == "__main__":
    with open("phantom.nii.gz", "wb") as file:
        with gzip.GzipFile("", "wb", 9, file, mtime=0) as packed:
            packed.write(volume())
    with open("stroke.csv", "w") as file:
        file.write(stroke())

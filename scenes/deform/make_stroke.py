#!/usr/bin/env python3
"""Writes stroke.csv: a finger presses, waits, lets go and presses again at once, slides while it presses, and presses afresh."""

rows, t = [], 0.0


def to(x, y, z, seconds):
    global t
    t += seconds
    rows.append((t, x, y, z))


SKIN = -0.02
to(0, 0, 0, 0.0)
to(-0.02, 0, SKIN + 0.004, 0.4)
to(-0.02, 0, SKIN - 0.012, 0.6)
to(-0.02, 0, SKIN - 0.012, 1.4)  # it relaxes
to(-0.02, 0, SKIN + 0.004, 0.15)
to(-0.02, 0, SKIN - 0.012, 0.4)  # felt lower down
to(0.02, 0.01, SKIN - 0.012, 2.0)  # the dimple follows
to(0.02, 0.01, SKIN + 0.004, 0.2)
to(0.02, 0.01, SKIN + 0.004, 2.4)  # it comes back
to(0.02, 0.01, SKIN - 0.012, 0.6)
to(0.02, 0.01, SKIN - 0.012, 0.9)
to(0, 0, 0, 0.7)
with open("stroke.csv", "w") as file:
    file.write("time_s,x_m,y_m,z_m\n" + "".join("%.2f,%.6f,%.6f,%.6f\n" % row for row in rows))

"""A force curve from the simulated arm. Cells (# %%) run one by one in an editor that knows them, or all at once:

    PYTHONPATH=build/python/python python3 docs/examples/force_curve.py curve.svg
"""

# %% A probe goes straight down into the floor of scenes/walls, which is 30 mm below home, 4 mm deep, and back.
import sys
from pathlib import Path

import numpy as np
import thimble

scene = Path(__file__).resolve().parents[2] / "scenes/walls/walls.scene.json"
time_s = np.array([0.0, 1.0, 2.0])
path = np.column_stack([time_s, np.zeros(3), np.zeros(3), [-0.020, -0.034, -0.020]])
floor_m = -0.03
exact = thimble.simulate(scene, path, ideal=True)  # the renderer alone
arm = thimble.simulate(scene, path)  # with the arm, its motors and the hand that holds it

# %% Force against depth.
import matplotlib  # noqa: E402

matplotlib.use("svg")
matplotlib.rcParams["svg.fonttype"] = "none"
import matplotlib.pyplot as plt  # noqa: E402

figure, axes = plt.subplots(figsize=(6, 4), layout="constrained")
for felt, name in ((exact, "renderer alone"), (arm, "with arm and hand")):
    axes.plot(1e3 * (floor_m - felt["tip_m"][:, 2]), np.linalg.norm(felt["force_N"], axis=1), label=name)
axes.set(xlabel="Depth / mm", ylabel="Force / N", xlim=(-2, 5))
axes.legend()

# %% Stiffness: the slope of the exact curve where there is contact.
touching = exact[exact["contacts"] > 0]
slope, _ = np.polyfit(floor_m - touching["tip_m"][:, 2], np.linalg.norm(touching["force_N"], axis=1), 1)
print(f"{slope:.0f} N/m")
figure.savefig(sys.argv[1] if len(sys.argv) > 1 else "force_curve.svg")

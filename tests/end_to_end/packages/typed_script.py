"""Is not run: mypy --strict checks it with the types of the package."""

import numpy as np
import thimble
from thimble.experiment import Fit, Session, fit


def hardest_N(scene: str, path: str) -> float:
    felt = thimble.simulate(scene, path, ideal=True)
    return float(np.linalg.norm(felt["force_N"], axis=1).max())


def wall(tip: thimble.Tip) -> list[float]:
    return [0.0, 0.0, max(0.0, -500.0 * float(tip.tip_m[2]))]


def feel(scene: str) -> int:
    with thimble.connect() as device:
        device.upload(scene)
        device.home()
        device.take_over()
        return device.render(wall, seconds=1.0)


def reach_m(name: str) -> float:
    arm = thimble.Arm(name)
    return float(np.linalg.norm(arm.tip_m(arm.home)))


def threshold(levels: list[float], correct: list[int], trials: list[int]) -> float:
    fitted: Fit = fit(levels, correct, trials)
    return fitted.location


def marked(session: Session, sim: thimble.Sim) -> list[int | None]:
    with thimble.connect() as device:
        return [device.event(7), device.set_trial(2), sim.event(65535), session.event(1, at=device), session.event(2, at=sim)]

"""How much stiffer must a block be to feel stiffer? The method of constant stimuli with a fitted psychometric function.

    PYTHONPATH=build/python/python python3 docs/examples/stiffness_jnd.py p00.jsonl             # a simulated observer
    PYTHONPATH=build/python/python python3 docs/examples/stiffness_jnd.py p00.jsonl DEVICE      # a person at a device

Each trial has two blocks, one of STANDARD and one of another stiffness, in random order. The same line again continues a file.
"""

import math
import sys

import numpy as np
import thimble
from thimble.experiment import ConstantStimuli, Experiment, Observer, Session, by_observer, by_person, fit, intervals, stiffness_N_m

STANDARD = 500.0  # N/m
LEVELS = (380, 420, 460, 500, 540, 590, 640)  # N/m
QUESTION = "Which block is stiffer?"


def material(stiffness_N_m):
    return {"stiffness_N_m": stiffness_N_m, "damping_N_s_m": 0}


def experiment(seed, participant=0, repeats=20):
    return Experiment("stiffness JND", {"stiffness": lambda method_seed: ConstantStimuli(LEVELS, repeats, method_seed)}, seed, participant,
                      settings={"standard_N_m": STANDARD})


def run(session, compare):
    """`compare` says whether the first block feels stiffer; the answer of a trial is whether the comparison does."""
    for trial in session:
        first = compare(trial, intervals.ordered(trial, material(trial.level), material(STANDARD)))
        session.answer(first == trial.comparison_first, first_is_greater=first)


def analyse(session):
    """A cumulative normal over ln(stiffness / STANDARD): its middle is the point of subjective equality, and 0.6745 times its width the JND."""
    levels, stiffer, trials = session.methods["stiffness"].counts()
    return fit(np.log(levels / STANDARD), stiffer, trials, function="normal", guess="lapse", lapse=0.0)


def observer(weber=0.1):
    """It feels the slope of the force over depth."""
    return Observer(stiffness_N_m, weber)


if __name__ == "__main__":
    with Session(sys.argv[1], experiment(seed=1)) as session:
        if len(sys.argv) > 2:
            with thimble.connect(sys.argv[2]) as device:
                intervals.upload(device, intervals.side_by_side(material(STANDARD), material(STANDARD)))
                device.home()
                device.arm()
                run(session, by_person(device, QUESTION))
                device.disarm()
        else:
            run(session, by_observer(observer(), intervals.presses()))
        fitted = analyse(session)
    jnd = 0.6745 * fitted.width
    print("equal at %.0f N/m, standard error %.0f" % (STANDARD * math.exp(fitted.location), STANDARD * fitted.location_error))
    print("JND %.1f %%, standard error %.1f" % (100 * jnd, 67.45 * fitted.width_error))

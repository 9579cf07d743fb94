"""How much more friction must a block have to feel so? Two staircases, interleaved.

    PYTHONPATH=build/python/python python3 docs/examples/friction_discrimination.py p00.jsonl             # a simulated observer
    PYTHONPATH=build/python/python python3 docs/examples/friction_discrimination.py p00.jsonl DEVICE      # a person at a device

One goes to 70.7 % correct (one up, two down), the other to 75 % (weighted). The level is by how much the friction of the comparison exceeds
STANDARD, as a part of it. The same line again continues a file.
"""

import sys

import thimble
from thimble.experiment import Experiment, Observer, Session, Staircase, by_observer, by_person, friction, intervals

STANDARD = 0.3  # coefficient of friction
STEPS = (1.25**2, 1.25)  # factors
QUESTION = "Which block has more friction?"


def material(coefficient):
    coefficient = round(coefficient, 4)
    return {"stiffness_N_m": 500, "static_friction": coefficient, "dynamic_friction": coefficient, "friction_mode": "steady"}


def experiment(seed, participant=0, reversals=16):
    limits = {"log": True, "reversals": reversals, "least": 0.01, "most": 1.0}
    conditions = {"two down": lambda _: Staircase(0.4, STEPS, down=2, **limits), "weighted": lambda _: Staircase.weighted(0.4, STEPS, **limits)}
    return Experiment("friction discrimination", conditions, seed, participant, settings={"standard": STANDARD})


def run(session, compare):
    """`compare` says whether the first block has more friction. The comparison always has."""
    for trial in session:
        first = compare(trial, intervals.ordered(trial, material(STANDARD * (1 + trial.level)), material(STANDARD)))
        session.answer(first == trial.comparison_first, first_is_greater=first)


def observer(weber=0.1):
    """It feels the ratio of the force along the surface to the force upwards."""
    return Observer(friction, weber)


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
            run(session, by_observer(observer(), intervals.strokes()))
        for name, staircase in session.methods.items():
            threshold, error = staircase.threshold()
            print("%s: %.1f %% correct at %.1f %% more friction, standard error %.1f" % (name, 100 * staircase.target, 100 * threshold, 100 * error))

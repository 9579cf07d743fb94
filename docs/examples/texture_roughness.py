"""How much higher must ridges be to feel rougher? QUEST.

    PYTHONPATH=build/python/python python3 docs/examples/texture_roughness.py p00.jsonl             # a simulated observer
    PYTHONPATH=build/python/python python3 docs/examples/texture_roughness.py p00.jsonl DEVICE      # a person at a device

The level is by how much the ridges of the comparison are higher than STANDARD, as a part of it. The same line again continues a file.
"""

import sys

import thimble
from thimble.experiment import Experiment, Observer, Quest, Session, by_observer, by_person, intervals, roughness_N

STANDARD = 0.0002  # m, from the bottom to the top of a ridge
SPACING = 0.003  # m
QUESTION = "Which block is rougher?"


def material(height_m):
    return {"stiffness_N_m": 500, "texture": {"kind": "height", "pattern": "ridges", "tile_m": [SPACING, SPACING], "height_m": height_m}}


def experiment(seed, participant=0, trials=60):
    conditions = {"ridges": lambda _: Quest(0.2, sd=0.4, target=0.75, slope=1.3, trials=trials, step=0.04, least=0.02, most=1.0)}
    return Experiment("texture roughness", conditions, seed, participant, settings={"standard_m": STANDARD, "spacing_m": SPACING})


def run(session, compare):
    """`compare` says whether the first block is rougher. The comparison always is."""
    for trial in session:
        first = compare(trial, intervals.ordered(trial, material(STANDARD * (1 + trial.level)), material(STANDARD)))
        session.answer(first == trial.comparison_first, first_is_greater=first)


def observer(weber=0.1):
    """It feels how much the force along the surface varies."""
    return Observer(roughness_N, weber)


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
        threshold, error = session.methods["ridges"].threshold()
        print("75 %% correct at %.1f %% higher ridges, standard deviation %.1f" % (100 * threshold, 100 * error))

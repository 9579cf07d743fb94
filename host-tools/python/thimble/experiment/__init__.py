"""Experiments in psychophysics: what is presented, in which order, and a file that loses nothing.

    from thimble.experiment import ConstantStimuli, Experiment, Session

    experiment = Experiment("stiffness", {"near 500 N/m": lambda seed: ConstantStimuli([400, 450, 500, 550, 600], 20, seed)}, seed=1)
    with Session("p00.jsonl", experiment) as session:
        for trial in session:
            session.answer(present(trial))       # a function of yours
    session.methods["near 500 N/m"].fit(function="normal", guess="lapse")

One module for each idea: staircase, quest, constant_stimuli and psychometric choose levels and estimate thresholds; blocks has seeds and
orders; session has trials and the file; events has ticks; intervals has scenes with two stimuli; compare is
who answers: a person, or the simulated participant of observer.
"""

from . import intervals
from .blocks import derive_seed, latin_square, order_for, shuffled, shuffled_blocks
from .compare import by_observer, by_observer_at, by_person
from .constant_stimuli import ConstantStimuli
from .events import Ticks
from .observer import Observer, friction, roughness_N, stiffness_N_m
from .psychometric import Fit, fit, psychometric
from .quest import Quest
from .session import Experiment, FileError, Method, Session, Trial, read_trials
from .staircase import Staircase

__all__ = ["ConstantStimuli", "Experiment", "FileError", "Fit", "Method", "Observer", "Quest", "Session", "Staircase", "Ticks", "Trial",
           "by_observer", "by_observer_at", "by_person", "derive_seed", "fit", "friction", "intervals", "latin_square", "order_for",
           "psychometric", "read_trials", "roughness_N", "shuffled", "shuffled_blocks", "stiffness_N_m"]

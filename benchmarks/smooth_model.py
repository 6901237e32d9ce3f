"""The model that the benchmarks scale: any number of rules and plays, made up and stable."""

from __future__ import annotations

import numpy as np

from hysgen.model.learner_settings import LearnerSettings
from hysgen.model.model import Grid, Model
from hysgen.model.terms.memory import Memory


def smooth(name: str, rules: int, plays: int = 0, learner: LearnerSettings | None = None) -> Model:
    """A lag whose rules change smoothly over 0.5 .. 9 um, with plays that weigh alike."""
    place = np.linspace(0.0, 1.0, rules)
    consequents = np.column_stack([0.9 + 0.05 * place, 1.5e-3 + 5e-4 * place, 0.02 + 0.5 * place * (1.0 - place)])
    terms = (Memory.uniform(plays, 60.0),) if plays else ()
    weights = np.full(plays, 1e-5)
    return Model(name, 2e-5, Grid(0.5, 9.0, rules), consequents, -20.0, 120.0, terms, weights, learner=learner)

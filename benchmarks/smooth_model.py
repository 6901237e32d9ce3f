"""The model that the benchmarks scale: any number of rules and plays, made up and stable."""

from __future__ import annotations

import numpy as np

from hysgen.model.learner_settings import LearnerSettings
from hysgen.model.model import Grid, Model
from hysgen.model.path.hysteresis import Hysteresis


def smooth(name: str, rules: int, plays: int = 0, learner: LearnerSettings | None = None) -> Model:
    """A lag whose rules change smoothly over 0.5 .. 9 um, behind a hysteresis whose plays weigh alike."""
    place = np.linspace(0.0, 1.0, rules)
    gain = 40.0 if plays else 1.0
    consequents = np.column_stack(
        [0.9 + 0.05 * place, gain * (1.5e-3 + 5e-4 * place), 0.02 + 0.5 * place * (1.0 - place)]
    )
    widths = tuple((np.arange(1, plays + 1) / (plays + 1.0)).tolist())
    weights = (0.5 / plays,) * plays if plays else ()
    blocks = (Hysteresis(-20.0, 120.0, (2.2, 1.2), widths, weights),) if plays else ()
    return Model(name, 2e-5, Grid(0.5, 9.0, rules), consequents, -20.0, 120.0, blocks=blocks, learner=learner)

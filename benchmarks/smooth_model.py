"""The model that the benchmarks scale: any number of rules and plays, made up and stable."""

from __future__ import annotations

import numpy as np

from hysgen.model.learner_settings import LearnerSettings
from hysgen.model.model import Grid, Model
from hysgen.model.path.creep import Creep
from hysgen.model.path.delay import Delay
from hysgen.model.path.hysteresis import Hysteresis
from hysgen.model.path.modes import Modes


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


def behind_path(name: str, plays: int, delay: float = 0.0) -> Model:
    """Six rules behind plays of degree 3, 2 Duhem states, 4 creep states and one mode, with a learner.

    delay: in samples; none if it is 0. Every coefficient has its own value, as those of a fit.
    """
    rng = np.random.default_rng(plays)
    widths = (np.arange(1, plays + 1) / (plays + 1.0)) ** 1.2
    weights = rng.uniform(0.5, 1.5, (plays, 3)) * [0.36, 0.012, 0.006] / plays if plays else np.zeros(0)
    slope = 0.95 + 0.002 * np.arange(6)
    consequents = np.column_stack([slope, 1.0 - slope, 1e-3 * np.sin(np.arange(6))])
    blocks = (
        *((Delay(delay),) if delay else ()),
        Hysteresis(
            -20.0,
            120.0,
            (2.2, 1.2, 0.05, 0.01),
            tuple(widths.tolist()),
            tuple(weights.ravel().tolist()),
            0.8,
            (0.03, 0.01, 0.02, 0.005),
        ),
        Creep(0.01, (1e-3, 1e-2, 0.1, 1.0)),
        Modes((730.0,), (0.05,), (0.3,), 4e-4),
    )
    grid = Grid(0.66, 3.73, 6)
    return Model(name, 2e-5, grid, consequents, -20.0, 120.0, blocks=blocks, learner=LearnerSettings())

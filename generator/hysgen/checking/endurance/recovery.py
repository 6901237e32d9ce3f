"""What good excitation makes of a learner that has endured: a second of it, held against fresh fits of that second."""

from __future__ import annotations

from functools import lru_cache
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hysgen.checking.endurance.cases import SECOND, TS_S, Case, good_drive, measured
from hysgen.checking.endurance.endure import Endurance
from hysgen.fitting import FitSettings, fit
from hysgen.model.model import Model
from hysgen.model.simulate import simulate
from hysgen.model.terms import Drive
from hysgen.record import Record
from hysgen.stage import Stage

Floats = NDArray[np.float64]

FIT_SEED, GOOD_SEED, VALIDATION_SEED = 3, 1, 2
VALIDATION_S: Final = 0.4


def bench_model(stage: Stage, rules: int = 6) -> Model:
    """The model whose learner is tried: fitted to one second of good excitation of the stage."""
    u_V = good_drive(FIT_SEED)
    return _fitted(measured(stage, u_V, FIT_SEED), u_V, rules)


class Recovery:
    """One second of good excitation of a stage, and a shorter drive that neither learner nor fit sees.

    The fits minimise what the learner does, the one-step error, in float64: one forgets as fast as the learner, the
    other weighs the whole second alike.
    """

    def __init__(self, stage: Stage, rules: int) -> None:
        u_V = good_drive(GOOD_SEED)
        self._good = Case("good excitation", measured(stage, u_V, GOOD_SEED), u_V, noise_um=0.0)
        self._check_V = good_drive(VALIDATION_SEED, VALIDATION_S)
        self._check_um = measured(stage, self._check_V, VALIDATION_SEED)
        self._rules = rules
        self._fresh_rms_um = lru_cache(maxsize=None)(self._fresh)

    def ratios(self, endurance: Endurance, forgetting: float) -> tuple[float, float]:
        """Feed the second to the learner: its free-run error over those of the two fits, infinite if it is broken."""
        endurance.feed(self._good, SECOND)
        if endurance.tally.broken_at:
            return np.inf, np.inf
        learned = self._free_run_rms_um(endurance.shadow())
        return learned / self._fresh_rms_um(forgetting), learned / self._fresh_rms_um(1.0)

    def _fresh(self, forgetting: float) -> float:
        return self._free_run_rms_um(_fitted(self._good.y_um, self._good.u_V, self._rules, forgetting))

    def _free_run_rms_um(self, model: Model) -> float:
        """rms of the free run's error on the unseen drive; infinite if the run leaves the numbers."""
        with np.errstate(all="ignore"):
            run = simulate(model, Drive(self._check_V, TS_S), float(self._check_um[0]))
            rms = float(np.sqrt(np.mean((run.y_um - self._check_um) ** 2)))
        return rms if np.isfinite(rms) else np.inf


def _fitted(y_um: Floats, u_V: Floats, rules: int, forgetting: float = 1.0) -> Model:
    """Least squares over a record, (n,) each; 1 % of its range is added at each end."""
    record = Record.from_arrays(u_V, y_um, TS_S, source="endurance")
    settings = FitSettings(name="bench", rules=rules, method="batch", margin=0.01, forgetting=forgetting)
    return fit(record, settings)

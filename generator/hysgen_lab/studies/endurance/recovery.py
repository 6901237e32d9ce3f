"""Recovery test after an endurance run: a second of persistent excitation, compared with fresh fits to that second."""

from __future__ import annotations

from functools import lru_cache
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hysgen.fitting import FitSettings, fit
from hysgen.model.disturbances import Drive
from hysgen.model.model import Model
from hysgen.model.simulate import simulate
from hysgen.record import Record
from hysgen_lab.stage import Stage
from hysgen_lab.studies.endurance.compiled_learner import CompiledLearner
from hysgen_lab.studies.endurance.excitations import SECOND, TS_S, Excitation, measured, persistent_excitation

Floats = NDArray[np.float64]

FIT_SEED, RECOVERY_SEED, VALIDATION_SEED = 3, 1, 2
VALIDATION_S: Final = 0.4


def bench_model(stage: Stage, rules: int = 6) -> Model:
    """The model of the tested learner, fitted to one second of persistent excitation of the stage."""
    u_V = persistent_excitation(FIT_SEED)
    return _fitted(measured(stage, u_V, FIT_SEED), u_V, rules)


class Recovery:
    """One second of persistent excitation of a stage, and a shorter validation record of another seed.

    The reference fits minimise the one-step error, as the learner does, in float64: one with the learner's forgetting,
    one with equal weights.
    """

    def __init__(self, stage: Stage, rules: int) -> None:
        u_V = persistent_excitation(RECOVERY_SEED)
        self._excitation = Excitation("persistent excitation", measured(stage, u_V, RECOVERY_SEED), u_V, noise_um=0.0)
        self._validation_V = persistent_excitation(VALIDATION_SEED, VALIDATION_S)
        self._validation_um = measured(stage, self._validation_V, VALIDATION_SEED)
        self._rules = rules
        self._fit_rms_um = lru_cache(maxsize=None)(self._compute_fit_rms_um)

    def ratios(self, learner: CompiledLearner, forgetting: float) -> tuple[float, float]:
        """Feed the second; the learner's free-run rms divided by that of each fit, infinite if a factor is broken."""
        learner.feed(self._excitation, SECOND)
        if learner.extremes.broken_at:
            return np.inf, np.inf
        learned = self._free_run_rms_um(learner.shadow())
        return learned / self._fit_rms_um(forgetting), learned / self._fit_rms_um(1.0)

    def _compute_fit_rms_um(self, forgetting: float) -> float:
        return self._free_run_rms_um(_fitted(self._excitation.y_um, self._excitation.u_V, self._rules, forgetting))

    def _free_run_rms_um(self, model: Model) -> float:
        """rms error of the free run over the validation record; infinite if the run is not finite."""
        with np.errstate(all="ignore"):
            run = simulate(model, Drive(self._validation_V, TS_S), float(self._validation_um[0]))
            rms = float(np.sqrt(np.mean((run.y_um - self._validation_um) ** 2)))
        return rms if np.isfinite(rms) else np.inf


def _fitted(y_um: Floats, u_V: Floats, rules: int, forgetting: float = 1.0) -> Model:
    """Batch least squares over y_um and u_V, (n,) each; the grid extends the range by 1 % at each end."""
    record = Record.from_arrays(u_V, y_um, TS_S, source="endurance")
    settings = FitSettings(name="bench", rules=rules, method="batch", margin=0.01, forgetting=forgetting)
    return fit(record, settings)

"""Endurance: the compiled learner under poor, broken and endless excitation, and what is left of it afterwards.

Every trial feeds the generated C, then lets one second of good excitation return and compares the free run of what was
learned with that of a fresh fit of the same second. Beside it stands Eq. (10) as printed, in float32.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hysgen.checking.endurance.cases import Case, cases
from hysgen.checking.endurance.endure import Endurance
from hysgen.checking.endurance.printed import dies_at
from hysgen.checking.endurance.recovery import Recovery, bench_model
from hysgen.checking.endurance.trials import ALLOWED_RATIO, CASES, HEADINGS, Outcome, Trial, rows, trials
from hysgen.float32.learner_status import LEARNER_COUNTERS
from hysgen.model.learner_settings import LearnerSettings
from hysgen.model.model import Model
from hysgen.stage import Stage

__all__ = ["ALLOWED_RATIO", "CASES", "HEADINGS", "Outcome", "Trial", "bench_model", "rows", "run", "trials"]

Floats = NDArray[np.float64]
Progress = Callable[[float, str], None]

PRINTED_SAMPLES: Final = 100_000


def run(
    todo: Sequence[Trial], progress: Progress | None = None, stage: Stage | None = None, model: Model | None = None
) -> list[Outcome]:
    """Try each of `todo` in turn.

    progress: told the fraction done and which trial is under way. stage: default Stage.nominal(). model: default
    `bench_model`; its learner settings, if any, apply but for forgetting and alpha.
    """
    chosen = stage or Stage.nominal()
    base = model or bench_model(chosen)
    drives, recovery = cases(chosen), Recovery(chosen, base.grid.rules)
    total, done = sum(trial.samples for trial in todo), 0
    outcomes = []
    for trial in todo:

        def advance(samples: int, trial: Trial = trial, before: int = done) -> None:
            if progress is not None:
                progress((before + samples) / total, f"{trial.case}, lambda {trial.forgetting:g}")

        outcomes.append(_outcome(trial, drives[trial.case], base, recovery, advance))
        done += trial.samples
    return outcomes


def _outcome(trial: Trial, case: Case, base: Model, recovery: Recovery, advance: Callable[[int], None]) -> Outcome:
    settings = base.learner or LearnerSettings()
    # Rest would teach nothing and prove nothing: here even a constant input has to be endured.
    settings = dataclasses.replace(settings, forgetting=trial.forgetting, alpha=trial.alpha, rest_V=0.0)
    endurance = Endurance(dataclasses.replace(base, learner=settings))
    endurance.begin(float(case.y_um[0]), float(case.u_V[0]))
    endurance.feed(case, trial.samples, advance)
    tally, learner = endurance.tally, endurance.learner
    events = {name: int(getattr(learner, name)) for name in LEARNER_COUNTERS}
    outcome = Outcome(
        trial=trial,
        updates=events.pop("updates"),
        broken_at=int(tally.broken_at) or None,
        least_d=float(tally.least_d),
        largest_d=float(tally.largest_d),
        largest_u=float(tally.largest_u),
        largest_theta_um=float(tally.largest_theta),
        bound_d=float(endurance.numbers.ceiling.max()),
        bound_theta_um=float(endurance.numbers.limit_um),
        events=events,
        recovered=np.inf,
        recovered_whole=np.inf,
        printed_dies_at=_printed(trial, case, base),
    )
    recovered, whole = recovery.ratios(endurance, trial.forgetting)
    return dataclasses.replace(outcome, recovered=recovered, recovered_whole=whole)


def _printed(trial: Trial, case: Case, base: Model) -> int | None:
    """Where Eq. (10) as printed dies in the first samples of the case: NaN and spikes left out, it has no defence."""
    rng = np.random.default_rng(20120321)
    repeated = np.arange(min(PRINTED_SAMPLES, trial.samples)) % case.u_V.size
    y_um = case.y_um[repeated] + rng.normal(0.0, case.noise_um, repeated.size)
    u_V = case.u_V[repeated] + rng.normal(0.0, max(case.noise_V, 1e-12), repeated.size)
    return dies_at(y_um, u_V, base.grid, trial.forgetting, trial.alpha)

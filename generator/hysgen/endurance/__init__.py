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

from hysgen.endurance.cases import SECOND, TS_S, Case, cases, good_drive, measured
from hysgen.endurance.endure import Endurance
from hysgen.endurance.printed import dies_at
from hysgen.endurance.trials import ALLOWED_RATIO, CASES, HEADINGS, Outcome, Trial, rows, trials
from hysgen.fit import FitSettings, fit
from hysgen.learner_status import LEARNER_COUNTERS
from hysgen.learning import LearnerSettings
from hysgen.model import Model
from hysgen.record import Record
from hysgen.simulate import simulate
from hysgen.stage import Stage
from hysgen.terms import Drive

__all__ = ["ALLOWED_RATIO", "CASES", "HEADINGS", "Outcome", "Trial", "bench_model", "rows", "run", "trials"]

Floats = NDArray[np.float64]
Progress = Callable[[float, str], None]

FIT_SEED: Final = 3
GOOD_SEED, VALIDATION_SEED = 1, 2
PRINTED_SAMPLES: Final = 100_000


def bench_model(stage: Stage, rules: int = 6) -> Model:
    """The model whose learner is tried: fitted to one second of good excitation of the stage."""
    u_V = good_drive(FIT_SEED)
    return _fitted(measured(stage, u_V, FIT_SEED), u_V, rules)


def _fitted(y_um: Floats, u_V: Floats, rules: int, forgetting: float = 1.0) -> Model:
    """Least squares over a record, (n,) each; 1 % of its range is added at each end."""
    record = Record.from_arrays(u_V, y_um, TS_S, source="endurance")
    settings = FitSettings(name="bench", rules=rules, method="batch", margin=0.01, forgetting=forgetting)
    return fit(record, settings)


def run(
    todo: Sequence[Trial], progress: Progress | None = None, stage: Stage | None = None, model: Model | None = None
) -> list[Outcome]:
    """Try each of `todo` in turn.

    progress: told the fraction done and which trial is under way. stage: default Stage.nominal(). model: default
    `bench_model`; its learner settings, if any, apply but for forgetting and alpha.
    """
    chosen = stage or Stage.nominal()
    base = model or bench_model(chosen)
    drives = cases(chosen)
    total, done = sum(trial.samples for trial in todo), 0
    outcomes = []
    for trial in todo:

        def advance(samples: int, trial: Trial = trial, before: int = done) -> None:
            if progress is not None:
                progress((before + samples) / total, f"{trial.case}, lambda {trial.forgetting:g}")

        outcomes.append(_outcome(trial, drives[trial.case], base, chosen, advance))
        done += trial.samples
    return outcomes


def _outcome(trial: Trial, case: Case, base: Model, stage: Stage, advance: Callable[[int], None]) -> Outcome:
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
        events=events,
        recovered=np.inf,
        recovered_whole=np.inf,
        printed_dies_at=_printed(trial, case, base),
    )
    recovered, whole = _recovered(endurance, stage, trial)
    return dataclasses.replace(outcome, recovered=recovered, recovered_whole=whole)


def _recovered(endurance: Endurance, stage: Stage, trial: Trial) -> tuple[float, float]:
    """Free-run error after one second of good excitation over that of two fresh fits of the same second.

    The errors belong to a drive that none of them has seen. The fits minimise what the learner does, the one-step
    error, in float64: one forgets as fast as the learner, the other weighs the whole second alike.
    """
    u_V = good_drive(GOOD_SEED)
    good = Case("good excitation", measured(stage, u_V, GOOD_SEED), u_V, noise_um=0.0)
    check_V = good_drive(VALIDATION_SEED, 0.4)
    check_um = measured(stage, check_V, VALIDATION_SEED)
    endurance.feed(good, SECOND)
    after = _free_run_rms(endurance.shadow(), check_V, check_um)
    rules = endurance.model.grid.rules
    fresh, whole = (_fitted(good.y_um, u_V, rules, forgetting) for forgetting in (trial.forgetting, 1.0))
    return after / _free_run_rms(fresh, check_V, check_um), after / _free_run_rms(whole, check_V, check_um)


def _free_run_rms(model: Model, u_V: Floats, y_um: Floats) -> float:
    """rms of the free run's error in um, (n,) each; infinite if the run leaves the numbers."""
    with np.errstate(all="ignore"):
        error = simulate(model, Drive(u_V, TS_S), float(y_um[0])).y_um - y_um
        rms = float(np.sqrt(np.mean(error * error)))
    return rms if np.isfinite(rms) else float("inf")


def _printed(trial: Trial, case: Case, base: Model) -> int | None:
    """Where Eq. (10) as printed dies in the first samples of the case: NaN and spikes left out, it has no defence."""
    rng = np.random.default_rng(20120321)
    repeated = np.arange(min(PRINTED_SAMPLES, trial.samples)) % case.u_V.size
    y_um = case.y_um[repeated] + rng.normal(0.0, case.noise_um, repeated.size)
    u_V = case.u_V[repeated] + rng.normal(0.0, max(case.noise_V, 1e-12), repeated.size)
    return dies_at(y_um, u_V, base.grid, trial.forgetting, trial.alpha)

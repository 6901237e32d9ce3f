"""From a record to a model: partition, least squares, certificates, refinement."""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.typing import NDArray

from hysgen.certify.certificates import certify
from hysgen.fitting.certified import CertifiedSet, certified_set, least_squares_inside
from hysgen.fitting.free_run import free_run_error
from hysgen.fitting.least_squares import Information, information
from hysgen.fitting.partition import structure_for
from hysgen.fitting.refine import Progress, refine
from hysgen.fitting.rls import recursive_least_squares
from hysgen.fitting.settings import FitSettings
from hysgen.machine.threads import one_blas_thread
from hysgen.model.model import Model
from hysgen.model.regression import Starts, Structure, Trust
from hysgen.model.terms import past_input
from hysgen.record import Record

Floats = NDArray[np.float64]


@one_blas_thread()
def fit(
    record: Record,
    settings: FitSettings | None = None,
    trust: Trust | None = None,
    starts: Starts | None = None,
    progress: Progress | None = None,
) -> Model:
    """Fit a model to a record as `settings` say (default: FitSettings()).

    trust: how much each sample counts, one array per segment; 0 leaves it out (outliers).
    starts: states of the terms before each segment, where they are known.
    progress: told the fraction done and one line, now and then.

    The model carries its history (settings, record, what the fit did) and its certificates.
    Raises FitError, ModelError or RecordError with one line.
    """
    chosen = settings or FitSettings()
    structure = structure_for(record, chosen)
    solver = (chosen.forgetting, chosen.alpha, chosen.epsilon, trust, starts)
    if chosen.method == "rls":
        model = _model(record, chosen, structure, recursive_least_squares(record, structure, *solver))
        return _finished(model, record, chosen, {})
    learnt = information(record, structure, *solver)
    allowed = allowed_set(record, structure, chosen, learnt)
    fitted = _inside(record, chosen, structure, learnt, allowed, trust, starts, progress)
    astray = allowed is not None and allowed.invertible and not all(allowed.looped)
    if astray and not certify(fitted[0]).inverse_holds:
        # Zeros of modes and slow states form no convex set: where they go astray, ask for a smaller one that does.
        allowed = allowed_set(record, structure, chosen, learnt, linear_looped=True)
        fitted = _inside(record, chosen, structure, learnt, allowed, trust, starts, progress)
    return _finished(fitted[0], record, chosen, fitted[1])


def _inside(
    record: Record,
    chosen: FitSettings,
    structure: Structure,
    learnt: Information,
    allowed: CertifiedSet | None,
    trust: Trust | None,
    starts: Starts | None,
    progress: Progress | None,
) -> tuple[Model, dict[str, object]]:
    """The model with least error inside the set, and what the fit did."""
    start = learnt.solve() if allowed is None else least_squares_inside(learnt.R, learnt.d, allowed).x
    model = _model(record, chosen, structure, start)
    outcome: dict[str, object] = {}
    if allowed is not None:
        outcome["least_squares_certified"] = allowed.violated(learnt.solve()).floor.size == 0
    if chosen.method == "refined":
        error = free_run_error(record, structure, chosen.settle, trust, starts).held_near(model, learnt)
        before = error.criterion(model)
        refined = refine(model, error, allowed, chosen.iterations, progress)
        model = refined.model
        outcome |= {
            "steps": refined.steps,
            "free_run_rms_um": {"least_squares": before.rms_um, "refined": refined.criterion.rms_um},
            "scored_weight": float(sum(weight[1:].sum() for weight in error.trust)),
        }
    return model, outcome


def allowed_set(
    record: Record, structure: Structure, settings: FitSettings, learnt: Information, linear_looped: bool = False
) -> CertifiedSet | None:
    """The set that a fit has to stay in; None if the settings do not ask for certificates."""
    if not settings.certified:
        return None
    gain_um_per_V = linear_gain(structure, learnt, record.Ts_s)
    return certified_set(
        structure, record.Ts_s, gain_um_per_V, settings.slope_limit, settings.loop_limit, linear_looped
    )


def linear_gain(structure: Structure, learnt: Information, Ts_s: float) -> float:
    """Gain b in um/V of the least-squares model in which all rules are one: y(k+1) = a y + b u + c + theta . phi.

    Without the regressors that are the past input: they would leave even the sign of b to how the samples fall. A mode
    can take nearly all of b to itself, or turn its sign if it is missing: of b with and without the linear terms, the
    larger that has the sign of the static slope s in y = s u + c.
    """
    rules, terms = structure.grid.rules, structure.terms
    one = np.zeros((structure.size, 3))
    one[: 3 * rules] = np.tile(np.eye(3), (rules, 1))
    slope_um_per_V = _tied(learnt, one[:, 1:])[0]
    gains = []
    for linear in (True, False):
        kept = [~past_input(term) & (linear or term.linear(Ts_s) is None) for term in terms]
        phi = np.eye(structure.size)[:, 3 * rules :] * np.concatenate([np.zeros(0), *kept])
        gains.append(float(_tied(learnt, np.hstack([one, phi]))[1]))
    return max((b for b in gains if b * slope_um_per_V > 0.0), key=abs, default=gains[0])


def _tied(learnt: Information, tied: Floats) -> Floats:
    """(m,) least squares over parameters that follow from fewer, q = tied x; tied (p, m)."""
    solution, *_ = np.linalg.lstsq(learnt.R @ tied, learnt.d, rcond=None)
    return np.asarray(solution)


def _model(record: Record, settings: FitSettings, structure: Structure, parameters: Floats) -> Model:
    cut = 3 * structure.grid.rules
    return Model(
        name=settings.name,
        Ts_s=record.Ts_s,
        grid=structure.grid,
        consequents=parameters[:cut].reshape(-1, 3).copy(),
        u_min_V=structure.u_min_V,
        u_max_V=structure.u_max_V,
        terms=structure.terms,
        weights=parameters[cut:].copy(),
        blocks=structure.blocks,
    )


def _finished(model: Model, record: Record, settings: FitSettings, outcome: dict[str, object]) -> Model:
    history = {
        "fit": settings.to_json(),
        "outcome": outcome,
        "record": {
            "source": record.source,
            "digest": record.digest,
            "samples": record.samples,
            "segments": len(record.segments),
        },
    }
    return dataclasses.replace(model, history=history, certificates=certify(model).to_json())

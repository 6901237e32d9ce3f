"""Shape parameters of terms (thresholds, time constants, frequencies) from the free-run error, with their uncertainty.

The same Gauss-Newton as for the linear parameters, with the columns dw/dshape beside them (see `free_run`), so shape
and weights move together. The model is fitted with the given shape first; from there on only steps that lower the error
and keep the certificates are taken.

    cov(x) = s^2 tau H^-1,   s^2 = J/N,   tau = 1 + 2 sum_m rho(m)

H = sum S S' at the end. The residuals of a free run are correlated, which a plain s^2 H^-1 ignores: tau, their
autocorrelation time, widens it. Source: Ljung, System Identification (1999), sections 9.2 and 10.2; Geyer, Statistical
Science 7 (1992) 473-483, for the sum over the initial positive pairs of rho.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import pinvh

from hysgen.certify.certificates import certify
from hysgen.errors import FitError
from hysgen.fitting.free_run import Criterion, FreeRunError, free_run_error
from hysgen.fitting.identify import allowed_set, fit
from hysgen.fitting.least_squares import information
from hysgen.fitting.partition import structure_for
from hysgen.fitting.refine import Progress, refine
from hysgen.fitting.settings import FitSettings
from hysgen.machine import kernels
from hysgen.machine.kernels import Rules
from hysgen.model.model import Model
from hysgen.model.regression import Starts, Trust, structure_of, term_output
from hysgen.record import Record

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class ShapeFit:
    """The refined model, and for each kind its shape parameters with their standard deviations, (m,) each.

    correlation: autocorrelation time of the free-run residuals in samples. rms_um: over the scored samples.
    """

    model: Model
    shapes: dict[str, Floats]
    deviations: dict[str, Floats]
    correlation: float
    rms_um: float
    steps: int


def fit_shape(
    record: Record,
    settings: FitSettings,
    kinds: Sequence[str],
    trust: Trust | None = None,
    starts: Starts | None = None,
    progress: Progress | None = None,
) -> ShapeFit:
    """Fit a model with its terms as in `settings`, then refine its parameters together with the shapes of `kinds`.

    Local: start from shapes near the right ones. Raises FitError if a kind is not among the terms or has no shape.
    """
    for kind in kinds:
        if not any(term.kind == kind and term.shape().size for term in settings.terms):
            raise FitError(f"shape: the model has no term {kind!r} with shape parameters; add it to the terms")
    start = fit(record, dataclasses.replace(settings, method="batch"), trust, starts)
    structure = structure_for(record, settings)
    prior = (settings.forgetting, settings.alpha, settings.epsilon)
    allowed = allowed_set(record, structure, settings, information(record, structure, *prior, trust, starts))
    # Not anchored: the one-step error was taken at the first shape, and would hold the weights back as the shape moves.
    error = free_run_error(record, structure, settings.settle, trust, starts, kinds)
    refined = refine(start, error, allowed, settings.iterations, progress)
    correlation = correlation_time(residuals(refined.model, error))
    deviation = _deviations(refined.criterion, correlation)
    shapes, deviations, at = {}, {}, refined.model.parameters.size
    for term in refined.model.terms:
        if term.kind in error.shaped:
            shapes[term.kind] = term.shape()
            deviations[term.kind] = deviation[at : at + term.shape().size]
            at += term.shape().size
    model = dataclasses.replace(
        refined.model,
        history={**start.history, "shaped": sorted(kinds), "steps": refined.steps},
        certificates=certify(refined.model).to_json(),
    )
    return ShapeFit(model, shapes, deviations, correlation, refined.criterion.rms_um, refined.steps)


def residuals(model: Model, error: FreeRunError) -> list[Floats]:
    """Free-run errors yhat - y of the scored samples, each times the root of its weight, segment by segment."""
    rules = Rules(structure_of(model).range_um, model.consequents)
    found = []
    for segment, drive, trust in zip(error.record.segments, error.drives, error.trust, strict=True):
        w_um = term_output(model, drive)
        y_um, _ = kernels.free_run(rules, drive.u_V, w_um, float(segment.y_um[0]))
        found.append((np.sqrt(trust) * (y_um - segment.y_um))[1:][trust[1:] > 0.0])
    return found


def correlation_time(series: Sequence[Floats]) -> float:
    """tau = 1 + 2 sum_m rho(m) in samples, at least 1, over as many lags as pairs of neighbours stay positive.

    rho is the autocorrelation of all series pooled, about zero mean, for a bias is an error too.
    """
    longest = max((part.size for part in series), default=0)
    if longest < 4:
        return 1.0
    pooled = np.zeros(longest)
    for part in series:
        spectrum = np.abs(np.fft.rfft(part, 2 * part.size)) ** 2
        pooled[: part.size] += np.fft.irfft(spectrum)[: part.size]
    if pooled[0] <= 0.0:
        return 1.0
    rho = pooled / pooled[0]
    pairs = rho[0 : longest - 1 : 2] + rho[1:longest:2]
    negative = np.flatnonzero(pairs <= 0.0)
    stop = int(negative[0]) if negative.size else pairs.size
    return max(1.0, 2.0 * float(pairs[:stop].sum()) - 1.0)


def _deviations(criterion: Criterion, correlation: float) -> Floats:
    """Standard deviations of x; infinite for parameters that the run does not depend on."""
    scale = np.sqrt(np.diag(criterion.hessian))
    told = scale > 0.0
    unit = np.where(told, scale, 1.0)
    covariance = pinvh(criterion.hessian / np.outer(unit, unit))
    variance = criterion.rms_um**2 * correlation * np.clip(np.diag(covariance), 0.0, None) / unit**2
    return np.where(told, np.sqrt(variance), np.inf)

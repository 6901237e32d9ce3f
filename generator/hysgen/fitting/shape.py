"""Shape parameters of terms (thresholds, time constants, frequencies) by least free-run error, with their uncertainty.

Gauss-Newton over weights and shape parameters together, with the columns dw/dshape (see `free_run`). The model is first
fitted with the given shapes; a step is accepted if it lowers the error and keeps the certificates.

    cov(x) = s^2 tau H^-1,   s^2 = J/N,   tau = 1 + 2 sum_m rho(m)

with H = sum S S' at the optimum. The residuals of a free run are correlated; s^2 H^-1 alone holds for independent
residuals, and the autocorrelation time tau corrects it. Source: Ljung, System Identification (1999), sections 9.2 and
10.2; Geyer, Statistical Science 7 (1992) 473-483, for the sum over the initial positive pairs of rho.
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
from hysgen.fitting.identify import allowed_set, fit, structure_for
from hysgen.fitting.least_squares import information
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
    """The refined model, and for each kind its shape parameters and their standard deviations, (m,) each.

    correlation: autocorrelation time tau of the free-run residuals in samples. rms_um: over the scored samples.
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

    The search is local: the shapes in `settings` must be near the optimum.
    Raises FitError if a kind is not among the terms or has no shape parameters.
    """
    for kind in kinds:
        if not any(term.kind == kind and term.shape().size for term in settings.terms):
            raise FitError(f"shape: the model has no term {kind!r} with shape parameters; add it to the terms")
    start = fit(record, dataclasses.replace(settings, method="batch"), trust, starts)
    structure = structure_for(record, settings)
    one_step = information(record, structure, settings.weighting(trust, starts))
    allowed = allowed_set(record, structure, settings, one_step)
    # Without penalties: the one-step information belongs to the initial shape and would bias the weights of another.
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
    """Free-run errors yhat - y of the scored samples times sqrt(weight), one array per segment."""
    rules = Rules(structure_of(model).range_um, model.consequents)
    found = []
    for segment, drive, trust in zip(error.record.segments, error.drives, error.trust, strict=True):
        w_um = term_output(model, drive)
        y_um, _ = kernels.free_run(rules, drive.u_V, w_um, float(segment.y_um[0]))
        found.append((np.sqrt(trust) * (y_um - segment.y_um))[1:][trust[1:] > 0.0])
    return found


def correlation_time(series: Sequence[Floats]) -> float:
    """tau = 1 + 2 sum_m rho(m) in samples, at least 1, summed as long as rho(2m) + rho(2m + 1) is positive.

    rho: autocorrelation pooled over all series, about zero and not about the mean, because a bias is an error too.
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
    """(p,) standard deviations of x; infinite for parameters that the run does not depend on."""
    scale = np.sqrt(np.diag(criterion.hessian))
    determined = scale > 0.0
    unit = np.where(determined, scale, 1.0)
    covariance = pinvh(criterion.hessian / np.outer(unit, unit))
    variance = criterion.rms_um**2 * correlation * np.clip(np.diag(covariance), 0.0, None) / unit**2
    return np.where(determined, np.sqrt(variance), np.inf)

"""The probe's fit by generalised least squares: its residual is an Ornstein-Uhlenbeck process along the path.

    e(k) = m(k) + n(k),    m(k) = exp(-|dv(k)| / length) m(k-1) + w(k),    n white,    var m constant

The model error m of a hysteresis model depends on the path: it is constant at constant input, and its correlation
decays with the distance v that the stage travels. Samples of one plateau therefore share their model error, and their
differences contain only the noise n; ordinary least squares does not use this. A Kalman filter turns the measurement
and every column into innovations, which are nearly independent, so that fits of different chains can be compared by
their likelihood.

Source: Harvey, "Forecasting, Structural Time Series Models and the Kalman Filter" (1989).
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Self

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

from hysgen.diagnosis.probe.chain import Chain
from hysgen.diagnosis.probe.scene import Scene
from hysgen.diagnosis.probe.solve import Fit, refine, rms
from hysgen.machine.kernels import innovation_gains, innovations, lag_states

Floats = NDArray[np.float64]

CORRELATION_LENGTH = 0.05
"""Start of the search for the correlation length of the model error, as a share of the range of the input."""


@dataclass(frozen=True, eq=False)
class Whitening:
    """The Kalman filter of one scene, (n,) each: correlation of m(k) and m(k-1), gains, variances of innovations."""

    keep: Floats
    gain: Floats
    variance: Floats

    def of(self, signals: Floats) -> Floats:
        """Innovations of `signals`, (n,) or (m, n), in standard deviations."""
        return innovations(np.atleast_2d(signals), self.keep, self.gain, self.variance).reshape(signals.shape)


@dataclass(frozen=True, eq=False)
class WhitenedScene(Scene):
    """A scene whose measurement and columns are innovations; chi square of a fit is rows * rms^2.

    `y_um` and the `error` of a fit are in standard deviations, not in um; the chain keeps its units.
    """

    whitening: Whitening = field(kw_only=True)

    @property
    def y_um(self) -> Floats:
        return self.whitening.of(super().y_um)

    def columns(self, chain: Chain) -> Floats:
        return self.whitening.of(super().columns(chain))

    def training_columns(self, chain: Chain) -> Floats:
        return self.columns(chain)[:, self.rows]

    def seen(self, paths: Sequence[Floats], chain: Chain, weights: Floats) -> Floats:
        return self.whitening.of(super().seen(paths, chain, weights))

    def seen_on_rows(self, paths: Sequence[Floats], chain: Chain, weights: Floats) -> Floats:
        return self.seen(paths, chain, weights)[self.rows]

    @classmethod
    def of(cls, scene: Scene, fit: Fit) -> Self:
        """The scene, whitened for the model error and the noise in the residual of a fit (maximum likelihood)."""
        plain = {one.name: getattr(scene, one.name) for one in dataclasses.fields(Scene)}
        return cls(**plain, whitening=_maximum_likelihood(scene, fit))


def whitened_fit(scene: Scene, fit: Fit) -> tuple[WhitenedScene, Fit]:
    """The scene, whitened for the residual of `fit`, and the fit of the same chain to it."""
    whitened = WhitenedScene.of(scene, fit)
    return whitened, refine(whitened, fit.chain)


def _maximum_likelihood(scene: Scene, fit: Fit) -> Whitening:
    """The whitening with the largest likelihood of the residual of `fit`.

    Minimises sum of z(k)^2 + ln var(k) over the correlation length and the standard deviations of m and n, with z the
    innovations on the fitted rows.
    """
    distance = _travelled(scene, fit.chain)
    observed = np.zeros(scene.samples)
    observed[scene.rows] = 1.0
    level_um = rms(fit.error[scene.rows]) + 1e-300

    def whitening(logarithms: Floats) -> Whitening:
        length, model_error_um, noise_um = np.exp(logarithms)
        keep = np.exp(-distance / length)
        return Whitening(keep, *innovation_gains(keep, observed, model_error_um**2, noise_um**2))

    def deviance(logarithms: Floats) -> float:
        trial = whitening(logarithms)
        z = trial.of(fit.error)[scene.rows]
        return float(z @ z + np.log(trial.variance[scene.rows]).sum())

    start = np.log([CORRELATION_LENGTH, level_um, 0.3 * level_um])
    optimum = minimize(deviance, start, method="Nelder-Mead", options={"maxfev": 100, "xatol": 0.02, "fatol": 0.1})
    return whitening(optimum.x)


def _travelled(scene: Scene, chain: Chain) -> Floats:
    """(n,) distance that the stage travels in each step, in ranges of the input; infinite at the start of a run."""
    span_V = scene.operator.high_V - scene.operator.low_V
    distances = []
    for run, command in zip(scene.runs, scene.commands, strict=True):
        rate = np.array([-np.expm1(-command[1] / chain.lag_s)])
        late = max(0, round(chain.delay / run.stride))
        v_V = chain.amplified(*command)
        v_V = np.concatenate([np.full(late, v_V[0]), v_V[: len(v_V) - late]])
        lagged_V = lag_states(v_V, rate, v_V[:1].copy())[:, 0]
        distances.append(np.abs(np.diff(lagged_V, prepend=np.inf)) / span_V)
    return np.concatenate(distances)

"""Standard errors of a fit of the probe, clustered in blocks, and the fit by generalised least squares along the path.

    cov = H^-1 (sum over blocks g_b g_b') H^-1,    H = J J',   g_b = J_b (I - L_b)^-1 e_b,   L_b = J_b' H^-1 J_b

J, (p, n), holds the sensitivities of the shape parameters and of the linear weights, e the residual, b one of 40 blocks
of consecutive rows; L_b is the leverage of block b. The residual of a block is smaller than its error, because the
block takes part in the fit; (I - L_b)^-1 e_b is the residual of a fit without the block.

Sources: Liang and Zeger (1986), cluster-robust covariance; Bell and McCaffrey (2002), leverage.

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
import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Self

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

from hysgen.diagnosis.probe.chain import Chain
from hysgen.diagnosis.probe.scene import Scene
from hysgen.diagnosis.probe.solve import Fit, Projector, projector_off, refine, rms, sensitivities
from hysgen.machine.kernels.operators import lag_states
from hysgen.machine.kernels.run import innovation_gains, innovations
from hysgen.record.series import BLOCKS, block_edges

Floats = NDArray[np.float64]

LEAST_LEVERAGE, MOST_LEVERAGE = 1e-12, 0.99
"""Bounds on the leverage of one block; at 1 the residual of a fit without the block does not exist."""


@dataclass(frozen=True)
class StandardErrors:
    """Standard errors of the chain's coordinates by name, and of the linear weights of the added columns, (q,)."""

    coordinates: Mapping[str, float]
    added: Floats


def standard_errors(scene: Scene, fit: Fit) -> StandardErrors:
    """Cluster-robust standard errors of a fit; infinite for a coordinate without influence on the fitted rows."""
    columns = scene.columns(fit.chain)[:, scene.rows]
    shape_columns = sensitivities(scene, fit, projector_off(scene, fit.chain, columns))
    beside = projector_off(scene, fit.chain, np.vstack([columns, shape_columns]))
    error = block_left_out_error(beside, fit.error[scene.rows])
    shape = _sandwich(shape_columns, error)
    # An added column counts with its component orthogonal to the columns of the hysteresis.
    size = scene.hysteresis_size(fit.chain)
    others = np.vstack([columns[size:], shape_columns])
    linear = _sandwich(_orthogonal_part(others, columns[:size]), error)[: len(columns) - size]
    return StandardErrors(dict(zip(fit.chain.names(), shape.tolist(), strict=True)), linear)


def block_left_out_error(projector: Projector, error: Floats, power: float = 1.0) -> Floats:
    """(n,) residual of each block for the linear fit to all other blocks, on the columns of `projector`.

        (I - L_b)^-power e_b

    error: (n,) residual of the fit to all blocks. power: below 1, a residual between this one and that of the fit to
    all blocks; at 1/2 it has the variance of a white error.
    """
    basis = projector.basis()
    parts = []
    for a, b in itertools.pairwise(block_edges(len(error))):
        part = basis[:, a:b]
        leverage, axes = np.linalg.eigh(part @ part.T)
        leverage = np.clip(leverage, LEAST_LEVERAGE, MOST_LEVERAGE)
        weight = np.expm1(-power * np.log1p(-leverage)) / leverage
        parts.append(error[a:b] + part.T @ (axes @ (weight * (axes.T @ (part @ error[a:b])))))
    return np.concatenate(parts)


def _orthogonal_part(columns: Floats, base: Floats) -> Floats:
    """(m, n) the columns less their projection on `base`, (p, n)."""
    scale = np.sqrt((base**2).sum(axis=1)) + 1e-300
    scaled = base / scale[:, None]
    gram = scaled @ scaled.T + 1e-9 * np.eye(len(base))
    return np.asarray(columns - (np.linalg.solve(gram, scaled @ columns.T).T) @ scaled)


def _sandwich(J: Floats, error: Floats) -> Floats:
    """(p,) square roots of the diagonal of cov for the sensitivities J, (p, n); infinite where J is 0."""
    norm = np.sqrt((J**2).sum(axis=1))
    zero = norm < 1e-12 * (norm.max() + 1e-300)
    scaled = J / np.where(zero, 1.0, norm)[:, None]
    inverse = np.linalg.pinv(scaled @ scaled.T, rcond=1e-12, hermitian=True)
    scores = np.stack([scaled[:, a:b] @ error[a:b] for a, b in itertools.pairwise(block_edges(len(error)))])
    covariance = inverse @ (scores.T @ scores) @ inverse * (BLOCKS - 1) / BLOCKS
    return np.where(zero, np.inf, np.sqrt(np.diag(covariance)) / np.where(zero, 1.0, norm))


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

"""Fitting a chain: linear least squares inside, Gauss-Newton over the shape parameters outside.

    minimise over s and theta   sum over rows (y - Phi(s) theta)^2

theta is eliminated (variable projection; Golub and Pereyra, 1973), in Kaufman's form: the derivative of the residual is
-P d(Phi)/ds theta, with P the projector off the columns. Levenberg-Marquardt: a step that does not lower the rms error
is rejected and repeated with more damping.

Standard errors of a fit of the probe, clustered in blocks, and the fit by generalised least squares along the path.

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
from scipy.linalg import cho_factor, cho_solve, solve_triangular
from scipy.optimize import minimize

from hysgen.diagnosis.probe.chain import Chain
from hysgen.diagnosis.probe.scene import Scene
from hysgen.machine.kernels import innovation_gains, innovations
from hysgen.machine.kernels.operators import lag_states
from hysgen.model.residual import BLOCKS, block_edges

Floats = NDArray[np.float64]

RIDGE = 1e-9

CURVE_RIDGE = 1e-7
"""Ridge of a weight of the sensor's curve, on a column of rms 1; from an rms of 1e-2 on it has no effect. A column that
shows in few samples, maybe in none of the rows, determines no weight: what it adds elsewhere would be arbitrary."""


@dataclass(frozen=True, eq=False)
class Fit:
    """A chain with its linear weights; `error`: (n,) y - prediction on all rows; `rms_um`: rms on the training rows."""

    chain: Chain
    weights: Floats
    error: Floats
    rms_um: float


@dataclass(frozen=True, eq=False)
class Projector:
    """Least squares on fixed columns: weights of a signal, and its component orthogonal to the columns.

    factor: U of U^T U, the Gram matrix of the columns with its ridge.
    """

    columns: Floats
    factor: Floats

    @classmethod
    def of(cls, columns: Floats, curve: slice = slice(0)) -> Projector:
        """Off columns, (p, n). curve: places of those of the sensor's curve (CURVE_RIDGE)."""
        gram = columns @ columns.T
        scale = np.sqrt(np.diag(gram)) + 1e-150
        gram /= np.outer(scale, scale)
        gram[np.diag_indices_from(gram)] += RIDGE
        at = np.arange(len(columns))[curve]
        gram[at, at] += CURVE_RIDGE / np.maximum(scale[at] ** 2 / columns.shape[1], 1e-12)
        return cls(columns, cho_factor(gram)[0] * scale)

    def weights(self, signal: Floats) -> Floats:
        """(p,) weights of the columns for `signal`, (n,)."""
        return np.asarray(cho_solve((self.factor, False), self.columns @ signal))

    def of_rows(self, functional: Floats) -> Floats:
        """(n,) what each row adds to functional @ weights, for a functional, (p,), per um of its signal."""
        return np.asarray(cho_solve((self.factor, False), functional) @ self.columns)

    def basis(self) -> Floats:
        """(p, n) orthonormal combinations of the columns."""
        return np.asarray(solve_triangular(self.factor, self.columns, trans="T"))

    def orthogonal_part(self, signal: Floats) -> Floats:
        """Component of `signal`, (n,) or (c, n), orthogonal to the columns."""
        return np.asarray(signal - cho_solve((self.factor, False), self.columns @ signal.T).T @ self.columns)


@dataclass(frozen=True, eq=False)
class TrainingFit:
    """A chain with its linear weights and the rms error on the training rows.

    projector: off its columns there; None in another process, which computes it sooner than it is sent.
    """

    chain: Chain
    weights: Floats
    rms_um: float
    projector: Projector | None

    def __getstate__(self) -> dict[str, object]:
        return {**self.__dict__, "projector": None}


def linear_fit(scene: Scene, chain: Chain) -> Fit:
    """Least squares over the linear weights with the shape parameters of the chain."""
    columns, y_um = scene.columns(chain), scene.y_um
    weights = projector_off(scene, chain, columns[:, scene.rows]).weights(y_um[scene.rows])
    error = y_um - weights @ columns
    return Fit(chain, weights, error, rms(error[scene.rows]))


def projector_off(scene: Scene, chain: Chain, columns: Floats) -> Projector:
    """The projector of the fits: off the columns of a chain, (p, r), or off more columns that follow them."""
    return Projector.of(columns, scene.curve_columns(chain))


def training_fit(scene: Scene, chain: Chain) -> TrainingFit:
    """`linear_fit` without the error outside the training rows."""
    return _on_rows(scene, chain, scene.training_columns(chain))


def single_fit(scene: Scene, chain: Chain) -> Fit:
    """`linear_fit` of a chain whose columns over all rows of the scene nobody else needs: they are not formed."""
    weights = _on_rows(scene, chain, scene.training_columns_once(chain)).weights
    error = scene.y_um - scene.seen(scene.moved_paths(chain, weights), chain, weights)
    return Fit(chain, weights, error, rms(error[scene.rows]))


def _on_rows(scene: Scene, chain: Chain, columns: Floats) -> TrainingFit:
    y_um, projector = scene.y_um[scene.rows], projector_off(scene, chain, columns)
    weights = projector.weights(y_um)
    return TrainingFit(chain, weights, rms(y_um - weights @ columns), projector)


def refine(scene: Scene, chain: Chain, rounds: int = 12, start: TrainingFit | None = None) -> Fit:
    """Least squares over weights and shape parameters, from `chain`. start: `training_fit` of `chain`, if known.

    Stops after `rounds` rounds, or if a round lowers the rms by less than the share 1e-4.
    If the scene keeps fits, the refined chain is kept on the disk for these inputs: an interrupted search that starts
    again takes it from there. The weights follow from the chain, so both give the same bits.
    """

    def refined() -> Chain:
        return _refined(scene, start or training_fit(scene, chain), rounds)

    best = refined() if scene.kept is None else scene.kept.get((scene, chain, rounds), refined)
    return linear_fit(scene, best)


def _refined(scene: Scene, best: TrainingFit, rounds: int) -> Chain:
    """The chain of `refine`, by Gauss-Newton on the training rows from the fit `best`."""
    y_um = scene.y_um[scene.rows]
    damping = 1e-3
    for _ in range(rounds):
        projector = best.projector or projector_off(scene, best.chain, scene.training_columns(best.chain))
        jacobian = sensitivities(scene, best, projector)
        error = projector.orthogonal_part(y_um)
        norm = np.sqrt((jacobian**2).sum(axis=1)) + 1e-300
        scaled = jacobian / norm[:, None]
        gram, slope = scaled @ scaled.T, scaled @ error
        before = best.rms_um
        for _ in range(5):
            step = np.linalg.solve(gram + damping * np.eye(len(norm)), slope) / norm
            trial = training_fit(scene, best.chain.bounded(best.chain.coordinates() + step, scene.extent))
            if trial.rms_um < best.rms_um:
                best, damping = trial, damping * 0.2
                break
            damping *= 10.0
        if best.rms_um > before * (1.0 - 1e-4):
            break
    return best.chain


def sensitivities(scene: Scene, fit: Fit | TrainingFit, projector: Projector) -> Floats:
    """(c, rows) d(prediction)/d(coordinates) on the training rows, projected off the columns of the fit's chain."""
    return projector.orthogonal_part(_moved(scene, fit))


def _moved(scene: Scene, fit: Fit | TrainingFit) -> Floats:
    """(c, rows) d(prediction)/d(coordinates) on the training rows, with the weights of the fit.

    The derivatives are forward differences; the chain is smooth except where a limit begins to act.
    """
    paths = scene.paths(fit.chain, fit.weights)
    base = scene.seen_on_rows(paths, fit.chain, fit.weights)
    at = fit.chain.coordinates()
    moved = np.empty((len(at), len(base)))
    for i, size in enumerate(fit.chain.steps(scene.extent)):
        shifted = at.copy()
        shifted[i] += size
        chain = fit.chain.at(shifted)
        here = paths if chain.amplifier == fit.chain.amplifier else scene.moved_paths(chain, fit.weights)
        moved[i] = (scene.seen_on_rows(here, chain, fit.weights) - base) / size
    return moved


def rms(values: Floats) -> float:
    """Root mean square."""
    return float(np.sqrt(np.mean(values * values)))


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
    linear = _sandwich(Projector.of(columns[:size]).orthogonal_part(others), error)[: len(columns) - size]
    return StandardErrors(dict(zip(fit.chain.names(), shape.tolist(), strict=True)), linear)


def functional_error(scene: Scene, fit: Fit, functional: Floats) -> float:
    """Cluster-robust standard error of functional @ weights of h, for a functional, (size of h,), in its unit.

    The shape parameters are fitted, too: a lag that is not known leaves the loop unknown.
    """
    columns = np.vstack([scene.training_columns(fit.chain), _moved(scene, fit)])
    beside = projector_off(scene, fit.chain, columns)
    error = block_left_out_error(beside, fit.error[scene.rows])
    of_all = np.concatenate([functional, np.zeros(len(columns) - len(functional))])
    parts = beside.of_rows(of_all) * error
    sums = [parts[a:b].sum() for a, b in itertools.pairwise(block_edges(len(error)))]
    return float(np.sqrt(_clustered(np.array(sums))))


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


def _sandwich(J: Floats, error: Floats) -> Floats:
    """(p,) square roots of the diagonal of cov for the sensitivities J, (p, n); infinite where J is 0."""
    norm = np.sqrt((J**2).sum(axis=1))
    zero = norm < 1e-12 * (norm.max() + 1e-300)
    scaled = J / np.where(zero, 1.0, norm)[:, None]
    inverse = np.linalg.pinv(scaled @ scaled.T, rcond=1e-12, hermitian=True)
    scores = np.stack([scaled[:, a:b] @ error[a:b] for a, b in itertools.pairwise(block_edges(len(error)))])
    return np.where(zero, np.inf, np.sqrt(_clustered(scores @ inverse)) / np.where(zero, 1.0, norm))


def _clustered(parts: Floats) -> Floats:
    """Variance of the sum of what each block adds, (BLOCKS,) or (BLOCKS, p)."""
    return np.asarray((parts**2).sum(axis=0) * (BLOCKS - 1) / BLOCKS)


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

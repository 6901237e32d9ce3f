"""Fitting a chain: linear least squares inside, Gauss-Newton over the shape parameters outside.

    minimise over s and theta   sum over rows (y - Phi(s) theta)^2

theta is eliminated (variable projection; Golub and Pereyra, 1973), in Kaufman's form: the derivative of the residual is
-P d(Phi)/ds theta, with P the projector off the columns. Levenberg-Marquardt: a step that does not lower the rms error
is rejected and repeated with more damping.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve, solve_triangular

from hysgen.diagnosis.probe.chain import Chain
from hysgen.diagnosis.probe.scene import Scene

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
    """Least squares on fixed columns: weights of a signal, and its component orthogonal to the columns."""

    columns: Floats
    scale: Floats
    factor: tuple[NDArray[np.float64], bool]

    @classmethod
    def of(cls, columns: Floats, curve: slice = slice(0)) -> Projector:
        """Off columns, (p, n). curve: places of those of the sensor's curve (CURVE_RIDGE)."""
        scale = np.sqrt(np.einsum("ij,ij->i", columns, columns)) + 1e-300
        scaled = columns / scale[:, None]
        gram = scaled @ scaled.T
        gram[np.diag_indices_from(gram)] += RIDGE
        at = np.arange(len(columns))[curve]
        gram[at, at] += CURVE_RIDGE / np.maximum(scale[at] ** 2 / columns.shape[1], 1e-12)
        return cls(scaled, scale, cho_factor(gram))

    def weights(self, signal: Floats) -> Floats:
        """(p,) weights of the columns for `signal`, (n,)."""
        return np.asarray(cho_solve(self.factor, self.columns @ signal) / self.scale)

    def basis(self) -> Floats:
        """(p, n) orthonormal combinations of the columns."""
        factor, lower = self.factor
        return np.asarray(solve_triangular(factor, self.columns, trans="N" if lower else "T", lower=lower))

    def orthogonal_part(self, signal: Floats) -> Floats:
        """Component of `signal`, (n,) or (c, n), orthogonal to the columns."""
        return np.asarray(signal - cho_solve(self.factor, self.columns @ signal.T).T @ self.columns)


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
    columns, y_um = scene.training_columns(chain), scene.y_um[scene.rows]
    projector = projector_off(scene, chain, columns)
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
    """(c, rows) d(prediction)/d(coordinates) on the training rows, projected off the columns.

    projector: off the columns of the fit's chain. The derivatives are forward differences; the chain is smooth except
    where a limit begins to act.
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
    return projector.orthogonal_part(moved)


def rms(values: Floats) -> float:
    """Root mean square."""
    return float(np.sqrt(np.mean(values * values)))

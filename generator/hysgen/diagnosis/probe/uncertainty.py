"""Cluster-robust standard errors of a fit of the probe: the error may be correlated within blocks of samples.

    cov = H^-1 (sum over blocks g_b g_b') H^-1,    H = J J',   g_b = J_b (I - L_b)^-1 e_b,   L_b = J_b' H^-1 J_b

J, (p, n), holds the sensitivities of the shape parameters and of the linear weights, e the residual, b one of 40 blocks
of consecutive rows; L_b is the leverage of block b. The residual of a block is smaller than its error, because the
block takes part in the fit; (I - L_b)^-1 e_b is the residual of a fit without the block.

Sources: Liang and Zeger (1986), cluster-robust covariance; Bell and McCaffrey (2002), leverage.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hysgen.diagnosis.probe.scene import Scene
from hysgen.diagnosis.probe.solve import Fit, Projector, projector_off, sensitivities

Floats = NDArray[np.float64]

BLOCKS = 40

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


def block_edges(rows: int) -> NDArray[np.intp]:
    return np.linspace(0, rows, BLOCKS + 1).astype(np.intp)


def _sandwich(J: Floats, error: Floats) -> Floats:
    """(p,) square roots of the diagonal of cov for the sensitivities J, (p, n); infinite where J is 0."""
    norm = np.sqrt((J**2).sum(axis=1))
    zero = norm < 1e-12 * (norm.max() + 1e-300)
    scaled = J / np.where(zero, 1.0, norm)[:, None]
    inverse = np.linalg.pinv(scaled @ scaled.T, rcond=1e-12, hermitian=True)
    scores = np.stack([scaled[:, a:b] @ error[a:b] for a, b in itertools.pairwise(block_edges(len(error)))])
    covariance = inverse @ (scores.T @ scores) @ inverse * (BLOCKS - 1) / BLOCKS
    return np.where(zero, np.inf, np.sqrt(np.diag(covariance)) / np.where(zero, 1.0, norm))

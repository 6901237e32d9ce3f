"""Standard errors that do not believe in independent samples.

    cov = H^-1 (sum over blocks g_b g_b') H^-1,    H = J J',   g_b = J_b (I - L_b)^-1 e_b,   L_b = J_b' H^-1 J_b

J holds the sensitivities of shape parameters and of linear weights. Errors may be correlated within a block in any way
(cluster-robust covariance; Liang and Zeger, 1986). A fit bends towards the errors of each block and leaves them too
small; (I - L_b)^-1 e_b is what the block shows to a fit that leaves it out (Bell and McCaffrey, 2002).
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hysgen.diagnosis.probe.scene import Scene
from hysgen.diagnosis.probe.solve import Fit, Projector, sensitivities

Floats = NDArray[np.float64]

BLOCKS = 40

MOST_LEVERAGE = 0.99
"""Share of what a direction of the columns is known by that is taken to stand in one block at most."""


@dataclass(frozen=True)
class Errors:
    """Standard errors of the chain's coordinates by name, and of the linear weights of the added columns, (q,)."""

    coordinates: Mapping[str, float]
    added: Floats


def standard_errors(scene: Scene, fit: Fit) -> Errors:
    """Cluster-robust standard errors of a fit; a coordinate that the record does not move has an infinite one."""
    columns = scene.columns(fit.chain)[:, scene.rows]
    moved = sensitivities(scene, fit, Projector.of(columns))
    error = left_out(np.vstack([columns, moved]), fit.error[scene.rows])
    shape = _sandwich(moved, error)
    # For an added column, everything else is eliminated: the column less its projection on all others.
    size = scene.hysteresis_size(fit.chain)
    rest = np.vstack([columns[size:], moved])
    linear = _sandwich(_off(rest, columns[:size]), error)[: len(columns) - size]
    return Errors(dict(zip(fit.chain.names(), shape.tolist(), strict=True)), linear)


def left_out(columns: Floats, error: Floats) -> Floats:
    """(n,) error of each block for a linear fit on `columns`, (p, n), that leaves the block out."""
    basis = Projector.of(columns).basis()
    parts = []
    for a, b in itertools.pairwise(_edges(len(error))):
        part = basis[:, a:b]
        share, axes = np.linalg.eigh(part @ part.T)
        # What this block alone decides is known no better than MOST_LEVERAGE says.
        weight = 1.0 / (1.0 - np.minimum(share, MOST_LEVERAGE))
        parts.append(error[a:b] + part.T @ (axes @ (weight * (axes.T @ (part @ error[a:b])))))
    return np.concatenate(parts)


def _off(columns: Floats, base: Floats) -> Floats:
    scale = np.sqrt((base**2).sum(axis=1)) + 1e-300
    scaled = base / scale[:, None]
    gram = scaled @ scaled.T + 1e-9 * np.eye(len(base))
    return np.asarray(columns - (np.linalg.solve(gram, scaled @ columns.T).T) @ scaled)


def _edges(rows: int) -> NDArray[np.intp]:
    return np.linspace(0, rows, BLOCKS + 1).astype(np.intp)


def _sandwich(J: Floats, error: Floats) -> Floats:
    norm = np.sqrt((J**2).sum(axis=1))
    lost = norm < 1e-12 * (norm.max() + 1e-300)
    scaled = J / np.where(lost, 1.0, norm)[:, None]
    inverse = np.linalg.pinv(scaled @ scaled.T, rcond=1e-12, hermitian=True)
    scores = np.stack([scaled[:, a:b] @ error[a:b] for a, b in itertools.pairwise(_edges(len(error)))])
    covariance = inverse @ (scores.T @ scores) @ inverse * (BLOCKS - 1) / BLOCKS
    return np.where(lost, np.inf, np.sqrt(np.diag(covariance)) / np.where(lost, 1.0, norm))

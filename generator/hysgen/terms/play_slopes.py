"""How far the outputs of weighted play operators can be apart under two inputs: no more than their slopes together.

    w = sum_j g_j(z_j),   g_j(z) = theta_j z + theta_2j T_2(x_j) + theta_3j T_3(x_j),   x_j = clamp((z - middle)/half)

Two inputs that are never further apart than d leave plays that are never further apart than d. With their states z and
z' and z_t = z' + t (z - z'), 0 <= t <= 1,

    |w - w'| <= d  max over t of sum_j |g_j'(z_t,j)|

and z_t is a state that plays can have: neighbours are no further apart than their half-widths differ,
|z_i - z_j| <= |r_i - r_j|, for that holds for z and z'. So not every play can stand at its own steepest place at once,
and the bound is the steepest state of all: a longest path over cells of z, from play to play. Each cell counts with the
largest slope in it and paths may move one cell more than the half-widths allow: the bound is above, never below.

Source of the neighbours' rule: Krasnosel'skii and Pokrovskii, Systems with Hysteresis (1989), section 2.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

Floats = NDArray[np.float64]

CELLS = 96
"""Cells of the range of the input: twice as many lower the bound by less than a hundredth."""


def steepest_state(weights: Floats, r_over_half: Floats, reach: Floats, half_V: float) -> Floats:
    """(size,) slopes d(phi_j)/dz, signed, in the steepest state: their product with `weights` is the bound.

    For other weights the product is at most their own bound, so {weights: row @ weights <= limit} holds all weights
    whose bound is below the limit. weights: (degree m,) of plays, then T_2, then T_3; r_over_half: (m,) half-widths and
    reach: (m,) largest |x_j|, in half ranges; half_V: half the range.
    """
    m = r_over_half.size
    per_play = weights.reshape(-1, m)
    edges = np.linspace(-1.0, 1.0, CELLS + 1)
    values, places = _steepest_in_cells(per_play, edges, reach, half_V)
    best, came = values[0], np.zeros((m, CELLS), dtype=np.intp)
    for j in range(1, m):
        # One cell more than the difference of the half-widths, for both ends of the move may stand anywhere in theirs.
        window = int(np.floor((r_over_half[j] - r_over_half[j - 1]) * 0.5 * CELLS)) + 1
        around = sliding_window_view(np.pad(best, window, constant_values=-np.inf), 2 * window + 1)
        at = np.argmax(around, axis=1)
        came[j] = np.arange(CELLS) + at - window
        best = values[j] + around[np.arange(CELLS), at]
    cell = int(np.argmax(best))
    path = np.empty(m, dtype=np.intp)
    for j in range(m - 1, -1, -1):
        path[j] = cell
        cell = int(came[j, cell])
    there = slopes(places[np.arange(m), path], reach, half_V, len(per_play))
    return np.asarray((there * np.sign((there * per_play).sum(axis=0))).ravel())


def steepest_places(weights: Floats, reach: Floats, half_V: float) -> Floats:
    """(size,) slopes, signed, of every play at its own steepest place: `steepest_state` without the neighbours' rule.

    Never less, and for weights of one density little more; a fit comes to rest at it in fewer steps.
    """
    per_play = weights.reshape(-1, reach.size)
    _, x = _steepest_in_cells(per_play, np.array([-1.0, 1.0]), reach, half_V)
    there = slopes(x[:, 0], reach, half_V, len(per_play))
    return np.asarray((there * np.sign((there * per_play).sum(axis=0))).ravel())


def _steepest_in_cells(per_play: Floats, edges: Floats, reach: Floats, half_V: float) -> tuple[Floats, Floats]:
    """(m, cells) largest |g_j'| in each cell, and the x where it is met: at an end, at the reach or where g'' is 0."""
    low, high = edges[:-1], edges[1:]
    shape = (reach.size, low.size)
    candidates = [np.broadcast_to(low, shape), np.broadcast_to(high, shape)]
    if len(per_play) == 3:
        with np.errstate(divide="ignore", invalid="ignore"):
            turn = np.nan_to_num(-per_play[1] / (6.0 * per_play[2]), nan=0.0, posinf=0.0, neginf=0.0)
        candidates.append(np.clip(turn[:, None], low, high))
    if len(per_play) > 1:
        candidates += [np.clip(side * reach[:, None], low, high) for side in (-1.0, 1.0)]
    x = np.stack(candidates)
    value = np.abs((slopes(x, reach[:, None], half_V, len(per_play)) * per_play[:, None, :, None]).sum(axis=0))
    first = np.argmax(value, axis=0)[None]
    return np.take_along_axis(value, first, 0)[0], np.take_along_axis(x, first, 0)[0]


def slopes(x: Floats, reach: Floats, half_V: float, degree: int) -> Floats:
    """(degree, ...) d(phi)/dz at x: 1, T_2'/half, T_3'/half; beyond the reach, where a play may start, 1, 0, 0."""
    inside = np.abs(x) <= reach
    bent: Sequence[Floats] = (
        np.ones_like(x),
        np.where(inside, 4.0 * x / half_V, 0.0),
        np.where(inside, (12.0 * x * x - 3.0) / half_V, 0.0),
    )
    return np.stack(bent[:degree])

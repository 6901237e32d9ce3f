"""Inputs and expected bit patterns of the self-test on the target, computed by the float32 reference."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hysgen.float32.reference.instance import Instance
from hysgen.machine.reproducible import drawn
from hysgen.model.model import Model
from hysgen.model.status import COUNTERS

Words = NDArray[np.uint32]

ROWS: Final = 32
RAMP: Final = 16
"""Samples between the levels of a ramp."""
SEED: Final = 20120321


@dataclass(frozen=True)
class CallSequence:
    """Successive calls of one function after `_init`.

    start: bit patterns of the arguments of `_init`. rows: bit patterns of arguments, channels and result of each call;
    comments: the same as decimal numbers. status, counters: expected words of the struct after the last call.
    """

    function: str
    start: tuple[int, int]
    rows: Sequence[tuple[Sequence[int], Sequence[int], int]]
    comments: Sequence[str]
    status: int
    counters: Sequence[tuple[str, int]]

    @property
    def columns(self) -> int:
        """Number of words in a row."""
        return len(self.rows[0][0]) + len(self.rows[0][1]) + 1


def chains(model: Model, *, inverse: bool) -> list[CallSequence]:
    """One chain per function, with arguments in range, at its limits, outside, tiny, huge and not finite."""
    functions = ["predict", "simulate", *(["inverse"] if inverse else [])]
    return [_chain(model, function, seed) for seed, function in enumerate(functions, SEED)]


def _chain(model: Model, function: str, seed: int) -> CallSequence:
    rng = np.random.default_rng(seed)
    y0, u0 = np.float32(0.5 * (model.grid.y_min_um + model.grid.y_max_um)), np.float32(0.0)
    lane = Instance(model, np.full(1, y0), np.full(1, u0))
    y, u, y_next = (_column(rng, *limits) for limits in _limits(model))
    ordinary = np.arange(ROWS) % 3 != 2
    y_next[ordinary] = (_followed if model.responds else _reachable)(model, y, rng)[ordinary]
    arguments = {"predict": [y, u], "simulate": [u], "inverse": [y, y_next]}[function]
    channels = [_column(rng, np.float32(-1.0), np.float32(40.0)) for _ in lane.channels]
    rows, comments = [], []
    with np.errstate(all="ignore"):
        for k in range(ROWS):
            if channels:
                lane.aux([column[k : k + 1] for column in channels])
            result = getattr(lane, function)(*(column[k : k + 1] for column in arguments))
            rows.append((_bits(arguments, k), _bits(channels, k), int(result.view(np.uint32)[0])))
            inputs = ", ".join(f"{column[k]:.6g}" for column in (*arguments, *channels))
            comments.append(f"{inputs} -> {result[0]:.6g}")
    return CallSequence(
        function=function,
        start=(int(y0.view(np.uint32)), int(u0.view(np.uint32))),
        rows=rows,
        comments=comments,
        status=int(lane.status[0]),
        counters=[(name, int(lane.counters[name][0])) for name in COUNTERS],
    )


def _reachable(model: Model, y: NDArray[np.float32], rng: np.random.Generator) -> NDArray[np.float32]:
    """Displacements y(k+1), (ROWS,), that random inputs in range reach from y, the terms in their initial state."""
    u = drawn(rng, model.u_min_V, model.u_max_V, ROWS).astype(np.float32)
    with np.errstate(all="ignore"):
        return Instance(model, y, np.zeros(ROWS, dtype=np.float32)).predict(y, u)


def _followed(model: Model, y: NDArray[np.float32], rng: np.random.Generator) -> NDArray[np.float32]:
    """Displacements y(k+1), (ROWS,), that the model predicts from y along a random ramp: what the path allows."""
    levels = np.append(0.0, drawn(rng, model.u_min_V, model.u_max_V, ROWS // RAMP))
    u = np.interp(np.arange(ROWS) / RAMP, np.arange(levels.size), levels).astype(np.float32)
    lane = Instance(model, y[:1], u[:1])
    with np.errstate(all="ignore"):
        return np.concatenate([lane.predict(y[k : k + 1], u[k : k + 1]) for k in range(ROWS)])


def _limits(model: Model) -> list[tuple[np.float32, np.float32]]:
    range_um = (np.float32(model.grid.y_min_um), np.float32(model.grid.y_max_um))
    return [range_um, (np.float32(model.u_min_V), np.float32(model.u_max_V)), range_um]


def _column(rng: np.random.Generator, low: np.float32, high: np.float32) -> NDArray[np.float32]:
    """(ROWS,) values: every third is a limit, outside, tiny, huge or not finite, the others are uniform in range."""
    column = drawn(rng, float(low), float(high), ROWS).astype(np.float32)
    special = [low, high, 2 * low - high, 2 * high - low, 0.0, -0.0, 1e-40, -1e30, np.inf, -np.inf, np.nan]
    column[2::3] = rng.permutation(np.array(special, dtype=np.float32))[: column[2::3].size]
    return column


def _bits(columns: Sequence[NDArray[np.float32]], k: int) -> list[int]:
    return [int(column[k : k + 1].view(np.uint32)[0]) for column in columns]

"""The first rows of a record whose simulation depends on the unknown input before the record.

A hysteresis keeps the extremes of the input before the record until later extremes wipe them out. Two runs of the block
bound its state: one after the lowest input of its range, one after the highest,

    d(k) = |h(k) after the highest - h(k) after the lowest|,   m(k) = max of d from k on

d falls to zero where the record covers the range of the model. Where it does not, a part m(n-1) never falls: no row
to leave out lowers it, and it is part of the error.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hysgen.model.model import Model
from hysgen.model.path.hysteresis import Hysteresis
from hysgen.record import Record

Floats = NDArray[np.float64]

LATEST = 0.8
"""Largest share of a segment that is left out: with more, too little is left for a score."""

ABOVE_NOISE, OF_SPAN = 2.0, 1e-3
"""A difference counts above this multiple of the noise floor, or above this share of the span if that is more."""


@dataclass(frozen=True)
class UnknownPast:
    """rows: at the start of each segment, in which the unknown past matters. later_um: what it may be after them."""

    rows: tuple[int, ...]
    later_um: float

    def describe(self, source: str, with_them_um: float) -> list[str]:
        """Lines for people; none if no row is left out. with_them_um: rms error of the free run with these rows."""
        lines = []
        if any(self.rows):
            lines.append(
                f"not scored: the first {', '.join(map(str, self.rows))} samples depend on the input before the "
                f"record, which is unknown; with them the free run is wrong by {with_them_um:.5f} um"
            )
        if self.later_um > 0.0:
            lines.append(
                f"{source}: the scored samples too depend on the input before the record, by up to {self.later_um:.2g} "
                "um: the record does not cover the range of the model"
            )
        return lines


def unknown_past(model: Model, record: Record, noise_um: float) -> UnknownPast:
    """The rows of a record in which the unknown past matters; none for a model without hysteresis.

    noise_um: noise floor of the record. A known past (`Segment.past`) takes the place of the first rows.
    """
    at = next((i for i, block in enumerate(model.blocks) if isinstance(block, Hysteresis)), None)
    if at is None:
        return UnknownPast((0,) * len(record.segments), 0.0)
    hysteresis = model.blocks[at]
    assert isinstance(hysteresis, Hysteresis)
    low_um, high_um = record.y_range_um
    least_um = max(ABOVE_NOISE * noise_um, OF_SPAN * (high_um - low_um))
    rows, later_um = [], 0.0
    for segment, past in zip(record.whole().segments, record.past_samples, strict=True):
        v_V = np.clip(segment.u_V, model.u_min_V, model.u_max_V)
        for block in model.blocks[:at]:
            v_V = block.apply(v_V, model.Ts_s)
        later = _largest_later(hysteresis, v_V)
        first = min(int(np.argmax(later <= later[-1] + least_um)), int(LATEST * v_V.size))
        rows.append(max(first - past, 0))
        later_um = max(later_um, float(later[max(first, past)]))
    return UnknownPast(tuple(rows), later_um if later_um > 2.0 * least_um else 0.0)


def _largest_later(hysteresis: Hysteresis, v_V: Floats) -> Floats:
    """m(k), (n,), of the inputs v_V of the block, (n,)."""
    low, high = (
        hysteresis.apply(np.concatenate([[end_V], v_V]), 1.0)[1:] for end_V in (hysteresis.low_V, hysteresis.high_V)
    )
    return np.asarray(np.maximum.accumulate(np.abs(high - low)[::-1])[::-1])

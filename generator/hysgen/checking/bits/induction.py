"""Equality of whole runs by induction: equal at the start, and every step from a recorded state equal to the next.

The C runs a chain of samples and records its state after each. The reference takes all these states as lanes, steps
each by its sample, and must arrive at the state that follows it in the record, with the same result. If it does from
the first state on, both would have produced the same run, however long, though the reference never ran it in a row.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hysgen.checking.bits.functions import Lanes

Words = NDArray[np.uint32]


@dataclass(frozen=True)
class Difference:
    """The first sample at which C and reference part: the word that differs, and its bits.

    place: index of the word in the state, None if it is the result.
    """

    sample: int
    place: int | None
    got: int
    expected: int


def first_difference(
    lanes: Lanes, function: str, inputs: Sequence[Words], aux: Sequence[Words], before: Words, out: Words, after: Words
) -> Difference | None:
    """Where a recorded run of `function` leaves the reference, or None.

    inputs, aux: bits of arguments and auxiliary channels, (n,) each; before, after: (n, words) states around each
    sample; out: (n,) bits of the results (0 where the function returns nothing).
    """
    with np.errstate(all="ignore"):
        lanes.restore(list(np.ascontiguousarray(before.T)))
        if aux:
            lanes.aux([column.view(np.float32) for column in aux])  # type: ignore[attr-defined]
        result = getattr(lanes, function)(*(column.view(np.float32) for column in inputs))
    expected = np.zeros_like(out) if result is None else result.view(np.uint32)
    found = _earlier(None, None, out, expected)
    for place, word in enumerate(lanes.words().values()):
        found = _earlier(found, place, after[:, place], word)
    return found


def _earlier(found: Difference | None, place: int | None, got: Words, expected: Words) -> Difference | None:
    """`found`, or the first difference of this word if it comes at an earlier sample."""
    wrong = np.flatnonzero(got != expected)
    if not wrong.size or (found is not None and found.sample <= wrong[0]):
        return found
    sample = int(wrong[0])
    return Difference(sample, place, int(got[sample]), int(expected[sample]))

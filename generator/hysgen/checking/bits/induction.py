"""Equality of whole runs by induction: equal at the start, and every step from a recorded state equal to the next.

The C runs a chain of samples and records its state after each. The reference takes all recorded states as lanes, steps
each lane by its sample, and must reproduce the next recorded state and the result. If every step agrees from the first
state on, C and reference would have produced the same run of any length, although the reference never ran in sequence.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hysgen.checking.bits.functions import Lanes

Words = NDArray[np.uint32]


@dataclass(frozen=True)
class CallTrace:
    """A recorded chain of n calls of one function, as bit patterns.

    inputs, aux: arguments and auxiliary channels, (n,) each. before, after: (n, words) states before and after each
    call. results: (n,), 0 where the function returns nothing.
    """

    inputs: Sequence[Words]
    aux: Sequence[Words]
    before: Words
    results: Words
    after: Words

    def equals(self, other: CallTrace) -> bool:
        """Whether two traces of the same inputs agree in every state and result."""
        pairs = ((self.before, other.before), (self.results, other.results), (self.after, other.after))
        return all(np.array_equal(mine, theirs) for mine, theirs in pairs)


@dataclass(frozen=True)
class Difference:
    """The first sample at which C and reference differ: the word that differs, and its bits.

    place: index of the word in the state; None for the result.
    """

    sample: int
    place: int | None
    got: int
    expected: int


def first_difference(lanes: Lanes, function: str, trace: CallTrace) -> Difference | None:
    """The first difference between a recorded run of `function` and the reference, or None."""
    with np.errstate(all="ignore"):
        lanes.restore(list(np.ascontiguousarray(trace.before.T)))
        if trace.aux:
            lanes.aux([column.view(np.float32) for column in trace.aux])  # type: ignore[attr-defined]
        result = getattr(lanes, function)(*(column.view(np.float32) for column in trace.inputs))
    expected = np.zeros_like(trace.results) if result is None else result.view(np.uint32)
    difference = _earlier(None, None, trace.results, expected)
    for place, word in enumerate(lanes.words().values()):
        difference = _earlier(difference, place, trace.after[:, place], word)
    return difference


def _earlier(difference: Difference | None, place: int | None, got: Words, expected: Words) -> Difference | None:
    """`difference`, or the first difference of this word if it comes at an earlier sample."""
    wrong = np.flatnonzero(got != expected)
    if not wrong.size or (difference is not None and difference.sample <= wrong[0]):
        return difference
    sample = int(wrong[0])
    return Difference(sample, place, int(got[sample]), int(expected[sample]))

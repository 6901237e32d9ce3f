"""Division of one update of the learner among several calls: the columns of U that each call computes.

    begin, f = U' x by columns, diagonal (alpha, l, D) | U and P x by columns, step (theta)

Each call computes neighbouring columns of one half. The cuts minimise the cycles of the most expensive call; the result
does not depend on them. A call without columns is allowed: `diagonal` or `step` may fill a call, and there may be more
calls than columns. After a restart, each call writes one slice of the second half of U = I.

Costs are stall-free cycles of the C674x, measured at 18, 27, 36 and 54 parameters (docs/target.md).
"""

from __future__ import annotations

import functools
from bisect import bisect_left, bisect_right
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import accumulate
from typing import Final

WRITTEN_OUT: Final = 24
"""Largest number of parameters with straight-line code for each element of U; above, loops run over columns."""

COLUMNS_PER_PASS: Final = 6
"""Columns of U' x that one pass of the loop computes together, above WRITTEN_OUT parameters."""

# Cycles per element of U up to WRITTEN_OUT parameters, per row of a pass or column above, per parameter elsewhere.
_PROJECT_ELEMENT, _FACTOR_ELEMENT = 1.7, 3.1
_PROJECT_PASS, _FACTOR_COLUMN = 7.4, 4.2
_BEGIN, _DIAGONAL, _STEP = 11.0, 30.0, 15.5


@dataclass(frozen=True)
class UpdateSchedule:
    """Division of an update among `calls` calls.

    project, factor: borders 0, ..., n between the columns of successive calls, in either half of the update.
    largest_cycles: cycles of the most expensive call.
    """

    calls: int
    project: tuple[int, ...]
    factor: tuple[int, ...]
    largest_cycles: float

    @property
    def single_call(self) -> bool:
        """Whether one call does a whole update or writes all of U."""
        return self.calls == 1

    @property
    def clearing(self) -> int:
        """First phase after a restart, which writes the first columns of U; phases 1 .. calls belong to an update."""
        return self.calls + 1

    @property
    def phases(self) -> int:
        """Largest value of the learner's phase."""
        return self.calls if self.single_call else self.calls + len(self.factor) - 1


def factors(parameters: int) -> int:
    """Number of words of U in C: packed columns above the diagonal, or whole columns above WRITTEN_OUT parameters."""
    n = parameters
    return n * (n - 1) // 2 if n <= WRITTEN_OUT else n * n


@functools.lru_cache(maxsize=256)
def update_schedule(parameters: int, calls: int) -> UpdateSchedule:
    """The division of an update of `parameters` parameters among `calls` calls.

    >>> update_schedule(18, 2).project, update_schedule(18, 2).factor
    ((0, 18), (0, 18))
    >>> update_schedule(54, 6).project
    (0, 24, 54)
    """
    n = parameters
    begin, diagonal, step = _BEGIN * n, _DIAGONAL * n, _STEP * n
    if n <= WRITTEN_OUT:
        grain = 1
        project = [_PROJECT_ELEMENT * (j + 1) for j in range(n)]
        factor = [_FACTOR_ELEMENT * (j + 1) for j in range(n)]
    else:
        grain = COLUMNS_PER_PASS
        project = [_PROJECT_PASS * n] * -(-n // grain)
        factor = [_FACTOR_COLUMN * n] * n
    if calls == 1:
        return UpdateSchedule(1, (0, n), (0, n), begin + sum(project) + diagonal + sum(factor) + step)
    found = []
    for first in range(1, calls):
        one, passes = _cut([begin, *project, diagonal], first)
        other, columns = _cut([0.0, *factor, step], calls - first)
        found.append(UpdateSchedule(calls, tuple(min(grain * c, n) for c in passes), columns, max(one, other)))
    return min(found, key=lambda schedule: schedule.largest_cycles)


def _cut(costs: Sequence[float], slices: int) -> tuple[float, tuple[int, ...]]:
    """Least largest sum of `slices` groups of neighbouring `costs`, and the borders of the groups in columns.

    The first and the last cost belong to no column; borders count the costs between them.
    """
    sums = [0.0, *accumulate(costs)]
    columns = len(costs) - 2

    def filled(most: float) -> list[int]:
        cuts = [0]
        while cuts[-1] < len(costs) and len(cuts) <= slices:
            cuts.append(bisect_right(sums, sums[cuts[-1]] + most * (1.0 + 1e-12)) - 1)
        return cuts

    candidates = sorted({end - start for end in sums for start in sums if end > start})
    most = candidates[bisect_left(candidates, True, key=lambda cost: filled(cost)[-1] == len(costs))]
    inner = [min(max(cut - 1, 0), columns) for cut in filled(most)[1:-1]]
    return most, (0, *inner, *[columns] * (slices - len(inner)))

"""Extensions that do not lower the error of the model on the held-out rows, and the ladder without them.

The gain of an extension depends on the extensions before it in the ladder: a delay in front of the memory may gain
nothing, and much behind it. So an extension whose step lies across or below zero is compared once more beside all
others, by a fit of the whole set without it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hysgen.diagnosis.bootstrap import Gain, gain
from hysgen.diagnosis.ladder import Rung

Rows = NDArray[np.intp]


@dataclass(frozen=True)
class Pruned:
    """kept: extensions in ladder order. rungs: their ladder. beside: held-out gain beside the others."""

    kept: list[str]
    rungs: list[Rung]
    beside: dict[str, Gain]


def prune(rungs: Sequence[Rung], names: Sequence[str], rows: Rows, fit: Callable[[Sequence[str]], Rung]) -> Pruned:
    """The ladder without extensions whose 95 % interval of the gain lies across or below zero.

    rungs: of the first 0, 1, 2, ... of `names`. rows: the held-out rows that are scored. fit: the rung of a set of
    extensions. If the last rung does not lower the error of the first for certain, no extension is kept.
    """
    kept, beside = list(names), {}

    def gained(before: Rung, after: Rung) -> Gain:
        return gain(before.error_um[rows], after.error_um[rows])

    doubtful = [
        name
        for name, before, after in zip(names, rungs, rungs[1:], strict=False)
        if gained(before, after).low_um <= 0.0
    ]
    whole = rungs[-1]
    for name in reversed(doubtful):
        rest = [other for other in kept if other != name]
        without = rungs[0] if not rest else fit(rest)
        beside[name] = gained(without, whole)
        if beside[name].low_um <= 0.0:
            kept, whole = rest, without
    if kept and gained(rungs[0], whole).low_um <= 0.0:
        beside.update({name: gained(rungs[0], whole) for name in kept if name not in beside})
        kept = []
    known = {rung.causes: rung for rung in (*rungs, whole)}
    ladder = []
    for count in range(len(kept) + 1):
        part = tuple(kept[:count])
        ladder.append(known[part] if part in known else fit(part))
    return Pruned(kept, ladder, beside)

"""Extensions that do not lower the error on held-out rows are left out of the model."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from hysgen.diagnosis.ladder import Rung, prune

RNG = np.random.default_rng(3)
N = 4800
NOISE = RNG.normal(size=N)
ROWS = np.arange(N)
MODEL: Any = None


def rung(names: Sequence[str], level: float) -> Rung:
    return Rung(tuple(names), MODEL, level * NOISE)


def ladder(levels: dict[tuple[str, ...], float], names: Sequence[str]) -> tuple[list[str], set[str]]:
    """The kept extensions of a ladder with these errors, and the names whose gain beside the others was measured."""
    rungs = [rung(names[:count], levels[tuple(names[:count])]) for count in range(len(names) + 1)]
    found = prune(rungs, names, ROWS, lambda chosen: rung(chosen, levels[tuple(chosen)]))
    assert [tuple(part.causes) for part in found.rungs] == [tuple(found.kept[:i]) for i in range(len(found.kept) + 1)]
    return found.kept, set(found.beside)


def test_an_extension_that_raises_the_held_out_error_is_left_out() -> None:
    levels = {(): 1.0, ("memory",): 0.1, ("memory", "creep"): 0.11}
    assert ladder(levels, ["memory", "creep"]) == (["memory"], {"creep"})


def test_an_extension_whose_step_gains_nothing_is_kept_if_it_gains_beside_the_others() -> None:
    levels = {(): 1.0, ("delay",): 1.0, ("delay", "memory"): 0.1, ("memory",): 0.3}
    assert ladder(levels, ["delay", "memory"]) == (["delay", "memory"], {"delay"})


def test_a_model_that_is_worse_than_the_papers_is_not_delivered() -> None:
    levels = {(): 1.0, ("memory",): 1.3}
    assert ladder(levels, ["memory"]) == ([], {"memory"})

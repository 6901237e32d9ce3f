"""How many plays the memory extension gets, and how far each of them bends: chosen inside the identification part.

Every shape is fitted with the other extensions to the identification part less a third of its blocks, each third in
turn, and scored in free run on these. More plays follow small loops, squares and cubes follow a density that changes
with the level; which pays depends on the stage, and on how much of it the record shows. The usual shape is kept unless
another is surely lower.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

from hysgen.diagnosis.bootstrap import blockwise_confidence, gain
from hysgen.diagnosis.extension import Extension
from hysgen.diagnosis.ladder import checked_error
from hysgen.diagnosis.prepare import Prepared
from hysgen.diagnosis.probe import rms
from hysgen.fitting import FitSettings
from hysgen.model.terms.memory import Memory

PLAYS, DEGREE = 10, 3
"""Plays of the usual shape, beside the past input: on Preisach stages half the error of 6."""

OTHERS = ((6, 3, True), (6, 3, False), (12, 1, False))
"""Plays, degree, and whether the past input is among them, instead of the usual ones: all are cheaper.

Without the past input where the output is a sample late: there it takes the place of the input.
"""

LATER = ("resonance",)
"""Its modes share the small gain of the inverse with the plays: they are asked for what the plays leave."""

SURE = 0.95
"""Share of bootstrap draws in which another shape must be lower: in the rms and in the mean over blocks alike."""


def usual_memory(low_V: float, high_V: float) -> Memory:
    """The usual shape for an input between low_V and high_V."""
    return Memory.polynomial(PLAYS, DEGREE, low_V, high_V, past_input=True)


def with_usual_memory(extensions: dict[str, Extension]) -> dict[str, Extension]:
    """The extensions, memory in its usual shape; unchanged without memory."""
    range_V = _range_V(extensions)
    return extensions if range_V is None else _with_term(extensions, usual_memory(*range_V))


def with_best_memory(
    prepared: Prepared, extensions: dict[str, Extension], names: Sequence[str], settings: FitSettings
) -> dict[str, Extension]:
    """The extensions, that of memory in its best shape; unchanged if memory is not among `names`, or has no range.

    Of the shapes that are surely lower than the usual one, the one with the lowest rms.
    """
    range_V = _range_V(extensions) if "memory" in names else None
    if range_V is None:
        return extensions
    low_V, high_V = range_V
    names = [name for name in names if name not in LATER]
    usual = best = with_usual_memory(extensions)
    _, usual_um = checked_error(prepared, usual, names, settings)
    best_um = rms(usual_um)
    for plays, degree, past_input in OTHERS:
        other = _with_term(extensions, Memory.polynomial(plays, degree, low_V, high_V, past_input))
        _, other_um = checked_error(prepared, other, names, settings)
        sure = min(gain(usual_um, other_um).confidence, blockwise_confidence(usual_um, other_um))
        if sure >= SURE and rms(other_um) < best_um:
            best, best_um = other, rms(other_um)
    return best


def _range_V(extensions: dict[str, Extension]) -> tuple[float, float] | None:
    """The input's range that memory counts with; None without memory, or with plays alone."""
    memory = extensions["memory"].term if "memory" in extensions else None
    return memory.range_V if isinstance(memory, Memory) else None


def _with_term(extensions: dict[str, Extension], term: Memory) -> dict[str, Extension]:
    return {**extensions, "memory": dataclasses.replace(extensions["memory"], term=term)}

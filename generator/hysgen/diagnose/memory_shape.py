"""How many plays the memory extension gets, and how far each of them bends: chosen inside the identification part.

Every shape is fitted with the other extensions to the identification part less a third of its blocks, and scored in
free run on these. More plays follow small loops, squares and cubes follow a density that changes with the level; which
pays depends on the stage, and on how much of it the record shows. The usual shape is kept unless another is surely
lower.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

from hysgen.diagnose.bootstrap import gain, surely_lower
from hysgen.diagnose.extension import Extension
from hysgen.diagnose.ladder import climb, left_out
from hysgen.diagnose.prepare import Prepared
from hysgen.fit import FitSettings
from hysgen.terms.memory import Memory

OTHERS = ((12, 1), (10, 3))
"""Plays and their degree beside the usual ones: cheaper, and dearer."""

LATER = ("resonance",)
"""Its modes share the small gain of the inverse with the plays: they are asked for what the plays leave."""

SURE = 0.9
"""Share of bootstrap draws in which another shape must be lower: in the rms and in the mean over blocks alike."""


def with_best_memory(
    prepared: Prepared, extensions: dict[str, Extension], names: Sequence[str], settings: FitSettings
) -> dict[str, Extension]:
    """The extensions, that of memory in its best shape; unchanged if memory is not among `names`."""
    memory = extensions["memory"].term if "memory" in names else None
    if not isinstance(memory, Memory) or memory.range_V is None:
        return extensions
    names = [name for name in names if name not in LATER]
    rows = left_out(prepared)[0]
    best, best_um = extensions, climb(prepared, extensions, names, settings, rows).error_um[rows]
    for plays, degree in OTHERS:
        term = Memory.polynomial(plays, degree, *memory.range_V)
        other = {**extensions, "memory": dataclasses.replace(extensions["memory"], term=term)}
        other_um = climb(prepared, other, names, settings, rows).error_um[rows]
        if min(gain(best_um, other_um).sure, surely_lower(best_um, other_um)) >= SURE:
            best, best_um = other, other_um
    return best

"""The form of each extension, such as the size of the hysteresis, chosen inside the identification part.

A cause may offer several forms of its extension (`Cause.forms`). Every form is fitted together with the other
extensions to two thirds of the blocks of the identification part and scored in free run on the remaining third, for
each third in turn. The cheapest form whose rms error is within TOLERATED of the least one is chosen.

Drift and aging are found jointly, and each takes a share of what the other would explain alone. A model that leaves one
of them out is extended by the others as they are without it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from hysgen.diagnosis.causes import Residual, causes, in_ladder_order, slow_causes, without_causes
from hysgen.diagnosis.extension import Extension
from hysgen.diagnosis.ladder import Rows, checked_errors
from hysgen.diagnosis.prepare import Prepared
from hysgen.diagnosis.probe import refine, rms
from hysgen.diagnosis.search import SearchResult, thinned
from hysgen.fitting import FitSettings

TOLERATED = 1.1
"""Largest error of the chosen form, as a multiple of the least error of all forms: the next larger size of a hysteresis
costs about 1.5 times the cycles, and 10 % on left-out blocks is not worth that."""


def with_best_forms(
    prepared: Prepared, extensions: dict[str, Extension], names: Sequence[str], settings: FitSettings
) -> dict[str, Extension]:
    """The extensions, those of `names` in the form chosen by cross-validation. Forms are offered in rising cost."""
    best = dict(extensions)
    for name in in_ladder_order(names):
        forms = causes()[name].forms(best[name])
        if len(forms) < 2:
            continue
        trials = [{**best, name: form} for form in forms]
        checked = checked_errors(prepared, [(trial, names) for trial in trials], settings)
        levels_um = [rms(error_um[_trusted(best, names, rows)]) for rows, error_um in checked]
        best = next(t for t, level in zip(trials, levels_um, strict=True) if level <= TOLERATED * min(levels_um))
    return best


def _trusted(extensions: dict[str, Extension], names: Sequence[str], rows: Rows) -> NDArray[np.bool_]:
    """Which of the rows count: not those that the extension of a cause takes out of the fit as corrupted."""
    kept = np.ones(len(rows), dtype=bool)
    for trust in (extensions[name].trust for name in names):
        if trust is not None:
            kept &= trust[rows] > 0.0
    return kept


def extensions_for(
    found: SearchResult, extensions: Mapping[str, Extension], names: Sequence[str]
) -> dict[str, Extension]:
    """The extensions of a model with those of `names`; found: the search that they come from."""
    left = [name for name in slow_causes() if name in extensions and name not in names]
    slow = [name for name in slow_causes() if name in names and extensions[name].correction is not None]
    if not left or not slow:
        return dict(extensions)
    if len(left) == 1 and left[0] in found.rivals:
        fit = found.rivals[left[0]]
    else:
        fit = refine(thinned(found.scene), without_causes(found.fit.chain, left))
    without = Residual(found.scene, fit)
    return {**extensions, **{name: causes()[name].extension(without) for name in slow}}

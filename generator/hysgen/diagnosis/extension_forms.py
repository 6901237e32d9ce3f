"""The form of each extension, such as the number of plays of the memory, chosen inside the identification part.

A cause may offer several forms of its extension (`Cause.other_forms`). Every form is fitted together with the other
extensions to two thirds of the blocks of the identification part and scored in free run on the remaining third, for
each third in turn. The usual form is kept unless another form has a lower error with LEAST_CONFIDENCE.
"""

from __future__ import annotations

from collections.abc import Sequence

from hysgen.diagnosis.bootstrap import blockwise_confidence, gain
from hysgen.diagnosis.causes import causes, in_ladder_order
from hysgen.diagnosis.extension import Extension
from hysgen.diagnosis.ladder import checked_error
from hysgen.diagnosis.prepare import Prepared
from hysgen.diagnosis.probe import rms
from hysgen.fitting import FitSettings

LEAST_CONFIDENCE = 0.95
"""Least share of bootstrap draws in which another form has a lower rms error and a lower geometric mean over blocks."""


def with_usual_forms(extensions: dict[str, Extension]) -> dict[str, Extension]:
    """The extensions, each in its usual form."""
    return {name: causes()[name].usual_form(extension) for name, extension in extensions.items()}


def with_best_forms(
    prepared: Prepared, extensions: dict[str, Extension], names: Sequence[str], settings: FitSettings
) -> dict[str, Extension]:
    """The extensions, those of `names` in the form with the lowest rms error.

    A form other than the usual one is chosen only if its error is lower with LEAST_CONFIDENCE.
    """
    beside = [name for name in names if not causes()[name].fitted_late]
    best = dict(extensions)
    for name in in_ladder_order(names):
        forms = causes()[name].other_forms(best[name])
        if not forms:
            continue
        usual = best = {**best, name: causes()[name].usual_form(best[name])}
        _, usual_um = checked_error(prepared, usual, beside, settings)
        best_um = rms(usual_um)
        for form in forms:
            other = {**usual, name: form}
            _, other_um = checked_error(prepared, other, beside, settings)
            sure = min(gain(usual_um, other_um).confidence, blockwise_confidence(usual_um, other_um))
            if sure >= LEAST_CONFIDENCE and rms(other_um) < best_um:
                best, best_um = other, rms(other_um)
    return best

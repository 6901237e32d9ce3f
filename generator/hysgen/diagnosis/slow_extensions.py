"""The corrections of slow causes for a model that is not extended by all slow causes which are named.

Drift and aging are found jointly, and each takes a share of what the other would explain alone. A model that leaves one
of them out is extended by the others as they are without it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from hysgen.diagnosis.causes import Residual, causes, slow_causes, without_causes
from hysgen.diagnosis.extension import Extension
from hysgen.diagnosis.probe import refine
from hysgen.diagnosis.search import SearchResult, thinned


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

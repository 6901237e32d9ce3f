"""Additive terms: disturbances, which do not depend on the input.

Each kind is a class derived from `Term` in a module here, and one template `disturbances/<kind>.c.j2`. Modules are
found by listing this package, so these two add a kind.
"""

import functools
from collections.abc import Mapping
from typing import Any

from hysgen.errors import ModelError
from hysgen.model.disturbances.base import Drive, Mirror, Term, TermBox, box_of

__all__ = [
    "Drive",
    "Mirror",
    "Term",
    "TermBox",
    "box_of",
    "kinds",
    "term_from_json",
]

FORMER = ("memory", "creep", "resonance")
"""Kinds of terms of earlier versions; blocks of the path (`model.path`) have taken their place."""


@functools.lru_cache(maxsize=1)
def kinds() -> Mapping[str, type[Term]]:
    """Every kind of term that is installed, by name."""
    return Term.kinds_in(__name__, __path__)


def term_from_json(data: Mapping[str, Any]) -> Term:
    """Inverse of `Term.to_json`. Raises ModelError if the kind is unknown or a field malformed."""
    kind = str(data.get("kind"))
    if kind in FORMER:
        raise ModelError(f"terms: {kind}: this hysgen has it in the path, ahead of the rules; fit the model again")
    if kind not in kinds():
        raise ModelError(f"terms: kind {kind!r} is unknown; this hysgen knows {', '.join(kinds()) or 'none'}")
    try:
        return kinds()[kind].from_json(data)
    except (KeyError, TypeError, ValueError) as fault:
        raise ModelError(f"terms: {kind}: {fault}; write the model file with hysgen, do not edit it") from fault

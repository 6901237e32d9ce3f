"""Effects of the virtual stage: one file each, found by looking into this package.

A new effect is one new file `effects/<name>.py`: a frozen dataclass that derives from `Effect`, and a last line that
names it EFFECT. No other file of the stage or the bank changes; docs/extend.md adds one step by step.

`Action` acts in Python on the command or on the displacement; `constants` instead sets members of the compiled plant
(plant.h). The other members of `Effect` have defaults, described there. A category that is new in the bank changes what
`pair` and `poor` draw, and no other category.
"""

from __future__ import annotations

import functools
import importlib
import pkgutil
from collections.abc import Mapping
from types import MappingProxyType

from hysgen_lab.stage.effects.base import (
    UNKNOWN,
    Action,
    Constants,
    Effect,
    Period,
    Setting,
    StageError,
    Tolerance,
    require,
    require_finite,
)

__all__ = [
    "UNKNOWN",
    "Action",
    "Constants",
    "Effect",
    "Period",
    "Setting",
    "StageError",
    "Tolerance",
    "effects",
    "require",
    "require_finite",
]


@functools.lru_cache(maxsize=1)
def effects() -> Mapping[str, type[Effect]]:
    """Class of every effect by its name, in the order of their ranks."""
    classes: list[type[Effect]] = []
    for module in pkgutil.iter_modules(__path__):
        kind = getattr(importlib.import_module(f"{__name__}.{module.name}"), "EFFECT", None)
        if kind is not None:
            classes.append(kind)
    return MappingProxyType({kind.name: kind for kind in sorted(classes, key=lambda kind: (kind.rank, kind.name))})

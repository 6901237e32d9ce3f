"""Effects of the virtual stage, found by looking into this package.

A new effect is a frozen dataclass that derives from `Effect`, in a file of its own or beside others. No other file of
the stage or the bank changes; docs/extend.md adds one step by step.

`Action` acts in Python on the command or on the displacement; `constants` instead sets members of the compiled plant
(plant.h). The other members of `Effect` have defaults, described there. A category that is new in the bank changes what
`pair` and `poor` draw, and no other category.
"""

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
    for module in pkgutil.iter_modules(__path__):
        importlib.import_module(f"{__name__}.{module.name}")
    classes = [kind for kind in Effect.__subclasses__() if kind.__module__.startswith(f"{__name__}.")]
    return MappingProxyType({kind.name: kind for kind in sorted(classes, key=lambda kind: (kind.rank, kind.name))})

"""Effects of the virtual stage: one file each, found by looking into this package.

A new effect is one new file `effects/<name>.py`: a frozen dataclass that derives from `Effect`, and a last line that
names it EFFECT. No other file of the stage or the bank changes:

    @dataclass(frozen=True)
    class EchoEffect(Effect):
        "The voltage of the period before acts on the displacement:  y(k) += um_per_V u(k - 2)."

        um_per_V: float                                       # the effect's parameters, with units

        name = "echo"                                         # Stage.nominal().with_effects(echo=0.002)
        bank_index = 15                                       # scenario("echo", seed); leave out: not in the bank
        tolerances: ClassVar = {"echo.um_per_V": Tolerance(0.1)}        # how near the diagnosis must come

        def action(self, Ts_s, seed, rest_V):                 # the equation, sample by sample
            return _Echo(self.um_per_V, rest_V)

        @classmethod
        def draw(cls, rng, setting):                          # strength in a bank scenario
            return cls(setting.share * setting.span_um / 100.0)

        def true_parameters(self):                            # by the names that the diagnosis uses
            return {"echo.um_per_V": self.um_per_V}

    class _Echo(Action):
        def __init__(self, um_per_V, rest_V):
            self.um_per_V, self.past_V = um_per_V, rest_V

        def added_um(self, u_V):                              # or command_V, to change what the D/A is given
            past_V, self.past_V = self.past_V, u_V
            return self.um_per_V * past_V

    EFFECT = EchoEffect

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

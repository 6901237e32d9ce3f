"""The guards that keep the state in its box, and the generated C without one of them.

Every guard is a line of the generated C at a hook `guard: ...` of the templates. Without this line Eva must raise an
alarm for the call that the guard protects; otherwise the proof does not depend on the generated code.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

from hysgen.checking.proof.eva.frama import Floats
from hysgen.checking.proof.sources import hook_names, replaced
from hysgen.model.model import Model

_HOOK: Final = "guard: "


@dataclass(frozen=True)
class Guard:
    """A guard of the generated C, and the call and inputs that show what it prevents.

    about: what the guard makes sure. name: of its hook, behind "guard: ". unguarded: C lines in place of its line, with
    NAME for the model's name. unless: name of another guard which limits the same number again, so that the box does
    not need this guard in a model that has both.
    """

    about: str
    function: str
    inputs: Floats
    name: str
    unguarded: tuple[str, ...]
    unless: str = ""


GUARDS: Final = (
    Guard(
        "an input that is not finite is replaced",
        "predict",
        "any",
        "finite",
        ("return NAME_float(bits & keep);",),
    ),
    Guard(
        "a displacement is limited to the identified range",
        "predict",
        "finite",
        "displacement",
        ("events->y_clamped = 0u;", "return finite;"),
    ),
    Guard(
        "a voltage is limited to the input range",
        "predict",
        "finite",
        "voltage",
        ("events->u_clamped = 0u;", "return finite;"),
    ),
    Guard(
        "the free run's own displacement is limited",
        "simulate",
        "finite",
        "free run",
        ("const float y = self->y_um;",),
    ),
    Guard(
        "a reference is limited to one range away",
        "inverse",
        "finite",
        "reference",
        ("const float wanted = finite;", "clamped = 0u;"),
    ),
    Guard(
        "the lowest voltage of the inverse is limited to the input range",
        "limits",
        "finite",
        "limits low",
        ("self->low_V = low;",),
    ),
    Guard(
        "the highest voltage of the inverse is limited to the input range",
        "limits",
        "finite",
        "limits high",
        ("self->high_V = high;",),
    ),
    Guard(
        "the largest step of the inverse's voltage is limited",
        "limits",
        "finite",
        "limits step",
        ("self->step_V = step;",),
    ),
    Guard(
        "the inverse's voltage is limited",
        "inverse",
        "finite",
        "inverse",
        ("const float u = exact;",),
    ),
    Guard(
        "the voltage that the inverse passes to the input blocks is limited",
        "inverse",
        "finite",
        "inverse into blocks",
        ("const float allowed = solved;", "found->u_clamped = 0u;"),
        unless="saturation",
    ),
    Guard(
        "the input of the rules is limited behind the path",
        "predict",
        "finite",
        "path",
        ("outside = 0u;", "return w;"),
    ),
    Guard(
        "saturation limits what reaches the stage",
        "predict",
        "finite",
        "saturation",
        ("clipped = 0u;", "return u;"),
    ),
    Guard(
        "the delay's ring is closed where it is written",
        "predict",
        "finite",
        "delay written",
        ("self->newest = (self->newest + 1u);",),
    ),
    Guard(
        "the delay's ring is closed where it is read",
        "predict",
        "finite",
        "delay read",
        ("return self->ring[self->newest - samples];",),
    ),
    Guard(
        "an accumulated state beyond its limit starts again from 0",
        "predict",
        "finite",
        "accumulate",
        ("return high + t;",),
    ),
    Guard(
        "the bias of a drift is limited",
        "predict",
        "finite",
        "drift",
        ("clamped = 0u;",),
    ),
    Guard(
        "an auxiliary channel is limited to its range",
        "aux",
        "finite",
        "coupling",
        ("const float inside = finite;", "clamped = 0u;"),
    ),
    Guard(
        "a candidate whose check points are done is checked no more",
        "commit",
        "finite",
        "commit",
        (";",),
    ),
    Guard(
        "only a shadow inside its limits becomes a candidate",
        "beyond",
        "any",
        "beyond",
        ("return 0u;",),
    ),
    Guard(
        "after the last parameter the prior of the first is put back",
        "learn",
        "any",
        "turn",
        ("self->turn = j + 1u;",),
    ),
    Guard(
        "a shadow that has to start again does",
        "learn",
        "any",
        "restart",
        ("if (lost > 1u) {",),
    ),
    Guard(
        "a displacement far outside the range teaches nothing",
        "learn",
        "any",
        "usable",
        ("const uint32_t usable = 1u ^ y_lost;",),
    ),
    Guard(
        "a voltage that is learnt from is limited to the input range",
        "learn",
        "any",
        "learn voltage",
        ("const float u = u_finite;", "moved = 0u;"),
    ),
    Guard(
        "a displacement that is kept is limited to the identified range",
        "learn",
        "any",
        "store displacement",
        ("const float y = y_um;", "outside = 0u;"),
    ),
    Guard(
        "a shadow beyond its limits has to start again",
        "update",
        "any",
        "step",
        ("return 0u;",),
    ),
)


def guards(model: Model, texts: Mapping[str, str]) -> tuple[Guard, ...]:
    """The guards whose line is in the C of the model and which its box needs."""
    hooks = set(hook_names(model, texts))
    return tuple(guard for guard in GUARDS if _HOOK + guard.name in hooks and _HOOK + guard.unless not in hooks)


def without(guard: Guard, model: Model, texts: Mapping[str, str]) -> dict[str, str]:
    """`texts` without one guard. Raises ModelError if its line differs from the templates."""
    lines = [line.replace("NAME", model.name) for line in guard.unguarded]
    return replaced(model, texts, _HOOK + guard.name, lines)

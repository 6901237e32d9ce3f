"""The guards that keep the state in its box, each taken out in turn: a proof that holds without one proves nothing.

Every guard is a line of the generated C. Without it Eva must raise an alarm for the call that it protects.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

from hysgen.checking.proof.eva.frama import Floats
from hysgen.errors import ModelError


@dataclass(frozen=True)
class Guard:
    """What a line of the C keeps out, the call and inputs that show it, and the line without its guard.

    pattern: regular expression with NAME for the model's name; replacement as `re.sub` takes it. unless: another line,
    which does the same once more where a model has it, so that the box does not need this one.
    """

    about: str
    function: str
    inputs: Floats
    pattern: str
    replacement: str
    unless: str = r"(?!)"


GUARDS: Final = (
    Guard(
        "an input that is not finite is replaced",
        "predict",
        "any",
        r"return NAME_float\(\(bits & keep & ~hold\) \| \(NAME_bits\(held\) & hold\)\);",
        "return NAME_float(bits & keep);",
    ),
    Guard(
        "a displacement is limited to the identified range",
        "predict",
        "finite",
        r"return NAME_limited\(finite, \w+_Y_MIN_UM, \w+_Y_MAX_UM, &events->y_clamped\);",
        "events->y_clamped = 0u;\n    return finite;",
    ),
    Guard(
        "a voltage is limited to the input range",
        "predict",
        "finite",
        r"return NAME_limited\(finite, \w+_U_MIN_V, \w+_U_MAX_V, &events->u_clamped\);",
        "events->u_clamped = 0u;\n    return finite;",
    ),
    Guard(
        "the free run's own displacement is limited",
        "simulate",
        "finite",
        r"(const float y =) NAME_limited\(self->y_um, .*\);",
        r"\1 self->y_um;",
    ),
    Guard(
        "a reference is limited to one range away",
        "inverse",
        "finite",
        r"(const float wanted =) NAME_limited\(finite, .*\);",
        r"\1 finite;\n    clamped = 0u;",
    ),
    Guard(
        "the inverse's voltage is limited",
        "inverse",
        "finite",
        r"(const float \w+ =) NAME_limited\(exact, .*\);",
        r"\1 exact;",
        unless=r"NAME_saturation_apply\(",
    ),
    Guard(
        "saturation limits what reaches the stage",
        "predict",
        "finite",
        r"return NAME_limited\(u, NAME_saturation_low\[0\], NAME_saturation_high\[0\], &clipped\);",
        "clipped = 0u;\n    return u;",
    ),
    Guard(
        "the delay's ring is closed where it is written",
        "predict",
        "finite",
        r"(self->newest = \(self->newest \+ 1u\)) & \d+u;",
        r"\1;",
    ),
    Guard(
        "the delay's ring is closed where it is read",
        "predict",
        "finite",
        r"return self->ring\[\(self->newest - samples\) & \d+u\];",
        "return self->ring[self->newest - samples];",
    ),
    Guard(
        "an accumulated state beyond its limit starts again from 0",
        "predict",
        "finite",
        r"\*high = NAME_inside\(sum, .*\);",
        "*high = sum;",
    ),
    Guard(
        "the bias of a drift is limited",
        "predict",
        "finite",
        r"self->bias_um = NAME_limited\(.*\);",
        "clamped = 0u;",
    ),
    Guard(
        "an auxiliary channel is limited to its range",
        "aux",
        "finite",
        r"(const float inside =) NAME_limited\(finite, .*\);",
        r"\1 finite;\n    clamped = 0u;",
    ),
    Guard(
        "a candidate whose check points are done is checked no more",
        "commit",
        "finite",
        r"candidate->phase \+= \(uint32_t\)\(candidate->point >= \w+\);",
        ";",
    ),
    Guard(
        "only a shadow inside its limits becomes a candidate",
        "beyond",
        "any",
        r"return \(uint32_t\)\(NAME_size\(theta\) >= NAME_bits\(\w+\)\);",
        "return 0u;",
    ),
    Guard(
        "after the last parameter the prior of the first is put back",
        "learn",
        "any",
        r"self->turn = \(j \+ 1u < \w+\) \? j \+ 1u : 0u;",
        "self->turn = j + 1u;",
    ),
    Guard(
        "a shadow that has to start again does",
        "learn",
        "any",
        r"if \(lost != 0u\) \{",
        "if (lost > 1u) {",
    ),
    Guard(
        "a displacement far outside the range teaches nothing",
        "learn",
        "any",
        r"(const uint32_t usable = 1u \^) \(y_lost \| implausible\);",
        r"\1 y_lost;",
    ),
    Guard(
        "a voltage that is learnt from is limited to the input range",
        "learn",
        "any",
        r"(const float u =) NAME_limited\(u_finite, .*\);",
        r"\1 u_finite;\n    moved = 0u;",
    ),
    Guard(
        "a displacement that is kept is limited to the identified range",
        "learn",
        "any",
        r"(const float y =) NAME_limited\(y_um, .*\);",
        r"\1 y_um;\n    outside = 0u;",
    ),
    Guard(
        "a shadow beyond its limits has to start again",
        "update",
        "any",
        r"( {4}self->age \+= .*\n(?:.*\n)?)    return beyond;",
        r"\1    return 0u;",
    ),
)


def guards(name: str, texts: Mapping[str, str]) -> tuple[Guard, ...]:
    """Those whose line the algorithm of model `name` has and needs."""
    source = texts[f"{name}.c"]
    return tuple(
        guard
        for guard in GUARDS
        if re.search(_named(guard.pattern, name), source) and not re.search(_named(guard.unless, name), source)
    )


def without(guard: Guard, name: str, texts: Mapping[str, str]) -> dict[str, str]:
    """The texts with that guard taken out, wherever it stands. Raises ModelError if it is not there."""
    source, count = re.subn(_named(guard.pattern, name), guard.replacement.replace("NAME", name), texts[f"{name}.c"])
    if count == 0:
        raise ModelError(f"{name}: no line that makes sure that {guard.about}; adapt proof/eva/guards.py")
    return {**texts, f"{name}.c": source}


def _named(pattern: str, name: str) -> str:
    return pattern.replace("NAME", re.escape(name))

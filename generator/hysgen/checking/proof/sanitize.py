"""Undefined behaviour and memory errors, looked for while the generated C runs on every kind of input.

The C is compiled with gcc's sanitizers, which stop the program at the first fault, and runs the self-test and the
samples of `hysgen verify`: random, smooth, the edges of every range, and any 32 bits at all, NaN, infinity and denormal
numbers among them. Its bits are compared on the way. A run shows that nothing happened, not that nothing can: that is
what `proof.eva` is for.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping
from typing import Final

from hysgen.checking.proof.emulated.equality import EmulatedReport, equality
from hysgen.checking.proof.emulated.machines import Machine
from hysgen.model.model import Model

SANITIZERS: Final = (
    "-g",
    "-fsanitize=undefined,address,float-divide-by-zero,float-cast-overflow,bounds-strict",
    "-fno-sanitize-recover=all",
    "-fno-omit-frame-pointer",
)

SANITIZED: Final = Machine(
    "sanitizers", "gcc", "", "<" if sys.byteorder == "little" else ">", ("gcc", "libasan8", "libubsan1"), SANITIZERS
)


def sanitize(
    model: Model,
    texts: Mapping[str, str],
    *,
    samples: int = 100_000,
    seed: int = 1,
    progress: Callable[[float, str], None] | None = None,
) -> EmulatedReport:
    """Run the C under gcc's sanitizers and compare its bits; samples: per function.

    Raises BuildError with the sanitizer's first line if it stops the program, or if gcc or its libraries are missing.
    """
    flags = ("-O1", "-ffp-contract=off")
    return equality(model, texts, samples=samples, machines=[SANITIZED], flags=flags, seed=seed, progress=progress)

"""Run-time checks for undefined behaviour and memory errors in the generated C.

The C is compiled with gcc's sanitizers, which stop the program at the first fault. It runs the self-test and the
samples of `hysgen verify`: random, smooth, edge values and arbitrary bit patterns, with NaN, infinities and denormal
numbers among them; its bits are compared as well. A run shows that no fault occurred; `proof.eva` proves that none can
occur.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping
from typing import Final

from hysgen.checking.proof.emulated.equality import EmulatedReport, EmulationSettings, equality
from hysgen.checking.proof.emulated.platforms import Platform
from hysgen.model.model import Model

SANITIZERS: Final = (
    "-g",
    "-fsanitize=undefined,address,float-divide-by-zero,float-cast-overflow,bounds-strict",
    "-fno-sanitize-recover=all",
    "-fno-omit-frame-pointer",
)

SANITIZED: Final = Platform(
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
    return equality(model, texts, EmulationSettings(samples, [SANITIZED], flags, seed), progress)

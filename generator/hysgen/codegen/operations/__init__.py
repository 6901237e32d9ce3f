"""Cost of the generated functions: operations per call by kind, counted in the C text, bytes of memory, and cycles of
the TMS320C6748, measured or estimated from operation counts, against the budget of a sample period.

    cycles = 60 + 0.75 operations + 20 branches          (stall-free, gcc 12.2 for the C674x)
    cycles = 400 + 0.92 (+-, *, loads, stores)           for a call of learn
    cycles = 60 + 0.8 (+-, *, loads, stores)             for a call of commit, of learn_init

Over 94 routines (predict, simulate and inverse of 32 structures, 2 to 50 rules, with and without terms and input
blocks, compiled for the C674x) the cycles of the compiled code were 0.74 to 1.23 times the first estimate. The
constant is the latency of exponential, sums and reciprocal in sequence; a branch costs its jump and the overlap of
operations that it prevents. The loops of learner and commit are unrolled on the target: indices and branches cost
nothing there.
tests/hysgen_c674x/test_cost.py checks that both ratios are within 0.7 .. 1.3.
"""

import functools
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

from pycparser import c_ast

from hysgen.codegen.operations.counting import Counts, Program
from hysgen.codegen.operations.text import Types, concatenated, parsed, words
from hysgen.errors import BudgetError
from hysgen.model.model import Model

CLOCK_HZ: Final = 375e6
"""Clock of the paper's DSP."""

STEPS: Final = ("predict", "simulate", "inverse")
"""Functions of which a controller calls one per sample."""

EVERY_SAMPLE: Final = ("correct", "learn", "commit")
"""Functions that a controller calls in every sample besides."""


@dataclass(frozen=True)
class Weights:
    """Cycles of a call on a processor: latency + per_operation * operations + per_branch * branches.

    processor: its name in tables. unrolled: constant, and cycles of a float operation, a load or a store, of the
    functions whose loops the compiler unrolls.
    """

    processor: str
    latency: float
    per_operation: float
    per_branch: float
    unrolled: Mapping[str, tuple[float, float]]


C674X: Final = Weights(
    "C674x", 60.0, 0.75, 20.0, {"learn": (400.0, 0.92), "commit": (60.0, 0.8), "learn_init": (60.0, 0.8)}
)
"""The estimates above."""


@dataclass(frozen=True)
class Cycles:
    """Stall-free cycles of one call, measured on the target's instruction set or estimated from operation counts."""

    value: int
    measured: bool

    def __str__(self) -> str:
        return f"{self.value} cycles" if self.measured else f"about {self.value} cycles (estimate)"


def estimated(counts: Counts, function: str = "predict", weights: Weights = C674X) -> Cycles:
    """The estimate for a call of `function`, named without the model's prefix."""
    if function in weights.unrolled:
        fixed, per_turn = weights.unrolled[function]
        return Cycles(
            round(fixed + per_turn * (counts.add + counts.multiply + counts.load + counts.store)), measured=False
        )
    straight = counts.total - counts.branch
    cycles = weights.latency + weights.per_operation * straight + weights.per_branch * counts.branch
    return Cycles(round(cycles), measured=False)


def cycles_of(
    operations: Mapping[str, Counts], measured: Mapping[str, int] | None = None, weights: Weights = C674X
) -> dict[str, Cycles]:
    """Cycles by public function, named without the model's prefix: from `measured` if listed, else estimated."""
    known = measured or {}
    return {
        name: Cycles(known[name], measured=True) if name in known else estimated(counts, name, weights)
        for name, counts in operations.items()
    }


def budget(Ts_s: float, clock_Hz: float = CLOCK_HZ) -> int:
    """Cycles in a sample period: 7500 at 50 kHz and 375 MHz."""
    return int(Ts_s * clock_Hz * (1.0 + 1e-12))


def per_sample(cycles: Mapping[str, Cycles]) -> Cycles:
    """Cycles of one sample period: the most expensive function of STEPS plus all generated ones of EVERY_SAMPLE."""
    step = max((cycles[name] for name in STEPS if name in cycles), key=lambda c: c.value)
    parts = [step, *(cycles[name] for name in EVERY_SAMPLE if name in cycles)]
    return Cycles(sum(part.value for part in parts), all(part.measured for part in parts))


def require_budget(
    model: Model, cycles: Mapping[str, Cycles], clock_Hz: float = CLOCK_HZ, stated: int | None = None
) -> None:
    """Raise BudgetError, with the numbers, if one sample takes more cycles than its period has, or than `stated`."""
    period, needed = budget(model.Ts_s, clock_Hz), per_sample(cycles)
    if needed.value > (period if stated is None else min(period, stated)):
        parts = ", ".join(f"{name} {cycles[name].value}" for name in (*STEPS, *EVERY_SAMPLE) if name in cycles)
        given = "" if stated is None else f", the budget is {stated}"
        raise BudgetError(
            f"{model.name}: one sample takes {needed} ({parts}), the period of {1e6 * model.Ts_s:.4g} us has {period} "
            f"at {clock_Hz / 1e6:.4g} MHz{given}; learn less (--learn gain or bias), fit fewer rules, or sample more "
            "slowly"
        )


__all__ = ["Counts", "Figures", "figures"]

_BYTES = 4


@dataclass(frozen=True)
class Figures:
    """Operations and bytes of one model's C code.

    operations: counts of the most expensive path, by public function, named without the model's prefix.
    struct_bytes: size by public struct; constant_bytes: size of all tables of constants, initial banks included.
    """

    operations: Mapping[str, Counts]
    struct_bytes: Mapping[str, int]
    constant_bytes: int


def figures(name: str, texts: Mapping[str, str]) -> Figures:
    """The figures of model `name` with the generated `texts` by file name.

    Raises HysgenError if the C code contains a statement without a fixed cost.
    """
    header = concatenated(texts, (f"{name}.h",))
    source = concatenated(texts, (f"{name}.h", f"{name}_params.h", f"{name}.c"), (f"{name.upper()}_NUMBERS",))
    return _counted(name, header, source)


@functools.lru_cache(maxsize=16)
def _counted(name: str, header: str, source: str) -> Figures:
    program, declared = Program(parsed(source, f"{name}.c")), Types()
    for node in parsed(header, f"{name}.h").ext:
        if isinstance(node, c_ast.Typedef):
            declared.define(node)
    return Figures(
        operations={function.removeprefix(f"{name}_"): program.count(function) for function in program.public()},
        struct_bytes={struct: _BYTES * words(program.types[struct]) for struct in declared.structs},
        constant_bytes=_BYTES * program.constant_words,
    )

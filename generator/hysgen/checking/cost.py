"""Cost of generated C: operations of the worst path, cycles, bytes, time on this machine.

Operations are counted exactly in the C text (`codegen.operations`). Cycles of the C674x are measured ones if the caller
passes them, else estimates, and labelled as such. Nanoseconds are those of this machine, not of the DSP.
"""

import json
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from hysgen.checking import Host
from hysgen.checking.bits.functions import COMPARED_STRUCTS, chunks
from hysgen.codegen.manifest import MANIFEST
from hysgen.codegen.operations import C674X, CLOCK_HZ, Counts, Cycles, Weights, budget, cycles_of, figures, per_sample
from hysgen.display import Displayed, Summary
from hysgen.machine.native import compiler_version, default_toolchain
from hysgen.model.model import Model

__all__ = [
    "Cost",
    "FunctionCost",
    "cost_of_texts",
]


REPEATS: Final = 9
SAMPLES: Final = 1 << 14
"""Samples of one timed run."""


@dataclass(frozen=True)
class FunctionCost:
    """Cost of one call of one function. host_ns: time on this machine, None if it was not timed."""

    name: str
    operations: Counts
    cycles: Cycles
    host_ns: float | None


@dataclass(frozen=True, repr=False)
class Cost(Displayed):
    """Cost of the generated C of a model.

    functions: the public ones, in the order of the source. struct_bytes: by public struct. constant_bytes: of the
    tables. per_sample: cycles of the most expensive step function, plus learn and commit. budget: cycles of a sample
    period at clock_Hz. host: compiler of the timed runs. processor: whose cycles these are.
    """

    model: str
    functions: Sequence[FunctionCost]
    struct_bytes: Mapping[str, int]
    constant_bytes: int
    per_sample: Cycles
    budget: int
    clock_Hz: float
    Ts_s: float
    host: str
    processor: str = C674X.processor

    @property
    def share(self) -> float:
        """Used part of the sample period."""
        return self.per_sample.value / self.budget

    def to_json(self) -> dict[str, Any]:
        """Plain JSON values."""
        return {
            "model": self.model,
            "functions": {
                f.name: {
                    "operations": f.operations.to_json(),
                    "cycles": {"value": f.cycles.value, "measured": f.cycles.measured},
                    "host_ns": f.host_ns,
                }
                for f in self.functions
            },
            "bytes": {"structs": dict(self.struct_bytes), "constants": self.constant_bytes},
            "per_sample": {"value": self.per_sample.value, "measured": self.per_sample.measured},
            "budget": self.budget,
            "share": self.share,
            "clock_Hz": self.clock_Hz,
            "Ts_s": self.Ts_s,
            "host": self.host,
        }

    def summary(self) -> Summary:
        """One row per function, and notes that explain the columns."""
        title = f"Cost of {self.model}: {self.per_sample} of {self.budget} a sample, {100.0 * self.share:.2g} %"
        return Summary(title, self.header(), self.rows(), self.notes())

    def header(self) -> list[str]:
        """Column heads of `rows`."""
        kinds = ("float +-", "float *", "compare", "integer", "load", "store", "branch")
        return ["function", *kinds, self.processor, "host ns"]

    def rows(self) -> list[list[str]]:
        """One row of cells per function."""
        return [_row(f) for f in self.functions]

    def notes(self) -> list[str]:
        """Lines below the table."""
        structs = ", ".join(f"{name} {size}" for name, size in self.struct_bytes.items())
        rate = f"{1e-3 / self.Ts_s:.4g} kHz and {self.clock_Hz / 1e6:.4g} MHz"
        return [
            f"bytes: {structs}, constants {self.constant_bytes}",
            f"one sample: {self.per_sample} of {self.budget} at {rate}, {100.0 * self.share:.1f} %",
            "~ before cycles: estimated from the operations, not measured on the target; stalls and caches left out",
            f"host ns: median of repeated runs on this machine ({self.host}); they say nothing about the DSP",
        ]


def cost_of_texts(
    model: Model,
    texts: Mapping[str, str],
    cycles: Mapping[str, int] | None = None,
    *,
    timed: bool = True,
    weights: Weights = C674X,
) -> Cost:
    """Cost of generated texts, against the clock that their manifest names.

    cycles: stall-free cycles per function, measured on the target. weights: of the estimates of the others. timed: also
    run the functions on this machine. Raises BuildError if `timed` and no compiler is installed.
    """
    clock_Hz = float(json.loads(texts.get(MANIFEST, "{}")).get("options", {}).get("clock_Hz", CLOCK_HZ))
    counted = figures(model.name, texts)
    known = cycles_of(counted.operations, cycles, weights)
    toolchain = default_toolchain() if timed else None
    host_ns = nanoseconds(Host(model.name, texts, toolchain), model) if timed else {}
    return Cost(
        model=model.name,
        functions=[
            FunctionCost(name, counts, known[name], host_ns.get(name)) for name, counts in counted.operations.items()
        ],
        struct_bytes=counted.struct_bytes,
        constant_bytes=counted.constant_bytes,
        per_sample=per_sample(known),
        budget=budget(model.Ts_s, clock_Hz),
        clock_Hz=clock_Hz,
        Ts_s=model.Ts_s,
        processor=weights.processor,
        host=f"{compiler_version(toolchain.command)}, {' '.join(toolchain.flags)}" if toolchain else "not timed",
    )


def nanoseconds(host: Host, model: Model, style: str = "smooth") -> Mapping[str, float]:
    """Time per sample of each step function, in ns: the median of REPEATS runs over inputs of a style of `chunks`."""
    nanoseconds = {}
    for compared in COMPARED_STRUCTS:
        for function in compared.functions:
            if function not in host.entries or function == "init":
                continue
            columns = next(chunks(model, style, compared.quantities(function, host), SAMPLES, seed=1))
            struct = compared.create(host)
            times = []
            for _ in range(REPEATS):
                started = time.perf_counter_ns()
                host.run(function, struct, columns)
                times.append((time.perf_counter_ns() - started) / SAMPLES)
            nanoseconds[function] = float(np.median(times))
    return nanoseconds


def _row(f: FunctionCost) -> list[str]:
    o = f.operations
    kinds = (o.add, o.multiply, o.compare, o.integer + o.convert, o.load, o.store, o.branch)
    cycles = f"{f.cycles.value}" if f.cycles.measured else f"~{f.cycles.value}"
    return [f.name, *(str(n) for n in kinds), cycles, "-" if f.host_ns is None else f"{f.host_ns:.1f}"]

"""What generated C costs: operations of the worst path, cycles and their budget, bytes, and time on this machine.

Operations are counted in the C text (package `operations`), exactly. Cycles of the C674x are those that the caller
measured on the target, else estimates and named so. Nanoseconds belong to this machine and say nothing about the DSP.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from hysgen.c674x.cost.timing import nanoseconds
from hysgen.checking.host import Host
from hysgen.codegen.manifest import read_folder
from hysgen.codegen.operations import Counts, figures
from hysgen.codegen.operations.cycles import CLOCK_HZ, Cycles, budget, cycles_of, per_sample
from hysgen.display import Displayed, Summary
from hysgen.machine.native import compiler_version, default_toolchain
from hysgen.model.model import Model

__all__ = ["Cost", "FunctionCost", "cost", "cost_of_texts"]


@dataclass(frozen=True)
class FunctionCost:
    """One call of one function; host_ns is None where it was not timed."""

    name: str
    operations: Counts
    cycles: Cycles
    host_ns: float | None


@dataclass(frozen=True, repr=False)
class Cost(Displayed):
    """functions: public ones, in the order of the source; struct_bytes: every public struct, constant_bytes: tables.

    per_sample: the dearest step, and learning if there is any; budget: cycles of a sample period at clock_Hz.
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

    @property
    def share(self) -> float:
        """Part of the sample period that is used."""
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
        """One row per function, and below what the columns mean."""
        title = f"Cost of {self.model}: {self.per_sample} of {self.budget} a sample, {100.0 * self.share:.2g} %"
        return Summary(title, self.header(), self.rows(), self.notes())

    def header(self) -> list[str]:
        """Column heads of `rows`."""
        return ["function", "float +-", "float *", "compare", "integer", "load", "store", "branch", "C674x", "host ns"]

    def rows(self) -> list[list[str]]:
        """One row of cells per function."""
        return [_row(f) for f in self.functions]

    def notes(self) -> list[str]:
        """What stands below the table."""
        structs = ", ".join(f"{name} {size}" for name, size in self.struct_bytes.items())
        rate = f"{1e-3 / self.Ts_s:.4g} kHz and {self.clock_Hz / 1e6:.4g} MHz"
        return [
            f"bytes: {structs}, constants {self.constant_bytes}",
            f"one sample: {self.per_sample} of {self.budget} at {rate}, {100.0 * self.share:.1f} %",
            "~ before cycles: estimated from the operations, not measured on the target; stalls and caches left out",
            f"host ns: median of repeated runs on this machine ({self.host}); they say nothing about the DSP",
        ]


def cost(folder: Path, cycles: Mapping[str, int] | None = None, *, timed: bool = True) -> Cost:
    """Cost of a folder that `hysgen generate` wrote.

    cycles: stall-free cycles per function, measured on the target. timed: run the functions on this machine as well.
    Raises HysgenError if the folder is not complete, BuildError if it is to be timed and there is no compiler.
    """
    generated = read_folder(folder)
    clock_Hz = float(generated.facts.get("options", {}).get("clock_Hz", CLOCK_HZ))
    return cost_of_texts(generated.model, generated.texts, cycles, timed=timed, clock_Hz=clock_Hz)


def cost_of_texts(
    model: Model,
    texts: Mapping[str, str],
    cycles: Mapping[str, int] | None = None,
    *,
    timed: bool = True,
    clock_Hz: float = CLOCK_HZ,
) -> Cost:
    """`cost` for generated texts that need not lie in a folder."""
    found = figures(model.name, texts)
    known = cycles_of(found.operations, cycles)
    toolchain = default_toolchain() if timed else None
    spent = nanoseconds(Host(model.name, texts, toolchain), model) if timed else {}
    return Cost(
        model=model.name,
        functions=[
            FunctionCost(name, counts, known[name], spent.get(name)) for name, counts in found.operations.items()
        ],
        struct_bytes=found.struct_bytes,
        constant_bytes=found.constant_bytes,
        per_sample=per_sample(known),
        budget=budget(model.Ts_s, clock_Hz),
        clock_Hz=clock_Hz,
        Ts_s=model.Ts_s,
        host=f"{compiler_version(toolchain.command)}, {' '.join(toolchain.flags)}" if toolchain else "not timed",
    )


def _row(f: FunctionCost) -> list[str]:
    o = f.operations
    kinds = (o.add, o.multiply, o.compare, o.integer + o.convert, o.load, o.store, o.branch)
    cycles = f"{f.cycles.value}" if f.cycles.measured else f"~{f.cycles.value}"
    return [f.name, *(str(n) for n in kinds), cycles, "-" if f.host_ns is None else f"{f.host_ns:.1f}"]

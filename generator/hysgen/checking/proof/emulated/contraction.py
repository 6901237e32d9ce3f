"""What fusing a multiplication with an addition does to the bits, and how the generated C keeps compilers from it.

A fused multiply-add rounds once where the C says twice. Compilers may form it by default; the generated C forbids it
where the compiler lets itself be told in the source. Here every machine is asked to fuse: with the guard all bits have
to stay; with the guard taken out of the text one sees what it guards against, and whether the self-test would tell.
"""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from hysgen.checking.bits.inputs import chunks
from hysgen.checking.host import Host
from hysgen.checking.proof.emulated.machines import MACHINES, Machine
from hysgen.checking.proof.emulated.program import Emulated
from hysgen.errors import BuildError
from hysgen.model.model import Model

Words = NDArray[np.uint32]

FUSING: Final = ("-O2", "-ffp-contract=fast")
_GUARD: Final = re.compile(r"^#if defined\(__clang__\)\n#pragma STDC FP_CONTRACT OFF\n.*?^#endif\n", re.M | re.S)


@dataclass(frozen=True)
class Fused:
    """One machine told to fuse.

    differing: results of predict that are not the host's, out of `samples`; largest_um: the largest difference;
    selftest: mismatches that the generated self-test counts.
    """

    machine: str
    flags: str
    guarded: bool
    samples: int
    differing: int
    largest_um: float
    selftest: int

    def to_json(self) -> dict[str, Any]:
        """Plain JSON values."""
        return dataclasses.asdict(self)


def contraction(
    model: Model,
    texts: Mapping[str, str],
    *,
    samples: int = 100_000,
    machines: Sequence[Machine] = MACHINES,
    progress: Callable[[float, str], None] | None = None,
) -> list[Fused]:
    """Each installed machine told to fuse, with the guard and without it.

    Raises BuildError if the guard is not found, or no machine is installed.
    """
    expected, inputs = _expected(model, texts, samples)
    bare = unguarded(model.name, texts)
    found = []
    there = [machine for machine in machines if not machine.missing]
    if not there:
        raise BuildError("no other instruction set is installed: qemu-user-static and a cross gcc are needed")
    for place, machine in enumerate(there):
        if progress is not None:
            progress(place / len(there), f"fusing on {machine.name}")
        for guarded, sources in ((True, texts), (False, bare)):
            flags = (*FUSING, *machine.fused)
            program = Emulated(model.name, sources, machine, flags)
            out = _results(program, inputs)
            away = np.abs(out.view(np.float32).astype(np.float64) - expected.view(np.float32))
            selftest = int(program.call("selftest")) if program.selftested else 0
            differing = int(np.count_nonzero(out != expected))
            largest = float(away.max())
            found.append(Fused(machine.name, " ".join(flags), guarded, samples, differing, largest, selftest))
    return found


def contraction_rows(found: Sequence[Fused]) -> tuple[list[str], list[list[str]]]:
    """Column heads and rows of a table."""
    header = ["machine", "flags", "guard", "predictions", "differ", "largest, um", "self-test"]
    rows = [
        [
            row.machine,
            row.flags,
            "there" if row.guarded else "taken out",
            f"{row.samples}",
            f"{row.differing}",
            f"{row.largest_um:.3g}",
            f"{row.selftest} mismatches",
        ]
        for row in found
    ]
    return header, rows


def unguarded(name: str, texts: Mapping[str, str]) -> dict[str, str]:
    """The same texts without what forbids fusing. Raises BuildError if there is no such guard."""
    bare, count = _GUARD.subn("", texts[f"{name}.c"])
    if count != 1:
        raise BuildError(f"{name}.c: the guard against fused multiply-adds was not found; adapt the proof")
    return {**texts, f"{name}.c": bare}


def _expected(model: Model, texts: Mapping[str, str], samples: int) -> tuple[Words, list[Words]]:
    host = Host(model.name, texts)
    heard = ["channel"] * host.channels
    pieces = list(chunks(model, "random", ["displacement", "voltage", *heard], samples, 1))
    inputs = [np.concatenate(column) for column in zip(*pieces, strict=True)]
    return _results(host, inputs), inputs


def _results(machine: Host | Emulated, inputs: Sequence[Words]) -> Words:
    return machine.run("predict", machine.instance(0.0, 0.0), inputs)[0]

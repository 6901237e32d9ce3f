"""Effect of fused multiply-adds on the bits, and the guard of the generated C against them.

A fused multiply-add rounds once where the C rounds twice. Compilers may form it by default; a guard in the generated C
forbids it to the compilers that accept this in the source. Every platform is compiled with fusing enabled: with the
guard no bit may change; without it, the changed results and the mismatches of the self-test are counted.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from hysgen.checking.bits.functions import MODEL
from hysgen.checking.bits.inputs import chunks
from hysgen.checking.host import Host
from hysgen.checking.proof.emulated.platforms import PLATFORMS, Platform
from hysgen.checking.proof.emulated.program import Emulated
from hysgen.checking.proof.hooked import replaced
from hysgen.errors import BuildError
from hysgen.model.model import Model

Words = NDArray[np.uint32]

FUSING: Final = ("-O2", "-ffp-contract=fast")


@dataclass(frozen=True)
class Fused:
    """Results of one platform compiled with fusing enabled, with or without the guard.

    differing: results of predict, out of `samples`, that differ from the host's. largest_um: the largest difference.
    selftest: mismatches counted by the generated self-test.
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
    platforms: Sequence[Platform] = PLATFORMS,
    progress: Callable[[float, str], None] | None = None,
) -> list[Fused]:
    """Compile and run every installed platform with fusing enabled, with the guard and without it.

    Raises ModelError if the guard is not that of the templates, BuildError if no platform is installed.
    """
    expected, inputs = _expected(model, texts, samples)
    bare = unguarded(model, texts)
    results = []
    installed = [platform for platform in platforms if not platform.missing]
    if not installed:
        raise BuildError("no other instruction set is installed: qemu-user-static and a cross gcc are needed")
    for place, platform in enumerate(installed):
        if progress is not None:
            progress(place / len(installed), f"fusing on {platform.name}")
        for guarded, sources in ((True, texts), (False, bare)):
            flags = (*FUSING, *platform.fused)
            program = Emulated(model.name, sources, platform, flags)
            out = _results(program, inputs)
            difference = np.abs(out.view(np.float32).astype(np.float64) - expected.view(np.float32))
            selftest = int(program.call("selftest")) if program.selftested else 0
            differing = int(np.count_nonzero(out != expected))
            largest = float(difference.max())
            results.append(Fused(platform.name, " ".join(flags), guarded, samples, differing, largest, selftest))
    return results


def contraction_rows(results: Sequence[Fused]) -> tuple[list[str], list[list[str]]]:
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
        for row in results
    ]
    return header, rows


def unguarded(model: Model, texts: Mapping[str, str]) -> dict[str, str]:
    """`texts` without the guard against fusing. Raises ModelError if its lines are not those of the templates."""
    return replaced(model, texts, "guard: contraction", [])


def _expected(model: Model, texts: Mapping[str, str], samples: int) -> tuple[Words, list[Words]]:
    host = Host(model.name, texts)
    pieces = list(chunks(model, "random", MODEL.quantities("predict", host), samples, 1))
    inputs = [np.concatenate(column) for column in zip(*pieces, strict=True)]
    return _results(host, inputs), inputs


def _results(host: Host | Emulated, inputs: Sequence[Words]) -> Words:
    return host.run("predict", host.instance(0.0, 0.0), inputs)[0]

"""Other processors under qemu: equality of bits, and what fused multiply-add would change."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from hysgen.checking.proof.emulated_equality import EmulationSettings, Fused, contraction, contraction_rows, equality
from hysgen.checking.proof.emulated_program import PLATFORMS
from hysgen.display import table
from hysgen.model.model import Model
from hysgen.targets.base import Equality, Extent, Progress, Target, Texts

SAMPLES = 20_000


@dataclass(frozen=True)
class FusedReport:
    """Bits that fused multiply-add changes, with the guard of the generated C and without it."""

    results: Sequence[Fused]

    @property
    def equal(self) -> bool:
        """Whether the guard keeps every bit on every platform."""
        guarded = [row for row in self.results if row.guarded]
        return bool(self.results) and all(row.differing == 0 and row.selftest == 0 for row in guarded)

    def lines(self) -> list[str]:
        """A row for each platform with the guard, and one without it."""
        header, rows = contraction_rows(self.results)
        return [table(header, rows, left=3)]

    def to_json(self) -> dict[str, Any]:
        """Plain JSON values."""
        return {"fused": [row.to_json() for row in self.results]}


def verify(model: Model, texts: Texts, extent: Extent, progress: Progress) -> Equality:
    """Compare the bits of emulated processors with those of the reference."""
    samples = SAMPLES if extent.samples is None else extent.samples
    platforms = [platform for platform in PLATFORMS if not extent.machines or platform.name in extent.machines]
    if extent.fused:
        return FusedReport(contraction(model, texts, samples=samples, platforms=platforms, progress=progress))
    return equality(model, texts, EmulationSettings(samples, platforms, seed=extent.seed), progress)


TARGET = Target(
    "emulated",
    about="on other processors under qemu, every one whose compiler is installed",
    verify=verify,
    verify_options=("machines", "fused"),
)

"""What a record holds and what it could show: ranges, rate, noise, excitation, and the requirement of each cause.

The figures come from voltage and displacement alone; no model is fitted. A requirement is a condition on the input
under which a cause leaves a trace; each cause states its own (`Cause.requirement`).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from hysgen.diagnosis.causes import causes, in_ladder_order
from hysgen.display import Displayed, Summary
from hysgen.record.data import Record
from hysgen.record.excitation import Excitation, check_for_fit

RULES = 6
"""Rules of the fit for which the excitation is checked."""


@dataclass(frozen=True)
class Requirement:
    """Whether the record meets what a cause needs, and what it has or lacks."""

    cause: str
    met: bool
    why: str


@dataclass(frozen=True, eq=False, repr=False)
class Inspection(Displayed):
    """The content of a record: its excitation and noise, and the requirement of each cause, in the ladder's order."""

    seen: Excitation
    requirements: tuple[Requirement, ...]
    warnings: tuple[str, ...]

    def summary(self) -> Summary:
        """Rate, ranges and excitation, then the requirement of each cause."""
        seen, record = self.seen, self.seen.record
        (low_um, high_um) = record.y_range_um
        per_sample = seen.noise.rms_um / max(high_um - low_um, 1e-300)
        first = [
            *(f"channel {name}: {low:.5g} .. {high:.5g}" for name, (low, high) in record.aux_ranges.items()),
            f"noise: {seen.noise.describe()}, {100.0 * per_sample:.2g} % of the stroke",
            f"excitation: {seen.swings} swings of {seen.sizes} sizes, {seen.lowest_Hz:.3g} to {seen.highest_Hz:.3g} "
            f"Hz, at most {seen.fastest_V_per_s:.4g} V/s; {seen.rests} rests, the longest {seen.longest_rest_s:.3g} s",
            *(f"warning: {line}" for line in self.warnings),
        ]
        rows = [[need.cause, "yes" if need.met else "no", need.why] for need in self.requirements]
        return Summary(record.one_line(), ["cause", "well excited", "because"], rows, left=3, first=first)

    def to_json(self) -> dict[str, Any]:
        """Plain JSON values."""
        seen, record = self.seen, self.seen.record
        return {
            "source": record.source,
            "samples": record.samples,
            "segments": [{"name": part.name, "samples": part.samples} for part in record.segments],
            "Ts_s": record.Ts_s,
            "duration_s": record.samples * record.Ts_s,
            "voltage_V": list(record.u_range_V),
            "displacement_um": list(record.y_range_um),
            "channels": {name: list(ends) for name, ends in record.aux_ranges.items()},
            "noise": seen.noise.to_json(),
            "excitation": {
                "swings": seen.swings,
                "sizes": seen.sizes,
                "rests": seen.rests,
                "longest_rest_s": seen.longest_rest_s,
                "lowest_Hz": seen.lowest_Hz,
                "highest_Hz": seen.highest_Hz,
                "fastest_V_per_s": seen.fastest_V_per_s,
            },
            "requirements": [{"cause": need.cause, "met": need.met, "why": need.why} for need in self.requirements],
            "warnings": [*record.warnings, *self.warnings],
        }


def inspect(record: Record) -> Inspection:
    """The content of a record and what it could show. Raises RecordError for a record too short for any fit."""
    seen = Excitation.of(record)
    needs = tuple(Requirement(name, *causes()[name].requirement(seen)) for name in in_ladder_order(causes()))
    return Inspection(seen, needs, check_for_fit(record, RULES, 3 * RULES))

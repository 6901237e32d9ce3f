"""What a record holds and what it could show: ranges, rate, noise, excitation, and the requirement of each cause.

The figures come from voltage and displacement alone; no model is fitted. A requirement is a condition on the input
under which a cause leaves a trace: creep needs a rest, memory needs swings of different size inside one another.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hysgen.display import Displayed, Summary
from hysgen.record.data import Record
from hysgen.record.excitation import check_for_fit, fastest_V_per_s
from hysgen.record.noise import NoiseFloor, noise_floor
from hysgen.record.series import SHORTEST_PLATEAU, plateaus, turning_rows

Floats = NDArray[np.float64]

TURN = 0.02
"""Part of the voltage range by which the voltage has to move back to make a turning point."""

SIZES = 0.05
"""Swings whose sizes differ by less than this part of the largest are one size."""

LONG_REST_S, DECADES = 0.5, 1.5
"""Rest from which creep shows, and the decades of time after a step that it needs."""

POWER = 0.999
"""Share of the power of the voltage's speed below the highest frequency of the excitation."""

LINE_PERIODS = 10
"""Periods of a disturbance that a record needs to tell it from the input."""

SAME_LEVEL = 0.02
"""Part of the range within which two voltages are the same level."""

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
    """The content of a record.

    swings, sizes: number of swings of the voltage and of distinct sizes. longest_rest_s, rests: constant voltage.
    lowest_Hz, highest_Hz: frequencies of the excitation. fastest_V_per_s: speed of the voltage (99.9 % quantile).
    """

    record: Record
    noise: NoiseFloor
    swings: int
    sizes: int
    rests: int
    longest_rest_s: float
    lowest_Hz: float
    highest_Hz: float
    fastest_V_per_s: float
    warnings: tuple[str, ...]

    @property
    def requirements(self) -> tuple[Requirement, ...]:
        """What each cause needs, and whether the record has it."""
        return tuple(_requirements(self))

    def summary(self) -> Summary:
        """Rate, ranges and excitation, then the requirement of each cause."""
        record = self.record
        (low_um, high_um) = record.y_range_um
        per_sample = self.noise.rms_um / max(high_um - low_um, 1e-300)
        first = [
            *(f"channel {name}: {low:.5g} .. {high:.5g}" for name, (low, high) in record.aux_ranges.items()),
            f"noise: {self.noise.describe()}, {100.0 * per_sample:.2g} % of the stroke",
            f"excitation: {self.swings} swings of {self.sizes} sizes, {self.lowest_Hz:.3g} to {self.highest_Hz:.3g} "
            f"Hz, at most {self.fastest_V_per_s:.4g} V/s; {self.rests} rests, the longest {self.longest_rest_s:.3g} s",
            *(f"warning: {line}" for line in self.warnings),
        ]
        rows = [[one.cause, "yes" if one.met else "no", one.why] for one in self.requirements]
        return Summary(record.one_line(), ["cause", "well excited", "because"], rows, left=3, first=first)

    def to_json(self) -> dict[str, Any]:
        """Plain JSON values."""
        record = self.record
        return {
            "source": record.source,
            "samples": record.samples,
            "segments": [{"name": one.name, "samples": one.samples} for one in record.segments],
            "Ts_s": record.Ts_s,
            "duration_s": record.samples * record.Ts_s,
            "voltage_V": list(record.u_range_V),
            "displacement_um": list(record.y_range_um),
            "channels": {name: list(ends) for name, ends in record.aux_ranges.items()},
            "noise": self.noise.to_json(),
            "excitation": {
                "swings": self.swings,
                "sizes": self.sizes,
                "rests": self.rests,
                "longest_rest_s": self.longest_rest_s,
                "lowest_Hz": self.lowest_Hz,
                "highest_Hz": self.highest_Hz,
                "fastest_V_per_s": self.fastest_V_per_s,
            },
            "requirements": [{"cause": one.cause, "met": one.met, "why": one.why} for one in self.requirements],
            "warnings": [*record.warnings, *self.warnings],
        }


def inspect(record: Record) -> Inspection:
    """The content of a record and what it could show. Raises RecordError for a record too short for any fit."""
    low_V, high_V = record.u_range_V
    heights: list[float] = []
    rests: list[int] = []
    for part in record.segments:
        turns = turning_rows(part.u_V, TURN * (high_V - low_V))
        heights += np.abs(np.diff(part.u_V[turns])).tolist()
        rests += [end - begin for begin, end in plateaus(part.u_V, SHORTEST_PLATEAU, 1e-6 * (high_V - low_V))]
    lowest, highest = _band(record)
    return Inspection(
        record=record,
        noise=noise_floor(record),
        swings=len(heights),
        sizes=len({round(height / (SIZES * (high_V - low_V))) for height in heights}),
        rests=len(rests),
        longest_rest_s=max(rests, default=0) * record.Ts_s,
        lowest_Hz=lowest,
        highest_Hz=highest,
        fastest_V_per_s=fastest_V_per_s(record),
        warnings=check_for_fit(record, RULES, 3 * RULES),
    )


def _band(record: Record) -> tuple[float, float]:
    """Lowest and highest frequency of the excitation in Hz, of the longest segment: POWER of the power of du/dt."""
    part = max(record.segments, key=lambda one: one.samples)
    speed = np.diff(part.u_V)
    power = np.cumsum(np.abs(np.fft.rfft(speed - speed.mean())) ** 2)
    if not power[-1] > 0.0:
        return 0.0, 0.0
    frequency = np.fft.rfftfreq(speed.size, record.Ts_s)
    low, high = np.searchsorted(power, [(1.0 - POWER) * power[-1], POWER * power[-1]])
    return float(frequency[low]), float(frequency[min(high, frequency.size - 1)])


def _requirements(found: Inspection) -> Iterator[Requirement]:
    record = found.record
    duration_s = record.samples * record.Ts_s
    decades = math.log10(max(found.longest_rest_s / (10.0 * record.Ts_s), 1e-9))
    nested = found.sizes >= 3
    yield Requirement("memory", nested, f"swings of {found.sizes} sizes" + ("" if nested else "; drive 3 or more"))
    rests = found.longest_rest_s >= LONG_REST_S and decades >= DECADES
    yield Requirement(
        "creep",
        rests,
        f"longest rest {found.longest_rest_s:.3g} s"
        + ("" if rests else f"; only strong creep shows, hold the voltage for {LONG_REST_S:g} s or more"),
    )
    yield Requirement(
        "resonance",
        found.highest_Hz > 0.0,
        f"the voltage has power up to {found.highest_Hz:.4g} Hz of {0.5 / record.Ts_s:.4g} Hz that the sampling shows",
    )
    wide = found.highest_Hz > 3.0 * max(found.lowest_Hz, 1e-12)
    yield Requirement(
        "delay",
        wide,
        f"{found.lowest_Hz:.3g} to {found.highest_Hz:.3g} Hz"
        + ("" if wide else "; lag and delay look alike at one frequency: drive a decade"),
    )
    yield Requirement(
        "saturation",
        True,
        f"only where the amplifier clips inside {record.u_range_V[0]:.4g} .. {record.u_range_V[1]:.4g} V",
    )
    yield Requirement("slew", found.fastest_V_per_s > 0.0, f"limits below {found.fastest_V_per_s:.4g} V/s")
    returns = _returns(record)
    yield Requirement(
        "drift",
        returns,
        "the voltage comes back to a level late in the record" if returns else "come back to a level later",
    )
    yield Requirement(
        "periodic", True, f"lines above {LINE_PERIODS / duration_s:.3g} Hz and below {0.5 / record.Ts_s:.4g} Hz"
    )
    yield Requirement(
        "aging", returns, "swings early and late at one level" if returns else "repeat the first swings at the end"
    )
    yield Requirement("outliers", True, f"jumps above about {8.0 * found.noise.rms_um:.2g} um")
    channels = bool(record.aux_names)
    yield Requirement(
        "coupling", channels, ", ".join(record.aux_names) if channels else "no further channel in the file"
    )


def _returns(record: Record) -> bool:
    """Whether the voltage is in the last fifth of the longest segment at the mean level of its first fifth."""
    part = max(record.segments, key=lambda one: one.samples)
    fifth = max(part.samples // 5, 1)
    low_V, high_V = record.u_range_V
    level = float(np.median(part.u_V[:fifth]))
    return bool(np.any(np.abs(part.u_V[-fifth:] - level) < SAME_LEVEL * (high_V - low_V)))

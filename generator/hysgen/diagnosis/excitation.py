"""The excitation of a record in figures."""

from dataclasses import dataclass
from typing import Self

import numpy as np

from hysgen.record import Record
from hysgen.record.excitation import fastest_V_per_s
from hysgen.record.noise import NoiseFloor, noise_floor
from hysgen.record.series import SHORTEST_PLATEAU, plateaus, turning_rows

TURN = 0.02
"""Part of the voltage range by which the voltage has to move back to make a turning point."""

SIZES = 0.05
"""Swings whose sizes differ by less than this part of the largest are one size."""

POWER = 0.999
"""Share of the power of the voltage's speed below the highest frequency of the excitation."""


@dataclass(frozen=True, eq=False)
class Excitation:
    """What the command of a record excites, and the noise beside it.

    swings, sizes: number of swings of the voltage and of distinct sizes. rests, longest_rest_s: constant voltage.
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

    @classmethod
    def of(cls, record: Record) -> Self:
        low_V, high_V = record.u_range_V
        heights: list[float] = []
        rests: list[int] = []
        for part in record.segments:
            turns = turning_rows(part.u_V, TURN * (high_V - low_V))
            heights += np.abs(np.diff(part.u_V[turns])).tolist()
            rests += [end - begin for begin, end in plateaus(part.u_V, SHORTEST_PLATEAU, 1e-6 * (high_V - low_V))]
        sizes = len({round(height / (SIZES * (high_V - low_V))) for height in heights})
        longest_s, band_Hz = max(rests, default=0) * record.Ts_s, _band(record)
        return cls(
            record,
            noise_floor(record),
            len(heights),
            sizes,
            len(rests),
            longest_s,
            *band_Hz,
            fastest_V_per_s(record),
        )


def _band(record: Record) -> tuple[float, float]:
    """Lowest and highest frequency of the excitation in Hz, of the longest segment: POWER of the power of du/dt."""
    part = max(record.segments, key=lambda part: part.samples)
    speed = np.diff(part.u_V)
    power = np.cumsum(np.abs(np.fft.rfft(speed - speed.mean())) ** 2)
    if not power[-1] > 0.0:
        return 0.0, 0.0
    frequency = np.fft.rfftfreq(speed.size, record.Ts_s)
    low, high = np.searchsorted(power, [(1.0 - POWER) * power[-1], POWER * power[-1]])
    return float(frequency[low]), float(frequency[min(high, frequency.size - 1)])

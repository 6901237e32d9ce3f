"""Coupling: other measured channels (a neighbouring drive, a temperature) act on the displacement.

    phi_ci(k) = clamp(a_c(k - i), low_c, high_c) - m_c,   i = 0 .. taps - 1,   m_c the middle of low_c .. high_c

a_c(k) is measured before y(k+1) is predicted and does not depend on u(k). Several taps are an FIR filter. A channel
outside its range is clamped; a sample that is not finite is replaced by the one before. Before the first sample every
channel is at the middle of its range.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import ClassVar, Self

import numpy as np

from hysgen.errors import ModelError
from hysgen.model.disturbances.base import Bits, Drive, Floats, Floats32, Mirror, Term, TermBox
from hysgen.model.float32_arithmetic import LEAST
from hysgen.model.intervals import Interval
from hysgen.model.part import Extent, RunSignals, octaves
from hysgen.model.structs import Member, Quantity, Status

MOST_TAPS = 64


@dataclass(frozen=True)
class Coupling(Term):
    """Auxiliary `channels`, each with its range `low` .. `high` in its own unit and `taps` samples.

    Raises ValueError if a range is empty, a channel stands twice, or taps is not 1 to 64.
    """

    kind: ClassVar[str] = "coupling"
    cause: ClassVar[str] = "coupling"
    place: ClassVar[int] = 90
    quantities: ClassVar[Mapping[str, Quantity]] = {
        "low": Quantity("lower limit of each channel, in its unit"),
        "high": Quantity("upper limit of each channel, in its unit"),
        "middle": Quantity("middle of the range of each channel, in its unit"),
    }
    channels: tuple[str, ...] = field()
    low: tuple[float, ...]
    high: tuple[float, ...]
    taps: int = 1

    def __post_init__(self) -> None:
        low, high = np.asarray(self.low, dtype=np.float64), np.asarray(self.high, dtype=np.float64)
        if not self.channels or len(set(self.channels)) != len(self.channels):
            raise ValueError("channels must name each auxiliary channel once")
        if not all(name.isprintable() and "/*" not in name and "*/" not in name for name in self.channels):
            raise ValueError("channels must have names that may stand in a C comment; rename the column")
        if not (low.shape == high.shape == (len(self.channels),)):
            raise ValueError("low and high must give one number for each channel")
        if not (np.isfinite(low).all() and np.isfinite(high).all() and (low < high).all()):
            raise ValueError("low must lie below high in each channel")
        if not 1 <= self.taps <= MOST_TAPS:
            raise ValueError(f"taps must be 1 to {MOST_TAPS}")

    @property
    def size(self) -> int:
        return len(self.channels) * self.taps

    @classmethod
    def of(cls, ranges: Mapping[str, tuple[float, float]], taps: int = 1) -> Self:
        """For channels with their ranges (low, high) by name."""
        low, high = zip(*ranges.values(), strict=True)
        return cls(tuple(ranges), low, high, taps)

    @property
    def ranges(self) -> dict[str, tuple[float, float]]:
        """Range (low, high) of each channel by its name; inverse of `of`."""
        return dict(zip(self.channels, zip(self.low, self.high, strict=True), strict=True))

    @property
    def weight_orders(self) -> float:
        return len(self.channels) * octaves(self.taps)

    def apart(self, runs: Sequence[RunSignals], Ts_s: float) -> bool:
        return True

    def columns(self, run: RunSignals, extent: Extent, seen: Callable[[Floats], Floats]) -> list[Floats]:
        lagged = [seen(run.aux[name]) for name in self.channels]
        at = np.arange(len(run.u_V))
        return [np.interp(at - tap / run.stride, at, channel) for channel in lagged for tap in range(self.taps)]

    def columns_depend_on(self, lag_s: float, delay: float) -> Hashable:
        return (self, lag_s, delay)

    @property
    def middle(self) -> Floats:
        """(channels,) m_c, float32 numbers, so that model and C subtract the same."""
        middle = 0.5 * (np.asarray(self.low) + np.asarray(self.high))
        return np.asarray(middle.astype(np.float32), dtype=np.float64)

    def describe(self) -> str:
        taps = f", {self.taps} samples of each" if self.taps > 1 else ""
        return "coupling to " + ", ".join(self.channels) + taps

    def regressors(self, drive: Drive) -> Floats:
        """(n, channels * taps), channel by channel, the newest sample first.

        The state is ((taps - 1) * channels,) samples before the first, as regressors, oldest first, channel by channel.

        Raises ModelError if the drive lacks a channel.
        """
        missing = [name for name in self.channels if name not in drive.aux]
        if missing:
            raise ModelError(
                f"coupling: channel {missing[0]!r} is not in the record; it has {', '.join(drive.aux) or 'none'}"
            )
        start = drive.start.get(self.kind, np.zeros(len(self.channels) * (self.taps - 1)))
        start = start.reshape(len(self.channels), self.taps - 1)
        columns = []
        for c, name in enumerate(self.channels):
            value = np.clip(drive.aux[name], self.low[c], self.high[c]) - self.middle[c]
            past = np.concatenate([start[c], value])
            columns += [past[self.taps - 1 - i : past.size - i] for i in range(self.taps)]
        return np.stack(columns, axis=1)

    def burn_in(self, drive: Drive) -> int:
        return min(self.taps - 1, drive.u_V.size)

    def box(self, Ts_s: float) -> TermBox:
        """low_c - m_c <= sample[c][i] <= high_c - m_c for every tap i, in the unit of channel c.

        The C subtracts in float32: 1e-6 of the range on either side is more than the subtraction rounds. phi is the
        samples themselves, channel by channel.
        """
        floats: dict[str, Interval] = {}
        sizes: list[float] = []
        limits = self.constants(Ts_s)
        for c, (low, high, middle) in enumerate(zip(*(limits[k] for k in ("low", "high", "middle")), strict=True)):
            away = Interval(float(low) - float(middle), float(high) - float(middle))
            away = away.outwards(1e-6 * float(high - low))
            floats |= {f"sample[{c}][{i}]": away for i in range(self.taps)}
            sizes += [away.magnitude] * self.taps
        return TermBox(floats, tuple(sizes))

    def members(self) -> tuple[Member, ...]:
        about = "[channel][age], in the unit of the channel, age 0 the newest"
        return (Member("sample", "float", about, (len(self.channels), self.taps)),)

    def mirror(self, lanes: int, Ts_s: float) -> ChannelMirror:
        return ChannelMirror(self, self.constants(Ts_s), lanes)

    def constants(self, Ts_s: float) -> Mapping[str, Floats32]:
        return {
            "low": np.asarray(self.low, dtype=np.float32),
            "high": np.asarray(self.high, dtype=np.float32),
            "middle": self.middle.astype(np.float32),
        }

    @classmethod
    def examples(cls, rng: np.random.Generator) -> tuple[Self, ...]:
        """Two channels with several taps, one channel with one tap."""
        several = cls(("other", "third"), (0.0, -5.0), (40.0, 5.0), int(rng.integers(2, 5)))
        return several, cls(("other",), (0.0,), (40.0,))


class ChannelMirror(Mirror):
    """Float32 channels over lanes."""

    def __init__(self, term: Coupling, constants: Mapping[str, Floats32], lanes: int) -> None:
        self.members = term.members()
        self._channels = term.channels
        self._limits = [np.asarray(constants[name]) for name in ("low", "high", "middle")]
        self.sample: list[list[Floats32]] = [[np.zeros(lanes, np.float32)] * term.taps for _ in term.channels]

    def listen(self, aux: Mapping[str, Floats32]) -> Bits:
        status = np.zeros(self.sample[0][0].shape, dtype=np.uint32)
        for past, name, low, high, middle in zip(self.sample, self._channels, *self._limits, strict=True):
            finite = np.isfinite(aux[name])
            value = np.where(finite, np.where(np.abs(aux[name]) < LEAST, np.float32(0.0), aux[name]), middle)
            limited = np.where(value < low, low, np.where(value > high, high, value))
            past[0] = np.where(finite, limited - middle, past[0])
            status = status | np.where(finite, np.uint32(0), np.uint32(Status.AUX_REJECTED))
            status = status | np.where(limited != value, np.uint32(Status.AUX_CLAMPED), np.uint32(0))
        return status

    def regressors(self) -> list[Floats32]:
        return [value for past in self.sample for value in past]

    def advance(self) -> None:
        for past in self.sample:
            past[1:] = past[:-1]

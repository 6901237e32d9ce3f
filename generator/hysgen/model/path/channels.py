"""Auxiliary channels of a part: other measured signals, limited to their range and taken about its middle.

A channel outside its range is clamped; a sample that is not finite is replaced by the one before. Before the first
sample every channel is at the middle of its range.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from hysgen.errors import ModelError
from hysgen.model.float32_arithmetic import LEAST
from hysgen.model.intervals import Interval
from hysgen.model.structs import Member, Quantity, Status

Floats = NDArray[np.float64]
Floats32 = NDArray[np.float32]
Bits = NDArray[np.uint32]


@dataclass(frozen=True)
class Channels:
    """Auxiliary `channels`, each with its range `low` .. `high` in its own unit; taps: samples of each that are kept.

    Raises ValueError if a range is empty, a channel stands twice, or a name may not stand in a C comment.
    """

    kind: ClassVar[str]
    quantities: ClassVar[Mapping[str, Quantity]] = {
        "low": Quantity("lower limit of each channel, in its unit"),
        "high": Quantity("upper limit of each channel, in its unit"),
        "middle": Quantity("middle of the range of each channel, in its unit"),
    }
    channels: tuple[str, ...] = field()
    low: tuple[float, ...]
    high: tuple[float, ...]
    taps = 1

    def __post_init__(self) -> None:
        low, high = np.asarray(self.low, dtype=np.float64), np.asarray(self.high, dtype=np.float64)
        if len(set(self.channels)) != len(self.channels):
            raise ValueError("channels must name each auxiliary channel once")
        if not all(name.isprintable() and "/*" not in name and "*/" not in name for name in self.channels):
            raise ValueError("channels must have names that may stand in a C comment; rename the column")
        if not (low.shape == high.shape == (len(self.channels),)):
            raise ValueError("low and high must give one number for each channel")
        if not (np.isfinite(low).all() and np.isfinite(high).all() and (low < high).all()):
            raise ValueError("low must lie below high in each channel")

    @property
    def middle(self) -> Floats:
        """(channels,) m_c, float32 numbers, so that model and C subtract the same."""
        middle = 0.5 * (np.asarray(self.low) + np.asarray(self.high))
        return np.asarray(middle.astype(np.float32), dtype=np.float64)

    def heard(self, aux: Mapping[str, Floats]) -> list[Floats]:
        """clamp(a_c(k), low_c, high_c) - m_c of every channel, (n,) each.

        Raises ModelError if `aux` lacks a channel.
        """
        missing = [name for name in self.channels if name not in aux]
        if missing:
            raise ModelError(
                f"{self.kind}: channel {missing[0]!r} is not in the record; it has {', '.join(aux) or 'none'}"
            )
        rows = zip(self.channels, self.low, self.high, self.middle, strict=True)
        return [np.clip(aux[name], low, high) - middle for name, low, high, middle in rows]

    def heard_box(self) -> dict[str, Interval]:
        """low_c - m_c <= sample[c][i] <= high_c - m_c for every tap i, in the unit of channel c.

        The C subtracts in float32: 1e-6 of the range on either side is more than the subtraction rounds.
        """
        limits = [np.asarray(limit, dtype=np.float32) for limit in (self.low, self.high, self.middle)]
        floats: dict[str, Interval] = {}
        for c, (low, high, middle) in enumerate(zip(*(limit.tolist() for limit in limits), strict=True)):
            away = Interval(low - middle, high - middle).outwards(1e-6 * (high - low))
            floats |= {f"sample[{c}][{i}]": away for i in range(self.taps)}
        return floats

    def members(self) -> tuple[Member, ...]:
        about = "[channel][age], in the unit of the channel, age 0 the newest"
        return (Member("sample", "float", about, (len(self.channels), self.taps)),) if self.channels else ()

    def constants(self, Ts_s: float) -> Mapping[str, Floats32]:
        if not self.channels:
            return {}
        return {name: np.asarray(getattr(self, name), dtype=np.float32) for name in ("low", "high", "middle")}


class ChannelListener:
    """The channels of a float32 mirror over lanes: `sample`, by channel and age."""

    def listen_to(self, part: Channels, constants: Mapping[str, Floats32], lanes: int | tuple[int, ...]) -> None:
        self._channels = part.channels
        self._limits = [np.asarray(constants.get(name, [])) for name in ("low", "high", "middle")]
        self.sample: list[list[Floats32]] = [[np.zeros(lanes, np.float32)] * part.taps for _ in part.channels]

    def listen(self, aux: Mapping[str, Floats32]) -> Bits | None:
        """The auxiliary channels of sample k, (lanes,) each. Returns the bits to set in the status word."""
        status: Bits | None = None
        for past, name, low, high, middle in zip(self.sample, self._channels, *self._limits, strict=True):
            finite = np.isfinite(aux[name])
            value = np.where(finite, np.where(np.abs(aux[name]) < LEAST, np.float32(0.0), aux[name]), middle)
            limited = np.where(value < low, low, np.where(value > high, high, value))
            past[0] = np.where(finite, limited - middle, past[0])
            rejected = np.where(finite, np.uint32(0), np.uint32(Status.AUX_REJECTED))
            bits = rejected | np.where(limited != value, np.uint32(Status.AUX_CLAMPED), np.uint32(0))
            status = np.asarray(bits if status is None else status | bits, dtype=np.uint32)
        return status

"""Delay of the input by whole samples and a fraction of one.

    v(k) = u(k-d) + mu (u(k-d-1) - u(k-d)),   d + mu = samples,  0 <= mu < 1

Linear interpolation: v stays in the range of u, and a sine of frequency f loses at most (pi f Ts)^2 / 2 of its
amplitude (at mu = 1/2), 2e-4 at f = fs/150. With a preview of n = ceil(samples), the command of the inverse is

    u(k) = v(k+n-1) + mu (v(k+n) - v(k+n-1))          (v(k+n) if mu = 0)

an interpolation again: stable for every mu, inside the range of v, and off by the same second-order loss. The exact
inverse would be a recursion with a pole at -mu/(1-mu), unstable beyond half a sample. What arrives at sample k+n-1 is
fixed by u(k) and u(k-1); what arrives at k+n depends on the next command too.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np

from hysgen.model.intervals import Interval
from hysgen.model.part import ShapeParameter
from hysgen.model.path.base import Bits, BlockBox, BlockMirror, Floats, Floats32, InputBlock
from hysgen.model.structs import Member, Quantity

MOST_SAMPLES = 1000

LEAST_FITTED, MOST_FITTED = 0.05, 200.0
"""Least and largest delay that a fit finds, in samples: below, the held input within a sampling period decides."""


@dataclass(frozen=True)
class Delay(InputBlock):
    """Delay of the input by `samples` sampling periods, 0 to 1000, not necessarily whole.

    Raises ValueError if it is outside that range.
    """

    kind: ClassVar[str] = "delay"
    cause: ClassVar[str] = "delay"
    quantities: ClassVar[Mapping[str, Quantity]] = {
        "part": Quantity("delay beyond whole samples", "samples"),
    }
    place: ClassVar[int] = 20
    limits: ClassVar[bool] = False
    table: ClassVar[tuple[ShapeParameter, ...]] = (
        ShapeParameter("samples", "samples", lambda e: (LEAST_FITTED, MOST_FITTED), step=lambda e: 1e-3),
    )
    samples: float

    def __post_init__(self) -> None:
        if not 0.0 <= self.samples <= MOST_SAMPLES:
            raise ValueError(f"samples must be 0 to {MOST_SAMPLES}")

    @property
    def whole(self) -> int:
        """d: whole samples of the delay."""
        return math.floor(self.samples)

    @property
    def part(self) -> float:
        """mu: the fractional part, 0 <= mu < 1."""
        return self.samples - self.whole

    @property
    def late(self) -> float:
        return self.samples

    @property
    def preview(self) -> int:
        return math.ceil(self.samples)

    @property
    def interpolates(self) -> bool:
        return self.part > 0.0

    @property
    def ring(self) -> int:
        """Length of the ring in C: a power of two that holds u(k) .. u(k-d-1)."""
        return 1 << (self.whole + 1).bit_length()

    def describe(self) -> str:
        return f"input delayed by {self.samples:.4g} samples"

    def apply(self, u_V: Floats, Ts_s: float, start: Floats | None = None) -> Floats:
        late = np.concatenate([np.full(self.whole + 1, u_V[0]), u_V])[: u_V.size + 1]
        return np.asarray(late[1:] + self.part * (late[:-1] - late[1:]))

    def box(self, u_V: Interval, Ts_s: float) -> BlockBox:
        """newest <= ring - 1, wanted_V in u_V [V], and a wider range for every place of the ring and what comes out:

            a + mu (b - a)   in   [low - mu (high - low),  high + mu (high - low)]      for a, b in [low, high]

        as intervals of each operation make it (mu times 1.01 for the roundings), once for the commands of the inverse,
        which the ring holds, and once more for the output; in truth both stay between a and b.
        """
        part = 1.01 * float(self.constants(Ts_s)["part"][0])
        commands = u_V.outwards(part * u_V.width)
        floats = {f"ring[{i}]": commands for i in range(self.ring)}
        if self.interpolates:
            floats["wanted_V"] = u_V
        return BlockBox(floats, commands.outwards(part * commands.width), commands, {"newest": self.ring - 1})

    def members(self) -> tuple[Member, ...]:
        ring = (
            Member("ring", "float", "past inputs, a ring", (self.ring,), unit="V"),
            Member("newest", "uint32_t", "index of the last input"),
        )
        wanted = Member("wanted_V", "float", "input that the last command asked for, or the last input", unit="V")
        return (*ring, wanted) if self.interpolates else ring

    def mirror(self, u_V: Floats32, Ts_s: float) -> DelayMirror:
        return DelayMirror(self, self.constants(Ts_s)["part"][0], u_V)

    def constants(self, Ts_s: float) -> Mapping[str, Floats32]:
        return {"part": np.array([self.part], dtype=np.float32)}

    @classmethod
    def examples(cls, rng: np.random.Generator) -> tuple[Self, ...]:
        return (cls(float(rng.uniform(0.0, 6.0))),)


class DelayMirror(BlockMirror):
    """The float32 delay over lanes: a ring of past inputs, (ring, lanes), and the place of the newest."""

    def __init__(self, block: Delay, part: np.float32, u_V: Floats32) -> None:
        self.members = block.members()
        self._whole, self._part = block.whole, part
        self.ring = np.tile(u_V, (block.ring, 1))
        self.newest = np.zeros(u_V.shape, dtype=np.uint32)
        self.wanted_V = u_V.copy()

    def apply(self, u_V: Floats32) -> Floats32:
        self.wanted_V = u_V
        self._push(u_V)
        return self._between(self._whole)

    def command(self, v_V: Floats32) -> Floats32:
        u = v_V if self._part == 0 else self.wanted_V + self._part * (v_V - self.wanted_V)
        self.wanted_V = v_V
        self._push(u)
        return u

    def arrived(self) -> Floats32:
        return self._between(0)

    def restore(self, words: Sequence[Bits]) -> None:
        super().restore(words)
        self.ring = np.array(self.ring)

    def rest(self) -> Floats32:
        return self.past(0)

    def _push(self, u_V: Floats32) -> None:
        self.newest = (self.newest + np.uint32(1)) % np.uint32(len(self.ring))
        self.ring[self.newest, np.arange(u_V.size)] = u_V

    def _between(self, samples: int) -> Floats32:
        """The input of `samples` + mu samples ago."""
        late, later = self.past(samples), self.past(samples + 1)
        return late + self._part * (later - late)

    def past(self, samples: int) -> Floats32:
        """What was handed over `samples` before the last input, (lanes,)."""
        place = (self.newest - np.uint32(samples)) % np.uint32(len(self.ring))
        return np.asarray(self.ring[place, np.arange(place.size)])

"""Memory: play operators, which remember past extremes of the input and keep the loop open as the frequency falls.

    z_j(k) = max(u(k) - r_j, min(u(k) + r_j, z_j(k-1)))        play (backlash) of half-width r_j [V]
    phi_j(k) = z_j(k-1)                                        taken before u(k) acts

The state one sample old costs nothing in accuracy and keeps the model affine in u(k). Thresholds beyond the largest
half-amplitude in the record never move and cannot be identified, so they are placed inside it.
Where the plays stand before a record is unknown: centred on u(0) by default, or as a past that `remembering` describes
left them; `settled` tells from where on it no longer matters.
Source: Krasnosel'skii and Pokrovskii, Systems with Hysteresis (1989); Brokate and Sprekels (1996), chapter 2.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, Self

import numpy as np

from hysgen.kernels import play_operators
from hysgen.terms.base import Bits, Drive, Floats, Floats32, Mirror, StateSpace


@dataclass(frozen=True)
class Memory:
    """Play operators with half-widths `thresholds_V`, (n,) positive and rising.

    Raises ValueError if they are not.
    """

    kind: ClassVar[str] = "memory"
    parts: ClassVar[tuple[str, ...]] = ()
    channels: ClassVar[tuple[str, ...]] = ()
    thresholds_V: tuple[float, ...]

    def __post_init__(self) -> None:
        r = np.asarray(self.thresholds_V, dtype=np.float64)
        if r.size == 0 or not np.isfinite(r).all() or r[0] <= 0 or (np.diff(r) <= 0).any():
            raise ValueError("thresholds_V must be positive and rising")

    @classmethod
    def uniform(cls, count: int, largest_half_amplitude_V: float) -> Self:
        """`count` thresholds spread evenly inside (0, largest_half_amplitude_V)."""
        return cls(tuple(float(r) for r in largest_half_amplitude_V * np.arange(1, count + 1) / (count + 1)))

    @property
    def size(self) -> int:
        return len(self.thresholds_V)

    def scales(self, span_V: float) -> tuple[float, ...]:
        return (span_V,) * self.size

    def describe(self) -> str:
        return f"{self.size} play operators, half-widths {self.thresholds_V[0]:.3g} .. {self.thresholds_V[-1]:.3g} V"

    def regressors(self, drive: Drive) -> Floats:
        """(n, size) play outputs in V, one sample old."""
        start = drive.start.get(self.kind, self.start(float(drive.u_V[0])))
        plays = play_operators(drive.u_V, np.asarray(self.thresholds_V), start)
        return np.vstack([start[None, :], plays[:-1]])

    def start(self, u_V: float) -> Floats:
        return np.full(self.size, u_V)

    def remembering(self, past_V: Sequence[float], u_V: float) -> Floats:
        """(size,) state after an input that turned at each of past_V and then went to u_V.

        The plays start centred on the first turn. One turn c gives the states clip(c, u - r_j, u + r_j): what is left
        of oscillations that died out around c, so that c is the one unknown of a stage that was switched on at rest.
        """
        turns = np.asarray([*past_V, u_V], dtype=np.float64)
        track = play_operators(turns, np.asarray(self.thresholds_V), np.full(self.size, turns[0]))
        return np.array(track[-1])

    def settled(self, drive: Drive) -> int:
        """First sample at which plays started at either end of their slack have met: from there on it is exact."""
        r = np.asarray(self.thresholds_V)
        low = play_operators(drive.u_V, r, drive.u_V[0] - r)[:, -1]
        high = play_operators(drive.u_V, r, drive.u_V[0] + r)[:, -1]
        met = np.flatnonzero(low == high)
        return int(met[0]) + 1 if met.size else drive.u_V.size

    def linear(self, Ts_s: float) -> StateSpace | None:
        return None

    def gains(self, Ts_s: float) -> tuple[float, ...]:
        """A play never leaves the range of its input, and two runs of it are never further apart than their inputs."""
        return (1.0,) * self.size

    def shape(self) -> Floats:
        """(1,) logarithm of the widest threshold; the others keep their ratio to it."""
        return np.array([np.log(self.thresholds_V[-1])])

    def with_shape(self, shape: Floats) -> Self:
        widen = float(np.exp(shape[0])) / self.thresholds_V[-1]
        return type(self)(tuple(widen * r for r in self.thresholds_V))

    def shape_bounds(self, drive: Drive) -> tuple[Floats, Floats]:
        half = max(0.5 * float(np.ptp(drive.u_V)), np.finfo(np.float64).tiny)
        return np.log([0.05 * half]), np.log([half])

    def mirror(self, u_V: Floats32, Ts_s: float) -> PlayMirror:
        return PlayMirror(self.constants(Ts_s)["half_width"], u_V)

    def constants(self, Ts_s: float) -> Mapping[str, Floats32]:
        return {"half_width": np.asarray(self.thresholds_V, dtype=np.float32)}

    def to_json(self) -> dict[str, Any]:
        return {"kind": self.kind, "thresholds_V": list(self.thresholds_V)}

    @classmethod
    def from_json(cls, data: Mapping[str, Any]) -> Self:
        return cls(tuple(float(r) for r in data["thresholds_V"]))


class PlayMirror(Mirror):
    """Float32 play operators over lanes; `low = u - r`, `high = u + r`, then the two comparisons of the C."""

    def __init__(self, half_width: Floats32, u_V: Floats32) -> None:
        self._half_width = half_width
        self._play = [u_V.copy() for _ in half_width]

    def regressors(self) -> list[Floats32]:
        return [play.copy() for play in self._play]

    def advance(self, u_V: Floats32) -> None:
        for j, r in enumerate(self._half_width):
            low, high, play = u_V - r, u_V + r, self._play[j]
            play = np.where(play > high, high, play)
            self._play[j] = np.where(play < low, low, play)

    def state(self) -> list[Floats32]:
        return self._play

    def restore(self, words: Sequence[Bits]) -> None:
        self._play = [word.view(np.float32) for word in words]


TERM = Memory

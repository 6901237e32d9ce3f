"""Memory: play operators, which remember past extremes of the input and keep the loop open as the frequency falls.

    z_j(k) = max(u(k) - r_j, min(u(k) + r_j, z_j(k-1)))        play (backlash) of half-width r_j [V]
    phi_j(k) = z_j(k-1)                                        taken before u(k) acts

The state one sample old costs nothing in accuracy and keeps the model affine in u(k). Thresholds beyond the largest
half-amplitude in the record never move and cannot be identified, so they are placed inside it.
Source: Krasnosel'skii and Pokrovskii, Systems with Hysteresis (1989); Brokate and Sprekels (1996), chapter 2.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Self

import numpy as np

from hysgen.kernels import play_operators
from hysgen.terms.base import Drive, Floats, Floats32


@dataclass(frozen=True)
class Memory:
    """Play operators with half-widths `thresholds_V`, (n,) positive and rising.

    Raises ValueError if they are not.
    """

    kind: ClassVar[str] = "memory"
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

    @property
    def scales(self) -> tuple[float, ...]:
        return (max(self.thresholds_V),) * self.size

    def describe(self) -> str:
        return f"{self.size} play operators, half-widths {self.thresholds_V[0]:.3g} .. {self.thresholds_V[-1]:.3g} V"

    def regressors(self, drive: Drive) -> Floats:
        """(n, size) play outputs in V, one sample old; every play starts centred on u(0)."""
        plays = play_operators(drive.u_V, np.asarray(self.thresholds_V), np.full(self.size, drive.u_V[0]))
        return np.vstack([np.full((1, self.size), drive.u_V[0]), plays[:-1]])

    def mirror(self, u_V: Floats32) -> PlayMirror:
        return PlayMirror(self.constants()["half_width"], u_V)

    def constants(self) -> Mapping[str, Floats32]:
        return {"half_width": np.asarray(self.thresholds_V, dtype=np.float32)}

    def to_json(self) -> dict[str, Any]:
        return {"kind": self.kind, "thresholds_V": list(self.thresholds_V)}

    @classmethod
    def from_json(cls, data: Mapping[str, Any]) -> Self:
        return cls(tuple(float(r) for r in data["thresholds_V"]))


class PlayMirror:
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


TERM = Memory

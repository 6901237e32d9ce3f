"""Saturation of the amplifier.

    v(k) = min(max(u(k), low), high)

The commands of the inverse lie between the levels already.

Slew: rate limit of the amplifier.

    v(k) = min(max(u(k), v(k-1) - fall Ts), v(k-1) + rise Ts)

Where the limit is not active, v = u bit for bit. The commands of the inverse are within the limit already.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from hysgen.machine.kernels.operators import slew_limited
from hysgen.model.intervals import Interval
from hysgen.model.part import Extent, ShapeParameter
from hysgen.model.path.base import BlockBox, BlockMirror, Floats, Floats32, InputBlock, limited
from hysgen.model.structs import Member, Quantity

LEAST_BEYOND = 0.01
"""Least share of the command's range beyond a level; at the end of the range every curve resembles saturation."""

UNLIMITED = np.finfo(np.float32).max
"""Level in C of a side that does not clip."""


def _least_V(extent: Extent) -> float:
    """Least distance of a level from the end of the command's range."""
    return 2.0 * LEAST_BEYOND * extent.half_V


def _step_V(extent: Extent) -> float:
    """Step of a forward difference in a level: a smaller one may pass no sample of the command."""
    return 2e-3 * extent.half_V


@dataclass(frozen=True)
class Saturation(InputBlock):
    """Levels between which the input passes unchanged; None where a side does not clip.

    Raises ValueError if they are not finite or low_V is not below high_V.
    """

    kind: ClassVar[str] = "saturation"
    cause: ClassVar[str] = "saturation"
    quantities: ClassVar[Mapping[str, Quantity]] = {
        "low": Quantity("lowest input", "V"),
        "high": Quantity("highest input", "V"),
    }
    place: ClassVar[int] = 0
    amplifies: ClassVar[bool] = True
    table: ClassVar[tuple[ShapeParameter, ...]] = (
        ShapeParameter("low_V", "V", lambda e: (e.low_V + _least_V(e), e.middle_V - _step_V(e)), step=_step_V),
        ShapeParameter("high_V", "V", lambda e: (e.middle_V + _step_V(e), e.high_V - _least_V(e)), step=_step_V),
    )
    low_V: float | None = None
    high_V: float | None = None

    def __post_init__(self) -> None:
        levels_V = [level_V for _, level_V, _ in self.levels]
        if not np.isfinite(levels_V).all() or levels_V != sorted(set(levels_V)):
            raise ValueError("low_V must lie below high_V")

    @property
    def levels(self) -> tuple[tuple[str, float, float], ...]:
        """Name, level and outward direction of each side that clips."""
        both = (("low_V", self.low_V, -1.0), ("high_V", self.high_V, 1.0))
        return tuple((name, level_V, sign) for name, level_V, sign in both if level_V is not None)

    def describe(self) -> str:
        return f"input saturates at {' and '.join(f'{level_V:.5g}' for _, level_V, _ in self.levels)} V"

    def apply(self, u_V: Floats, Ts_s: float, start: Floats | None = None) -> Floats:
        return np.clip(u_V, self.low_V, self.high_V)

    def box(self, u_V: Interval, Ts_s: float) -> BlockBox:
        """No state; max(u_low, low) <= v <= min(u_high, high) [V], or the level that all of u_V lies beyond."""
        levels = self.constants(Ts_s)
        low, high = float(levels["low"][0]), float(levels["high"][0])
        through = Interval(min(max(u_V.low, low), high), max(min(u_V.high, high), low))
        return BlockBox({}, through, through)

    def members(self) -> tuple[Member, ...]:
        return ()

    def mirror(self, u_V: Floats32, Ts_s: float) -> ClipMirror:
        levels = self.constants(Ts_s)
        return ClipMirror(levels["low"][0], levels["high"][0], u_V)

    def constants(self, Ts_s: float) -> Mapping[str, Floats32]:
        low, high = (
            level if level_V is None else np.float32(level_V)
            for level_V, level in ((self.low_V, -UNLIMITED), (self.high_V, UNLIMITED))
        )
        return {"low": np.array([low]), "high": np.array([high])}

    @classmethod
    def examples(cls, rng: np.random.Generator) -> tuple[Self, ...]:
        return (cls(float(rng.uniform(-15.0, -5.0)), float(rng.uniform(90.0, 110.0))),)


class ClipMirror(BlockMirror):
    """Float32 clipping over lanes; no state."""

    def __init__(self, low: np.float32, high: np.float32, u_V: Floats32) -> None:
        self._low, self._high = low, high
        self._rest = self.apply(u_V)

    def rest(self) -> Floats32:
        return self._rest

    def apply(self, u_V: Floats32) -> Floats32:
        return limited(u_V, self._low, self._high)


@dataclass(frozen=True)
class Slew(InputBlock):
    """Largest rates of the input in V/s, upwards and downwards, both positive.

    A fit finds one rate for both. Raises ValueError if one of them is not positive and finite.
    """

    kind: ClassVar[str] = "slew"
    cause: ClassVar[str] = "slew"
    quantities: ClassVar[Mapping[str, Quantity]] = {
        "rise": Quantity("largest rise of the input per sample", "V"),
        "fall": Quantity("largest fall of the input per sample", "V"),
    }
    place: ClassVar[int] = 10
    amplifies: ClassVar[bool] = True
    table: ClassVar[tuple[ShapeParameter, ...]] = (
        ShapeParameter(
            "rise_V_s",
            "V/s",
            lambda e: (0.1 * e.half_V / e.span_s, 4 * e.half_V / e.Ts_s),
            logarithm=True,
            step=lambda e: 1e-3,
        ),
    )
    rise_V_s: float
    fall_V_s: float

    def __post_init__(self) -> None:
        if not (np.isfinite(self.rise_V_s) and np.isfinite(self.fall_V_s) and min(self.rise_V_s, self.fall_V_s) > 0):
            raise ValueError("rise_V_s and fall_V_s must be positive")

    def describe(self) -> str:
        return f"input slews at most {self.rise_V_s:.5g} V/s up and {self.fall_V_s:.5g} V/s down"

    def apply(self, u_V: Floats, Ts_s: float, start: Floats | None = None) -> Floats:
        return slew_limited(u_V, self.rise_V_s * Ts_s, self.fall_V_s * Ts_s, float(u_V[0]))

    def with_values(self, values: Sequence[float]) -> Self:
        return type(self)(values[0], values[0])

    def apply_held(self, u_V: Floats, held: NDArray[np.int64], Ts_s: float) -> Floats:
        v_V = u_V.copy()
        for k in range(1, len(u_V)):
            samples = Ts_s * float(held[k - 1])
            v_V[k] = min(max(u_V[k], v_V[k - 1] - self.fall_V_s * samples), v_V[k - 1] + self.rise_V_s * samples)
        return v_V

    def averaged(self, columns: Floats, v_V: Floats, Ts_s: float) -> Floats:
        """A limited amplifier moves for the share |dv| / (rate Ts) of a period; the mean lags by half of this share."""
        moves_V = np.diff(v_V)
        moving = np.minimum(np.maximum(moves_V / self.rise_V_s, -moves_V / self.fall_V_s) / Ts_s, 1.0)
        columns[:, 1:] -= 0.5 * moving * np.diff(columns, axis=1)
        return columns

    def box(self, u_V: Interval, Ts_s: float) -> BlockBox:
        """last_V = v(k) lies between v(k-1) and u(k) [V]: both start in u_V, so v never leaves u_V."""
        return BlockBox({"last_V": u_V}, u_V, u_V)

    def members(self) -> tuple[Member, ...]:
        return (Member("last_V", "float", "last output of the limiter", unit="V"),)

    def mirror(self, u_V: Floats32, Ts_s: float) -> SlewMirror:
        steps = self.constants(Ts_s)
        return SlewMirror(self, steps["rise"][0], steps["fall"][0], u_V)

    def constants(self, Ts_s: float) -> Mapping[str, Floats32]:
        return {
            "rise": np.array([self.rise_V_s * Ts_s], dtype=np.float32),
            "fall": np.array([self.fall_V_s * Ts_s], dtype=np.float32),
        }

    @classmethod
    def examples(cls, rng: np.random.Generator) -> tuple[Self, ...]:
        return (cls(float(rng.uniform(1e5, 3e5)), float(rng.uniform(0.5e5, 2e5))),)


class SlewMirror(BlockMirror):
    """The float32 rate limiter over lanes."""

    def __init__(self, block: Slew, rise: np.float32, fall: np.float32, u_V: Floats32) -> None:
        self.members = block.members()
        self._rise, self._fall = rise, fall
        self.last_V = u_V.copy()

    def rest(self) -> Floats32:
        return self.last_V

    def apply(self, u_V: Floats32) -> Floats32:
        self.last_V = limited(u_V, self.last_V - self._fall, self.last_V + self._rise)
        return self.last_V

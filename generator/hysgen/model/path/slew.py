"""Slew: rate limit of the amplifier.

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
from hysgen.model.part import ShapeParameter
from hysgen.model.path.base import BlockBox, BlockMirror, Floats, Floats32, InputBlock, limited
from hysgen.model.structs import Member, Quantity


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


BLOCK = Slew

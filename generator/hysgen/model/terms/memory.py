"""Memory: play operators, whose state depends on past extremes of the input; their loop stays open at low frequency.

    z_j(k) = max(u(k) - r_j, min(u(k) + r_j, z_j(k-1)))        play (backlash) of half-width r_j [V]
    phi_j(k) = z_j(k-1)                                        before u(k) acts
    phi(k)   = T_2(x_j), T_3(x_j)                              up to `degree`, T_m Chebyshev polynomials
    x_j      = clamp((z_j(k-1) - middle) / half, -a_j, a_j)    middle and half width of range_V; a_j = 1 - r_j/half,
                                                               the largest |x_j| of a play that has moved once

A play of half-width 0 is the input one sample ago; its polynomials are a curve without memory. The plays enter y(k+1)
one sample late. The inverse compensates this lag through u(k); it overshoots where the plays' slope exceeds the gain b.
With a weight of -s for u(k-1) and a gain of b + s instead of b, the inverse does not overshoot: u(k) then contains part
of the plays' next step.

Without polynomials, a play has the same weight at every level of the input. The weights of a Preisach operator with a
density depend on the level: it is the integral over r of a function of z_r (Brokate and Sprekels, 1996, chapter 2.4),
which T_2 and T_3 approximate. The lag of one sample keeps the model affine in u(k); its error is negligible.
Half-widths above the largest half-amplitude of the record never move and cannot be identified, so they are placed
below it. The states before a record are unknown: centred on u(0) by default, or from the turning points of a past
input (`state_after`); `burn_in` is the number of samples that depend on them.
Source: Krasnosel'skii and Pokrovskii, Systems with Hysteresis (1989); Brokate and Sprekels (1996), chapter 2.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, Self

import numpy as np

from hysgen.machine.kernels import play_operators
from hysgen.model.float32_constants import LEAST
from hysgen.model.intervals import Interval
from hysgen.model.structs import Member
from hysgen.model.terms.base import Drive, Flags, Floats, Floats32, Mirror, StateSpace, Term, TermBox
from hysgen.model.terms.play_density import rising_rows, roughness_rows
from hysgen.model.terms.play_slopes import steepest_move

ONE = np.float32(1.0)
ROOT_2 = np.float32(np.sqrt(2.0))
"""T_2 = (sqrt(2) x - 1)(sqrt(2) x + 1) has no product of two small numbers, hence no denormal result."""


@dataclass(frozen=True)
class Memory(Term):
    """Play operators with half-widths `thresholds_V`, (m,) rising; the first may be 0.

    degree: of the polynomials, 1, 2 or 3; range_V: lowest and highest input, required for a degree above 1.
    Raises ValueError if a value is outside its domain.
    """

    kind: ClassVar[str] = "memory"
    thresholds_V: tuple[float, ...]
    degree: int = 1
    range_V: tuple[float, float] | None = None

    def __post_init__(self) -> None:
        r = np.asarray(self.thresholds_V, dtype=np.float64)
        if r.size == 0 or not np.isfinite(r).all() or r[0] < 0 or (np.diff(r) <= 0).any():
            raise ValueError("thresholds_V must be rising, from 0 or above")
        if self.degree not in (1, 2, 3):
            raise ValueError("degree must be 1, 2 or 3")
        if (self.range_V is None) != (self.degree == 1):
            raise ValueError("range_V belongs to a degree above 1, and to no other")
        if self.range_V is not None and not (np.isfinite(self.range_V).all() and self.range_V[0] < self.range_V[1]):
            raise ValueError("range_V must hold the lowest input, then the highest")
        if self.range_V is not None and r[-1] >= 0.5 * (self.range_V[1] - self.range_V[0]):
            raise ValueError("thresholds_V must lie below half the width of range_V")

    @classmethod
    def uniform(cls, count: int, largest_half_amplitude_V: float) -> Self:
        """`count` half-widths at equal distances inside (0, largest_half_amplitude_V)."""
        return cls(tuple(float(r) for r in largest_half_amplitude_V * np.arange(1, count + 1) / (count + 1)))

    @classmethod
    def polynomial(cls, count: int, degree: int, low_V: float, high_V: float, past_input: bool = False) -> Self:
        """`count` plays up to the half range, closer together near 0, because narrow plays determine small loops.

        past_input: one additional play of half-width 0.
        """
        r = 0.5 * (high_V - low_V) * (np.arange(0 if past_input else 1, count + 1) / (count + 1)) ** 1.5
        return cls(tuple(float(x) for x in r), degree, (low_V, high_V) if degree > 1 else None)

    @property
    def plays(self) -> int:
        """m: number of play operators."""
        return len(self.thresholds_V)

    @property
    def size(self) -> int:
        return self.plays * self.degree

    @property
    def middle_and_half_V(self) -> tuple[float, float]:
        """Middle and half width of range_V; the middle is a float32 number, so that model and C subtract the same."""
        low, high = self.range_V or (-1.0, 1.0)
        middle = np.float32(0.5 * (low + high))
        return (float(middle) if abs(middle) >= LEAST else 0.0), 0.5 * (high - low)

    @property
    def reach(self) -> Floats:
        """(m,) a_j: largest |x_j|."""
        return np.asarray(1.0 - np.asarray(self.thresholds_V) / self.middle_and_half_V[1])

    def describe(self) -> str:
        polynomials = "" if self.degree == 1 else f", polynomials up to degree {self.degree}"
        widths = f"half-widths {self.thresholds_V[0]:.3g} .. {self.thresholds_V[-1]:.3g} V"
        return f"{self.plays} play operators, {widths}{polynomials}"

    def regressors(self, drive: Drive) -> Floats:
        """(n, size) play outputs in V, one sample old; then T_2 of every play, then T_3."""
        start = drive.start.get(self.kind, self.start(float(drive.u_V[0])))
        plays = play_operators(drive.u_V, np.asarray(self.thresholds_V), start)
        z = np.vstack([start[None, :], plays[:-1]])
        if self.degree == 1:
            return z
        middle, half = self.middle_and_half_V
        x = np.clip((z - middle) / half, -self.reach, self.reach)
        return np.hstack([z, 2.0 * x * x - 1.0, (4.0 * x * x - 3.0) * x][: self.degree])

    def start(self, u_V: float) -> Floats:
        return np.full(self.plays, u_V)

    def state_after(self, past_V: Sequence[float], u_V: float) -> Floats:
        """(m,) state after an input with the turning points past_V that ended at u_V.

        The plays start centred on the first turning point. One turning point c gives the states
        clip(c, u - r_j, u + r_j), the states after oscillations about c that died out: the past of a stage that was
        switched on at rest has this one unknown.
        """
        turns = np.asarray([*past_V, u_V], dtype=np.float64)
        track = play_operators(turns, np.asarray(self.thresholds_V), np.full(self.plays, turns[0]))
        return np.array(track[-1])

    def burn_in(self, drive: Drive) -> int:
        """First sample at which the widest play has the same state from both ends of its slack; exact from there on."""
        r = np.asarray(self.thresholds_V)
        low = play_operators(drive.u_V, r, drive.u_V[0] - r)[:, -1]
        high = play_operators(drive.u_V, r, drive.u_V[0] + r)[:, -1]
        met = np.flatnonzero(low == high)
        return int(met[0]) + 1 if met.size else drive.u_V.size

    def linear(self, Ts_s: float) -> StateSpace | None:
        return None

    def gains(self, Ts_s: float) -> tuple[float, ...]:
        """1 for a play: |z| <= sup |u|, and the distance of two plays is at most that of their inputs.

        |T_2'| <= 4 a and |T_3'| <= max(3, 12 a^2 - 3) on [-a, a].
        """
        half, a = self.middle_and_half_V[1], self.reach
        steepest = np.concatenate([4.0 * a, np.maximum(3.0, 12.0 * a * a - 3.0)]) / half
        return (1.0,) * self.plays + tuple(float(x) for x in steepest[: self.size - self.plays])

    def steepest(self, weights: Floats) -> Floats:
        """Sharper than `gains`, because all moving plays move in one direction: see `play_slopes`."""
        return steepest_move(weights, self._r_over_half, self.middle_and_half_V[1])

    def rising(self) -> Floats:
        """(n, size) slopes g_j'(z) of every play, which are not negative for a Preisach operator's density.

        Unconstrained, T_2 and T_3 give negative slopes where the record has few samples. No rows for degree 1.
        """
        if self.degree == 1:
            return np.zeros((0, self.size))
        return rising_rows(self._r_over_half, self.middle_and_half_V[1], self.degree)

    def roughness(self) -> Floats:
        """(n, size) curvature of the density over the half-widths, see `play_density`. No rows for degree 1."""
        if self.degree == 1:
            return np.zeros((0, self.size))
        return roughness_rows(self._r_over_half, self.middle_and_half_V[1], self.degree)

    def past_input(self) -> Flags:
        """(size,) the play of half-width 0 and its polynomials."""
        return np.tile(np.asarray(self.thresholds_V) == 0.0, self.degree)

    @property
    def _r_over_half(self) -> Floats:
        return np.asarray(self.thresholds_V) / self.middle_and_half_V[1]

    def box(self, v_V: Interval, Ts_s: float) -> TermBox:
        """A play stays within its half-width of the input: v_low - r_j <= play[j] <= v_high + r_j [V], (m,).

        r_j times 1.0001, for v - r_j and v + r_j are rounded. |phi| is |play| [V], then, with |x_j| <= a_j,

            |T_2| = |(sqrt(2) x - 1) (sqrt(2) x + 1)| <= (sqrt(2) a_j + 1)^2
            |T_3| = |x (2 T_2 - 1)|                   <= a_j (2 |T_2| + 1)

        factor by factor, as intervals of each operation make it (1.001 a_j and 1.4143 for the roundings).
        """
        numbers = self.constants(Ts_s)
        plays = [v_V.outwards(1.0001 * float(r)) for r in numbers["half_width"]]
        reach = [1.001 * float(a) for a in numbers.get("reach", ())]
        even = [(1.4143 * a + 1.0) ** 2 for a in reach]
        odd = [a * (2.0 * size + 1.0) for a, size in zip(reach, even, strict=True)]
        sizes = ([play.magnitude for play in plays], even, odd)[: self.degree]
        return TermBox(
            {f"play[{j}]": play for j, play in enumerate(plays)}, tuple(size for group in sizes for size in group)
        )

    def shape(self) -> Floats:
        """(1,) logarithm of the largest half-width; the ratios of the others to it are constant."""
        return np.array([np.log(self.thresholds_V[-1])])

    def with_shape(self, shape: Floats) -> Self:
        widen = float(np.exp(shape[0])) / self.thresholds_V[-1]
        return dataclasses.replace(self, thresholds_V=tuple(widen * r for r in self.thresholds_V))

    def shape_bounds(self, drive: Drive) -> tuple[Floats, Floats]:
        half = max(0.5 * float(np.ptp(drive.u_V)), np.finfo(np.float64).tiny)
        return np.log([0.05 * half]), np.log([half])

    def members(self) -> tuple[Member, ...]:
        return (Member("play", "float", "[V]", (self.plays,)),)

    def mirror(self, u_V: Floats32, Ts_s: float) -> PlayMirror:
        return PlayMirror(self, self.constants(Ts_s), u_V)

    def constants(self, Ts_s: float) -> Mapping[str, Floats32]:
        constants = {"half_width": np.asarray(self.thresholds_V, dtype=np.float32)}
        if self.degree > 1:
            middle, half = self.middle_and_half_V
            constants["middle"] = np.array([middle], dtype=np.float32)
            constants["per_half"] = np.array([1.0 / half], dtype=np.float32)
            constants["reach"] = self.reach.astype(np.float32)
        return constants

    def to_json(self) -> dict[str, Any]:
        data: dict[str, Any] = {"kind": self.kind, "thresholds_V": list(self.thresholds_V)}
        return data if self.range_V is None else {**data, "degree": self.degree, "range_V": list(self.range_V)}

    @classmethod
    def from_json(cls, data: Mapping[str, Any]) -> Self:
        thresholds = tuple(float(r) for r in data["thresholds_V"])
        if "range_V" not in data:
            return cls(thresholds, int(data.get("degree", 1)))
        low, high = (float(end) for end in data["range_V"])
        return cls(thresholds, int(data["degree"]), (low, high))

    @classmethod
    def examples(cls, rng: np.random.Generator) -> tuple[Self, ...]:
        """1 to 12 plays: with the past input and cubics, with quadratics, and plain."""
        half_widths = tuple(np.cumsum(rng.uniform(0.5, 8.0, int(rng.integers(1, 13)))).tolist())
        range_V = (-100.0, 120.0)
        return cls((0.0, *half_widths), 3, range_V), cls(half_widths, 2, range_V), cls(half_widths)


class PlayMirror(Mirror):
    """Float32 play operators over lanes; `low = u - r`, `high = u + r`, then the two comparisons of the C."""

    def __init__(self, term: Memory, constants: Mapping[str, Floats32], u_V: Floats32) -> None:
        self.members = term.members()
        self._half_width = constants["half_width"]
        self._degree = degree = term.degree
        self._scaling = [constants[name] for name in ("middle", "per_half", "reach")] if degree > 1 else []
        self.play: list[Floats32] = [u_V.copy() for _ in self._half_width]

    def regressors(self) -> list[Floats32]:
        plays = [play.copy() for play in self.play]
        if self._degree == 1:
            return plays
        places = [self._place(j, play) for j, play in enumerate(plays)]
        even = [(ROOT_2 * x - ONE) * (ROOT_2 * x + ONE) for x in places]
        odd = [x * ((t + t) - ONE) for x, t in zip(places, even, strict=True)]
        return [*plays, *even, *odd][: len(plays) * self._degree]

    def _place(self, j: int, play: Floats32) -> Floats32:
        middle, per_half, reach = self._scaling
        x = (play - middle[0]) * per_half[0]
        x = np.where(x < -reach[j], -reach[j], x)
        return np.asarray(np.where(x > reach[j], reach[j], x))

    def advance(self, u_V: Floats32) -> None:
        for j, r in enumerate(self._half_width):
            low, high, play = u_V - r, u_V + r, self.play[j]
            play = np.where(play > high, high, play)
            self.play[j] = np.where(play < low, low, play)


TERM = Memory

"""Hysteresis: the displacement as a functional of the past voltages, rate-independent unless the plays relax.

    h(k) = g0(x) + sum_j g_j(z_j) + sum_i (b_i d_i + c_i d_i |d_i|)                              [um]
    x = (v - middle) / half range, limited to -1 .. 1
    z_j(k) = max(x(k) - r_j, min(x(k) + r_j, z_j(k-1)))                                    play operators
    d_i(k) = e_i d_i(k-1) + (1 - e_i) sign(dx),   e_i = exp(-2^i |dx| / reach),   i = 0, 1, ...     Duhem states

g0 and g_j are polynomials, stored as coefficients of Chebyshev polynomials. g0 and sum_j g_j(z_j) are a Preisach
operator (Brokate and Sprekels, 1996, chapter 2.4). The Duhem states decay along the path of the input, not in time,
and add operators such as Dahl's and Bouc-Wen's; their decay lengths halve from state to state, so that all of them cost
one exponential, e_(i+1) = e_i^2. Without plays and Duhem states the block is a single-valued curve.

With relaxation > 0 the domains switch by thermal activation: after each sample every play moves on, the input held,

    z_j <- z_j + s_j exp(-a_j (1 + a_j / 32)) sign(x - z_j),   a_j = (r_j - |x - z_j|) / s_j,   s_j = relaxation r_j

where a_j <= 15 and |z_j| <= min(1, 1 - r_j + 8 s_j). The exponent is a barrier that falls with the square of the field
(Neel, 1949; Sharrock, 1994), with exp(8) attempts per sample. At rest z_j moves by s_j per factor e of time (creep);
under drive the threshold grows by s_j per factor e of the rate, both less the curvature of the barrier. Within a sample
dh/dv is that of plays that do not relax.

`fitting` requires dh/dv > 0 along the record's path and sampled paths over the range, not of every g_j alone. There h
rises with v, and the inverse is a root of a rising, piecewise smooth function.
"""

import functools
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Self

import numpy as np
from numpy.polynomial import chebyshev

from hysgen.machine.kernels.operators import HysteresisSeries, hysteresis_path
from hysgen.model.float32_arithmetic import KEPT
from hysgen.model.intervals import Interval, symmetric
from hysgen.model.path.base import BlockBox, Floats, Floats32, InputBlock
from hysgen.model.path.hysteresis_mirror import (
    BARRIER,
    FROZEN,
    RELAXED,
    SLACK,
    HysteresisMirror,
    Numbers,
    RelaxingMirror,
)
from hysgen.model.path.hysteresis_steps import accepted_residual, newton_steps
from hysgen.model.structs import Member, Quantity

LEAST_HALF_WIDTH = 2.0**-12
"""Smallest half-width of a play: the state x - r or x + r of a play is then 0 or at least 2^-40 in magnitude."""

LEAST_REACH, LEAST_LAST_REACH = 0.3607, 0.0451
"""Smallest decay lengths of the first and of the last Duhem state, in half ranges. Over the whole range the first
state decays by 2^(-2 log2(e) / reach) >= 2^-8, the limit of the float32 power of two, the last by 2^-64 or more."""

LEAST_RELAXATION, MOST_RELAXATION = 2.0**-9, 2.0**-4
"""Limits of s_j / r_j. Above 1/16 a play would move at |x - z| = 0, below 1/512 the last bit of z exceeds s/1000."""

GROUP = 6
"""Plays that the C computes side by side: of 12 plays on the C674x, groups of 3, 4 and 6 take 277, 274, 271 cycles."""

PLACES = 257
"""Points of a polynomial at which its range is read; `Chain` clamps the input of the rules, so the range need not be
exact."""


@dataclass(frozen=True)
class Hysteresis(InputBlock):
    """Coefficients of the operator over the input range low_V .. high_V.

    curve_um: of T_0(x) .. T_C(x) in g0. half_widths: r_j in half ranges, rising, below 1. plays_um: of T_1(z_j) ..
    T_D(z_j) in g_j, play after play. reach: the longest decay length of the Duhem states in half ranges. duhem_um: b_0,
    c_0, b_0, c_0, ..., from the longest decay length on. relaxation: s_j / r_j, 0 for plays that do not relax; it
    belongs to the sampling period of the model.
    Raises ValueError if sizes disagree, or if a half-width, a decay length or the relaxation has no float32 form
    (LEAST_HALF_WIDTH, LEAST_REACH, LEAST_LAST_REACH, LEAST_RELAXATION, MOST_RELAXATION).
    """

    kind: ClassVar[str] = "hysteresis"
    quantities: ClassVar[Mapping[str, Quantity]] = {
        "range": Quantity(
            "middle and half of the input range [V], 1 / half [1/V], least, largest [um] and 1 / mean slope [1/um]"
        ),
        "curve": Quantity("coefficients of g0 with the first n plays, for either direction", "um"),
        "play": Quantity("half-width [half ranges] and coefficients [um] of each play"),
        "relax": Quantity("s [half ranges], 1 / s and largest magnitude [half ranges] of each play that relaxes"),
        "rate": Quantity("exponent of the first Duhem state per half range"),
        "duhem": Quantity("b and c [um], 1 / reach of each Duhem state"),
    }
    place: ClassVar[int] = 30
    limits: ClassVar[bool] = False
    responds: ClassVar[bool] = True
    unit: ClassVar[str] = "um"

    low_V: float
    high_V: float
    curve_um: tuple[float, ...]
    half_widths: tuple[float, ...] = ()
    plays_um: tuple[float, ...] = ()
    reach: float = 1.0
    duhem_um: tuple[float, ...] = ()
    relaxation: float = 0.0

    def __post_init__(self) -> None:
        if not self.low_V < self.high_V:
            raise ValueError("low_V must be below high_V")
        if len(self.curve_um) < 2:
            raise ValueError("curve_um must have at least two coefficients")
        widths = self.half_widths
        if any(not LEAST_HALF_WIDTH <= r < 1.0 for r in widths) or list(widths) != sorted(set(widths)):
            raise ValueError("half_widths must rise and lie between 2^-12 and 1")
        if len(self.plays_um) != self.degree * len(widths) or bool(widths) != bool(self.plays_um):
            raise ValueError("plays_um must have the same number of coefficients for every play")
        if not 0.0 < self.reach < np.inf or len(self.duhem_um) % 2:
            raise ValueError("reach must be positive, and duhem_um must have two coefficients for each state")
        if self.states and (self.reach < LEAST_REACH or self.reaches[-1] < LEAST_LAST_REACH):
            raise ValueError(
                f"reach must be at least {LEAST_REACH} half ranges, and that of the last Duhem state "
                f"{LEAST_LAST_REACH}: over the whole range a state decays by a float32 power of two"
            )
        if self.relaxation and not (self.plays and LEAST_RELAXATION <= self.relaxation <= MOST_RELAXATION):
            raise ValueError("relaxation must be 0, or lie between 1/512 and 1/16 in a block with plays")
        if not np.isfinite([*self.curve_um, *self.plays_um, *self.duhem_um]).all():
            raise ValueError("the coefficients must be finite")

    def to_json(self) -> dict[str, Any]:
        plain = super().to_json()
        if not self.relaxation:
            del plain["relaxation"]
        return plain

    @property
    def two_words(self) -> bool:  # type: ignore[override]
        """Whether the plays are sums of two words: increments at rest are below the last bit of one."""
        return self.relaxes

    @property
    def relaxes(self) -> bool:
        """Whether the plays relax."""
        return self.relaxation > 0.0

    @property
    def ends(self) -> tuple[float, ...]:
        """Largest magnitude of every play, in half ranges."""
        return tuple(largest_play(r, self.relaxation) for r in self.half_widths)

    @property
    def plays(self) -> int:
        """Number of play operators."""
        return len(self.half_widths)

    @property
    def degree(self) -> int:
        """D: degree of the polynomial of each play; 0 without plays."""
        return len(self.plays_um) // len(self.half_widths) if self.half_widths else 0

    @property
    def states(self) -> int:
        """Number of Duhem states."""
        return len(self.duhem_um) // 2

    @property
    def reaches(self) -> tuple[float, ...]:
        """Decay length of every Duhem state in half ranges."""
        return tuple(self.reach * 0.5**i for i in range(self.states))

    @property
    def series(self) -> HysteresisSeries:
        """The coefficients as arrays."""
        return HysteresisSeries(
            np.array(self.curve_um),
            np.array(self.half_widths),
            np.array(self.plays_um).reshape(self.plays, self.degree),
            np.array(self.reaches),
            np.array(self.duhem_um).reshape(self.states, 2),
            self.relaxation,
        )

    @property
    def numbers(self) -> Numbers:
        """The float32 constants. Raises ModelError if h does not change over the input range."""
        return _numbers(self)

    def describe(self) -> str:
        if not self.plays and not self.states:
            return f"curve of degree {len(self.curve_um) - 1}"
        relaxing = f", relaxing by {self.relaxation:.3g} of their half-widths" if self.relaxes else ""
        return (
            f"{self.plays} plays of degree {self.degree}{relaxing}, {self.states} Duhem states, "
            f"curve of degree {len(self.curve_um) - 1}"
        )

    def normalised(self, v_V: Floats) -> Floats:
        """x, (n,), of the voltages v_V, limited to -1 .. 1."""
        x = (v_V - 0.5 * (self.low_V + self.high_V)) * (2.0 / (self.high_V - self.low_V))
        return np.asarray(np.clip(x, -1.0, 1.0))

    def start(self, v_V: float) -> Floats:
        """State at rest under v_V: every play as near to the input as its range allows, d = 0, and the input."""
        x = float(self.normalised(np.array([v_V]))[0])
        r = np.array(self.half_widths)
        return np.concatenate([np.clip(x, r - 1.0, 1.0 - r), np.zeros(self.states), [x]])

    def apply(self, u_V: Floats, Ts_s: float, start: Floats | None = None) -> Floats:
        state = self.start(float(u_V[0])) if start is None else start
        return hysteresis_path(self.series, self.normalised(u_V), state)[0]

    def image(self, u_V: Interval) -> Interval:
        """Range of h for inputs in u_V, whatever the past: the sum of the ranges of its parts."""
        x = self.normalised(np.array([u_V.low, u_V.high]))
        low, high = _range(np.array(self.curve_um), float(x[0]), float(x[1]))
        for end, row in zip(self.ends, self.series.plays, strict=True):
            less, more = _range(np.array([0.0, *row]), -end, end)
            low, high = low + less, high + more
        for b, c in self.series.duhem:
            d = np.linspace(-1.0, 1.0, PLACES)
            values = b * d + c * d * np.abs(d)
            low, high = low + float(values.min()), high + float(values.max())
        return Interval(low, high)

    def slope_range(self) -> tuple[float, float]:
        """(m, M): bounds of dh/dx along every path, um per half range; the plays move together at most."""
        x = np.linspace(-1.0, 1.0, PLACES)
        slopes = chebyshev.chebval(x, chebyshev.chebder(np.array(self.curve_um)))
        low, high = float(slopes.min()), float(slopes.max())
        for end, row in zip(self.ends, self.series.plays, strict=True):
            z = np.linspace(-end, end, PLACES)
            moved = chebyshev.chebval(z, chebyshev.chebder(np.array([0.0, *row])))
            low, high = low + min(float(moved.min()), 0.0), high + max(float(moved.max()), 0.0)
        for (b, c), reach in zip(self.series.duhem, self.reaches, strict=True):
            d = np.linspace(-1.0, 1.0, PLACES)
            moved = (b + 2.0 * c * np.abs(d)) * (1.0 - d) / reach
            low, high = low + float(moved.min()), high + float(moved.max())
        return low, high

    @property
    def mean_slope(self) -> float:
        """Mean dh/dx over the input range where every play has been taken along, um per half range."""
        rise = chebyshev.chebval(1.0, self.series.curve) - chebyshev.chebval(-1.0, self.series.curve)
        for r, row in zip(self.half_widths, self.series.plays, strict=True):
            moved = np.array([0.0, *row])
            rise += chebyshev.chebval(1.0 - r, moved) - chebyshev.chebval(r - 1.0, moved)
        return 0.5 * float(rise)

    @property
    def curve_degree(self) -> int:
        """Degree of the curve in the C, at least that of the plays."""
        return max(len(self.curve_um) - 1, self.degree)

    @property
    def steps(self) -> int:
        """Newton steps of the inverse."""
        return _steps(self)

    @property
    def groups(self) -> list[list[int]]:
        """The plays from the last to the first, in groups of up to GROUP that the C computes side by side."""
        last_first = list(range(self.plays))[::-1]
        size = -(-self.plays // -(-self.plays // GROUP)) if self.plays else 1
        return [last_first[i : i + size] for i in range(0, self.plays, size)]

    @property
    def frozen(self) -> np.float32:
        """Distance from the threshold, in units of s, from which on a play does not relax."""
        return FROZEN

    @property
    def barrier(self) -> tuple[np.float32, np.float32]:
        """Coefficients of the exponent of a play's step (`hysteresis_mirror.BARRIER`)."""
        return BARRIER

    @property
    def slack(self) -> np.float32:
        """Distance in half ranges from which on the inverse takes a play along."""
        return SLACK

    def box(self, u_V: Interval, Ts_s: float) -> BlockBox:
        """Normalised inputs lie in [-1, 1], plays in [r - 1, 1 - r]; with e <= 1,

            left in [0, 2],   d = 1 - left e in [-1, 1],   back = 1 + d in [0, 2]

        and the output, as intervals of each operation make it, within the sum of the magnitudes

            |h - c_0| <= sum_m |c_m| + sum_j sum_m |c_jm| (1 - r_j)^m + sum_i (|b_i| + |c_i|)

        times 1.001 for rounding errors. Plays that relax lie in [-1, 1] after a sample and in [-2, 2] while x - r and x
        + r bound them, which intervals do not relate to x; their lower words are those of sums in two words. `solve`
        finds voltages within the input range.
        """
        number = self.numbers
        ways = [symmetric(float(np.float32(1.0) - row[0])) for row in number.play]
        moving = [
            symmetric(1.0 + float(row[0])) if self.relaxes else way for way, row in zip(ways, number.play, strict=True)
        ]
        sizes = [
            sum(abs(float(c)) * way.high ** (m + 1) for m, c in enumerate(row[1:]))
            for way, row in zip(moving, number.play, strict=True)
        ]
        size = float(np.abs(number.curve[0, 0, 1:]).sum()) + sum(sizes) + float(np.abs(number.duhem[:, :2]).sum())
        middle = float(number.curve[0, 0, 0])
        h = Interval(middle, middle).outwards(1.001 * size + 1e-6 * abs(middle))
        floats = {f"play[{j}]": way for j, way in enumerate(ways)}
        if self.relaxes:
            floats |= {f"play[{j}]": symmetric(float(row[2])) for j, row in enumerate(number.relax)}
            floats |= {f"play_low[{j}]": KEPT for j in range(self.plays)}
        if self.plays:
            floats |= {f"sum_um[{j}]": symmetric(1.001 * sum(sizes[j:])).outwards() for j in range(self.plays + 1)}
        if self.states:
            floats |= {f"{name}[{i}]": Interval(0.0, 2.0) for name in ("left", "back") for i in range(self.states)}
            floats["turn"] = symmetric(1.0)
        # Behind the relaxation h + (relaxed sum - sum), whose two sums intervals do not relate.
        behind = h.outwards(2.002 * sum(sizes)) if self.relaxes else h
        floats |= {"last": symmetric(1.0), "h_um": behind}
        half = float(number.half)
        return BlockBox(floats, h, Interval(float(number.middle) - half, float(number.middle) + half).outwards())

    def members(self) -> tuple[Member, ...]:
        plays = (
            Member("play", "float", "positions z_j of the plays", (self.plays,), unit="half ranges"),
            Member("sum_um", "float", "sum of the outputs of the plays from j on", (self.plays + 1,), unit="um"),
        )
        low = Member(
            "play_low", "float", "rounding errors of `play`, added to the next steps", (self.plays,), unit="half ranges"
        )
        duhem = (
            Member("left", "float", "Duhem states as 1 - d_i at the last turn of the input", (self.states,)),
            Member("back", "float", "Duhem states as 1 - d_i after a turn at the present input", (self.states,)),
            Member("turn", "float", "input at the last turn", unit="half ranges"),
        )
        last = (
            Member("last", "float", "last input of the block", unit="half ranges"),
            Member("h_um", "float", "last output of the block", unit="um"),
        )
        play, sums = plays
        moving = (play, low, sums) if self.relaxes else plays
        return (*(moving if self.plays else ()), *(duhem if self.states else ()), *last)

    def mirror(self, u_V: Floats32, Ts_s: float) -> HysteresisMirror:
        return (RelaxingMirror if self.relaxes else HysteresisMirror)(self.numbers, self.members(), self.steps, u_V)

    def constants(self, Ts_s: float) -> Mapping[str, Floats32]:
        number = self.numbers
        constants = {
            "range": np.array([number.middle, number.half, number.per_half, *number.slope]),
            "curve": number.curve.ravel(),
        }
        if self.plays:
            constants["play"] = number.play.ravel()
        if self.relaxes:
            constants["relax"] = number.relax.ravel()
        if self.states:
            constants["rate"] = np.array([number.rate])
            constants["duhem"] = number.duhem.ravel()
        return constants

    @classmethod
    def examples(cls, rng: np.random.Generator) -> tuple[Self, ...]:
        """Plays and Duhem states; a curve alone."""
        r = tuple(float(x) for x in np.sort(rng.uniform(0.02, 0.9, 6)))
        plays = rng.uniform(0.0, 0.3, (6, 3)) * np.array([1.0, 0.05, 0.02])
        duhem = tuple(float(x) for x in rng.uniform(0.0, 0.1, 4))
        curve = (5.0, 4.0, 0.1, 0.05)
        return (
            cls(-20.0, 120.0, curve, r, tuple(plays.ravel().tolist()), 0.8, duhem),
            cls(-20.0, 120.0, curve),
            cls(-20.0, 120.0, curve, r, tuple(plays.ravel().tolist()), 0.8, duhem, 0.03),
        )


def largest_play(half_width: float, relaxation: float) -> float:
    """Largest magnitude of a play in half ranges: 1 - r, and by RELAXED s more if it relaxes."""
    return min(1.0, 1.0 - half_width + RELAXED * relaxation * half_width)


@functools.lru_cache(maxsize=16)
def _numbers(block: Hysteresis) -> Numbers:
    return Numbers.of(
        block.series, Interval(block.low_V, block.high_V), Interval(*block.slope_range()), block.mean_slope
    )


@functools.lru_cache(maxsize=16)
def _steps(block: Hysteresis) -> int:
    range_V = Interval(block.low_V, block.high_V)
    return newton_steps(block, block.numbers, range_V, accepted_residual(block.image(range_V)))


def _range(coefficients: Floats, low: float, high: float) -> tuple[float, float]:
    """Smallest and largest value of a Chebyshev series over low .. high."""
    values = chebyshev.chebval(np.linspace(low, high, PLACES), coefficients)
    return float(values.min()), float(values.max())

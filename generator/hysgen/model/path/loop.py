"""Loop: hysteretic states in the loop of a mode, driven by the displacement that leaves the block.

    y(k+1) = a y(k) + (1 - a) w(k),   a = exp(-Ts/lag)                    the displacement without the states
    x <- lam x + sum_r e_r h_r,   zeta = y + Re x,   d = zeta - its last,   s = sign d        n = 1 or 2 times a sample
    w_r = s h_r,   dw_r/d|zeta| = 1 - p_r w_r for w_r > 0, 1 - q_r w_r for w_r < 0,   -box_r <= h_r <= box_r
    out(k) = w(k) + (Re x(k+1) - a Re x(k)) / (1 - a)                     behind the lag of the rules, y is zeta

A mode of the blocks before has the pole lam^n: a linear system superposes, so its responses to input and states stand
side by side. Half a sample early y is a cubic of its last four samples; each h moves by one step of Heun's method.
p = q = 0 is a spring, which the mode has already; p > 0 saturates under load, q > 0 returns sooner. Where p <= 0,
nothing but the box bounds h. Bounded by construction: |h| <= box and |lam| < 1.
Source: Ismail, Ikhouane and Rodellar, The hysteresis Bouc-Wen model, a survey (2009); two rates in place of powers.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np

from hysgen.machine.kernels.operators import lag_of_signals, lag_states, loop_states
from hysgen.machine.reproducible import expm1
from hysgen.model.float32_arithmetic import KEPT, accumulate, flushed
from hysgen.model.intervals import Interval, symmetric
from hysgen.model.path.base import BlockBox, BlockMirror, Floats, Floats32, InputBlock, limited, singles
from hysgen.model.path.modes import Modes
from hysgen.model.structs import INPUT_UNIT, Member, Quantity

MOST_STATES, MOST_PARTS = 3, 2
MIDDLE = (0.3125, 0.9375, -0.3125, 0.0625)
"""Weights of y(k+1), y(k), y(k-1), y(k-2) in y half a sample before k+1: the cubic through them."""

ROUNDS, CONTRACTING = 3, 0.1
"""Rounds in which the inverse finds the half sample, and the largest share of an error that a round may keep."""


@dataclass(frozen=True)
class Loop(InputBlock):
    """A mode of undamped frequency `f_Hz` and damping ratio `zeta`, with r = 1 .. 3 states.

    force, quadrature: e_r of a step; loading p_r, unloading q_r in 1/um; box_um, (r,) each. parts: n. lag_s: of the
    rules. gain: static gain in um per unit of the input with which the states were identified.
    Raises ValueError as `Modes` does, and for numbers that do not fit or are not finite, a negative q or an empty box.
    """

    kind: ClassVar[str] = "loop"
    quantities: ClassVar[Mapping[str, Quantity]] = {
        "mode": Quantity("1 - Re and Im of the pole per step"),
        "force": Quantity("what each state adds to the position in a step"),
        "quadrature": Quantity("what each state adds to the velocity in a step"),
        "loading": Quantity("fall of the slope of each state under load"),
        "unloading": Quantity("rise of the slope of each state on its way back"),
        "box": Quantity("bound of each state"),
        "lag": Quantity("a, 1 - a and 1 / (1 - a) of the lag of the rules"),
    }
    place: ClassVar[int] = 58
    limits: ClassVar[bool] = False
    responds: ClassVar[bool] = True
    two_words: ClassVar[bool] = True

    f_Hz: float
    zeta: float
    force: tuple[float, ...]
    quadrature: tuple[float, ...]
    loading: tuple[float, ...]
    unloading: tuple[float, ...]
    box_um: tuple[float, ...]
    parts: int
    lag_s: float
    gain: float
    rounds: ClassVar[int] = ROUNDS

    def __post_init__(self) -> None:
        self.mode  # noqa: B018  # checks frequency, damping ratio and lag
        lists = (self.force, self.quadrature, self.loading, self.unloading, self.box_um)
        if {len(values) for values in lists} not in [{r} for r in range(1, MOST_STATES + 1)]:
            raise ValueError(f"each state needs one of every number, and there are 1 to {MOST_STATES} states")
        if not np.isfinite([*lists, [self.gain] * len(self.force)]).all() or min(self.unloading) < 0.0:
            raise ValueError("every number must be finite, and unloading not negative")
        if min(self.box_um) <= 0.0 or self.parts not in range(1, MOST_PARTS + 1):
            raise ValueError("box_um must be positive and parts 1 or 2")

    @property
    def mode(self) -> Modes:
        return Modes((self.f_Hz,), (self.zeta,), (1.0,), self.lag_s)

    def describe(self) -> str:
        return f"{len(self.force)} hysteretic states in the loop of the mode at {self.f_Hz:.5g} Hz"

    def moved(self, y: Floats, Ts_s: float) -> Floats:
        """(n, 1 + r) Re x and every h at the samples of y, (n,) the displacement without the states; from rest."""
        step = complex(self.mode.steps(Ts_s / self.parts)[0])
        e, shape = np.stack([self.force, self.quadrature], 1), np.stack([self.loading, self.unloading, self.box_um], 1)
        return loop_states(y, self.parts, np.array([1.0 - step.real, step.imag]), e, shape)

    def apply(self, u_V: Floats, Ts_s: float, start: Floats | None = None) -> Floats:
        # The lag, one sample further than the input.
        rate = -expm1(-Ts_s / self.lag_s)
        y = lag_states(np.append(u_V, u_V[-1]), np.array([rate]), u_V[:1])[:, 0]
        x = self.moved(y, Ts_s)[:, 0]
        return np.asarray(u_V + (x[1:] - (1.0 - rate) * x[:-1]) / rate)

    def linear_part(self, u_V: Floats, Ts_s: float) -> Floats:
        return u_V

    def added_um(self, u_V: Floats, aux: Mapping[str, Floats], Ts_s: float) -> Floats:
        rate = -expm1(-Ts_s / self.lag_s)
        return self.moved(self.gain * lag_of_signals(u_V[None], rate, np.arange(u_V.size))[0], Ts_s)[:, 0]

    def image(self, u_V: Interval) -> Interval:
        """The range of the input, wider by half its width at each end: more is not believed of a mode."""
        return Interval(u_V.low - 0.5 * u_V.width, u_V.high + 0.5 * u_V.width)

    def solves(self, Ts_s: float) -> bool:
        """Whether a round of the inverse keeps less than CONTRACTING of an error, MIDDLE sum |e| max dh/dzeta."""
        steepest = [
            1.0 + max(abs(p), q) * box for p, q, box in zip(self.loading, self.unloading, self.box_um, strict=True)
        ]
        share = MIDDLE[0] * sum(abs(e) * slope for e, slope in zip(self.force, steepest, strict=True))
        return self.parts == 1 or share < CONTRACTING

    def box(self, u_V: Interval, Ts_s: float) -> BlockBox:
        """|h| <= box by its clamp; position and velocity, in two words, below LIMIT of `float32_arithmetic`.

        y is a mean of itself and the input, so it leaves the range of the input by roundings alone, and

            |out - w| <= 2 LIMIT / (1 - a)        times 1.01 for the roundings, in `apply` and in `solve`
        """
        words = ("position", "position_low", "velocity", "velocity_low")
        state = {f"h[{r}]": symmetric(most).outwards() for r, most in enumerate(self.box_um)}
        y = u_V.outwards(0.01 * u_V.magnitude + 1e-6)
        away = 2.02 * float(self.constants(Ts_s)["lag"][2]) * KEPT.high
        floats = {**dict.fromkeys(words, KEPT), **state, **{f"y[{i}]": y for i in range(3)}}
        return BlockBox(floats, u_V.outwards(away), u_V.outwards(2.0 * away))

    def members(self) -> tuple[Member, ...]:
        return (
            Member("position", "float", "what the states add to the displacement", unit=INPUT_UNIT),
            Member("position_low", "float", "rounding error of `position`, added to the next step", unit=INPUT_UNIT),
            Member("velocity", "float", "its velocity over the angular frequency", unit=INPUT_UNIT),
            Member("velocity_low", "float", "rounding error of `velocity`, added to the next step", unit=INPUT_UNIT),
            Member("y", "float", "last three displacements without the states", (3,), unit=INPUT_UNIT),
            Member("h", "float", "hysteretic states", (len(self.force),), unit=INPUT_UNIT),
        )

    def mirror(self, u_V: Floats32, Ts_s: float) -> LoopMirror:
        return LoopMirror(self, self.constants(Ts_s), u_V)

    def constants(self, Ts_s: float) -> Mapping[str, Floats32]:
        step, rate = complex(self.mode.steps(Ts_s / self.parts)[0]), -expm1(-Ts_s / self.lag_s)
        return {
            "mode": singles(np.array([step.real, step.imag])),
            "force": singles(np.array(self.force)),
            "quadrature": singles(np.array(self.quadrature)),
            "loading": singles(np.array(self.loading)),
            "unloading": singles(np.array(self.unloading)),
            "box": singles(np.array(self.box_um)),
            "lag": singles(np.array([1.0 - rate, rate, 1.0 / rate])),
        }

    @classmethod
    def examples(cls, rng: np.random.Generator) -> tuple[Self, ...]:
        made = []
        for r, parts in ((1, 2), (3, 1)):
            force, q = (-0.01 * rng.uniform(0.5, 1.0, r)).tolist(), rng.uniform(0.5, 2.0, r).tolist()
            p, box = rng.uniform(0.0, 0.5, r).tolist(), rng.uniform(1.0, 3.0, r).tolist()
            shapes = (tuple(force), tuple(-10.0 * e for e in force), tuple(p), tuple(q), tuple(box))
            f_Hz, lag_s = float(rng.uniform(100.0, 1000.0)), float(rng.uniform(1e-5, 1e-4))
            made.append(cls(f_Hz, 0.02, *shapes, parts, lag_s, 1.0))
        return tuple(made)


class LoopMirror(BlockMirror):
    """Float32 states over lanes, position and velocity each a sum of two words."""

    def __init__(self, block: Loop, constants: Mapping[str, Floats32], u_V: Floats32) -> None:
        self.members = block.members()
        self._parts, self._constants, self._rest = block.parts, constants, u_V
        names = ("force", "quadrature", "loading", "unloading", "box")
        self._shapes = list(zip(*(constants[name] for name in names), strict=True))
        self.position, self.position_low, self.velocity, self.velocity_low = (np.zeros_like(u_V) for _ in range(4))
        self.y = [u_V.copy() for _ in range(3)]
        self.h = [np.zeros_like(u_V) for _ in self._shapes]

    def rest(self) -> Floats32:
        return self._rest

    def apply(self, u_V: Floats32) -> Floats32:
        keep, _, per_rate = self._constants["lag"]
        before, y = self.position, self._next(u_V)
        zeta = self.y[0] + before
        for i in range(1, self._parts + 1):
            forward, turn = self._turned(self.position, self.velocity, self.h)
            self.position, self.position_low = accumulate(self.position, self.position_low, forward)
            self.velocity, self.velocity_low = accumulate(self.velocity, self.velocity_low, turn)
            last, zeta = zeta, (y if i == self._parts else self._middle(y)) + self.position
            self.h = self._followed(flushed(zeta - last))
        self.y = [y, self.y[0], self.y[1]]
        return np.asarray(u_V + (self.position - keep * before) * per_rate)

    def solve(self, wanted: Floats32) -> Floats32:
        """The input by ROUNDS of the half sample, or at once for one step a sample."""
        forward, turn = self._turned(self.position, self.velocity, self.h)
        position = self.position + forward
        if self._parts == 1:
            return self._input(wanted, position)
        zeta, h = self.y[0] + self.position, self.h
        real, imag = self._constants["mode"]
        velocity = self.velocity + turn
        moved = position - (real * position + imag * velocity)
        for _ in range(ROUNDS):
            u_V = self._aimed(wanted, moved, h)
            h = self._followed(flushed((self._middle(self._next(u_V)) + position) - zeta))
        return self._aimed(wanted, moved, h)

    def _aimed(self, wanted: Floats32, moved: Floats32, h: list[Floats32]) -> Floats32:
        """The input for which `wanted` leaves, if the states stand at h half a sample before."""
        for (force, *_), state in zip(self._shapes, h, strict=True):
            moved = moved + force * state
        return self._input(wanted, moved)

    def _input(self, wanted: Floats32, position: Floats32) -> Floats32:
        keep, _, per_rate = self._constants["lag"]
        return np.asarray(wanted - (position - keep * self.position) * per_rate)

    def _next(self, u_V: Floats32) -> Floats32:
        keep, rate, _ = self._constants["lag"]
        return flushed(keep * self.y[0] + rate * u_V)

    def _middle(self, y: Floats32) -> Floats32:
        first, second, third, fourth = (np.float32(weight) for weight in MIDDLE)
        return np.asarray((first * y + second * self.y[0]) + (third * self.y[1] + fourth * self.y[2]))

    def _turned(self, position: Floats32, velocity: Floats32, h: list[Floats32]) -> tuple[Floats32, Floats32]:
        """What a step adds to position and velocity."""
        real, imag = self._constants["mode"]
        forward, turn = -(real * position + imag * velocity), imag * position - real * velocity
        for (force, quadrature, *_), state in zip(self._shapes, h, strict=True):
            forward, turn = forward + force * state, turn + quadrature * state
        return np.asarray(forward), np.asarray(turn)

    def _followed(self, d: Floats32) -> list[Floats32]:
        """The states behind a displacement by d."""
        falls, half, unit = d < 0.0, np.float32(0.5), np.float32(1.0)
        size = np.where(falls, -d, d)
        moved = []
        for (_, _, loading, unloading, box), state in zip(self._shapes, self.h, strict=True):
            w = np.where(falls, -state, state)
            first = unit - np.where(w > 0.0, loading, unloading) * w
            far = w + size * first
            second = unit - np.where(far > 0.0, loading, unloading) * far
            to = flushed(limited(w + (half * size) * (first + second), -box, box))
            moved.append(np.where(falls, -to, to))
        return moved

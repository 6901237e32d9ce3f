"""Modes: lightly damped structural modes between the ceramic and the sensor.

    w = (1 - sum_j q_j) x + sum_j q_j osc_j(x),   osc'' + 2 zeta w0 osc' + w0^2 osc = w0^2 x,   w0 = 2 pi f
    c(k+1) = c(k) + s (x(k) - c(k)),   s = 1 - exp(lambda Ts),   lambda = (-zeta - i sqrt(1 - zeta^2)) w0

exact for an input held over a sample; c = position + i velocity, with osc = Re c - zeta/sqrt(1 - zeta^2) Im c. A
sensor that is read within the sample sees osc + early osc' in place of osc: zeta - w0 early in place of zeta there.
The rules hold their input over a sample too, but a mode goes on moving in it. The block therefore puts out the mean of
osc over the coming sample, weighted as the lag of the rules (lag_s = tau) weights it:

    osc(k) = Re(M c(k)) + (1 - Re M) x(k),
    M = (1 + i (zeta - w0 early)/sqrt(1 - zeta^2)) (exp(lambda Ts) - a) / ((1 - a)(1 + lambda tau))

with a = exp(-Ts/tau): behind the lag, the chain is exact.
Source: Rader and Gold (1967), coupled form; Franklin, Powell and Workman, Digital Control (1998), section 4.3.
"""

from __future__ import annotations

import dataclasses
import functools
import math
from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from hysgen.errors import ModelError
from hysgen.machine.kernels.operators import mode_states
from hysgen.machine.reproducible import exp, expm1, sine, spectral_radius
from hysgen.model.float32_arithmetic import KEPT
from hysgen.model.intervals import Interval, symmetric
from hysgen.model.part import Extent, Mode, RunSignals, ShapeParameter
from hysgen.model.path.base import BlockBox, Floats, Floats32, InputBlock, StateSpace, singles
from hysgen.model.path.modes_mirror import ModesMirror
from hysgen.model.structs import INPUT_UNIT, Member, Quantity

LEAST_DAMPING, MOST_DAMPING = 1e-4, 0.95

LEAST_FITTED, MOST_FITTED = 5e-4, 0.4
"""Damping ratios that a fit finds: below these a mode is a line, above them its response is that of a delay."""

MODE = (
    ShapeParameter("f_Hz", "Hz", lambda e: (3.0 / e.span_s, 0.48 / e.Ts_s), logarithm=True, order=3.0),
    ShapeParameter("zeta", "1", lambda e: (LEAST_FITTED, MOST_FITTED), logarithm=True),
    ShapeParameter("share", "1", lambda e: (-3.0, 3.0)),
)
"""Shape parameters of one mode."""

EARLY = ShapeParameter("early_s", "s", lambda e: (1e-3 * e.Ts_s, e.Ts_s), step=lambda e: 1e-3 * e.Ts_s)
"""Shape parameter of all modes: more than a sample is a negative delay."""

DECAYED, MOST_IMPULSE = 1e-4, 1_000_000
"""Rest of an impulse response at which the sum of its magnitudes ends, and the most samples of it."""

LEAST_CALM = 1e-3
"""Share of its velocity below which a mode that a limit left ringing is left to its own damping."""

LEAST_DIRECT = 1e-3
"""Share of x(k) in w(k), and of an x that alternates from sample to sample, below which the inverse would amplify
rounding errors of w a thousandfold: then a zero lies near -1, where sampling has put it, and rings for as long."""


@dataclass(frozen=True)
class Modes(InputBlock):
    """Modes of undamped frequency `f_Hz`, damping ratio `zeta` and `share` q, (m,) each; `lag_s`: lag of the rules.

    early_s: time by which the sensor sees them early, None for 0. Raises ValueError if a frequency or the lag is not
    positive, a damping ratio outside 1e-4 .. 0.95 or early_s no number.
    """

    kind: ClassVar[str] = "modes"
    cause: ClassVar[str] = "resonance"
    quantities: ClassVar[Mapping[str, Quantity]] = {
        "real": Quantity("1 - Re of each pole per sample"),
        "imag": Quantity("Im of each pole per sample"),
        "of_position": Quantity("weight of each position in the output"),
        "of_velocity": Quantity("weight of each velocity in the output"),
        "direct": Quantity("output per change of the input in the same sample"),
        "per_direct": Quantity("1 / direct"),
        "calm": Quantity("input per velocity that a limit has left in a mode"),
    }
    place: ClassVar[int] = 50
    limits: ClassVar[bool] = False
    responds: ClassVar[bool] = True
    two_words: ClassVar[bool] = True
    timed: ClassVar[bool] = True

    f_Hz: tuple[float, ...]
    zeta: tuple[float, ...]
    share: tuple[float, ...]
    lag_s: float
    early_s: float | None = field(default=None, kw_only=True)

    def __post_init__(self) -> None:
        f = np.asarray(self.f_Hz, dtype=np.float64)
        if f.size == 0 or not np.isfinite(f).all() or f[0] <= 0 or (np.diff(f) < 0).any():
            raise ValueError("f_Hz must be positive and rising")
        if not len(self.zeta) == len(self.share) == f.size or not np.isfinite(self.share).all():
            raise ValueError("zeta and share must have one finite number for each mode")
        if not all(LEAST_DAMPING <= zeta <= MOST_DAMPING for zeta in self.zeta):
            raise ValueError(f"zeta must give each mode a damping ratio of {LEAST_DAMPING} to {MOST_DAMPING}")
        if not self.lag_s > 0.0:
            raise ValueError("lag_s must be positive")
        if not math.isfinite(self.early_s or 0.0):
            raise ValueError("early_s must be finite")

    @classmethod
    def of(cls, modes: Sequence[Mode], lag_s: float) -> Self:
        """The block of these modes, all as early as the first, behind a lag."""
        rising = sorted(modes, key=lambda mode: mode.f_Hz)
        f_Hz, zeta, share = zip(*((mode.f_Hz, mode.zeta, mode.share) for mode in rising), strict=True)
        return cls(f_Hz, zeta, share, lag_s, early_s=rising[0].early_s or None)

    @property
    def modes(self) -> tuple[Mode, ...]:
        early_s = self.early_s or 0.0
        return tuple(Mode(*mode, early_s) for mode in zip(self.f_Hz, self.zeta, self.share, strict=True))

    @property
    def parameters(self) -> tuple[tuple[str, ShapeParameter], ...]:
        early = () if self.early_s is None else ((f"{self.cause}.{EARLY.field}", EARLY),)
        return (*((f"{self.cause}.{i}.{item.field}", item) for i in range(len(self.f_Hz)) for item in MODE), *early)

    @property
    def values(self) -> tuple[float, ...]:
        early = () if self.early_s is None else (self.early_s,)
        return (*(value for mode in self.modes for value in (mode.f_Hz, mode.zeta, mode.share)), *early)

    def with_values(self, values: Sequence[float]) -> Self:
        early = values[3 * len(self.f_Hz) :]
        return self.of([Mode(*values[i : i + 3], *early) for i in range(0, 3 * len(self.f_Hz), 3)], self.lag_s)

    def behind(self, lag_s: float) -> Self:
        return dataclasses.replace(self, lag_s=lag_s)

    @property
    def added(self) -> int:
        return 2 * len(self.f_Hz)

    @property
    def weight_orders(self) -> float:
        return 0.0  # a ringing that fades is known no better from a longer record

    def columns(self, run: RunSignals, extent: Extent, seen: Callable[[Floats], Floats]) -> list[Floats]:
        return self.free_responses(run.time_s(extent.Ts_s))

    def columns_depend_on(self, lag_s: float, delay: float) -> Hashable:
        return (self.f_Hz, self.zeta)

    @property
    def stiff(self) -> float:
        """Share of no mode, 1 - sum q."""
        return 1.0 - sum(self.share)

    def fading_samples(self, folds: float, Ts_s: float) -> int:
        """Samples in which the slowest mode falls by a factor exp(folds), rounded down."""
        slowest = min(f * zeta for f, zeta in zip(self.f_Hz, self.zeta, strict=True))
        return int(folds / (2.0 * np.pi * slowest * Ts_s))

    def impulse_samples(self, Ts_s: float) -> int:
        """Samples of an impulse response until the slowest mode has decayed to DECAYED, at most MOST_IMPULSE."""
        return min(2 + self.fading_samples(-np.log(DECAYED), Ts_s), MOST_IMPULSE)

    def steps(self, Ts_s: float) -> NDArray[np.complex128]:
        """(m,) s = 1 - exp(lambda Ts), free of cancellation for slow modes.

        Raises ModelError if a mode lies beyond half the sampling frequency.
        """
        w, zeta = 2 * np.pi * np.asarray(self.f_Hz) * Ts_s, np.asarray(self.zeta)
        if (w >= np.pi).any():
            raise ModelError(
                f"modes: {max(self.f_Hz):.6g} Hz lies beyond half the sampling frequency, {0.5 / Ts_s:.6g} Hz; "
                "sample faster or take the mode out"
            )
        decay, angle = zeta * w, np.sqrt(1.0 - zeta * zeta) * w
        fading, faded = (np.array([f(-x) for x in decay.tolist()]) for f in (exp, expm1))
        half, whole = (np.array([sine(x) for x in turn.tolist()]) for turn in (0.5 * angle, angle))
        # Part by part, for a product of complex numbers may be rounded once or twice.
        steps = np.empty(w.size, dtype=np.complex128)
        steps.real, steps.imag = fading * 2.0 * (half * half) - faded, fading * whole
        return steps

    def residues(self) -> NDArray[np.complex128]:
        """(m,) Q of each mode: q (1 + i (zeta - w0 early)/sqrt(1 - zeta^2)) / (1 + lambda tau)."""
        residues = np.empty(len(self.f_Hz), dtype=np.complex128)
        for j, (f, zeta, q) in enumerate(zip(self.f_Hz, self.zeta, self.share, strict=True)):
            root, w_tau = math.sqrt(1.0 - zeta * zeta), 2.0 * math.pi * f * self.lag_s
            re, im = 1.0 - zeta * w_tau, -root * w_tau
            scale, turn = q / (re * re + im * im), (zeta - 2.0 * math.pi * f * (self.early_s or 0.0)) / root
            residues[j] = complex(scale * (re + turn * im), scale * (turn * re - im))
        return residues

    def weights(self, Ts_s: float) -> tuple[Floats, Floats]:
        """(m,) weights of position and velocity in w(k): Re and -Im of Q (1 - s/(1 - a)), q Re M and -q Im M."""
        a_left, steps, residues = -expm1(-Ts_s / self.lag_s), self.steps(Ts_s), self.residues()
        # Part by part, for a product of complex numbers may be rounded once or twice.
        re, im = 1.0 - steps.real / a_left, -steps.imag / a_left
        return residues.real * re - residues.imag * im, -(residues.real * im + residues.imag * re)

    def direct(self, Ts_s: float) -> float:
        """Share of x(k) in w(k): what no position carries, because the static gain is 1."""
        return 1.0 - float(sum(self.weights(Ts_s)[0].tolist()))

    def describe(self) -> str:
        modes = (
            f"{f:.5g} Hz (damping {zeta:.3g}, share {q:.3g})"
            for f, zeta, q in zip(self.f_Hz, self.zeta, self.share, strict=True)
        )
        early = "" if self.early_s is None else f", seen {1e6 * self.early_s:.3g} us early"
        return "modes at " + ", ".join(modes) + early

    def start(self, x: float) -> Floats:
        """State at rest under x: position x, velocity 0, mode after mode."""
        return np.tile([x, 0.0], len(self.f_Hz))

    def apply(self, u_V: Floats, Ts_s: float, start: Floats | None = None) -> Floats:
        states = mode_states(u_V, self.steps(Ts_s), self.start(float(u_V[0])) if start is None else start)
        out = self.direct(Ts_s) * u_V
        for j, (of_position, of_velocity) in enumerate(zip(*self.weights(Ts_s), strict=True)):
            out += of_position * states[:, 2 * j] + of_velocity * states[:, 2 * j + 1]
        return out

    def free_responses(self, t_s: Floats) -> list[Floats]:
        """exp(-zeta w0 t) cos(wd t), exp(-zeta w0 t) sin(wd t),   wd = sqrt(1 - zeta^2) w0"""
        responses = []
        for f_Hz, zeta in zip(self.f_Hz, self.zeta, strict=True):
            fading, turn = np.exp(-zeta * 2.0 * np.pi * f_Hz * t_s), math.sqrt(1.0 - zeta**2) * 2.0 * np.pi * f_Hz * t_s
            responses += [fading * np.cos(turn), fading * np.sin(turn)]
        return responses

    def image(self, u_V: Interval) -> Interval:
        """The bound of a linear block: half the width of the range times the integral of |impulse response|.

            |1 - sum q| + sum_j |q_j| (coth(pi zeta_j / (2 sqrt(1 - zeta_j^2))) + 2 w0_j early / (1 - r_j))

        r: what half a turn leaves. The impulse response of osc' rises to at most w0 in each half turn, and falls again.
        w(k) is a mean of osc with positive weights, so that no command inside the range drives w out of it.
        """
        factor = abs(self.stiff)
        for f, zeta, q in zip(self.f_Hz, self.zeta, self.share, strict=True):
            half_turn = exp(-math.pi * zeta / math.sqrt(1.0 - zeta * zeta))
            early = 4.0 * math.pi * f * abs(self.early_s or 0.0)
            factor += abs(q) * (1.0 + half_turn + early) / (1.0 - half_turn)
        return u_V.scaled(factor)

    def zero(self, Ts_s: float) -> float:
        """Largest |eigenvalue| of the inverse, A - B C / direct with the state (position, velocity) of every mode.

        Infinite if w(k) does not depend on x(k).
        """
        return _zero(self, Ts_s)

    def state_space(self, Ts_s: float) -> StateSpace:
        m = 2 * len(self.f_Hz)
        A, B, C = np.eye(m), np.zeros(m), np.zeros(m)
        for j, (step, *weights) in enumerate(zip(self.steps(Ts_s), *self.weights(Ts_s), strict=True)):
            at = slice(2 * j, 2 * j + 2)
            A[at, at] += [[-step.real, step.imag], [-step.imag, -step.real]]
            B[at], C[at] = (step.real, step.imag), weights
        return A, B, C, self.direct(Ts_s)

    def solves(self, Ts_s: float) -> bool:
        A, B, C, direct = self.state_space(Ts_s)
        alternating = direct - float(C @ np.linalg.solve(np.eye(B.size) + A, B))
        return min(abs(direct), abs(alternating)) >= LEAST_DIRECT and self.zero(Ts_s) < 1.0

    def box(self, u_V: Interval, Ts_s: float) -> BlockBox:
        """Each of the four words of a mode stays below LIMIT of `float32_arithmetic`, in the unit of x, and with them

            |w - direct x| <= sum_j |q_j| (|Re M_j| + |Im M_j|) LIMIT        times 1.01 for the roundings

        and `solve` divides by direct. That |c| decays is a relation between its parts, which intervals do not describe.
        """
        numbers = self.constants(Ts_s)
        words = ("position", "position_low", "velocity", "velocity_low")
        floats = {f"{word}[{j}]": KEPT for word in words for j in range(len(self.f_Hz))}
        state = 1.01 * float(np.abs([*numbers["of_position"], *numbers["of_velocity"]]).sum()) * KEPT.high
        through = symmetric(1.01 * abs(float(numbers["direct"][0])) * u_V.magnitude + state).outwards()
        if not self.solves(Ts_s):
            return BlockBox(floats, through, through)
        solved = 1.01 * abs(float(numbers["per_direct"][0])) * (through.magnitude + state)
        return BlockBox(floats, through, symmetric(solved).outwards())

    def members(self) -> tuple[Member, ...]:
        modes = (len(self.f_Hz),)
        return (
            Member("position", "float", "position of each mode", modes, unit=INPUT_UNIT),
            Member(
                "position_low", "float", "rounding error of `position`, added to the next step", modes, unit=INPUT_UNIT
            ),
            Member("velocity", "float", "velocity of each mode over the angular frequency", modes, unit=INPUT_UNIT),
            Member(
                "velocity_low", "float", "rounding error of `velocity`, added to the next step", modes, unit=INPUT_UNIT
            ),
        )

    def to_json(self) -> dict[str, Any]:
        """Without early_s where the sensor is not early, as before it was known."""
        plain = super().to_json()
        return {name: value for name, value in plain.items() if name != EARLY.field or value is not None}

    def mirror(self, u_V: Floats32, Ts_s: float) -> ModesMirror:
        return ModesMirror(self.members(), self.constants(Ts_s), u_V)

    def constants(self, Ts_s: float) -> Mapping[str, Floats32]:
        """Parts of s, shares q Re M and -q Im M, direct and, if the inverse is stable, 1/direct and -calm.

        Raises ModelError if a pole, rounded to float32, would not decay.
        """
        steps = self.steps(Ts_s)
        real, imag = steps.real.astype(np.float32), steps.imag.astype(np.float32)
        rest, turn = 1.0 - real.astype(np.float64), imag.astype(np.float64)
        if not (rest * rest + turn * turn < 1.0).all():
            raise ModelError("modes: a mode this slow and light does not decay in float32; raise its damping")
        of_position, of_velocity = self.weights(Ts_s)
        direct = self.direct(Ts_s)
        inverse = {}
        if self.solves(Ts_s):
            inverse = {"per_direct": singles(np.array([1.0 / direct])), "calm": singles(np.array([-_calm(self, Ts_s)]))}
        return {
            "real": real,
            "imag": imag,
            "of_position": singles(of_position),
            "of_velocity": singles(of_velocity),
            "direct": singles(np.array([direct])),
            **inverse,
        }

    @classmethod
    def examples(cls, rng: np.random.Generator) -> tuple[Self, ...]:
        return (
            cls(
                (float(rng.uniform(100.0, 2000.0)),),
                (float(rng.uniform(0.01, 0.1)),),
                (float(rng.uniform(0.1, 0.6)),),
                float(rng.uniform(1e-4, 1e-3)),
            ),
        )


@functools.lru_cache(maxsize=64)
def _calm(block: Modes, Ts_s: float) -> float:
    """The largest of 1, 1/2, 1/4, .. of the velocities that, taken off the input, makes the modes decay sooner."""
    A, B, _, _ = block.state_space(Ts_s)
    share, against = 1.0, np.outer(B, np.tile([0.0, 1.0], len(block.f_Hz)))
    while share > LEAST_CALM and spectral_radius(A - share * against) > spectral_radius(A):
        share *= 0.5
    return share if share > LEAST_CALM else 0.0


def straying(blocks: Sequence[InputBlock], Ts_s: float) -> Modes | None:
    """The first modes that the inverse solves: what a limit leaves in them is kept (`chain`)."""
    return next((block for block in blocks if isinstance(block, Modes) and block.solves(Ts_s)), None)


def astray_members(block: Modes | None) -> tuple[Member, ...]:
    """What the struct of the inputs keeps of limits, with the modes of `block`."""
    if block is None:
        return ()
    modes = (len(block.f_Hz),)
    return (
        Member("asked_um", "float", "displacement that the inverse was asked for last", unit="um"),
        Member("astray_um", "float", "what limits of the inverse add to the displacement", unit="um"),
        Member("astray_position", "float", "what they add to the position of each mode", modes, unit=INPUT_UNIT),
        Member("astray_velocity", "float", "and to its velocity", modes, unit=INPUT_UNIT),
    )


@functools.lru_cache(maxsize=64)
def _zero(block: Modes, Ts_s: float) -> float:
    A, B, C, direct = block.state_space(Ts_s)
    return float("inf") if direct == 0.0 else spectral_radius(A - B[:, None] * (C / direct))

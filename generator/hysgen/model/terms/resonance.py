"""Resonance: lightly damped structural modes driven by the input.

    x'' + 2 zeta w x' + w^2 x = w^2 u,   w = 2 pi f               each mode; static gain 1
    c(k+1) = c(k) + q (u(k) - c(k)),     q = 1 - exp((-zeta - i sqrt(1 - zeta^2)) w Ts)   exact for a held input
    phi = Re c,  Im c                                             [V]

Re c = x + (zeta/w) x' is close to the position, Im c = sqrt(1 - zeta^2) x'/w to the velocity; their linear combinations
are all responses with these two poles. In this coupled form the state has the magnitude of the motion, and rounding q
moves the pole by 6e-8 of its distance from 1; rounding the coefficients of a difference equation in x would destroy f
and zeta at f = fs/1000. Each state is a sum of two words (module `twofloat`), so that slow modes do not stall.
Source: Rader and Gold (1967), coupled form; Franklin, Powell and Workman, Digital Control (1998), section 4.3.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from hysgen.errors import ModelError
from hysgen.machine.kernels import mode_states
from hysgen.machine.reproducible import exp, expm1, sine
from hysgen.model.intervals import Interval
from hysgen.model.structs import Member
from hysgen.model.terms.base import Drive, Floats, Floats32, Mirror, StateSpace, Term, TermBox
from hysgen.model.twofloat import KEPT, accumulate

LEAST_DAMPING, MOST_DAMPING = 1e-4, 0.95


@dataclass(frozen=True)
class Resonance(Term):
    """Modes of undamped frequency `f_Hz` and damping ratio `zeta`, (m,) each, frequencies rising.

    Raises ValueError if a frequency is not positive or a damping ratio outside 1e-4 .. 0.95.
    """

    kind: ClassVar[str] = "resonance"
    two_words: ClassVar[bool] = True
    f_Hz: tuple[float, ...]
    zeta: tuple[float, ...]

    def __post_init__(self) -> None:
        f, zeta = np.asarray(self.f_Hz, dtype=np.float64), np.asarray(self.zeta, dtype=np.float64)
        if f.size == 0 or not np.isfinite(f).all() or f[0] <= 0 or (np.diff(f) <= 0).any():
            raise ValueError("f_Hz must be positive and rising")
        if zeta.shape != f.shape or not ((zeta >= LEAST_DAMPING) & (zeta <= MOST_DAMPING)).all():
            raise ValueError(f"zeta must give each mode a damping ratio of {LEAST_DAMPING} to {MOST_DAMPING}")

    @property
    def size(self) -> int:
        return 2 * len(self.f_Hz)

    def steps(self, Ts_s: float) -> NDArray[np.complex128]:
        """(m,) q = 1 - p, free of cancellation for slow modes.

        Raises ModelError if a mode lies beyond half the sampling frequency.
        """
        w, zeta = 2 * np.pi * np.asarray(self.f_Hz) * Ts_s, np.asarray(self.zeta)
        if (w >= np.pi).any():
            raise ModelError(
                f"resonance: {max(self.f_Hz):.6g} Hz lies beyond half the sampling frequency, {0.5 / Ts_s:.6g} Hz; "
                "sample faster or take the mode out"
            )
        decay, angle = zeta * w, np.sqrt(1.0 - zeta * zeta) * w
        fading, faded = (np.array([f(-x) for x in decay.tolist()]) for f in (exp, expm1))
        half, whole = (np.array([sine(x) for x in turn.tolist()]) for turn in (0.5 * angle, angle))
        # Part by part, for a product of complex numbers may be rounded once or twice.
        steps = np.empty(w.size, dtype=np.complex128)
        steps.real, steps.imag = fading * 2.0 * (half * half) - faded, fading * whole
        return steps

    def describe(self) -> str:
        modes = (f"{f:.5g} Hz (damping {zeta:.3g})" for f, zeta in zip(self.f_Hz, self.zeta, strict=True))
        return "resonance at " + ", ".join(modes)

    def regressors(self, drive: Drive) -> Floats:
        """(n, 2 m) position and velocity of each mode in V."""
        start = drive.start.get(self.kind, self.start(float(drive.u_V[0])))
        return mode_states(drive.u_V, self.steps(drive.Ts_s), start)

    def start(self, u_V: float) -> Floats:
        return np.tile([u_V, 0.0], len(self.f_Hz))

    def burn_in(self, drive: Drive) -> int:
        rate = min(2 * np.pi * f * zeta * drive.Ts_s for f, zeta in zip(self.f_Hz, self.zeta, strict=True))
        return int(min(drive.u_V.size, np.ceil(np.log(100.0) / rate)))

    def linear(self, Ts_s: float) -> StateSpace:
        q = self.steps(Ts_s)
        A, B = np.eye(self.size), np.zeros(self.size)
        for j, step in enumerate(q):
            at = 2 * j
            A[at : at + 2, at : at + 2] += [[-step.real, step.imag], [-step.imag, -step.real]]
            B[at : at + 2] = step.real, step.imag
        return StateSpace(A, B, np.eye(self.size))

    def gains(self, Ts_s: float) -> tuple[float, ...]:
        """|q| / (1 - |p|): the sum of the moduli of the impulse response."""
        q = self.steps(Ts_s)
        return tuple(float(g) for g in np.repeat(_modulus(q) / (1.0 - _modulus(1.0 - q)), 2))

    def box(self, v_V: Interval, Ts_s: float) -> TermBox:
        """Each of the four words of a mode stays below LIMIT of `twofloat` [V], and so do phi = Re c, Im c [V].

        That |c| decays is a relation between Re c and Im c, which intervals do not see.
        """
        words = ("position", "position_low", "velocity", "velocity_low")
        floats = {f"{word}[{j}]": KEPT for word in words for j in range(len(self.f_Hz))}
        return TermBox(floats, (KEPT.high,) * self.size)

    def shape(self) -> Floats:
        """(2 m,) ln f_1, ln zeta_1, ln f_2, ..., f in Hz."""
        return np.asarray(np.log(np.stack([self.f_Hz, self.zeta], axis=1).ravel()))

    def with_shape(self, shape: Floats) -> Self:
        modes = sorted(tuple(float(x) for x in pair) for pair in np.exp(shape).reshape(-1, 2))
        return type(self)(tuple(mode[0] for mode in modes), tuple(mode[1] for mode in modes))

    def shape_bounds(self, drive: Drive) -> tuple[Floats, Floats]:
        """From one oscillation in the record to 0.45 of the sampling frequency."""
        low = np.log([1.0 / (drive.Ts_s * drive.u_V.size), 1e-3])
        high = np.log([0.45 / drive.Ts_s, 0.9])
        return np.tile(low, len(self.f_Hz)), np.tile(high, len(self.f_Hz))

    def members(self) -> tuple[Member, ...]:
        modes = (len(self.f_Hz),)
        return (
            Member("position", "float", "[V]", modes),
            Member("position_low", "float", "rounding error of `position`, carried along [V]", modes),
            Member("velocity", "float", "[V], in units of the mode's angular frequency", modes),
            Member("velocity_low", "float", "rounding error of `velocity`, carried along [V]", modes),
        )

    def mirror(self, u_V: Floats32, Ts_s: float) -> ModeMirror:
        constants = self.constants(Ts_s)
        return ModeMirror(self, constants["real"], constants["imag"], u_V)

    def constants(self, Ts_s: float) -> Mapping[str, Floats32]:
        """Raises ModelError if the pole, rounded to float32, would not decay."""
        q = self.steps(Ts_s)
        real, imag = q.real.astype(np.float32), q.imag.astype(np.float32)
        rounded = real.astype(np.complex128)
        rounded.imag = imag
        radius = _modulus(1.0 - rounded)
        if not (radius < 1.0).all():
            raise ModelError("resonance: a mode this slow and light does not decay in float32; raise its damping")
        return {"real": real, "imag": imag}

    @classmethod
    def examples(cls, rng: np.random.Generator) -> tuple[Self, ...]:
        return (cls((float(rng.uniform(100.0, 2000.0)),), (float(rng.uniform(0.01, 0.1)),)),)


def _modulus(z: NDArray[np.complex128]) -> Floats:
    """|z| without hypot, whose last bit is the C library's."""
    return np.asarray(np.sqrt(z.real * z.real + z.imag * z.imag))


class ModeMirror(Mirror):
    """Float32 modes over lanes, position and velocity each a sum of two words."""

    def __init__(self, term: Resonance, real: Floats32, imag: Floats32, u_V: Floats32) -> None:
        self.members = term.members()
        self._steps = list(zip(real, imag, strict=True))
        self.position: list[Floats32] = [u_V.copy() for _ in self._steps]
        self.velocity: list[Floats32] = [np.zeros_like(u_V) for _ in self._steps]
        self.position_low: list[Floats32] = [np.zeros_like(u_V) for _ in self._steps]
        self.velocity_low: list[Floats32] = [np.zeros_like(u_V) for _ in self._steps]

    def regressors(self) -> list[Floats32]:
        return [high for mode in zip(self.position, self.velocity, strict=True) for high in mode]

    def advance(self, u_V: Floats32) -> None:
        for j, (real, imag) in enumerate(self._steps):
            position, velocity = self.position[j], self.velocity[j]
            away = u_V - position
            forward, turn = real * away + imag * velocity, imag * away - real * velocity
            self.position[j], self.position_low[j] = accumulate(position, self.position_low[j], forward)
            self.velocity[j], self.velocity_low[j] = accumulate(velocity, self.velocity_low[j], turn)


TERM = Resonance

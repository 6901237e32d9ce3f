"""Modes: lightly damped structural modes between the ceramic and the sensor.

    w = (1 - sum_j q_j) x + sum_j q_j osc_j(x),   osc'' + 2 zeta w0 osc' + w0^2 osc = w0^2 x,   w0 = 2 pi f
    c(k+1) = c(k) + s (x(k) - c(k)),   s = 1 - exp(lambda Ts),   lambda = (-zeta - i sqrt(1 - zeta^2)) w0

exact for an input held over a sample; c = position + i velocity, with osc = Re c - zeta/sqrt(1 - zeta^2) Im c. The
rules hold their input over a sample too, but a mode goes on moving in it. The block therefore puts out the mean of osc
over the coming sample, weighted as the lag of the rules (lag_s = tau) weights it:

    osc(k) = Re(M c(k)) + (1 - Re M) x(k),
    M = (1 + i zeta/sqrt(1 - zeta^2)) (exp(lambda Ts) - a) / ((1 - a)(1 + lambda tau))

with a = exp(-Ts/tau): behind the lag, the chain is exact.
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
from hysgen.model.path.base import BlockMirror, Floats, Floats32, InputBlock

LEAST_DAMPING, MOST_DAMPING = 1e-4, 0.95


@dataclass(frozen=True)
class Modes(InputBlock):
    """Modes of undamped frequency `f_Hz`, damping ratio `zeta` and `share` q, (m,) each; `lag_s`: lag of the rules.

    Raises ValueError if a frequency or the lag is not positive or a damping ratio outside 1e-4 .. 0.95.
    """

    kind: ClassVar[str] = "modes"
    place: ClassVar[int] = 5
    limits: ClassVar[bool] = False
    responds: ClassVar[bool] = True

    f_Hz: tuple[float, ...]
    zeta: tuple[float, ...]
    share: tuple[float, ...]
    lag_s: float

    def __post_init__(self) -> None:
        f = np.asarray(self.f_Hz, dtype=np.float64)
        if f.size == 0 or not np.isfinite(f).all() or f[0] <= 0 or (np.diff(f) <= 0).any():
            raise ValueError("f_Hz must be positive and rising")
        if not len(self.zeta) == len(self.share) == f.size or not np.isfinite(self.share).all():
            raise ValueError("zeta and share must have one finite number for each mode")
        if not all(LEAST_DAMPING <= zeta <= MOST_DAMPING for zeta in self.zeta):
            raise ValueError(f"zeta must give each mode a damping ratio of {LEAST_DAMPING} to {MOST_DAMPING}")
        if not self.lag_s > 0.0:
            raise ValueError("lag_s must be positive")

    @property
    def stiff(self) -> float:
        """Share of no mode, 1 - sum q."""
        return 1.0 - sum(self.share)

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

    def outputs(self, Ts_s: float) -> tuple[Floats, Floats]:
        """(m,) position and velocity: Re M and -Im M, the share of the state in osc(k)."""
        a_left = -expm1(-Ts_s / self.lag_s)
        position, velocity = np.empty(len(self.f_Hz)), np.empty(len(self.f_Hz))
        for j, (f, zeta, step) in enumerate(zip(self.f_Hz, self.zeta, self.steps(Ts_s), strict=True)):
            root, w_tau = float(np.sqrt(1.0 - zeta * zeta)), 2.0 * np.pi * f * self.lag_s
            # exp(lambda Ts) - a = (1 - a) - s, so M = (1 + i zeta/root) (1 - s/(1 - a)) / (1 + lambda tau)
            top_re, top_im = 1.0 - step.real / a_left, -step.imag / a_left
            top_re, top_im = top_re - zeta / root * top_im, top_im + zeta / root * top_re
            low_re, low_im = 1.0 - zeta * w_tau, -root * w_tau
            square = low_re * low_re + low_im * low_im
            position[j] = (top_re * low_re + top_im * low_im) / square
            velocity[j] = -(top_im * low_re - top_re * low_im) / square
        return position, velocity

    def direct(self, Ts_s: float) -> float:
        """Share of x(k) in w(k): the stiff share and what the modes answer within the sample."""
        position, _ = self.outputs(Ts_s)
        return self.stiff + float(sum(q * (1.0 - p) for q, p in zip(self.share, position.tolist(), strict=True)))

    def describe(self) -> str:
        modes = (
            f"{f:.5g} Hz (damping {zeta:.3g}, share {q:.3g})"
            for f, zeta, q in zip(self.f_Hz, self.zeta, self.share, strict=True)
        )
        return "modes at " + ", ".join(modes)

    def start(self, x: float) -> Floats:
        """State at rest under x: position x, velocity 0, mode after mode."""
        return np.tile([x, 0.0], len(self.f_Hz))

    def apply(self, u_V: Floats, Ts_s: float, start: Floats | None = None) -> Floats:
        states = mode_states(u_V, self.steps(Ts_s), self.start(float(u_V[0])) if start is None else start)
        out = self.direct(Ts_s) * u_V
        for j, (position, velocity) in enumerate(zip(*self.outputs(Ts_s), strict=True)):
            out += self.share[j] * (position * states[:, 2 * j] + velocity * states[:, 2 * j + 1])
        return out

    def image(self, u_V: Interval) -> Interval:
        """The range of the input, wider by half its width at each end: more is not believed of a mode."""
        return Interval(u_V.low - 0.5 * u_V.width, u_V.high + 0.5 * u_V.width)

    def mirror(self, u_V: Floats32, Ts_s: float) -> BlockMirror:
        raise NotImplementedError

    def constants(self, Ts_s: float) -> Mapping[str, Floats32]:
        return {}

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


BLOCK = Modes

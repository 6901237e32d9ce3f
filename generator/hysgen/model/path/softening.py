"""Softening: modes whose frequency falls with a short-term amplitude of their own motion, under several drives.

    zeta(k) = Re sum_m z_m c_m(k),   env <- min(env + (1 - exp(-Ts/env_s)) (|zeta| - env), MOST),   s = env / (1 + env)
    lam_m(k) = lam_m (1 + s f_m Ts),   d_m = sum_j Q_mj v_j(k),   y(k) = level + Re sum_m c_m(k)
    c_m(k+1) = c_m(k) + (1 - lam_m(k)) (d_m - c_m(k)) + s sum_j R_mj (v_j(k) - v_j(k-1))
    w(k) = level + (y(k+1) - a y(k) - (1 - a) level) / (1 - a),   a = exp(-Ts/lag): behind the lag of the rules, w is y

v_0: input about `level_um`, sum_m Re Q_m0 = 1; v_j: channel j about the middle of its range, clamped to it. One
amplitude moves all modes, so states of all drives superpose. At rest c_m = d_m for every s: the amplitude changes no
static gain. Bounded by construction: s lies in 0 .. s(MOST), so lam_m(k) between two points inside the unit circle.
That two courses approach each other is shown for a held amplitude alone.
Source: Rugh and Shamma, Research on gain scheduling (2000): linear systems whose parameters move with a bounded signal.
"""

from __future__ import annotations

import functools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from hysgen.errors import ModelError
from hysgen.machine.kernels.operators import softening_states
from hysgen.machine.reproducible import expm1
from hysgen.model.float32_arithmetic import KEPT
from hysgen.model.intervals import Interval
from hysgen.model.path.base import BlockBox, Floats, Floats32, InputBlock, StateSpace, singles
from hysgen.model.path.channels import Channels
from hysgen.model.path.modes import Modes
from hysgen.model.path.softening_mirror import SHARES, SofteningMirror
from hysgen.model.structs import INPUT_UNIT, Member, Quantity

Complex = NDArray[np.complex128]

MOST = 12.0
"""Largest amplitude, in units in which s = env / (1 + env): 12/13 of the whole fall."""
LARGEST_POLE = 1.0 - 1e-6
ENDS = (0.0, MOST / (1.0 + MOST))
"""Least and largest s; a pole at another one lies between those at these."""


@dataclass(frozen=True)
class Softening(Channels, InputBlock):
    """m modes of undamped frequency `f_Hz` and damping ratio `zeta` at small amplitudes, under 1 + j drives.

    fall, fall_quadrature: f in 1/s, (m,). seen, seen_quadrature: z, (m,) in 1/um. share, quadrature: Q, and swing,
    swing_quadrature: R, (m (1 + j),) by mode, the input first. Identified with `gain` um per unit of the command about
    `middle_V`, at the sampling period Ts_s. Raises ValueError as `Modes` and `Channels` do, and for numbers that do not
    fit or are not finite.
    """

    kind: ClassVar[str] = "softening"
    quantities: ClassVar[Mapping[str, Quantity]] = {
        **Channels.quantities,
        "real": Quantity("1 - Re of each pole per sample"),
        "imag": Quantity("Im of each pole per sample"),
        "fall": Quantity("what the amplitude adds to each pole: Re, then Im"),
        "seen": Quantity("weight of each mode in the amplitude: of positions, then of velocities"),
        "share": Quantity("static share of each mode by drive, the input first"),
        "quadrature": Quantity("the same, a quarter of a turn later"),
        "swing": Quantity("what a step of each drive adds to the position of each mode, at the whole amplitude"),
        "swing_quadrature": Quantity("what it adds to the velocity"),
        "of_amplitude": Quantity("rate and bound of the amplitude"),
        "lag": Quantity("a and 1 / (1 - a) of the lag of the rules"),
        "level": Quantity("displacement about which the modes move", "um"),
    }
    place: ClassVar[int] = 57
    limits: ClassVar[bool] = False
    responds: ClassVar[bool] = True
    two_words: ClassVar[bool] = True

    f_Hz: tuple[float, ...]
    zeta: tuple[float, ...]
    fall: tuple[float, ...]
    fall_quadrature: tuple[float, ...]
    seen: tuple[float, ...]
    seen_quadrature: tuple[float, ...]
    share: tuple[float, ...]
    quadrature: tuple[float, ...]
    swing: tuple[float, ...]
    swing_quadrature: tuple[float, ...]
    env_s: float
    level_um: float
    gain: float
    middle_V: float
    lag_s: float
    Ts_s: float

    def __post_init__(self) -> None:
        super().__post_init__()
        modes, drives = len(self.f_Hz), 1 + len(self.channels)
        of_modes = (self.zeta, self.fall, self.fall_quadrature, self.seen, self.seen_quadrature)
        of_drives = (self.share, self.quadrature, self.swing, self.swing_quadrature)
        if not self.channels:
            raise ValueError("softening is a block of several drives: name a channel")
        if {len(x) for x in of_modes} != {modes} or {len(x) for x in of_drives} != {modes * drives}:
            raise ValueError("each mode needs one of every number, and one of those of a drive for each drive")
        numbers = [*sum(of_modes + of_drives, ()), self.level_um, self.gain, self.middle_V]
        if not np.isfinite(numbers).all() or not min(self.env_s, self.Ts_s) > 0.0:
            raise ValueError("every number must be finite, env_s and Ts_s positive")
        self._modes  # noqa: B018  # checks frequencies, damping ratios and lag

    @functools.cached_property
    def _modes(self) -> Modes:
        return Modes(self.f_Hz, self.zeta, (0.0,) * len(self.f_Hz), self.lag_s)

    def poles(self, Ts_s: float, s: float = 0.0) -> Complex:
        """(m,) lam_m(k) at the amplitude s; Im < 0."""
        fall = np.array(self.fall) + 1j * np.array(self.fall_quadrature)
        return np.asarray((1.0 - self._modes.steps(Ts_s)) * (1.0 + s * Ts_s * fall))

    @functools.cached_property
    def of_drives(self) -> tuple[Complex, Complex]:
        """Q and R, (m, 1 + j) each."""
        Q, R, S, T = (np.reshape(getattr(self, name), (len(self.f_Hz), -1)) for name in SHARES)
        return Q + 1j * R, S + 1j * T

    def numbers(self, Ts_s: float) -> Floats:
        """(m, 6 + 4 (1 + j)) the numbers of every mode as `softening_states` takes them."""
        (Q, R), poles = self.of_drives, self.poles(Ts_s)
        z = np.array(self.seen) + 1j * np.array(self.seen_quadrature)
        first = [part for x in (poles, self.poles(Ts_s, 1.0) - poles, z) for part in (x.real, x.imag)]
        return np.column_stack([*first, Q.real, Q.imag, R.real, R.imag])

    def natural(self, s: float) -> tuple[Floats, Floats]:
        """(m,) undamped frequency in Hz and damping ratio of each mode at the held amplitude s."""
        rates = np.log(self.poles(self.Ts_s, s)) / self.Ts_s
        return np.abs(rates) / (2.0 * np.pi), -rates.real / np.abs(rates)

    def held(self, s: float, Ts_s: float) -> StateSpace:
        """The own drive, about the level, to w at the held amplitude s; state: positions, velocities and the last v."""
        (Q, R), poles, a_left = self.of_drives, self.poles(Ts_s, s), -expm1(-Ts_s / self.lag_s)
        of_v, of_last = (1.0 - poles) * Q[:, 0] + s * R[:, 0], -s * R[:, 0]
        m = poles.size
        A, B = np.zeros((2 * m + 1, 2 * m + 1)), np.concatenate([of_v.real, of_v.imag, [1.0]])
        A[:-1, :-1] = np.block(
            [[np.diag(poles.real), -np.diag(poles.imag)], [np.diag(poles.imag), np.diag(poles.real)]]
        )
        A[:-1, -1] = np.concatenate([of_last.real, of_last.imag])
        seen = np.concatenate([np.ones(m), np.zeros(m + 1)])
        return A, B, seen @ (A - (1.0 - a_left) * np.eye(2 * m + 1)) / a_left, float(of_v.real.sum()) / a_left

    def rate(self, Ts_s: float) -> float:
        """Share of its way that the amplitude goes in a sample."""
        return -expm1(-Ts_s / self.env_s)

    def describe(self) -> str:
        drives = f", driven by {', '.join(self.channels)} too" if self.channels else ""
        return f"{len(self.f_Hz)} modes whose frequency follows their amplitude{drives}"

    def moved(self, x: Floats, values: Sequence[Floats], Ts_s: float) -> tuple[Floats, Floats]:
        """(n,) displacement at the samples of the input and of the channels about their middles, and s; from rest."""
        v = np.column_stack([x - self.level_um, *values])
        moved = softening_states(v, self.numbers(Ts_s), self.rate(Ts_s), MOST)[1]
        return self.level_um + moved[:, 0], moved[:, 2]

    def apply(self, u_V: Floats, Ts_s: float, start: Floats | None = None) -> Floats:
        return self.driven(u_V, None, Ts_s)

    def driven(self, u_V: Floats, aux: Mapping[str, Floats] | None, Ts_s: float, start: Floats | None = None) -> Floats:
        values = [np.zeros(u_V.size) for _ in self.channels] if aux is None else self.heard(aux)
        # One sample further than the input.
        x, *values = (np.append(signal, signal[-1]) for signal in (u_V, *values))
        y, _ = self.moved(x, values, Ts_s)
        rate = -expm1(-Ts_s / self.lag_s)
        return np.asarray(y[:-1] + np.diff(y) / rate)

    def linear_part(self, u_V: Floats, Ts_s: float) -> Floats:
        """(n,) output for an input about 0 at no amplitude, of the input alone."""
        y = self._at_rest(u_V, Ts_s)
        return np.asarray(y[:-1] + np.diff(y) / -expm1(-Ts_s / self.lag_s))

    def _at_rest(self, u_V: Floats, Ts_s: float) -> Floats:
        """(n + 1,) displacement for an input about 0 at no amplitude, one sample further than the input."""
        numbers = self.numbers(Ts_s)
        numbers[:, 2:6] = 0.0
        v = np.zeros((u_V.size + 1, 1 + len(self.channels)))
        v[:, 0] = np.append(u_V, u_V[-1])
        return softening_states(v, numbers, 1.0, MOST)[1][:, 0]

    def added_um(self, u_V: Floats, aux: Mapping[str, Floats], Ts_s: float) -> Floats:
        own = self.gain * (u_V - self.middle_V)
        y, _ = self.moved(self.level_um + own, self.heard(aux), Ts_s)
        return np.asarray(y - self.level_um - self._at_rest(own, Ts_s)[:-1])

    def image(self, u_V: Interval) -> Interval:
        """About the level: half the width of every drive times the sum of |impulse response| at a held amplitude."""
        wide = [max(u_V.high - self.level_um, self.level_um - u_V.low), *(np.subtract(self.high, self.low) / 2.0)]
        most = 1.01 * float(_magnitudes(self) @ wide)
        return Interval(self.level_um - most, self.level_um + most)

    def solves(self, Ts_s: float) -> bool:
        """Never: solved from the state itself, one limited sample keeps the inverse at its limits for ever."""
        return False

    def box(self, u_V: Interval, Ts_s: float) -> BlockBox:
        """Position and velocity, in two words, below LIMIT of `float32_arithmetic`; env in 0 .. MOST by its clamp.

        |w - level| <= (1 + a) sum_m LIMIT / (1 - a)        times 1.01 for the roundings
        """
        words = ("position", "position_low", "velocity", "velocity_low")
        numbers, modes, drives = self.constants(Ts_s), len(self.f_Hz), 1 + len(self.channels)
        own = Interval(u_V.low - self.level_um, u_V.high - self.level_um).outwards(1e-6 * u_V.magnitude + 1e-6)
        floats = {f"{word}[{m}]": KEPT for word in words for m in range(modes)}
        floats |= {"env": Interval(0.0, MOST), "last[0]": own, **self.heard_box()}
        floats |= {f"last[{j}]": floats[f"sample[{j - 1}][0]"] for j in range(1, drives)}
        away = 1.01 * 2.0 * float(numbers["lag"][1]) * modes * KEPT.high
        through = Interval(self.level_um - away, self.level_um + away).outwards()
        return BlockBox(floats, through, through)

    def members(self) -> tuple[Member, ...]:
        modes, lost = (len(self.f_Hz),), "added to the next step"
        return (
            *super().members(),
            Member("position", "float", "position of each mode", modes, unit=INPUT_UNIT),
            Member("position_low", "float", f"rounding error of `position`, {lost}", modes, unit=INPUT_UNIT),
            Member("velocity", "float", "velocity of each mode over the angular frequency", modes, unit=INPUT_UNIT),
            Member("velocity_low", "float", f"rounding error of `velocity`, {lost}", modes, unit=INPUT_UNIT),
            Member("last", "float", "last input and channels, about their middles", (1 + len(self.channels),)),
            Member("env", "float", "short-term amplitude"),
        )

    def mirror(self, u_V: Floats32, Ts_s: float) -> SofteningMirror:
        return SofteningMirror(self, self.constants(Ts_s), u_V)

    def constants(self, Ts_s: float) -> Mapping[str, Floats32]:
        """Raises ModelError if a pole would not decay at every amplitude."""
        rate, numbers = -expm1(-Ts_s / self.lag_s), self.numbers(Ts_s)
        if max(np.abs(self.poles(Ts_s, s)).max() for s in ENDS) > LARGEST_POLE:
            raise ModelError("softening: a mode does not decay at every amplitude; fit the model again")
        return {
            **super().constants(Ts_s),
            "real": singles(1.0 - numbers[:, 0]),
            "imag": singles(-numbers[:, 1]),
            "fall": singles(numbers[:, 2:4].T.ravel()),
            "seen": singles(np.array([*self.seen, *self.seen_quadrature])),
            **{name: singles(np.array(getattr(self, name))) for name in SHARES},
            "of_amplitude": np.array([self.rate(Ts_s), MOST], dtype=np.float32),
            "lag": singles(np.array([1.0 - rate, 1.0 / rate])),
            "level": singles(np.array([self.level_um])),
        }

    @classmethod
    def examples(cls, rng: np.random.Generator) -> tuple[Self, ...]:
        """Two modes under the input and two channels."""
        f_Hz, share = float(rng.uniform(500.0, 1000.0)), rng.uniform(0.01, 0.05, (2, 3))
        share[:, 0] = 0.5
        turned = rng.uniform(-0.3, 0.3, share.shape) * share
        return (
            cls(
                channels=("other", "third"),
                low=(0.0, -5.0),
                high=(40.0, 5.0),
                f_Hz=(f_Hz, 2.5 * f_Hz),
                zeta=tuple(rng.uniform(0.01, 0.1, 2).tolist()),
                fall=tuple(rng.uniform(-10.0, 0.0, 2).tolist()),
                fall_quadrature=tuple(rng.uniform(50.0, 200.0, 2).tolist()),
                seen=tuple(rng.uniform(0.1, 0.3, 2).tolist()),
                seen_quadrature=tuple(rng.uniform(-0.1, 0.1, 2).tolist()),
                share=tuple(share.ravel().tolist()),
                quadrature=tuple(turned.ravel().tolist()),
                swing=tuple((0.1 * turned).ravel().tolist()),
                swing_quadrature=tuple((0.1 * turned[::-1]).ravel().tolist()),
                env_s=float(rng.uniform(1e-3, 5e-3)),
                level_um=float(rng.uniform(-2.0, 2.0)),
                gain=1.0,
                middle_V=0.0,
                lag_s=float(rng.uniform(6e-6, 3e-5)),
                Ts_s=2e-5,
            ),
        )


@functools.lru_cache(maxsize=64)
def _magnitudes(block: Softening) -> Floats:
    """(1 + j,) sum of |y(k)| for a unit impulse of each drive, at the least or the largest amplitude: the larger."""
    Q, R = block.of_drives
    sums = []
    for s in ENDS:
        poles = block.poles(block.Ts_s, s)[:, None]
        first = (1.0 - poles) * Q + s * R
        powers = poles ** np.arange(min(int(9.0 / -np.log(np.abs(poles).max())) + 2, 20_000))
        later = np.einsum("mk,mj->kj", powers, poles * first - s * R)
        sums.append(np.abs(first.real.sum(axis=0)) + np.abs(later.real).sum(axis=0))
    return np.asarray(np.max(sums, axis=0))

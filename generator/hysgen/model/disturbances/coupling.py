"""Coupling: other measured channels (a neighbouring drive, a temperature) act on the displacement.

    phi_ci(k) = clamp(a_c(k - i), low_c, high_c) - m_c,   i = 0 .. taps - 1,   m_c the middle of low_c .. high_c

a_c(k) is measured before y(k+1) is predicted and does not depend on u(k). Several taps are an FIR filter. A channel
outside its range is clamped; a sample that is not finite is replaced by the one before. Before the first sample every
channel is at the middle of its range.

Drives: the drives of other axes move the stage through its modes.

    c_m(k+1) = c_m(k) + s_m (sum_j Q_mj v_j(k) - c_m(k)),   o(k) = sum_m Re c_m(k)
    phi_1 = o(k),   phi_2 = o(k+1) - o(k);   with the weights 1 - a and 1, o adds to y behind the lag a of the rules

v_j: channel j about the middle of its range, clamped to it; s_m as in `path.modes`, Q_mj a static share in um
per unit. v_j(k) is measured before y(k+1) is predicted and does not depend on the own input, whose modes are the block
`structure`. Before the first sample every channel is at the middle of its range.
"""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np

from hysgen.machine.kernels.operators import mode_states
from hysgen.model.disturbances.base import Drive, Floats, Floats32, Mirror, Term, TermBox
from hysgen.model.float32_arithmetic import KEPT, accumulate
from hysgen.model.part import Extent, RunSignals, octaves
from hysgen.model.path.base import limited
from hysgen.model.path.channels import ChannelListener, Channels
from hysgen.model.path.modes import Modes
from hysgen.model.structs import Member, Quantity

MOST_TAPS = 64


@dataclass(frozen=True)
class Coupling(Channels, Term):
    """Auxiliary `channels`, each with its range `low` .. `high` in its own unit and `taps` samples.

    Raises ValueError as `Channels` does, and if there is no channel or taps is not 1 to 64.
    """

    kind: ClassVar[str] = "coupling"
    cause: ClassVar[str] = "coupling"
    place: ClassVar[int] = 90
    taps: int = 1

    def __post_init__(self) -> None:
        super().__post_init__()
        if not self.channels:
            raise ValueError("channels must name each auxiliary channel once")
        if not 1 <= self.taps <= MOST_TAPS:
            raise ValueError(f"taps must be 1 to {MOST_TAPS}")

    @property
    def size(self) -> int:
        return len(self.channels) * self.taps

    @classmethod
    def of(cls, ranges: Mapping[str, tuple[float, float]], taps: int = 1) -> Self:
        """For channels with their ranges (low, high) by name."""
        low, high = zip(*ranges.values(), strict=True)
        return cls(tuple(ranges), low, high, taps)

    @property
    def ranges(self) -> dict[str, tuple[float, float]]:
        """Range (low, high) of each channel by its name; inverse of `of`."""
        return dict(zip(self.channels, zip(self.low, self.high, strict=True), strict=True))

    @property
    def weight_orders(self) -> float:
        return len(self.channels) * octaves(self.taps)

    def apart(self, runs: Sequence[RunSignals], Ts_s: float) -> bool:
        return True

    def columns(self, run: RunSignals, extent: Extent, seen: Callable[[Floats], Floats]) -> list[Floats]:
        lagged = [seen(run.aux[name]) for name in self.channels]
        at = np.arange(len(run.u_V))
        return [np.interp(at - tap / run.stride, at, channel) for channel in lagged for tap in range(self.taps)]

    def columns_depend_on(self, lag_s: float, delay: float) -> Hashable:
        return (self, lag_s, delay)

    def describe(self) -> str:
        taps = f", {self.taps} samples of each" if self.taps > 1 else ""
        return "coupling to " + ", ".join(self.channels) + taps

    def regressors(self, drive: Drive) -> Floats:
        """(n, channels * taps), channel by channel, the newest sample first.

        The state is ((taps - 1) * channels,) samples before the first, as regressors, oldest first, channel by channel.

        Raises ModelError if the drive lacks a channel.
        """
        start = drive.start.get(self.kind, np.zeros(len(self.channels) * (self.taps - 1)))
        start = start.reshape(len(self.channels), self.taps - 1)
        columns = []
        for c, value in enumerate(self.heard(drive.aux)):
            past = np.concatenate([start[c], value])
            columns += [past[self.taps - 1 - i : past.size - i] for i in range(self.taps)]
        return np.stack(columns, axis=1)

    def burn_in(self, drive: Drive) -> int:
        return min(self.taps - 1, drive.u_V.size)

    def box(self, Ts_s: float) -> TermBox:
        """Samples as `heard_box` bounds them; phi is the samples themselves, channel by channel."""
        floats = self.heard_box()
        return TermBox(floats, tuple(bound.magnitude for bound in floats.values()))

    def mirror(self, lanes: int, Ts_s: float) -> ChannelMirror:
        return ChannelMirror(self, self.constants(Ts_s), lanes)

    @classmethod
    def examples(cls, rng: np.random.Generator) -> tuple[Self, ...]:
        """Two channels with several taps, one channel with one tap."""
        several = cls(("other", "third"), (0.0, -5.0), (40.0, 5.0), int(rng.integers(2, 5)))
        return several, cls(("other",), (0.0,), (40.0,))


class ChannelMirror(ChannelListener, Mirror):
    """Float32 channels over lanes."""

    def __init__(self, term: Coupling, constants: Mapping[str, Floats32], lanes: int) -> None:
        self.members = term.members()
        self.listen_to(term, constants, lanes)

    def regressors(self) -> list[Floats32]:
        return [value for past in self.sample for value in past]

    def advance(self) -> None:
        for past in self.sample:
            past[1:] = past[:-1]


WORDS = ("position", "position_low", "velocity", "velocity_low")


@dataclass(frozen=True, kw_only=True)
class Drives(Coupling):
    """Modes of undamped frequency `f_Hz`, damping ratio `zeta`, (m,), and Q = `share` + i `quadrature`, (m j,) by mode.

    Raises ValueError as `Coupling` and `Modes` do, and if a share does not fit or a channel has several taps.
    """

    kind: ClassVar[str] = "drives"
    two_words: ClassVar[bool] = True
    quantities: ClassVar[Mapping[str, Quantity]] = {
        **Coupling.quantities,
        "real": Quantity("1 - Re of each pole per sample"),
        "imag": Quantity("Im of each pole per sample"),
        "share": Quantity("static share of each mode by channel, in um per unit of the channel"),
        "quadrature": Quantity("the same, a quarter of a turn later"),
        "most": Quantity("bounds of the motion of all modes, and of its difference", "um"),
    }
    f_Hz: tuple[float, ...]
    zeta: tuple[float, ...]
    share: tuple[float, ...]
    quadrature: tuple[float, ...]

    def __post_init__(self) -> None:
        super().__post_init__()
        numbers = len(self.f_Hz) * len(self.channels)
        if self.taps != 1 or not len(self.share) == len(self.quadrature) == numbers:
            raise ValueError("share and quadrature must have one number for each mode and channel, taps must be 1")
        if not np.isfinite([*self.share, *self.quadrature]).all():
            raise ValueError("share and quadrature must be finite")
        self._modes  # noqa: B018  # checks frequencies and damping ratios

    @functools.cached_property
    def _modes(self) -> Modes:
        return Modes(self.f_Hz, self.zeta, (0.0,) * len(self.f_Hz), 1.0)

    @property
    def size(self) -> int:
        return 2

    def describe(self) -> str:
        return f"{len(self.f_Hz)} modes driven by " + ", ".join(self.channels)

    def _shares(self) -> tuple[Floats, Floats]:
        shape = (len(self.f_Hz), len(self.channels))
        return np.reshape(self.share, shape), np.reshape(self.quadrature, shape)

    def _values(self, drive: Drive) -> Floats:
        """(j, n) of the channels about their middles. Raises ModelError if the drive lacks a channel."""
        return super().regressors(dataclasses.replace(drive, start={})).T

    def states(self, drive: Drive) -> Floats:
        """(n, m, 2) position and velocity of each mode, from those in `drive.start`, (2 m,), or at rest.

        Raises ModelError if the drive lacks a channel.
        """
        return self._states(self._values(drive), drive)

    def _states(self, values: Floats, drive: Drive) -> Floats:
        """`states` under the values of the channels."""
        start = drive.start.get(self.kind, np.zeros(2 * len(self.f_Hz)))
        out = np.empty((drive.u_V.size, len(self.f_Hz), 2))
        for m, (step, re, im) in enumerate(zip(self._modes.steps(drive.Ts_s), *self._shares(), strict=True)):
            # The response to a complex input is that to its real part, and i times that to its imaginary part.
            steps = np.array([step])
            of_re = mode_states(np.ascontiguousarray(re @ values), steps, start[2 * m : 2 * m + 2])
            of_im = mode_states(np.ascontiguousarray(im @ values), steps, np.zeros(2))
            out[:, m, 0], out[:, m, 1] = of_re[:, 0] - of_im[:, 1], of_re[:, 1] + of_im[:, 0]
        return out

    def regressors(self, drive: Drive) -> Floats:
        """(n, 2) o(k) and o(k+1) - o(k). Raises ModelError if the drive lacks a channel."""
        values = self._values(drive)
        states, steps, (re, im) = self._states(values, drive), self._modes.steps(drive.Ts_s), self._shares()
        last = values[:, -1]
        away = re @ last - states[-1, :, 0] + 1j * (im @ last - states[-1, :, 1])
        moved = states[:, :, 0].sum(axis=1)
        return np.stack([moved, np.diff(moved, append=moved[-1] + float((steps * away).real.sum()))], axis=1)

    def burn_in(self, drive: Drive) -> int:
        return min(1 + self._modes.fading_samples(np.log(100.0), drive.Ts_s), drive.u_V.size)

    def box(self, Ts_s: float) -> TermBox:
        """Samples as those of a coupling; each of the four words of a mode stays below LIMIT of `float32_arithmetic`.

        phi is limited to the sum over the channels of half their width times the sum of |impulse response| of o and of
        its difference, which these do not leave.
        """
        floats = dict(super().box(Ts_s).floats)
        floats |= {f"{word}[{m}]": KEPT for word in WORDS for m in range(len(self.f_Hz))}
        moved, moves = self.constants(Ts_s)["most"].tolist()
        return TermBox(floats, (moved, moves))

    def members(self) -> tuple[Member, ...]:
        modes = (len(self.f_Hz),)
        return (
            *super().members(),
            Member("position", "float", "position of each mode", modes, unit="um"),
            Member("position_low", "float", "rounding error of `position`, added to the next step", modes, unit="um"),
            Member("velocity", "float", "velocity of each mode over the angular frequency", modes, unit="um"),
            Member("velocity_low", "float", "rounding error of `velocity`, added to the next step", modes, unit="um"),
        )

    def mirror(self, lanes: int, Ts_s: float) -> DrivesMirror:
        return DrivesMirror(self, self.constants(Ts_s), lanes)

    def constants(self, Ts_s: float) -> Mapping[str, Floats32]:
        steps = self._modes.steps(Ts_s)
        return {
            **super().constants(Ts_s),
            "real": steps.real.astype(np.float32),
            "imag": steps.imag.astype(np.float32),
            "share": np.asarray(self.share, dtype=np.float32),
            "quadrature": np.asarray(self.quadrature, dtype=np.float32),
            "most": np.array(_most(self, Ts_s), dtype=np.float32),
        }

    @classmethod
    def examples(cls, rng: np.random.Generator) -> tuple[Self, ...]:
        """Two channels through two modes."""
        f_Hz = float(rng.uniform(100.0, 1000.0))
        return (
            cls(
                ("other", "third"),
                (0.0, -5.0),
                (40.0, 5.0),
                f_Hz=(f_Hz, 2.5 * f_Hz),
                zeta=tuple(rng.uniform(0.01, 0.1, 2).tolist()),
                share=tuple(rng.uniform(-1e-3, 1e-3, 4).tolist()),
                quadrature=tuple(rng.uniform(-1e-3, 1e-3, 4).tolist()),
            ),
        )


@functools.lru_cache(maxsize=64)
def _most(term: Drives, Ts_s: float) -> tuple[float, float]:
    """1.01 sum over channels of half the width times the sum of |phi| for a unit impulse, until it has decayed."""
    samples = term._modes.impulse_samples(Ts_s)
    most = np.zeros(2)
    for c, name in enumerate(term.channels):
        aux = {other: np.full(samples, middle) for other, middle in zip(term.channels, term.middle, strict=True)}
        aux[name][0] = term.high[c]
        share = 0.5 * (term.high[c] - term.low[c]) / (term.high[c] - term.middle[c])
        most += share * np.abs(term.regressors(Drive(np.zeros(samples), Ts_s, aux))).sum(axis=0)
    return 1.01 * float(most[0]), 1.01 * float(most[1])


class DrivesMirror(ChannelMirror):
    """Float32 modes over lanes, position and velocity each a sum of two words."""

    def __init__(self, term: Drives, constants: Mapping[str, Floats32], lanes: int) -> None:
        super().__init__(term, constants, lanes)
        modes, drives = len(term.f_Hz), len(term.channels)
        self._steps = list(zip(constants["real"], constants["imag"], strict=True))
        shares = [constants[name].reshape(modes, drives) for name in ("share", "quadrature")]
        self._shares = list(zip(*shares, strict=True))
        self._most = constants["most"]
        self.position, self.position_low, self.velocity, self.velocity_low = (
            [np.zeros(lanes, np.float32) for _ in range(modes)] for _ in WORDS
        )

    def regressors(self) -> list[Floats32]:
        moved, moves = self.position[0], self._steps_of(0)[0]
        for m in range(1, len(self._steps)):
            moved = moved + self.position[m]
            moves = moves + self._steps_of(m)[0]
        return [limited(value, -most, most) for value, most in zip((moved, moves), self._most, strict=True)]

    def advance(self) -> None:
        for m in range(len(self._steps)):
            forward, turn = self._steps_of(m)
            self.position[m], self.position_low[m] = accumulate(self.position[m], self.position_low[m], forward)
            self.velocity[m], self.velocity_low[m] = accumulate(self.velocity[m], self.velocity_low[m], turn)

    def _steps_of(self, m: int) -> tuple[Floats32, Floats32]:
        """s (sum_j Q_j v_j - c) of a mode: of its position and of its velocity."""
        (real, imag), (share, quadrature) = self._steps[m], self._shares[m]
        forward, turn = share[0] * self.sample[0][0], quadrature[0] * self.sample[0][0]
        for j in range(1, len(share)):
            forward = forward + share[j] * self.sample[j][0]
            turn = turn + quadrature[j] * self.sample[j][0]
        away, across = forward - self.position[m], turn - self.velocity[m]
        return real * away - imag * across, imag * away + real * across

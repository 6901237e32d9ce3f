"""What the probe assumes between command and sensor.

    u -> clamp -> rate limit -> h(u) -> (1 + creep) -> modes -> 1/(lag s + 1) -> delay -> (1 + aging t)  + disturbances

h is linear in its coefficients (`operator`), everything after it is linear in h: given the few shape parameters of this
chain, all other unknowns follow from linear least squares. A part that is None or empty is absent.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Mode:
    """share / (1 + 2 zeta s/w + s^2/w^2), w = 2 pi f_Hz; what no mode carries follows stiffly."""

    f_Hz: float
    zeta: float
    share: float


@dataclass(frozen=True)
class Chain:
    """Shape parameters of one hypothesis about the stage.

    lag_s: time constant of the one pole that every stage has. delay: in samples, whole or fractional, beyond the one
    sample that sampling costs, negative where the channels of the record are not aligned; delayed: whether it is free.
    low_V, high_V: clamp. rate_V_per_s: rate limit. memory: whether h is a hysteresis operator or a single-valued curve.
    creep: share of a step moved per decade of time, from creep_from_s on. aging_per_s: relative change of the gain.
    drift: whether there is a ramp; since_s: if not None, it slows down as the creep of a move does that long before the
    run, log(1 + t / since). lines_Hz: disturbing lines. coupled: auxiliary channels, each
    with `taps` samples of its past.
    """

    lag_s: float
    delay: float = 0.0
    low_V: float | None = None
    high_V: float | None = None
    rate_V_per_s: float | None = None
    creep: float | None = None
    creep_from_s: float = 0.0
    modes: tuple[Mode, ...] = ()
    aging_per_s: float | None = None
    drift: bool = False
    since_s: float | None = None
    lines_Hz: tuple[float, ...] = ()
    coupled: tuple[str, ...] = ()
    taps: int = 1
    delayed: bool = False
    memory: bool = True

    @property
    def amplifier(self) -> tuple[float | None, ...]:
        """What stands before the hysteresis: the clamp's two levels and the rate limit."""
        return (self.low_V, self.high_V, self.rate_V_per_s)

    def coordinates(self) -> Floats:
        """The free shape parameters as one vector; those that must stay positive as logarithms."""
        values = [math.log(self.lag_s)]
        if self.delayed:
            values.append(self.delay)
        values.extend(level for level in (self.low_V, self.high_V) if level is not None)
        if self.rate_V_per_s is not None:
            values.append(math.log(self.rate_V_per_s))
        if self.creep is not None:
            values.extend((self.creep, math.log(self.creep_from_s)))
        for mode in self.modes:
            values.extend((math.log(mode.f_Hz), math.log(mode.zeta), mode.share))
        if self.aging_per_s is not None:
            values.append(self.aging_per_s)
        if self.since_s is not None:
            values.append(math.log(self.since_s))
        values.extend(self.lines_Hz)
        return np.array(values)

    def at(self, coordinates: Sequence[float] | Floats) -> Chain:
        """The same structure with other numbers; inverse of `coordinates`."""
        left = iter([float(value) for value in coordinates])
        lag_s = math.exp(next(left))
        return dataclasses.replace(
            self,
            lag_s=lag_s,
            delay=next(left) if self.delayed else self.delay,
            low_V=None if self.low_V is None else next(left),
            high_V=None if self.high_V is None else next(left),
            rate_V_per_s=None if self.rate_V_per_s is None else math.exp(next(left)),
            creep=None if self.creep is None else next(left),
            creep_from_s=0.0 if self.creep is None else math.exp(next(left)),
            modes=tuple(Mode(math.exp(next(left)), math.exp(next(left)), next(left)) for _ in self.modes),
            aging_per_s=None if self.aging_per_s is None else next(left),
            since_s=None if self.since_s is None else math.exp(next(left)),
            lines_Hz=tuple(next(left) for _ in self.lines_Hz),
        )

    def names(self) -> tuple[str, ...]:
        """Names of the coordinates, in their order."""
        names = ["lag"]
        names.extend(["delay"] if self.delayed else [])
        names.extend(
            name
            for name, part in (
                ("low", self.low_V),
                ("high", self.high_V),
                ("rate", self.rate_V_per_s),
                ("creep", self.creep),
                ("creep_from", self.creep),
            )
            if part is not None
        )
        for i, _ in enumerate(self.modes):
            names.extend((f"f{i}", f"zeta{i}", f"share{i}"))
        names.extend(["aging"] if self.aging_per_s is not None else [])
        names.extend(["since"] if self.since_s is not None else [])
        names.extend(f"line{i}" for i, _ in enumerate(self.lines_Hz))
        return tuple(names)

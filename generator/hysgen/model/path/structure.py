"""Structure: the modes that the own drive excites, as an identification finds them, with the sensor's phase of each.

    c_m(k+1) = c_m(k) + s_m (x(k) - c_m(k)),   y(k) = sum_m Re(Q_m c_m(k)),   Q_m = q_m + i r_m
    w(k) = (y(k+1) - a y(k)) / (1 - a) = direct x(k) + sum_m Re(Q_m (1 - s_m/(1 - a)) c_m(k))

c_m, s_m as in `modes`; a = exp(-Ts/lag): behind the lag of the rules y is exact, for a is a zero of w, too. What is
left of sum q = 1 passes the lag alone. A mode of `modes` has the phase of a force on one mass; Q_m is complex, so N
such modes are every linear system of simple poles. The modes of other drives are the term `drives`.
"""

import functools
from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from hysgen.model.intervals import Interval
from hysgen.model.path.modes import Modes


@dataclass(frozen=True)
class Structure(Modes):
    """Modes of undamped frequency `f_Hz`, damping ratio `zeta`, Q = `share` + i `quadrature`, (m,) each.

    Ts_s: sampling period of the identification. Raises ValueError as `Modes`, and if quadrature or Ts_s do not fit.
    """

    kind: ClassVar[str] = "structure"
    place: ClassVar[int] = 55
    quadrature: tuple[float, ...]
    Ts_s: float

    def __post_init__(self) -> None:
        super().__post_init__()
        if len(self.quadrature) != len(self.share) or not np.isfinite(self.quadrature).all():
            raise ValueError("quadrature must have one finite number for each mode")
        if self.early_s is not None:
            raise ValueError("early_s stands in the quadrature of each mode")
        if not self.Ts_s > 0.0:
            raise ValueError("Ts_s must be positive")

    def residues(self) -> NDArray[np.complex128]:
        return np.array([complex(q, r) for q, r in zip(self.share, self.quadrature, strict=True)])

    def image(self, u_V: Interval) -> Interval:
        """The bound of a linear block: half the width of the range times the sum of |impulse response|, about rest."""
        return u_V.scaled(_magnitude(self))

    def describe(self) -> str:
        modes = (f"{f:.5g} Hz (damping {zeta:.3g})" for f, zeta in zip(self.f_Hz, self.zeta, strict=True))
        return "structure with modes at " + ", ".join(modes)

    @classmethod
    def examples(cls, rng: np.random.Generator) -> tuple[Self, ...]:
        """Two modes."""
        f_Hz = float(rng.uniform(100.0, 1000.0))
        damping, share = rng.uniform(0.01, 0.1, 2).tolist(), rng.uniform(0.1, 0.4, 2).tolist()
        turn = rng.uniform(-0.1, 0.1, 2).tolist()
        lag_s = float(rng.uniform(1e-4, 1e-3))
        return (cls((f_Hz, 2.5 * f_Hz), tuple(damping), tuple(share), lag_s, tuple(turn), 2e-5),)


@functools.lru_cache(maxsize=64)
def _magnitude(block: Structure) -> float:
    """Sum of |w(k)| for a unit impulse, 1.01 times, until the slowest mode has decayed (`impulse_samples`)."""
    impulse = np.zeros(block.impulse_samples(block.Ts_s))
    impulse[0] = 1.0
    return 1.01 * float(np.abs(block.apply(impulse, block.Ts_s, block.start(0.0))).sum())

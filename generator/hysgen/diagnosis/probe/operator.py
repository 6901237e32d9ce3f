"""The hysteresis of the probe: a Preisach operator plus Duhem operators, linear in its coefficients.

    h(u) = g(u) + integral over r of q(r, z_r(u)) dr + sum_j (b_j d_j + c_j d_j |d_j|)
    z_r: play of half-width r;      d_j' = (sign(u') - d_j) |u'| / reach_j

The first two terms are every Preisach operator with a density (Brokate and Sprekels, 1996, chapter 2.4). g and q are
Chebyshev polynomials of the normalised input and play, q is piecewise linear in r (hat functions). The states d_j
decay with the path length of the input, not in time; they approximate Duhem operators such as Dahl's and Bouc-Wen's,
which are not Preisach operators.

    h = sum_m a_m T_m(v) + sum_b sum_m c_bm * sum_i hat_b(r_i) T_m(z_i) + ...,     v, z_i in [-1, 1]

Only the probe uses this operator; a delivered model has terms of `hysgen.model.terms` that cost fewer cycles.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from hysgen.machine.kernels import PreisachBasis, duhem_columns, preisach_columns

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Operator:
    """Size of the expansion over the input range [low_V, high_V].

    plays: number of half-widths r_i of the quadrature; hats: hat functions of r, 0 for a single-valued curve g(u).
    curve, degree: degree of the Chebyshev polynomials of the input and of the plays. reaches: decay lengths of the
    Duhem states along the path, in half ranges of the input.
    """

    low_V: float
    high_V: float
    plays: int = 24
    hats: int = 4
    curve: int = 7
    degree: int = 5
    reaches: tuple[float, ...] = (0.06, 0.12, 0.25, 0.5, 1.0)

    @property
    def size(self) -> int:
        """Number of coefficients without the constant."""
        return self.curve + self.hats * self.degree + 2 * len(self.reaches)

    def columns(self, u_V: Floats, start: float) -> Floats:
        """(size, n) columns of h for the path u_V, (n,); one column per row, contiguous in memory.

        start: initial state of the plays, z_r = u(0) + start * r within the range: +1 after a falling, -1 after a
        rising input.
        """
        half = 0.5 * (self.high_V - self.low_V)
        v = (u_V - 0.5 * (self.low_V + self.high_V)) / half
        # Half-widths are denser near 0, because narrow plays determine the small loops.
        r = (np.arange(1, self.plays + 1) / (self.plays + 1)) ** 1.5
        place = np.sqrt(r / r[-1]) * (self.hats - 1)
        hats = np.clip(1.0 - np.abs(place[:, None] - np.arange(self.hats)), 0.0, None)
        hats /= hats.sum(axis=0) if self.hats else 1.0
        begin = np.clip(v[0] + start * r, -1.0 + r, 1.0 - r)
        out = np.empty((self.size, len(v)))
        duhem = self.size - 2 * len(self.reaches)
        basis = PreisachBasis(r, hats, self.curve, self.degree if self.hats else 0)
        preisach_columns(out[:duhem], v, begin, basis)
        duhem_columns(out[duhem:], v, np.array(self.reaches))
        return out

    def at(self, u_V: float) -> Floats:
        """(size,) columns at u_V, mean of both branches of the major loop; extrapolated linearly outside the range.

        On the major loop the values of the plays are those of a record; elsewhere the polynomials would extrapolate.
        """
        return _middle(self, u_V)


@lru_cache(maxsize=16)
def _middle(operator: Operator, u_V: float) -> Floats:
    low_V, high_V = operator.low_V, operator.high_V
    inside_V = min(max(u_V, low_V), high_V)
    down, up = (operator.columns(np.array([*way, inside_V]), 0.0) for way in ((low_V, high_V), (high_V, low_V)))
    middle = 0.5 * (down[:, -1] + up[:, -1]) + (u_V - inside_V) / (high_V - low_V) * (down[:, 1] - up[:, 1])
    middle[operator.size - 2 * len(operator.reaches) :] = 0.0
    middle.flags.writeable = False
    return middle

"""A hysteresis operator that is linear in its coefficients: the hysteresis of the probe and of delivered models.

    h(u) = g(u) + integral over r of q(r, z_r(u)) dr + sum_j (b_j d_j + c_j d_j |d_j|)
    z_r: play of half-width r;      d_j' = (sign(u') - d_j) |u'| / reach_j

The first two terms are every Preisach operator with a density (Brokate and Sprekels, 1996, chapter 2.4). g and q are
Chebyshev polynomials of the normalised input and play, q is piecewise linear in r (hat functions). The states d_j
decay with the path length of the input, not in time; they approximate Duhem operators such as Dahl's and Bouc-Wen's,
which are not Preisach operators.

    h = sum_m a_m T_m(v) + sum_b sum_m c_bm * sum_i hat_b(r_i) T_m(z_i) + ...,     v, z_i in [-1, 1]
"""

import dataclasses
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import lru_cache, partial

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import NDArray

from hysgen.machine.kernels.operators import (
    PreisachBasis,
    duhem_columns,
    play_operators,
    preisach_columns,
    preisach_path,
)
from hysgen.model.path.hysteresis import Hysteresis, largest_play

Floats = NDArray[np.float64]

SEARCHED = -1.0
"""Relaxation of a `PathSize` that the fit finds."""

LONG_PATH = 200_000
"""Samples of a path above which what is summed is formed one after the other: Duhem states take 80 bytes a sample."""

PLACES_PER_DEGREE = 4
"""Places per degree at which the slope of a polynomial is required: between them a slope of degree n is at most
1 / cos(pi/8) - 1 = 8 % of its largest value below 0."""

TOUCHING = 1e-9
"""Distance from the end of its play, in half ranges, up to which the input takes the play along."""


@dataclass(frozen=True)
class Operator:
    """Size of the expansion over the input range [low_V, high_V].

    plays: number of half-widths r_i of the quadrature; hats: hat functions of r, 0 for a single-valued curve g(u).
    curve, degree: degree of the Chebyshev polynomials of the input and of the plays. reaches: decay lengths of the
    Duhem states along the path, in half ranges of the input. relaxation: s_j / r_j of plays that relax by thermal
    activation (`model.path.hysteresis`), 0 for plays that do not.
    """

    low_V: float
    high_V: float
    plays: int = 24
    hats: int = 4
    curve: int = 7
    degree: int = 5
    reaches: tuple[float, ...] = (0.06, 0.12, 0.25, 0.5, 1.0)
    relaxation: float = 0.0

    @property
    def size(self) -> int:
        """Number of coefficients without the constant."""
        return self.curve + self.hats * self.degree + 2 * len(self.reaches)

    @property
    def half_widths(self) -> Floats:
        """(plays,) r_i in half ranges, denser near 0, because narrow plays determine the small loops."""
        return np.asarray((np.arange(1, self.plays + 1) / (self.plays + 1)) ** 1.5)

    @property
    def hat_weights(self) -> Floats:
        """(plays, hats) value of every hat function at every half-width, each with the sum 1, or 0 without plays."""
        r = self.half_widths
        place = np.sqrt(r / r[-1:]) * (self.hats - 1)
        hats = np.clip(1.0 - np.abs(place[:, None] - np.arange(self.hats)), 0.0, None)
        return np.asarray(hats / np.maximum(hats.sum(axis=0), 1e-300))

    def normalised(self, u_V: Floats) -> Floats:
        """v of the voltages u_V: -1 .. 1 over the input range."""
        half = 0.5 * (self.high_V - self.low_V)
        return np.asarray((u_V - 0.5 * (self.low_V + self.high_V)) / half)

    def columns(self, u_V: Floats, start: float = 0.0) -> Floats:
        """(size, n) columns of h for the path u_V, (n,); one column per row, contiguous in memory.

        start: initial state of the plays, z_r = u(0) + start * r within the range: +1 after a falling, -1 after a
        rising input.
        """
        v, begin, basis = self._along(u_V, start)
        out = np.empty((self.size, len(v)))
        duhem = self.size - 2 * len(self.reaches)
        preisach_columns(out[:duhem], v, begin, basis)
        duhem_columns(out[duhem:], v, np.array(self.reaches))
        return out

    def groups(self) -> Iterator[tuple[slice, Callable[..., Floats]]]:
        """`columns` in groups of a few rows with the same bits, for a path whose columns take much memory.

        Of each group: its rows among those of the columns, and the function from u_V and start to these rows.
        """
        yield slice(0, self.curve), dataclasses.replace(self, plays=0, hats=0, reaches=()).columns
        turned = slice(self.curve, self.curve + self.hats * self.degree)
        for hat in range(self.hats):
            yield slice(turned.start + hat, turned.stop, self.hats), partial(self._of_hat, hat)
        for j, reach in enumerate(self.reaches):
            first = turned.stop + 2 * j
            yield slice(first, first + 2), dataclasses.replace(self, plays=0, hats=0, curve=0, reaches=(reach,)).columns

    def _of_hat(self, hat: int, u_V: Floats, start: float = 0.0) -> Floats:
        """(degree, n) the columns of one hat function, from the plays that it weighs."""
        v, begin, basis = self._along(u_V, start)
        weighed = np.flatnonzero(basis.hat[:, hat])
        out = np.empty((self.degree, len(v)))
        few = PreisachBasis(basis.half_width[weighed], basis.hat[weighed, hat, None], 0, self.degree, self.relaxation)
        preisach_columns(out, v, begin[weighed], few)
        return out

    def path(self, u_V: Floats, weights: Floats, start: float = 0.0) -> Floats:
        """(n,) weights @ columns(u_V, start), for weights, (size,): a third of the time of the columns."""
        v, begin, basis = self._along(u_V, start)
        duhem = self.size - 2 * len(self.reaches)
        h = preisach_path(v, begin, basis, weights[:duhem])
        if len(v) > LONG_PATH:
            for j, reach in enumerate(self.reaches):
                states = np.empty((2, len(v)))
                duhem_columns(states, v, np.array([reach]))
                h += weights[duhem + 2 * j : duhem + 2 * j + 2] @ states
            return h
        states = np.empty((2 * len(self.reaches), len(v)))
        duhem_columns(states, v, np.array(self.reaches))
        return h + weights[duhem:] @ states

    def _along(self, u_V: Floats, start: float) -> tuple[Floats, Floats, PreisachBasis]:
        """Normalised input, (n,), state of the plays before it, (plays,), and the basis without Duhem states."""
        v, r = self.normalised(u_V), self.half_widths
        begin = np.clip(v[0] + start * r, -1.0 + r, 1.0 - r)
        return (
            v,
            begin,
            PreisachBasis(r, self.hat_weights, self.curve, self.degree if self.hats else 0, self.relaxation),
        )

    def slopes(self, v: Floats) -> Floats:
        """(2 n, size) rows: row @ coefficients is dh/dv at the states along the path v, (n,), normalised.

        First for an input that rises from there, then for one that falls. Only plays that the input takes along move.
        """
        r, hats = self.half_widths, self.hat_weights
        z = play_operators(np.ascontiguousarray(v), r, np.clip(v[0], r - 1.0, 1.0 - r))
        states = np.empty((2 * len(self.reaches), len(v)))
        duhem_columns(states, np.ascontiguousarray(v), np.array(self.reaches))
        curve = [_slope(v, m) for m in range(1, self.curve + 1)]
        turned = [_slope(z, m) for m in range(1, self.degree + 1)] if self.hats else []
        rows = []
        for sign, taken in ((1.0, z <= v[:, None] - r + TOUCHING), (-1.0, z >= v[:, None] + r - TOUCHING)):
            columns = [*curve, *(column for slope in turned for column in ((slope * taken) @ hats).T)]
            for d, reach in zip(states[::2], self.reaches, strict=True):
                along = (1.0 - sign * d) / reach
                columns += [along, 2.0 * np.abs(d) * along]
            rows.append(np.stack(columns, axis=1))
        return np.vstack(rows)

    def density_slopes(self) -> tuple[Floats, Floats]:
        """Slopes that bound dh/dv from below for every past, and the part of the mean slope that each must reach.

        (n, size) rows: row @ coefficients is dg0/dv, the slope dg_i/dz of a play, or b_j and b_j + 2 c_j of a Duhem
        state; (n,) 1 for dg0/dv, 0 for the others. dg_i/dz is the Preisach density of the hysterons of half-width r_i,
        in um per half range. Where no row of a play or of a Duhem state is negative, dh/dv >= dg0/dv on every path.
        """
        rows = np.zeros((0, self.size))
        for first, stride, degree, weights, end in self._polynomials():
            places = end * np.cos(np.linspace(0.0, np.pi, PLACES_PER_DEGREE * degree + 1))
            part = np.zeros((places.size, self.size))
            for m in range(1, degree + 1):
                at = first + (m - 1) * stride
                part[:, at : at + stride] = _slope(places, m)[:, None] * weights
            rows = np.vstack([rows, part])
        duhem = np.zeros((2 * len(self.reaches), self.size))
        first = self.size - duhem.shape[0]
        for j in range(len(self.reaches)):
            duhem[2 * j : 2 * j + 2, first + 2 * j] = 1.0
            duhem[2 * j + 1, first + 2 * j + 1] = 2.0
        rows = np.vstack([rows, duhem])
        return rows, (np.arange(len(rows)) <= PLACES_PER_DEGREE * self.curve).astype(float)

    def _polynomials(self) -> Iterator[tuple[int, int, int, Floats, float]]:
        """Of g0 and each g_i: first column, columns per degree, degree, weights of the columns, largest |argument|."""
        yield 0, 1, self.curve, np.ones(1), 1.0
        if self.hats:
            for r, weights in zip(self.half_widths, self.hat_weights, strict=True):
                yield self.curve, self.hats, self.degree, weights, largest_play(float(r), self.relaxation)

    def penalties(self) -> Floats:
        """(size,) weight of the prior of each coefficient of plays that relax: m^4 for degree m; 1 for all others.

        The prior of a smooth density: a coefficient of T_m contributes to its second derivative with about m^4.
        """
        weights = np.ones(self.size)
        if self.relaxation:
            degrees = np.repeat(np.arange(1.0, self.degree + 1.0), self.hats)
            weights[self.curve : self.curve + degrees.size] = degrees**4
        return weights

    def block(self, coefficients: Floats, constant_um: float = 0.0) -> Hysteresis:
        """The block of a model with these coefficients, (size,), of `columns`.

        Raises ValueError unless the decay lengths halve from each to the next (a block has one longest decay length).
        """
        plays = self.hats * self.degree
        per_play = self.hat_weights @ coefficients[self.curve : self.curve + plays].reshape(self.degree, self.hats).T
        duhem = coefficients[self.curve + plays :]
        longest = self.reaches[0] if self.reaches else 1.0
        if any(reach != longest * 0.5**i for i, reach in enumerate(self.reaches)):
            raise ValueError("the decay lengths of the Duhem states must halve from each to the next")
        return Hysteresis(
            self.low_V,
            self.high_V,
            (constant_um, *(float(a) for a in coefficients[: self.curve])),
            tuple(self.half_widths.tolist()) if plays else (),
            tuple(per_play.ravel().tolist()) if plays else (),
            longest,
            tuple(duhem.tolist()),
            self.relaxation,
        )

    def at(self, u_V: float) -> Floats:
        """(size,) columns at u_V, mean of both branches of the major loop; extrapolated linearly outside the range.

        On the major loop the values of the plays are those of a record; elsewhere the polynomials would extrapolate.
        """
        return _middle(self, u_V)


MOST_PLAYS = 64
"""Plays of an operator at most, a limit of the compiled kernel (`machine.kernels.operators.preisach_columns`)."""


@dataclass(frozen=True)
class PathSize:
    """Size of the hysteresis: plays in `hats` hat functions with polynomials of `degree`, curve, and Duhem states.

    hats: at most `plays` of them are used. relaxation: s_j / r_j of plays that relax, SEARCHED for the value of least
    error, 0 for plays that do not relax.
    """

    plays: int = 8
    degree: int = 3
    states: int = 5
    hats: int = 4
    curve: int = 7
    relaxation: float = 0.0

    def to_json(self) -> dict[str, float]:
        """Plain JSON values; `relaxation` only of plays that relax."""
        return {name: value for name, value in dataclasses.asdict(self).items() if name != "relaxation" or value}

    def operator(self, low_V: float, high_V: float) -> Operator:
        """The operator of this size over an input range."""
        reaches = tuple(0.5**i for i in range(self.states))
        if not self.plays:
            return Operator(low_V, high_V, hats=0, curve=self.curve, reaches=reaches)
        hats = min(self.hats, self.plays)
        return Operator(low_V, high_V, self.plays, hats, self.curve, self.degree, reaches, self.relaxation)


RELAXING = PathSize(plays=24, degree=7, states=0, hats=12, relaxation=SEARCHED)
"""Plays that relax, with densities fine enough for a stage of thermally activated hysterons."""

CURVE = PathSize(plays=0, states=0)
"""A single-valued curve, for a path without memory."""


def _slope(x: Floats, order: int) -> Floats:
    """dT_order/dx."""
    return np.asarray(chebyshev.chebval(x, chebyshev.chebder(np.eye(order + 1)[order])))


@lru_cache(maxsize=16)
def _middle(operator: Operator, u_V: float) -> Floats:
    low_V, high_V = operator.low_V, operator.high_V
    inside_V = min(max(u_V, low_V), high_V)
    down, up = (operator.columns(np.array([*way, inside_V]), 0.0) for way in ((low_V, high_V), (high_V, low_V)))
    middle = 0.5 * (down[:, -1] + up[:, -1]) + (u_V - inside_V) / (high_V - low_V) * (down[:, 1] - up[:, 1])
    middle[operator.size - 2 * len(operator.reaches) :] = 0.0
    middle.flags.writeable = False
    return middle

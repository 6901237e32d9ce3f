"""Certificates of a model over its operating range, y in [y_min, y_max] and u in [u_min, u_max].

    gain         b(y) has one sign, and |b(y)| >= 1 % of its largest value: Eq. (11) may divide by it
    contraction  |df/dy| < 1: two free runs under the same input converge, for any initial states
    inverse      the inputs that Eq. (11) computes are bounded, with the feedback of past inputs through the terms

The inverse solves b u(k) = r(k) - sum_j theta_j phi_j(k) for the right-hand side r(k) = y(k+1) - f(y(k), 0). The
regressors phi(k) depend on u(k-1), u(k-2), ... Linear terms x(k+1) = A x + B u, phi = C x, with transfer function T,
make the inverse a filter (b + T)^-1 with the poles eig(A - B theta C/b), evaluated for frozen b between the extrema of
b(y). Nonlinear terms (play operators) are a second feedback loop around this filter. With the input steps
d(k) = u(k) - u(k-1), this loop is stable by the small-gain theorem if

    loop = ||(b + T)^-1||_1  N < 1,     N >= |theta . phi(k+1) - theta . phi(k)| / |d(k)|,  phi of the nonlinear terms

N = sum_j |theta_j| gamma_j with the gains gamma_j of the terms, or a sharper bound from the slopes that play operators
can have at the same time, see `play_slopes`. Then

    sup |d| <= ||(b + T)^-1||_1 / (1 - loop)  sup |r(k) - r(k-1)|

so the steps d are bounded. The inputs are bounded too: with w(u) the sum of the nonlinear terms on a branch of the
hysteresis, b + dw/du >= (1 - loop) b > 0, and |b u + w(u) - r| <= N |d|.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hysgen.certify.enclosure import Extremum, gain, gain_extrema, slope, slope_extremum
from hysgen.certify.zeros import Rational, rational, zeros
from hysgen.machine.reproducible import geometric, product, rounded_down, rounded_up
from hysgen.model.model import Model
from hysgen.model.terms import loop_row

Floats = NDArray[np.float64]

SMALLEST_GAIN_RATIO = 0.01
"""Smallest ratio of the least |b| to the largest |b| for which the inverse is certified."""

DIGITS = 12
"""Significant digits of every bound, rounded outward, so that it remains a bound. A sum of a hundred float64 numbers
has an error of 1e-14 of the largest; gain and slope of rules that nearly cancel are a hundredth of the largest, so 12
digits are exact. The distance of a pole from 1, 1e-6 for lags of 30 s, then has 6 digits."""

FROZEN_GAINS = 33
"""Frozen gains between the extrema of b(y) at which the poles of the inverse are computed."""


@dataclass(frozen=True)
class Certificates:
    """The certificates of a model, with the points of their extrema.

    gain_lowest, gain_highest: extrema of b(y) in um/V. slope: the largest |df/dy|.
    contracting_V: the inputs for which contraction holds, None if there are none inside the input range.
    zero: largest modulus of eig(A - B theta C/b), the zeros of b + T. loop: loop gain of the nonlinear terms.
    """

    y_range_um: tuple[float, float]
    u_range_V: tuple[float, float]
    gain_lowest: Extremum
    gain_highest: Extremum
    slope: Extremum
    contracting_V: tuple[float, float] | None
    zero: float
    loop: float

    @property
    def gain_holds(self) -> bool:
        """b(y) has one sign, and its least magnitude is above SMALLEST_GAIN_RATIO of its largest."""
        low, high = self.gain_lowest.bound, self.gain_highest.bound
        weakest, strongest = (low, high) if high > 0.0 else (-high, -low)
        return weakest > SMALLEST_GAIN_RATIO * strongest

    @property
    def contraction_holds(self) -> bool:
        """|df/dy| < 1 over the whole range."""
        return self.slope.bound < 1.0

    @property
    def inverse_holds(self) -> bool:
        """Eq. (11) is stable: the gain holds, and both zero and loop are below 1."""
        return self.gain_holds and self.zero < 1.0 and self.loop < 1.0

    def lines(self) -> tuple[str, ...]:
        """One line of text per certificate."""
        return (self._gain_line(), self._contraction_line(), self._inverse_line())

    def _gain_line(self) -> str:
        low, high = self.gain_lowest, self.gain_highest
        at = f"gain {low.value:.4g} (y = {low.y_um:.4g} um) .. {high.value:.4g} (y = {high.y_um:.4g} um) um/V"
        return f"{at}: {'holds' if self.gain_holds else 'NOT certified, no inverse can be emitted'}"

    def _contraction_line(self) -> str:
        at = f"slope at most {self.slope.bound:.4f} (y = {self.slope.y_um:.4g} um, u = {self.slope.u_V:.4g} V)"
        if self.contraction_holds:
            return f"{at}: contraction holds"
        if self.contracting_V is None:
            return f"{at}: contraction NOT certified at any voltage, the free run is not to be trusted"
        low, high = self.contracting_V
        return f"{at}: contraction certified for {low:.4g} .. {high:.4g} V only, no free run is to be trusted beyond"

    def _inverse_line(self) -> str:
        line = f"inverse zeros within {self.zero:.4f}, loop gain of its nonlinear terms {self.loop:.3g}"
        if not self.gain_holds:
            return f"{line}: NOT certified, for the gain is not"
        return f"{line}: {'stable' if self.inverse_holds else 'NOT certified, past inputs may build up'}"

    def to_json(self) -> dict[str, Any]:
        """Plain JSON values; an infinite loop gain becomes null."""
        return {
            "y_range_um": list(self.y_range_um),
            "u_range_V": list(self.u_range_V),
            "gain": {
                "holds": self.gain_holds,
                "lowest": self.gain_lowest.to_json(),
                "highest": self.gain_highest.to_json(),
                "unit": "um/V",
            },
            "contraction": {
                "holds": self.contraction_holds,
                "slope": self.slope.to_json(),
                "inputs_V": list(self.contracting_V) if self.contracting_V else None,
            },
            "inverse": {
                "holds": self.inverse_holds,
                "zero": self.zero,
                "loop": self.loop if np.isfinite(self.loop) else None,
            },
        }


def certify(model: Model) -> Certificates:
    """Compute every certificate of `model` over its own ranges."""
    lowest, highest = gain_extrema(model)
    lowest = dataclasses.replace(lowest, bound=rounded_down(lowest.bound, DIGITS))
    highest = dataclasses.replace(highest, bound=rounded_up(highest.bound, DIGITS))
    steepest = slope_extremum(model)
    steepest = dataclasses.replace(steepest, bound=rounded_up(steepest.bound, DIGITS))
    ends = (model.w_range.low, model.w_range.high)
    zero, loop = inverse_stability(model, lowest.value, highest.value)
    return Certificates(
        y_range_um=(model.grid.y_min_um, model.grid.y_max_um),
        u_range_V=ends,
        gain_lowest=lowest,
        gain_highest=highest,
        slope=steepest,
        contracting_V=ends if steepest.bound < 1.0 else _contracting_inputs(model),
        zero=rounded_up(zero, DIGITS),
        loop=rounded_up(loop, DIGITS),
    )


def inverse_stability(model: Model, gain_lowest: float, gain_highest: float) -> tuple[float, float]:
    """(zero, loop) of `Certificates` over frozen gains between gain_lowest and gain_highest.

    Both are infinite if the model has terms and the interval contains a gain of zero.
    """
    if not model.terms:
        return 0.0, 0.0
    if gain_lowest <= 0.0 <= gain_highest:
        return np.inf, np.inf
    zero, size, nonlinear = inverse_filter(model, gain_lowest, gain_highest)
    return zero, nonlinear * size if nonlinear > 0.0 else 0.0


def least_stable(model: Model, gain_lowest: float, gain_highest: float) -> tuple[float, float]:
    """Displacement in um and gain b in um/V with the largest ||(b + T)^-1||_1, i.e. the least stable inverse."""
    terms = _feedback(model)
    gains = geometric(gain_lowest, gain_highest, FROZEN_GAINS)
    worst = max(gains, key=lambda b: _inverse_filter(terms, b)[::-1])
    y = np.linspace(model.grid.y_min_um, model.grid.y_max_um, 200 * model.grid.rules)
    nearest = int(np.argmin(np.abs(gain(model, y) - worst)))
    return float(y[nearest]), float(worst)


def inverse_filter(model: Model, gain_lowest: float, gain_highest: float) -> tuple[float, float, float]:
    """Largest |eig(A - B theta C/b)| and largest ||(b + T)^-1||_1 over frozen gains b, and N."""
    terms = _feedback(model)
    filters = [_inverse_filter(terms, b) for b in geometric(gain_lowest, gain_highest, FROZEN_GAINS)]
    return max(zero for zero, _ in filters), max(size for _, size in filters), terms.nonlinear


@dataclass(frozen=True)
class _Feedback:
    """Feedback of the terms: T of all linear terms, ||T||_1 <= linear, and the bound N = nonlinear of the others."""

    T: Rational
    linear: float
    nonlinear: float


def _feedback(model: Model) -> _Feedback:
    systems, linear, nonlinear, start = [], 0.0, 0.0, 0
    for term in model.terms:
        theta = model.weights[start : start + term.size]
        start += term.size
        system = term.linear(model.Ts_s)
        bound = float(product(loop_row(term, theta, model.Ts_s), theta))
        if system is None:
            nonlinear += bound
        else:
            linear += bound
            systems.append((system, theta))
    order = sum(len(system.B) for system, _ in systems)
    A, at = np.zeros((order, order)), 0
    for system, _ in systems:
        A[at : at + len(system.B), at : at + len(system.B)] = system.A
        at += len(system.B)
    B = np.concatenate([np.zeros(0), *(system.B for system, _ in systems)])
    theta_C = np.concatenate([np.zeros(0), *(product(system.C.T, theta) for system, theta in systems)])
    return _Feedback(rational(A, B, theta_C), linear, nonlinear)


def _inverse_filter(terms: _Feedback, b: float) -> tuple[float, float]:
    """Spectral radius of A - B theta C/b, and a bound of ||(b + T)^-1||_1 (infinite if unstable).

    The impulse response of (b + T)^-1 is 1/b, then -theta C (A - B theta C/b)^(k-1) B/b^2: a sum of modes r p^(k-1),
    each of which has the sum |r|/(1 - |p|). If ||T||_1 < |b|, 1/(|b| - ||T||_1) is a bound as well.
    """
    if terms.T.B.size == 0:
        return 0.0, 1.0 / abs(b)
    radius, size = zeros(terms.T, b)
    if radius >= 1.0:
        return radius, np.inf
    return radius, min(size, 1.0 / (abs(b) - terms.linear)) if terms.linear < abs(b) else size


def _contracting_inputs(model: Model) -> tuple[float, float] | None:
    """The part of the input range over which contraction holds; None if it is empty.

    max_y |df/dy| is convex in u, so the inputs form an interval, and bounds that hold at its ends hold between them.
    """
    y = np.linspace(model.grid.y_min_um, model.grid.y_max_um, 200 * model.grid.rules)
    at_zero = slope(model, y, np.zeros_like(y))
    per_volt = slope(model, y, np.ones_like(y)) - at_zero
    with np.errstate(divide="ignore", invalid="ignore"):
        ends = np.sort(np.stack([(-1.0 - at_zero) / per_volt, (1.0 - at_zero) / per_volt]), axis=0)
    flat = per_volt == 0.0
    if (np.abs(at_zero[flat]) >= 1.0).any():
        return None
    first, last = model.w_range.low, model.w_range.high
    low = max(first, float(np.max(ends[0][~flat], initial=-np.inf)))
    high = min(last, float(np.min(ends[1][~flat], initial=np.inf)))
    # The grid may miss the worst displacement: narrow the interval until the enclosure confirms it.
    for share in geometric(1e-6, 0.5, 40):
        margin = share * (last - first)
        inner = (low if low == first else low + margin, high if high == last else high - margin)
        if inner[0] >= inner[1]:
            return None
        if slope_extremum(model, inner).bound < 1.0:
            return float(inner[0]), float(inner[1])
    return None

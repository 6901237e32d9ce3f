"""What is guaranteed of a model over its operating range, y in [y_min, y_max] and u in [u_min, u_max].

    gain         b(y) keeps one sign, at least 1 % of its largest magnitude: Eq. (11) may divide by it
    contraction  |df/dy| < 1: two free runs under the same input approach each other, whatever they started from
    inverse      the inputs that Eq. (11) computes stay bounded, although the terms feed past inputs back into it

The inverse solves b u(k) = y(k+1) - f(y(k), 0) - sum_j theta_j phi_j(k), where phi(k) remembers u(k-1), u(k-2), ...
Linear terms x(k+1) = A x + B u, phi = C x turn it into a filter with the zeros eig(A - B theta C/b), looked at for
frozen b between the extrema of b(y). Nonlinear terms (play operators) close a second loop around that filter. For the
steps d(k) = u(k) - u(k-1) it is stable by the small-gain theorem if

    loop = ||(b + T)^-1||_1  N < 1,     N a bound of |theta . phi(k+1) - theta . phi(k)| / |d(k)| over all nonlinear
                                        terms: sum_j |theta_j| gamma_j with the terms' gains, or sharper and of slopes
                                        that play operators can have at a time, see `play_slopes`.

Then sup |d| <= ||(b + T)^-1||_1 / (1 - loop) times the largest step of what is asked: steps do not build up, which is
how an inverse fails that answers one sample late. Nor do the inputs: b + dw/du >= (1 - loop) b > 0 on every branch of
the hysteresis w, so b u + w(u), which differs from what is asked by N |d| at most, is bounded only with u.
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
from hysgen.model.membership import memberships
from hysgen.model.model import Model
from hysgen.model.terms import loop_row

Floats = NDArray[np.float64]

SMALLEST_GAIN_RATIO = 0.01
"""Least |b| over largest |b| for which the inverse is worth dividing by."""

DIGITS = 12
"""Significant digits of every bound, rounded outward, so that a bound stays one. A sum of some hundred float64 numbers
errs by 1e-14 of the largest, which the gain and slope of rules that nearly cancel have a hundredth of: 12 digits hold,
and the distance of a zero from 1, 1e-6 for lags of 30 s, keeps 6 of them."""

FROZEN_GAINS = 33
"""Gains between the extrema of b(y) at which the zeros of the inverse are computed."""


@dataclass(frozen=True)
class Certificates:
    """What holds for a model, and where it is closest to not holding.

    gain_lowest, gain_highest: extrema of b(y) in um/V. slope: the largest |df/dy|.
    contracting_V: the inputs for which contraction holds, None if there are none inside the input range.
    zero: largest modulus of the inverse's zeros. loop: small gain of the nonlinear terms around it, for its steps.
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
        """b(y) keeps one sign and stays away from zero."""
        low, high = self.gain_lowest.bound, self.gain_highest.bound
        weakest, strongest = (low, high) if high > 0.0 else (-high, -low)
        return weakest > SMALLEST_GAIN_RATIO * strongest

    @property
    def contraction_holds(self) -> bool:
        """|df/dy| < 1 over the whole range."""
        return self.slope.bound < 1.0

    @property
    def inverse_holds(self) -> bool:
        """Eq. (11) may be used: the gain holds, and past inputs do not build up in it."""
        return self.gain_holds and self.zero < 1.0 and self.loop < 1.0

    def lines(self) -> tuple[str, ...]:
        """One line for people per certificate."""
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
        """Plain JSON values; a loop gain that is not finite becomes null."""
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
    ends = (model.u_min_V, model.u_max_V)
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


def steady_input(model: Model, y_um: Floats) -> Floats:
    """The steady-state line of the rules, u_ss(y) = (y - sum_l p_l (q_l1 y + q_l3))/b(y) in V, (n,); terms left out.

    Infinite where the gain vanishes.
    """
    p = memberships(y_um, model.grid)
    q1, q2, q3 = model.consequents.T
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray((y_um - product(p, q1) * y_um - product(p, q3)) / product(p, q2))


def inverse_stability(model: Model, gain_lowest: float, gain_highest: float) -> tuple[float, float]:
    """Largest modulus of the inverse's zeros, and loop gain of the nonlinear terms, over frozen gains in between.

    Both are infinite if the gain interval contains zero and there are terms.
    """
    if not model.terms:
        return 0.0, 0.0
    if gain_lowest <= 0.0 <= gain_highest:
        return np.inf, np.inf
    zero, size, nonlinear = inverse_filter(model, gain_lowest, gain_highest)
    return zero, nonlinear * size if nonlinear > 0.0 else 0.0


def least_stable(model: Model, gain_lowest: float, gain_highest: float) -> tuple[float, float]:
    """Displacement in um and gain in um/V at which the inverse is closest to building up past inputs."""
    terms = _feedback(model)
    gains = geometric(gain_lowest, gain_highest, FROZEN_GAINS)
    worst = max(gains, key=lambda b: _inverse_filter(terms, b)[::-1])
    y = np.linspace(model.grid.y_min_um, model.grid.y_max_um, 200 * model.grid.rules)
    nearest = int(np.argmin(np.abs(gain(model, y) - worst)))
    return float(y[nearest]), float(worst)


def inverse_filter(model: Model, gain_lowest: float, gain_highest: float) -> tuple[float, float, float]:
    """Largest modulus of the zeros, largest ||(b + T)^-1||_1 over frozen gains b in between, and N."""
    terms = _feedback(model)
    filters = [_inverse_filter(terms, b) for b in geometric(gain_lowest, gain_highest, FROZEN_GAINS)]
    return max(zero for zero, _ in filters), max(size for _, size in filters), terms.nonlinear


@dataclass(frozen=True)
class _Feedback:
    """What the terms feed back into the inverse: the linear ones as one transfer function T, whose ||T||_1 is at most
    `linear`, and the bound N of the others, `nonlinear`."""

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
    each of which adds up to |r|/(1 - |p|). Where ||T||_1 < |b|, 1/(|b| - ||T||_1) is a bound too.
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
    low = max(model.u_min_V, float(np.max(ends[0][~flat], initial=-np.inf)))
    high = min(model.u_max_V, float(np.min(ends[1][~flat], initial=np.inf)))
    # The grid may miss the worst displacement by a little: draw the ends in until the enclosure agrees.
    for share in geometric(1e-6, 0.5, 40):
        margin = share * (model.u_max_V - model.u_min_V)
        inner = (low if low == model.u_min_V else low + margin, high if high == model.u_max_V else high - margin)
        if inner[0] >= inner[1]:
            return None
        if slope_extremum(model, inner).bound < 1.0:
            return float(inner[0]), float(inner[1])
    return None

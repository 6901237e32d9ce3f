"""Certificates of the inverse of a path: slope of the hysteresis, zeros of creep and modes, blocks that it leaves out.

    hysteresis       dh/dx keeps the sign of its mean: then h(x) = w has one solution x, which Newton steps find
    creep and modes  zero = largest |eigenvalue| of the block's inverse, below 1: errors of the state decay

The slope is computed along fixed paths of random turns over the whole input range, for a rising and for a falling input
at every point. Paths are a sample of all pasts: the smallest and largest slope are no bounds for other pasts. Plays
that relax have pasts that no path without time shows. Where their densities dg_j/dz are nowhere negative, as `fitting`
requires, dh/dx >= min dg0/dx is a bound for every past, and the certificate is a proof.
Source of the Newton steps and of the states: `model.path.hysteresis`.
"""

import functools
import itertools
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import NDArray

from hysgen.machine.reproducible import drawn, exponential, rounded_down, rounded_up, total
from hysgen.model.intervals import Interval
from hysgen.model.model import Model
from hysgen.model.path.hysteresis import Hysteresis

Floats = NDArray[np.float64]

DIGITS = 9
"""Significant digits of slopes and zeros, rounded outward."""

TURNS, SMALL_LOOPS, POINTS = 120, 60, 33
"""Turns anywhere in the range, turns of loops of random sizes after them, and points of the path between two turns."""

PLACES = 4097
"""Places at which the slope of a polynomial is computed for its bounds."""

TOUCHING = 1e-9
"""Distance from the end of its play, in half ranges, up to which the input takes the play along."""


@dataclass(frozen=True)
class HysteresisSlopes:
    """Smallest and largest dh/dx as parts of the mean slope, and the mean slope in um/V.

    proved: whether both are bounds for every past (`bounded_slopes`), or extremes of sampled paths (`sampled_slopes`).
    """

    least: float
    largest: float
    mean_um_per_V: float
    proved: bool = False


@dataclass(frozen=True)
class PathInverse:
    """What the inverse of a path rests on.

    slopes: of the hysteresis, None without one. zero: the largest of creep and modes that the inverse solves, 0 without
    one. left_out: kinds of responses without a stable inverse, which the inverse of the model leaves out.
    """

    slopes: HysteresisSlopes | None
    zero: float
    left_out: tuple[str, ...]

    @property
    def holds(self) -> bool:
        """The hysteresis keeps the sign of its slope, and every zero is inside the unit circle."""
        return (self.slopes is None or self.slopes.least > 0.0) and self.zero < 1.0

    def parts(self) -> list[str]:
        """Text of slopes, zero and blocks that are left out; empty without responses of the stage."""
        texts = []
        if self.slopes is not None:
            slopes = self.slopes
            texts.append(
                f"slope of the hysteresis {slopes.least:.3g} .. {slopes.largest:.3g} of its mean "
                f"{slopes.mean_um_per_V:.3g} um/V ({'for every past' if slopes.proved else 'sampled, not proved'})"
            )
        if self.zero > 0.0:
            texts.append(f"zeros of creep and modes within {self.zero:.6f}")
        return texts + [f"{kind} left out" for kind in self.left_out]

    def to_json(self) -> dict[str, Any]:
        """Plain JSON values."""
        slopes = None
        if self.slopes is not None:
            slopes = {
                "least_of_mean": self.slopes.least,
                "largest_of_mean": self.slopes.largest,
                "mean_um_per_V": self.slopes.mean_um_per_V,
                "proved": self.slopes.proved,
            }
        return {"hysteresis_slopes": slopes, "zero": self.zero, "left_out": list(self.left_out)}


def path_inverse(model: Model) -> PathInverse:
    """The certificates of a model's path over its input range."""
    u_V, slopes, zero, left_out = Interval(model.u_min_V, model.u_max_V), None, 0.0, []
    for block in model.blocks:
        if isinstance(block, Hysteresis):
            slopes = bounded_slopes(block) if block.relaxes else None
            if slopes is None or slopes.least <= 0.0:
                slopes = sampled_slopes(block, u_V)
        if block.responds and not block.solves(model.Ts_s):
            left_out.append(block.kind)
        elif block.responds:
            zero = max(zero, block.zero(model.Ts_s))
        u_V = block.image(u_V)
    return PathInverse(slopes, zero, tuple(left_out))


@functools.lru_cache(maxsize=16)
def sampled_slopes(block: Hysteresis, v_V: Interval) -> HysteresisSlopes:
    """Slopes of a hysteresis along paths of random turns of the voltages v_V."""
    x = np.clip(block.normalised(np.array([v_V.low, v_V.high])), -1.0, 1.0)
    mean = block.mean_slope
    slopes = slopes_along(block, turning_points(float(x[0]), float(x[1]))) * (1.0 if mean > 0.0 else -1.0) / abs(mean)
    return HysteresisSlopes(
        rounded_down(float(slopes.min()), DIGITS),
        rounded_up(float(slopes.max()), DIGITS),
        rounded_down(2.0 * mean / (block.high_V - block.low_V), DIGITS),
    )


def bounded_slopes(block: Hysteresis) -> HysteresisSlopes:
    """Bounds of dh/dx for every past of the plays and Duhem states, over the whole input range of the block.

    A play either moves with the input or rests: its part of dh/dx lies between 0 and the extremes of dg_j/dz. That of a
    Duhem state, (b + 2 c |d|) (1 - d) / reach with |d| <= 1, lies between 0 and 2 b / reach or 2 (b + 2 c) / reach.
    """
    mean, series = block.mean_slope, block.series
    sign = 1.0 if mean > 0.0 else -1.0
    low, high = _polynomial_slopes(sign * series.curve, 1.0)
    parts = [
        _polynomial_slopes(sign * np.append(0.0, row), end) for end, row in zip(block.ends, series.plays, strict=True)
    ]
    for (b, c), reach in zip(sign * series.duhem, block.reaches, strict=True):
        parts.append((2.0 * min(b, b + 2.0 * c) / reach, 2.0 * max(b, b + 2.0 * c) / reach))
    low += float(total(np.array([min(least, 0.0) for least, _ in parts])))
    high += float(total(np.array([max(largest, 0.0) for _, largest in parts])))
    return HysteresisSlopes(
        rounded_down(low / abs(mean), DIGITS),
        rounded_up(high / abs(mean), DIGITS),
        rounded_down(2.0 * mean / (block.high_V - block.low_V), DIGITS),
        proved=True,
    )


def _polynomial_slopes(coefficients: Floats, end: float) -> tuple[float, float]:
    """Bounds of dp/dx over [-end, end], end <= 1, p = sum_n c_n T_n.

    Between places a distance h apart dp/dx leaves the chord by at most h^2/8 times the largest third derivative of p;
    that of T_n is at most n^2 (n^2 - 1) (n^2 - 4) / 15.
    """
    slopes = chebyshev.chebval(np.linspace(-end, end, PLACES), chebyshev.chebder(coefficients))
    squares = np.arange(coefficients.size) ** 2.0
    bend = float(np.abs(coefficients) @ np.abs(squares * (squares - 1.0) * (squares - 4.0))) / 15.0
    beyond = (2.0 * end / (PLACES - 1)) ** 2 / 8.0 * bend
    return float(slopes.min()) - beyond, float(slopes.max()) + beyond


def slopes_along(block: Hysteresis, turns: Floats) -> Floats:
    """dh/dx, um per half range, at POINTS points between two turns, for an input that rises and one that falls there.

    turns: (n,) turning points in half ranges; the path starts at rest at the first one.
    """
    half = 0.5 * (block.high_V - block.low_V)
    state = block.start(0.5 * (block.low_V + block.high_V) + half * float(turns[0]))
    z, d = state[: block.plays], state[block.plays : block.plays + block.states]
    paths, plays, states = [], [], []
    for stroke in strokes(turns):
        path = stroke[:, None]
        z_on, d_on = _moved(block, path, z, d)
        z, d = z_on[-1], d_on[-1]
        paths.append(path)
        plays.append(z_on)
        states.append(d_on)
    x, z_all, d_all = np.concatenate(paths), np.concatenate(plays), np.concatenate(states)
    rising, falling = (_slope(block, x, z_all, d_all, sign).reshape(-1, POINTS) for sign in (1.0, -1.0))
    return np.hstack([rising, falling]).ravel()


def strokes(turns: Floats) -> list[Floats]:
    """The path between each two turning points, (POINTS,) each."""
    return [np.linspace(a, b, POINTS) for a, b in itertools.pairwise(turns)]


def _moved(block: Hysteresis, path: Floats, z: Floats, d: Floats) -> tuple[Floats, Floats]:
    """(n, plays) plays and (n, states) Duhem states along a path, (n, 1), without turns."""
    r = np.array(block.half_widths)
    rising = path[-1, 0] > path[0, 0]
    taken = np.maximum(z, path - r) if rising else np.minimum(z, path + r)
    sign = 1.0 if rising else -1.0
    remaining = exponential(-np.abs(path - path[0]) / np.array(block.reaches))
    return taken, sign - (sign - d) * remaining


def _slope(block: Hysteresis, x: Floats, z: Floats, d: Floats, sign: float) -> Floats:
    """(n,) dh/dx where the input moves on in the direction `sign`."""
    series = block.series
    slope = chebyshev.chebval(x[:, 0], chebyshev.chebder(series.curve))
    for j, (r, row) in enumerate(zip(series.half_width, series.plays, strict=True)):
        along = sign * (x[:, 0] - z[:, j]) >= r - TOUCHING
        slope = slope + along * chebyshev.chebval(z[:, j], chebyshev.chebder(np.array([0.0, *row])))
    b, c = series.duhem.T
    return np.asarray(slope + total((b + 2.0 * c * np.abs(d)) * (1.0 - sign * d) / np.array(block.reaches)))


def turning_points(low: float = -1.0, high: float = 1.0) -> Floats:
    """(n,) turning points in low .. high: the major loop, random turns, loops of random sizes about random places."""
    rng = np.random.default_rng(0)
    anywhere = drawn(rng, low, high, TURNS)
    places, sizes = drawn(rng, low, high, SMALL_LOOPS), drawn(rng, 0.0, 0.25 * (high - low), SMALL_LOOPS)
    loops = np.stack([places - sizes, places + sizes], axis=1).ravel()
    return np.concatenate([[low, high, low], anywhere, np.clip(loops, low, high)])

"""Kernels of the operators between command and displacement: limiters, plays, Duhem states, linear states, filters."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hysgen.machine.kernels import call

Floats = NDArray[np.float64]

MOST_STATES, MOST_BRANCHES, MOST_ORDER = 64, 8, 4


def play_operators(u_V: Floats, half_width_V: Floats, initial_V: Floats) -> Floats:
    """z_j(k) = max(u(k) - r_j, min(u(k) + r_j, z_j(k-1))) for every k and j.

    u_V: (n,); half-widths r_j and initial_V, the z_j before the first sample: (m,). Returns (n, m) in V.
    """
    out = np.empty((u_V.size, half_width_V.size))
    state = np.array(initial_V, dtype=np.float64)
    call("states.c", "hysgen_play", u_V.size, half_width_V.size, u_V, half_width_V, state, out)
    return out


def lag_states(u_V: Floats, rates: Floats, start_V: Floats) -> Floats:
    """First-order lags, s_j(k+1) = s_j(k) + a_j (u(k) - s_j(k)).

    u_V: (n,); rates a_j, start_V s_j(0): (m,). Returns (n, m): row k holds s_j(k), before u(k) acts.
    """
    u, q, s = (np.ascontiguousarray(x, dtype=np.float64) for x in (u_V, rates, np.array(start_V)))
    out = np.empty((u.size, q.size))
    call("states.c", "hysgen_lags", u.size, q.size, u, q, s, out)
    return out


def lag_of_signals(signals: Floats, rate: float, rows: NDArray[np.intp]) -> Floats:
    """One first-order lag of several signals, s_l(k+1) = s_l(k) + rate (u_l(k) - s_l(k)), s_l(0) = u_l(0).

    signals: (m, n); rows: (r,) rising. Returns (m, r): column i holds s_l(k) at k = rows[i], before u_l(k) acts, with
    the bits of `lag_states`. Raises ValueError for rows outside the signals.
    """
    if len(rows) and not (rows[0] >= 0 and rows[-1] < signals.shape[1] and bool((rows[1:] > rows[:-1]).all())):
        raise ValueError("the rows must rise within the samples of the signals")
    u, chosen = np.ascontiguousarray(signals, dtype=np.float64), np.ascontiguousarray(rows, dtype=np.int64)
    out = np.empty((len(u), len(chosen)))
    call("states.c", "hysgen_lag_signals", *u.shape, u, rate, len(chosen), chosen, out)
    return out


def lag_sums(u_V: Floats, rates: Floats, start_V: Floats) -> Floats:
    """(n,) the sum over j of `lag_states`, for u_V, (n,), rates and start_V, (m,)."""
    u, q, s = (np.ascontiguousarray(x, dtype=np.float64) for x in (u_V, rates, np.array(start_V)))
    out = np.empty(u.size)
    call("states.c", "hysgen_lag_sums", u.size, q.size, u, q, s, out)
    return out


def mode_states(u_V: Floats, steps: NDArray[np.complex128], start: Floats) -> Floats:
    """Damped modes driven by u: c_j(k+1) = c_j(k) + q_j (u(k) - c_j(k)), c_j = position + i velocity.

    u_V: (n,); steps q_j: (m,) complex; start: (2 m,) position and velocity of each mode at k = 0. Returns (n, 2 m) in
    the same order: row k holds the state before u(k) acts.
    """
    pairs = np.ascontiguousarray(steps, dtype=np.complex128).view(np.float64)
    u, c = np.ascontiguousarray(u_V, dtype=np.float64), np.array(start, dtype=np.float64)
    out = np.empty((u.size, pairs.size))
    call("states.c", "hysgen_modes", u.size, pairs.size // 2, u, pairs, c, out)
    return out


def loop_states(y: Floats, parts: int, pole: Floats, force: Floats, shape: Floats) -> Floats:
    """A mode with hysteretic states in its loop (`model.path.loop`): (n, 1 + r) Re x and every h at each sample.

    y: (n,) displacement without the states; pole: its two parts per step; force e: (r, 2); shape: (r, 3) p, q and box.
    """
    arrays = [np.ascontiguousarray(values, dtype=np.float64) for values in (y, pole, force, shape)]
    out = np.empty((y.size, 1 + len(shape)))
    call("loop.c", "hysgen_loop", y.size, parts, len(shape), *arrays, out)
    return out


MOST_MODES, MOST_DRIVES, SLOPES_TOGETHER = 64, 16, 32
"""Sizes of the arrays of softening.c."""


def softening_states(v: Floats, numbers: Floats, rate: float, most: float) -> tuple[Floats, Floats]:
    """Modes that follow a bounded amplitude (softening.c), from rest under v(0).

    v: (n, drives); numbers: (modes, 6 + 4 drives); rate, most: of the amplitude. Returns c, (n, 2 modes), and y, zeta
    and s, (n, 3). Raises ValueError for more modes or drives than the kernel has room for.
    """
    v, numbers = (np.ascontiguousarray(values, dtype=np.float64) for values in (v, numbers))
    modes, drives = len(numbers), v.shape[1]
    if modes > MOST_MODES or drives > MOST_DRIVES or numbers.shape[1] != 6 + 4 * drives:
        raise ValueError(f"at most {MOST_MODES} modes and {MOST_DRIVES} drives")
    c, moved = np.empty((len(v), 2 * modes)), np.empty((len(v), 3))
    call("softening.c", "hysgen_softening", len(v), modes, drives, numbers, rate, most, v, c, moved)
    return c, moved


def softening_slopes(v: Floats, numbers: Floats, rate: float, run: tuple[Floats, Floats]) -> NDArray[np.float32]:
    """(n, p) dy/d(number) along a run of `softening_states`, in the order of the numbers; zero at its first sample."""
    v, numbers, c, moved = (np.ascontiguousarray(values, dtype=np.float64) for values in (v, numbers, *run))
    J = np.empty((len(v), numbers.size), dtype=np.float32)
    for first in range(0, numbers.size, SLOPES_TOGETHER):
        part = np.empty((len(v), min(SLOPES_TOGETHER, numbers.size - first)), dtype=np.float32)
        sizes = (len(v), len(numbers), v.shape[1])
        call("softening.c", "hysgen_softening_slopes", *sizes, numbers, rate, v, c, moved, first, part.shape[1], part)
        J[:, first : first + part.shape[1]] = part
    return J


def slew_limited(u_V: Floats, rise_V: float, fall_V: float, start_V: float) -> Floats:
    """Slew-rate limiter, v(k) = max(v(k-1) - fall, min(v(k-1) + rise, u(k))).

    u_V: (n,); rise_V, fall_V: largest steps up and down in one sample; start_V: v before the first sample.
    """
    u = np.ascontiguousarray(u_V, dtype=np.float64)
    out = np.empty(u.size)
    call("states.c", "hysgen_slew", u.size, u, rise_V, fall_V, start_V, out)
    return out


@dataclass(frozen=True, eq=False)
class Branch:
    """A filter share * numerator/denominator in z^-1, order 1 to 4: (order + 1,) coefficients, denominator[0] = 1."""

    share: float
    numerator: Floats
    denominator: Floats


@dataclass(frozen=True, eq=False)
class LinearPart:
    """Creep, then parallel filters F_j, then a delay.

        c(k) = direct x(k) + creep sum_i s_i(k) / 2,    s_i(k+1) = (1 - decay_i) x(k) + decay_i s_i(k),    x = h - h(0)
        y(k) = h(0) + sum_j F_j c(k - delay)

    decay: (states,), exp(-Ts/tau_i). delay: in samples; with a negative delay the last value is held at the end.
    Raises ValueError if a size is not supported.
    """

    creep: float
    decay: Floats
    branches: Sequence[Branch]
    delay: int
    direct: float = 1.0

    def __post_init__(self) -> None:
        if len(self.decay) > MOST_STATES or not 1 <= len(self.branches) <= MOST_BRANCHES:
            raise ValueError(f"at most {MOST_STATES} slow states, and 1 to {MOST_BRANCHES} branches")
        for branch in self.branches:
            taps = len(branch.numerator)
            if len(branch.denominator) != taps or not 2 <= taps <= MOST_ORDER + 1 or branch.denominator[0] != 1.0:
                raise ValueError(
                    "numerator and denominator need the same length, 2 to 5, and a leading 1 in the denominator"
                )


def linear_response(h: Floats, linear: LinearPart) -> Floats:
    """(m, n) response of `linear` to each row of h, (m, n). Before the record the input rested at h(0)."""
    out = np.empty(h.shape)
    call("response.c", "hysgen_respond", *_response_arguments(h, linear), h.shape[1], out)
    return out


def linear_response_rows(h: Floats, linear: LinearPart, rows: NDArray[np.int64]) -> Floats:
    """(m, r) the samples `rows`, (r,) rising, of the response of `linear` to each row of h, (m, n): `linear_response`.

    The result is in Fortran order, as h[:, rows] is. Raises ValueError for rows outside h.
    """
    columns, samples = h.shape
    if len(rows) and not (rows[0] >= 0 and rows[-1] < samples and bool((rows[1:] > rows[:-1]).all())):
        raise ValueError("the rows must rise within the samples of h")
    out = np.empty((len(rows), columns))
    with_h = _response_arguments(h, linear)
    chosen = np.ascontiguousarray(rows, dtype=np.int64)
    call("response.c", "hysgen_respond_rows", *with_h, len(rows), chosen, 1, columns, out)
    return out.T


def _response_arguments(h: Floats, linear: LinearPart) -> tuple[Any, ...]:
    """The C arguments that describe h and `linear`."""
    branches = linear.branches
    orders = np.array([len(branch.numerator) - 1 for branch in branches], dtype=np.uintp)
    coefficients = np.zeros((2, len(branches), MOST_ORDER + 1))
    for j, branch in enumerate(branches):
        coefficients[0, j, : orders[j] + 1] = branch.numerator
        coefficients[1, j, : orders[j] + 1] = branch.denominator
    return (
        *h.shape,
        np.ascontiguousarray(h),
        len(linear.decay),
        linear.direct,
        linear.creep,
        np.ascontiguousarray(linear.decay),
        1.0 - linear.decay,
        len(branches),
        np.array([branch.share for branch in branches]),
        orders,
        coefficients[0],
        coefficients[1],
        linear.delay,
    )


@dataclass(frozen=True, eq=False)
class PreisachBasis:
    """Functions that a Preisach operator is expanded in.

    half_width: (m,) of the plays. hat: (m, b) weights of the plays in each of b hat functions of the half-width.
    curve, degree: highest Chebyshev polynomial of the input and of the plays. relaxation: s_j / r_j of plays that relax
    by thermal activation (`model.path.hysteresis`), 0 for plays that do not.
    """

    half_width: Floats
    hat: Floats
    curve: int
    degree: int
    relaxation: float = 0.0


def preisach_columns(out: Floats, v: Floats, start: Floats, basis: PreisachBasis) -> None:
    """Write the columns of a Preisach operator: T_1(v) .. T_curve(v), then for each power p and each hat b

        sum_i hat_ib T_p(z_i),    z_i(k) = max(v(k) - r_i, min(v(k) + r_i, z_i(k-1)))

    v: (n,); start: (m,) z_i before the first sample; out: (curve + degree * b, n), overwritten.
    Raises ValueError for more than 64 plays, for degree * b above 128, or if `out` has another shape.
    """
    (plays, hats), curve, degree = basis.hat.shape, basis.curve, basis.degree
    if plays > 64 or degree * hats > 128:
        raise ValueError("at most 64 plays, and 128 hats times powers")
    if out.shape != (curve + degree * hats, v.size):
        raise ValueError("the result needs a row for each polynomial, and for each power of each hat")
    call(
        "preisach.c",
        "hysgen_preisach",
        v.size,
        np.ascontiguousarray(v),
        plays,
        np.ascontiguousarray(basis.half_width),
        basis.relaxation,
        np.array(start, dtype=np.float64),
        hats,
        np.ascontiguousarray(basis.hat),
        curve,
        degree,
        out,
    )


def preisach_path(v: Floats, start: Floats, basis: PreisachBasis, weights: Floats) -> Floats:
    """(n,) weights @ columns, for the columns of `preisach_columns`, which are not formed.

    weights: (curve + degree * b,). Raises ValueError if there are more or fewer.
    """
    plays, hats = basis.hat.shape
    if weights.shape != (basis.curve + basis.degree * hats,):
        raise ValueError("one weight for each polynomial, and for each power of each hat")
    of_plays = basis.hat @ weights[basis.curve :].reshape(basis.degree, hats).T
    out = np.empty(v.size)
    call(
        "preisach.c",
        "hysgen_preisach_path",
        v.size,
        np.ascontiguousarray(v),
        plays,
        np.ascontiguousarray(basis.half_width),
        basis.relaxation,
        np.array(start, dtype=np.float64),
        basis.curve,
        np.ascontiguousarray(weights[: basis.curve]),
        basis.degree,
        np.ascontiguousarray(of_plays),
        out,
    )
    return out


def duhem_columns(out: Floats, v: Floats, reach: Floats) -> None:
    """Write d_j and d_j |d_j| of the Duhem states d_j' = (sign(v') - d_j) |v'| / reach_j, d_j(0) = 0.

    v: (n,); reach: (m,); out: (2 m, n), overwritten, rows d_1, d_1 |d_1|, d_2, ...
    Raises ValueError if `out` has another shape.
    """
    if out.shape != (2 * reach.size, v.size):
        raise ValueError("the result needs two rows for each reach")
    call("preisach.c", "hysgen_duhem", v.size, np.ascontiguousarray(v), reach.size, np.ascontiguousarray(reach), out)


@dataclass(frozen=True, eq=False)
class HysteresisSeries:
    """Coefficients of a hysteresis operator, all for inputs in [-1, 1].

    curve: (C + 1,) of T_0(v) .. T_C(v). half_width: (m,) of the plays. plays: (m, degree) of T_1(z_j) .. T_degree(z_j).
    reach: (s,) of the Duhem states. duhem: (s, 2) of d_i and d_i |d_i|. relaxation: s_j / r_j of plays that relax.
    """

    curve: Floats
    half_width: Floats
    plays: Floats
    reach: Floats
    duhem: Floats
    relaxation: float = 0.0


def hysteresis_path(series: HysteresisSeries, v: Floats, state: Floats) -> tuple[Floats, Floats]:
    """Displacement h(k) along the input v, (n,), and the state after the last sample.

    state: plays z_j, Duhem states d_i, and the input before the first sample, (m + s + 1,).
    """
    return _along("hysgen_hysteresis", series, v, state)


def hysteresis_inverse(series: HysteresisSeries, wanted: Floats, state: Floats) -> tuple[Floats, Floats]:
    """The input v(k) in -1 .. 1, (n,), along which h(k) is `wanted`, and the state after the last sample.

    Where no v(k) gives the wanted h(k), the end of -1 .. 1 that comes nearer. h must rise or fall with v.
    """
    return _along("hysgen_hysteresis_inverse", series, wanted, state)


def _along(function: str, series: HysteresisSeries, values: Floats, state: Floats) -> tuple[Floats, Floats]:
    after, out = np.array(state, dtype=np.float64), np.empty(values.size)
    arrays = (series.curve, series.half_width, series.plays, series.reach, series.duhem)
    curve, half_width, plays, reach, duhem = (np.ascontiguousarray(x, dtype=np.float64) for x in arrays)
    call(
        "preisach.c",
        function,
        values.size,
        np.ascontiguousarray(values, dtype=np.float64),
        curve.size,
        curve,
        half_width.size,
        plays.shape[1] if plays.ndim == 2 else 0,
        half_width,
        series.relaxation,
        plays,
        reach.size,
        reach,
        duhem,
        after,
        out,
    )
    return out, after

"""Integral and filter of the largest bandwidth that keeps its margins for every draw of the uncertainty.

    L(z) = K/2 (z + 1)/(z - 1) F(z) P(z),   F(1) = 1
    F = prod_m (s^2 + 2 n_m v_m s + v_m^2)/(s^2 + 2 d_m w_m s + w_m^2) w_m^2/v_m^2

The integral is a trapezoid: its zero at half the sampling rate meets what rings there, the zeros of sampled modes in
the inverse. n_m, d_m, v_m, w_m of a notch are free: a narrow one damps nothing, a wide one below the mode turns its
phase (resonant damping). The margins are an ellipse about -1, over phase and logarithm of |L|, that no draw enters:

    (phase/45 deg)^2 + (20 log10 |L| / 6 dB)^2 >= 1

and where the phase is within 45 degrees of -180, |L| < 1. The open loop is stable but for its integral, so L does not
encircle -1, and K is given by F in closed form. F is found by Nelder and Mead from several starts.
Source: Nichols' exclusion region, as GARTEUR TP-088-7 (1997) and MIL-F-9490D ask for; here 45 degrees, and an ellipse.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy  # its parts are imported where they work
from numpy.typing import NDArray
from scipy.optimize import minimize

from hysgen.feedback.stage import natural
from hysgen.model.path.modes import MOST_DAMPING
from hysgen.model.path.structure import Structure

Floats = NDArray[np.float64]
Complex = NDArray[np.complex128]

GAIN_MARGIN_DB, PHASE_MARGIN_DEG = 6.0, 45.0

MOST_NOTCHES = 3
"""Notches of a filter: each costs a mode of the structure block in every sample."""

PLACES, DAMPINGS = (1.0, 2.0, 4.0), (0.3, 0.7, 0.95)
"""Frequencies of a notch's poles against its mode, and their damping ratios, from which the search begins."""

LEAST_POLE, LEAST_ZERO, MOST_ZERO = 0.2, 1e-3, 2.0
"""Least damping ratio of the poles, so that the filter itself does not ring; least and largest of the zeros."""

EVALUATIONS, EDGE = 150, 0.2
"""Evaluations of the search for each number of the filter, and the edge of its first simplex, in logarithms."""

LARGEST_WEIGHT = 100.0
"""Largest weight of a mode of the filter: beyond it two weights cancel, and float32 loses two digits."""


@dataclass(frozen=True)
class Notch:
    """Zeros of frequency v and damping ratio n, poles of w and d; frequencies in Hz."""

    zero_Hz: float
    zero_damping: float
    pole_Hz: float
    pole_damping: float


def zpk(notches: tuple[Notch, ...], Ts_s: float) -> tuple[Complex, Complex, float]:
    """Zeros, poles and gain of F(z) by the bilinear transform; F(1) = 1."""
    zeros = [_pair(notch.zero_Hz, notch.zero_damping) for notch in notches]
    poles = [_pair(notch.pole_Hz, notch.pole_damping) for notch in notches]
    z, p, _ = scipy.signal.bilinear_zpk(np.ravel(zeros), np.ravel(poles), 1.0, 1.0 / Ts_s)
    return z, p, float(np.real(np.prod(1.0 - p) / np.prod(1.0 - z)))


def filter_block(notches: tuple[Notch, ...], Ts_s: float) -> Structure | None:
    """F as a structure of as many modes, whose mirror, C and proof it shares; None for F = 1.

    F(z) = D + sum_m Re(W_m s_m/(z - p_m)),   W_m = 2 Res F(p_m)/s_m,   s_m = 1 - p_m,   Q_m = W_m/p_m
    """
    if not notches:
        return None
    z, p, k = zpk(notches, Ts_s)
    modes = []
    # The structure block turns clockwise: its poles have imaginary parts below 0.
    for pole in p[p.imag < 0.0]:
        others = p[np.abs(p - pole) > 0.0]
        residue = k * np.prod(pole - z) / np.prod(pole - others)
        weight = 2.0 * residue / (1.0 - pole) / pole
        modes.append((*natural(pole, Ts_s), weight.real, weight.imag))
    f_Hz, zeta, share, quadrature = (tuple(map(float, row)) for row in zip(*sorted(modes), strict=True))
    # A lag that is gone within a sample: the filter stands before no rules.
    return Structure(f_Hz, zeta, share, Ts_s / 40.0, quadrature, Ts_s)


def largest_gains(loops: Complex) -> Floats:
    """(draws,) Largest K with which a row of K loops, (draws, frequencies), stays out of the ellipse and below it."""
    away = np.abs(np.angle(-loops, deg=True)) / PHASE_MARGIN_DEG
    limit_dB = -GAIN_MARGIN_DB * np.sqrt(np.maximum(1.0 - away**2, 0.0))
    return np.asarray(np.where(away < 1.0, 10.0 ** (limit_dB / 20.0) / np.abs(loops), np.inf).min(axis=1))


def bandwidths_Hz(loops: Complex, f_Hz: Floats) -> Floats:
    """-3 dB frequency of every closed loop L/(1 + L), (draws,): the lowest, read on a logarithmic axis."""
    closed_dB = 20.0 * np.log10(np.abs(loops / (1.0 + loops))) + 10.0 * math.log10(2.0)
    below = closed_dB < 0.0
    k = np.where(below.any(axis=1), np.argmax(below, axis=1), f_Hz.size - 1)
    k = np.maximum(k, 1)
    rows = np.arange(k.size)
    high, low = closed_dB[rows, k - 1], closed_dB[rows, k]
    share = np.clip(high / np.where(high > low, high - low, 1.0), 0.0, 1.0)
    return np.asarray(f_Hz[k - 1] * (f_Hz[k] / f_Hz[k - 1]) ** share)


def best_filter(
    stages: Complex, f_Hz: Floats, Ts_s: float, starts: Sequence[Sequence[tuple[float, float]]]
) -> tuple[Notch, ...]:
    """The notches with the largest least bandwidth over the rows of `stages`.

    stages: (draws, frequencies) P with the integral (z + 1)/2(z - 1). starts: sets of frequency in Hz and damping ratio
    at which notches begin.
    """
    z = np.exp(2j * math.pi * f_Hz * Ts_s)

    def bandwidth(x: Floats) -> float:
        notches = of(x)
        block = filter_block(notches, Ts_s)
        if block is not None and np.abs(block.residues()).max() > LARGEST_WEIGHT:
            return 0.0
        zeros, poles, k = zpk(notches, Ts_s)
        loops = stages * k * np.prod(z - zeros[:, None], axis=0) / np.prod(z - poles[:, None], axis=0)
        return float(bandwidths_Hz(largest_gains(loops).min() * loops, f_Hz).min())

    def of(x: Floats) -> tuple[Notch, ...]:
        v, n, w, d = np.exp(x.reshape(-1, 4)).T
        hertz = [np.clip(f, f_Hz[0], 0.3 / Ts_s).tolist() for f in (v, w)]
        zeros, poles = np.clip(n, LEAST_ZERO, MOST_ZERO).tolist(), np.clip(d, LEAST_POLE, MOST_DAMPING).tolist()
        return tuple(map(Notch, hertz[0], zeros, hertz[1], poles))

    best = bandwidth(np.zeros(0)), np.zeros(0)
    search: Any = minimize
    for lines in (lines[:MOST_NOTCHES] for lines in starts if lines):
        # The poles of notches stand apart, or their weights would be large.
        grid = [
            np.log([[f, n, place * f * 1.05**i, d] for i, (f, n) in enumerate(lines)]).ravel()
            for place in PLACES
            for d in DAMPINGS
        ]
        start = max(grid, key=bandwidth)
        simplex = np.vstack([start, start + EDGE * np.eye(start.size)])
        options = {"maxfev": EVALUATIONS * start.size, "initial_simplex": simplex}
        answer = search(lambda x: -bandwidth(x), start, method="Nelder-Mead", options=options)
        best = max(best, (-float(answer.fun), answer.x), key=lambda pair: pair[0])
    return of(best[1])


def _pair(f_Hz: float, damping: float) -> list[complex]:
    root = np.sqrt(complex(damping**2 - 1.0))
    return [2.0 * math.pi * f_Hz * (-damping + root), 2.0 * math.pi * f_Hz * (-damping - root)]

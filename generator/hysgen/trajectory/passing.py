"""What the stage passes beside its model, by what was played, and how much of an error that allows to learn.

    Y = T M + N,   T = P'/P = T_d + sum_t h(t) z^-t / P,   |N|^2 = s^2 + |P|^2 H

M and Y are spectra of what a play changed in the answer of the model and in that of the stage, which cancels what
repeats; the first play counts as a change from rest. T_d is a draw of the uncertainty of the model, h is small and soon
over, as of modes that the model lacks. Gain, lag, delay, shares of the modes and h are estimated by least squares from
their uncertainty on (Gauss and Newton). s: of the reading. H: what hystereses do otherwise than the model, as a
voltage, smooth over frequency; it rings near a mode as the answer does, so lines near one are left out. Then

    q = mean conj T / (mean |T|^2 + (p/|P|)^2)

over draws of what is left of the uncertainty: the q that leaves least of an error e in the mean square. Where the stage
passes the share |P| of what it passes at rest, mending e moves the voltage by e/|P| and hystereses with it, which move
otherwise than the model says by the share p of what that voltage moves at rest.
Source: Pillonetto and De Nicolao, Automatica 46 (2010) 81-93, the impulse response as a draw of a decaying process.
"""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import pairwise, product

import numpy as np
import scipy  # its parts are imported where they work
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from hysgen.feedback.stage import Uncertainty, draws, frequencies, modes_of, response
from hysgen.feedback.stage import stage as stage_of
from hysgen.model.model import Model

Floats = NDArray[np.float64]
Complex = NDArray[np.complex128]

BESIDE, REMEMBERED, TAPS = 0.05, 150.0, np.arange(-4, 300)
"""Standard deviation of what passes beside the model, as a share of what the stage passes at rest; samples in which the
power of its impulse response falls by e; delays of it in samples."""

DRAWS, ROUNDS, MOST = 64, 3, 8.0
"""Draws of the stage; rounds of Gauss and Newton; half widths of the uncertainty that a number may be off by."""

NEAR_MODE, SMOOTH, TAPER = 0.15, 0.35, 0.1
"""Share of its frequency to both sides of a mode whose lines are left out, and of a frequency over which H is averaged;
share of a record that fades in and out."""

PIECE = 8192
"""Rows of a spectrum at most: a longer record is several."""

LEAST_KNOWN, SURE = 0.2, 0.95
"""Share of the power of T, over the draws, that its mean has where it is known at all; share of the draws that leave no
more than is said."""


@dataclass(frozen=True, eq=False)
class Passing:
    """units: (draws, d) of `feedback.stage`; beside: (draws, taps) h; otherwise: p."""

    units: Floats
    beside: Floats
    otherwise: float


def passing(
    model: Model, answers: Sequence[Floats], missed: Sequence[Floats], counts: Sequence[int], noise_um: float
) -> Passing:
    """Draws of what the stage passes after plays, each a mean over counts.

    answers: of the model, (lead + n,), the last n along the reference; missed: (n,) reading less answer.
    """
    n, first = missed[0].size, draws(model)[:DRAWS]
    rows, d = n // math.ceil(n / PIECE), first.shape[1]
    f_Hz, free = np.arange(rows // 2 + 1) / (rows * model.Ts_s), [0, 1, 2, *range(6, d, 3)]
    (P, T), taper = _ratio(model, f_Hz), scipy.signal.windows.tukey(rows, TAPER)
    changes = _changes(model, answers, missed, counts)

    def pieces() -> Iterator[tuple[Complex, Complex, Complex, float]]:
        """Spectra of what moved, of that beside the model by delay, of what was missed, and power of its noise."""
        for (m, v, e, by), k in product(changes, range(0, n - rows + 1, rows)):
            # Each delay in time: a window after it would show next to a strong line what is none.
            late = sliding_window_view(v, rows)[m.size - n + k - TAPS + TAPS.size]
            m, e = m[m.size - n + k :][:rows], e[k : k + rows]
            noise = noise_um**2 * by * float(np.sum(taper**2))
            yield np.fft.rfft(taper * m), np.fft.rfft(taper * late), np.fft.rfft(taper * e), noise

    gain, smooth = np.abs(P), partial(mean_near, least=3, share=SMOOTH)
    used = np.all([np.abs(f_Hz / mode_Hz - 1.0) > NEAR_MODE for mode_Hz, _ in modes_of(model)], axis=0) & (f_Hz > 0.0)
    unit, h, p = np.zeros(d), np.zeros(TAPS.size), len(free)
    decay = np.exp(-np.abs(TAPS) / REMEMBERED)
    prior = np.concatenate([np.ones(p), np.sum(decay) / (BESIDE**2 * decay)])
    for _ in range(ROUNDS):
        slopes = np.array([(T(unit + 0.02 * e) - T(unit - 0.02 * e)) / 0.04 for e in np.eye(d)[free]])
        now, curvature, moved, others = np.append(unit[free], h), np.diag(prior), [], []
        along = -prior * now
        for M, beside, missing, noise in pieces():
            rest = missing - (T(unit) - 1.0) * M - h @ beside
            moved.append(float(np.sum(np.abs(M / P) ** 2)))
            others.append(float(np.sum(np.abs(rest) ** 2 - noise)))
            H = smooth(np.maximum(np.abs(rest) ** 2 - noise, 0.0)) / smooth(gain**2)
            weight = np.sqrt(used / (noise + gain**2 * H))
            seen, rest = weight * np.concatenate([slopes * M, beside]), weight * rest
            parts = np.concatenate([seen.real, seen.imag], axis=1)
            curvature = curvature + 2.0 * (parts @ parts.T)
            along = along + 2.0 * parts @ np.concatenate([rest.real, rest.imag])
        now += np.linalg.solve(curvature, along)
        unit[free], h = np.clip(now[:p], -MOST, MOST), now[p:]
    spread = np.linalg.inv(np.linalg.cholesky(curvature))
    off = np.random.default_rng(0).standard_normal((DRAWS, p + h.size)) @ spread
    units = first.copy()
    units[:, free] = np.clip(unit[free] + off[:, :p], -MOST, MOST)
    later = len(moved) // len(missed)
    return Passing(units, h + off[:, p:], math.sqrt(max(sum(others[later:]), 0.0) / max(sum(moved[later:]), 1e-300)))


def _changes(
    model: Model, answers: Sequence[Floats], missed: Sequence[Floats], counts: Sequence[int]
) -> list[tuple[Floats, Floats, Floats, float]]:
    """What each play changed, the first from rest: answers of the model along the reference and up to TAPS rows before,
    their voltages M/P with TAPS rows more at both ends, what was missed, and the variance of its noise in readings."""
    n = missed[0].size
    plays = [(m[-n - TAPS.size :], e, 1.0 / count) for m, e, count in zip(answers, missed, counts, strict=True)]
    size = scipy.fft.next_fast_len(plays[0][0].size + 4 * TAPS.size)
    P, _ = _ratio(model, np.arange(size // 2 + 1) / (size * model.Ts_s))
    changes = []
    for (m0, e0, by0), (m1, e1, by1) in pairwise([(0.0 * plays[0][0], 0.0 * missed[0], 0.0), *plays]):
        m, e = m1 - m0, e1 - e0
        held = np.pad(m - m[0], TAPS.size, "edge")
        v = np.fft.irfft(np.fft.rfft(held, size) / P, size)[: held.size]
        # A constant is no part of a spectrum that is looked at.
        changes.append((m - m[-n:].mean(), v - v[-n - TAPS.size : -TAPS.size].mean(), e - e.mean(), by0 + by1))
    return changes


def learnt(model: Model, passed: Passing, f_Hz: Floats) -> tuple[Complex, Floats]:
    """q at each frequency, (n,), 0 where the stage is not known, and the share of an error that it leaves, at most."""
    parts = 2 * TAPS.size
    grid_Hz = np.union1d(frequencies(model, Uncertainty()), np.arange(1, parts) / (2 * parts * model.Ts_s))
    P, T_of = _ratio(model, grid_Hz)
    T = np.array([T_of(unit) for unit in passed.units]) + passed.beside @ (_beside(model, grid_Hz) / P)
    mean, power = T.mean(axis=0), np.mean(np.abs(T) ** 2, axis=0)
    q = np.conj(mean) / (power + (passed.otherwise / np.abs(P)) ** 2)
    q[np.abs(mean) ** 2 < LEAST_KNOWN * power] = 0.0
    leaves = np.quantile(np.abs(1.0 - q * T), SURE, axis=0)
    return np.interp(f_Hz, grid_Hz, q), np.interp(f_Hz, grid_Hz, leaves)


def _ratio(model: Model, f_Hz: Floats) -> tuple[Complex, Callable[[Floats], Complex]]:
    """P at frequencies, (n,), and T_d of a draw, (d,)."""
    z = np.exp(2j * math.pi * f_Hz * model.Ts_s)

    def passes(unit: Floats) -> Complex:
        return response(stage_of(model, unit, Uncertainty(), 1.0), z)

    P = passes(np.zeros(draws(model).shape[1]))
    return P, lambda unit: passes(unit) / P


def _beside(model: Model, f_Hz: Floats) -> Complex:
    """z^-t of each delay, (taps, n)."""
    return np.asarray(np.exp(-2j * math.pi * model.Ts_s * np.outer(TAPS, f_Hz)))


def mean_near(values: Floats, least: int, share: float) -> Floats:
    """Mean near each frequency: over `least` lines and a share of the frequency to both sides."""
    sums, k = np.concatenate([[0.0], np.cumsum(values)]), np.arange(values.size)
    half = least + (share * k).astype(np.int64)
    low, high = np.maximum(k - half, 0), np.minimum(k + half + 1, values.size)
    return np.asarray((sums[high] - sums[low]) / (high - low))

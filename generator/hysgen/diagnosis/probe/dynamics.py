"""The linear part of the chain, exact for an input that is held between samples."""

from __future__ import annotations

import functools
import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import expm

from hysgen.diagnosis.probe.chain import Chain
from hysgen.diagnosis.probe.part import Mode
from hysgen.machine.kernels import Branch, LinearPart, linear_response, linear_response_rows

Floats = NDArray[np.float64]


def respond(h: Floats, chain: Chain, Ts_s: float) -> Floats:
    """Response of slow states, modes, lag and delay to h, (n,) or (m, n) along the last axis; h(k) = h(0) for k < 0.

    y(k) depends on h(k-1), h(k-2), ...: every record has one sample of delay.
    """
    out = np.empty(np.atleast_2d(h).shape)
    respond_into(out, 0, np.atleast_2d(h), chain, Ts_s)
    return out.reshape(h.shape)


def respond_into(out: Floats, first: int, h: Floats, chain: Chain, Ts_s: float, whole_run: float = 0.0) -> None:
    """`respond` of h, (m, n), written to out[:, first : first + n].

    whole_run: samples of the segment of h, on which the slowest of the slow states depends; 0 for n.
    """
    linear_response(h, _linear_part(chain, Ts_s, whole_run or float(h.shape[-1])), out, first)


def respond_on_rows(h: Floats, chain: Chain, Ts_s: float, rows: NDArray[np.intp]) -> Floats:
    """(m, r) the samples `rows`, (r,) rising, of `respond` of h, (m, n); in Fortran order."""
    return linear_response_rows(h, _linear_part(chain, Ts_s, float(h.shape[-1])), rows)


def _linear_part(chain: Chain, Ts_s: float, samples: float) -> LinearPart:
    """Slow states, modes, lag and delay of the chain. samples: length of the segment."""
    slow = chain.slow_states(samples, Ts_s)
    branches, whole = _branches(chain.lag_s, chain.delay, chain.modes, Ts_s)
    return LinearPart(slow.share, slow.keep, branches, whole)


def lagged(signals: Floats, lag_s: float, delay: float, Ts_s: float, rows: NDArray[np.intp] | None = None) -> Floats:
    """(m, n) response of the lag and the delay alone to signals, (m, n), constant before their first sample.

    rows: (r,) rising samples of the result, (m, r); None for all.
    """
    branches, whole = _branches(lag_s, delay, (), Ts_s)
    linear = LinearPart(0.0, np.zeros(0), branches, whole)
    if rows is not None:
        return linear_response_rows(signals, linear, rows)
    out = np.empty(signals.shape)
    linear_response(signals, linear, out, 0)
    return out


def _branches(lag_s: float, delay: float, modes: Sequence[Mode], Ts_s: float) -> tuple[list[Branch], int]:
    """Branches with the fractional delay (lag with the share of no mode, lag with each mode), and the whole delay."""
    whole = math.floor(delay)
    late = delay - whole
    stiff = 1.0 - sum(mode.share for mode in modes)
    branches = [Branch(stiff, *_lag(lag_s, None, Ts_s, late))]
    return branches + [Branch(mode.share, *_lag(lag_s, mode, Ts_s, late)) for mode in modes], whole


@functools.lru_cache(maxsize=64)
def _lag(lag_s: float, mode: Mode | None, Ts_s: float, late: float) -> tuple[Floats, Floats]:
    """Transfer function in z of lag (and mode) behind a zero-order hold, late by `late` < 1 samples.

    Over one period the older held value acts for late * Ts, then the newer one:
        x(k+1) = Phi x(k) + G_new h(k) + G_old h(k-1),   y = c x
    """
    if mode is None:
        a, a_new = math.exp(-Ts_s / lag_s), math.exp(-(1.0 - late) * Ts_s / lag_s)
        # The older value acts for the first late * Ts of the period and decays until the end.
        return np.array([0.0, 1.0 - a_new, a_new - a]), np.array([1.0, -a, 0.0])
    w = 2.0 * math.pi * mode.f_Hz
    A = np.array([[-1.0 / lag_s, 1.0 / lag_s, 0.0], [0.0, 0.0, 1.0], [0.0, -w * w, -2.0 * mode.zeta * w]])
    b = np.array([0.0, 0.0, w * w])
    whole, part = _held(A, b, Ts_s), _held(A, b, (1.0 - late) * Ts_s)
    phi, g_new = whole[0], part[1]
    g_old = whole[1] - g_new
    denominator = np.real(np.poly(np.linalg.eigvals(phi)))
    numerator = np.zeros(5)
    for g, step in ((g_new, 0), (g_old, 1)):
        # Markov parameters of (phi, g, c) times the denominator give the numerator.
        pulse, state = np.zeros(3), g
        for i in range(3):
            pulse[i] = state[0]
            state = phi @ state
        numerator[1 + step : 4 + step] += np.convolve(pulse, denominator)[:3]
    return numerator, np.append(denominator, 0.0)


def _held(A: Floats, b: Floats, t_s: float) -> tuple[Floats, Floats]:
    """(exp(A t), integral of exp(A s) b ds over 0..t)."""
    size = len(b)
    block = np.zeros((size + 1, size + 1))
    block[:size, :size], block[:size, size] = A, b
    e = np.asarray(expm(block * t_s))
    return e[:size, :size], e[:size, size]

"""The linear part of the chain, exact for an input that is held between samples."""

from __future__ import annotations

import functools
import math

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import expm

from hysgen.diagnosis.probe.chain import Chain, Mode
from hysgen.machine.kernels import Branch, LinearPart, linear_response

Floats = NDArray[np.float64]


def respond(h: Floats, chain: Chain, Ts_s: float) -> Floats:
    """What creep, modes, lag and delay make of h, (n,) or (m, n) along the last axis; at rest before the record.

    y(k) answers h(k-1), h(k-2), ... : one sample of delay is in every record.
    """
    out = np.empty(np.atleast_2d(h).shape)
    respond_into(out, 0, np.atleast_2d(h), chain, Ts_s)
    return out.reshape(h.shape)


def respond_into(out: Floats, first: int, h: Floats, chain: Chain, Ts_s: float) -> None:
    """`respond` of h, (m, n), written to out[:, first : first + n]."""
    whole = math.floor(chain.delay)
    late = chain.delay - whole
    keep = np.zeros(0)
    if chain.creep is not None:
        keep = np.exp(-Ts_s / creep_times_s(chain.creep_from_s, _slowest_s(h.shape[-1], Ts_s)))
    stiff = 1.0 - sum(mode.share for mode in chain.modes)
    branches = [Branch(stiff, *_lag(chain.lag_s, None, Ts_s, late))]
    branches += [Branch(mode.share, *_lag(chain.lag_s, mode, Ts_s, late)) for mode in chain.modes]
    linear_response(h, LinearPart(chain.creep or 0.0, keep, branches, whole), out, first)


def crept_step(samples: int, Ts_s: float, from_s: float) -> Floats:
    """(samples,) logarithmic creep of a unit step at the first one, per unit of `creep` per decade.

    sum_i (1 - exp(-t / tau_i)) / 2,    two tau_i per decade, as `respond` has them
    """
    t_s = Ts_s * np.arange(samples)
    return np.asarray(sum(-0.5 * np.expm1(-t_s / tau_s) for tau_s in creep_times_s(from_s, _slowest_s(samples, Ts_s))))


def _slowest_s(samples: int, Ts_s: float) -> float:
    """Ten times the length of the record: slower creep cannot be told from standing still."""
    return 10.0 * samples * Ts_s


def creep_times_s(from_s: float, to_s: float) -> Floats:
    """Time constants, two per decade, from from_s to at most to_s."""
    count = max(1, int(2 * math.log10(to_s / from_s)) + 1)
    return np.asarray(from_s * 10.0 ** (0.5 * np.arange(count) + 0.25))


@functools.lru_cache(maxsize=64)
def _lag(lag_s: float, mode: Mode | None, Ts_s: float, late: float) -> tuple[Floats, Floats]:
    """Transfer function in z of lag (and mode) behind a zero-order hold, late by `late` < 1 samples.

    Over one period the older held value acts for late * Ts, then the newer one:
        x(k+1) = Phi x(k) + G_new h(k) + G_old h(k-1),   y = c x
    """
    if mode is None:
        a, a_new = math.exp(-Ts_s / lag_s), math.exp(-(1.0 - late) * Ts_s / lag_s)
        # An input that acted early in the period has decayed by its end.
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

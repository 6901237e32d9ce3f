"""Excitations that identify a piezo stage: each excites dynamics that a single sine does not.

Each begins and ends at a stated level, so that signals can be joined; `joining.safe` adds the ways from and to rest.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from hysgen.stage.signals.joining import SignalError, clock, require_resolved, travel

Floats = NDArray[np.float64]


def nested_amplitudes(
    Ts_s: float, frequencies_Hz: Sequence[float], centre_V: float, amplitude_V: float, cycles: int, grow: bool = True
) -> Floats:
    """At each frequency in turn: a sine whose amplitude falls to nothing and grows again.

        u(t) = centre + amplitude e(t) sin(2 pi f t),   e: 1 -> 0 over `cycles` periods, then (if `grow`) 0 -> 1

    Use: hysteresis. The turning points cover the Preisach plane around the centre, the falling half leaves nested
    loops behind and the growing half wipes them out; several frequencies separate lag from memory.
    Begins and ends at centre_V. Returns (n,) in V. Raises SignalError for an unresolved frequency or no cycles.
    """
    if cycles < 1 or not frequencies_Hz:
        raise SignalError(
            f"nested amplitudes: {len(frequencies_Hz)} frequencies of {cycles} cycles; give at least 1 each"
        )
    blocks = []
    for f_Hz in frequencies_Hz:
        require_resolved(Ts_s, f_Hz)
        whole = cycles * (2 if grow else 1)
        turns = f_Hz * clock(Ts_s, whole / f_Hz)
        envelope = np.abs(1.0 - turns / cycles)
        blocks.append(centre_V + amplitude_V * envelope * np.sin(2 * np.pi * turns))
    return np.append(np.concatenate(blocks), centre_V)


def reversal_curves(Ts_s: float, low_V: float, high_V: float, curves: int, rate_V_per_s: float) -> Floats:
    """First-order reversal curves: from high_V down to one of `curves` levels and up again, each level lower.

    Use: the whole Preisach plane. Together the curves cross every relay inside low_V .. high_V, at a constant |du/dt|,
    so that a lag shifts all curves equally. The corners of the triangles excite modes: keep the rate low.
    Begins and ends at low_V. Returns (n,) in V. Raises SignalError for an empty range, or a rate that cannot follow.
    """
    if not (low_V < high_V and curves >= 1):
        raise SignalError(
            f"reversal curves: {curves} between {low_V} and {high_V} V; give at least 1, and low below high"
        )
    if not 0 < rate_V_per_s * Ts_s <= (high_V - low_V) / (4 * curves):
        raise SignalError(
            f"rate_V_per_s: {rate_V_per_s} V/s leaves a curve with fewer than 4 samples; choose a lower one"
        )
    levels_V = high_V - (high_V - low_V) * np.arange(1, curves + 1) / curves
    corners_V = np.array([low_V, *(v for level in levels_V for v in (high_V, float(level))), high_V, low_V])
    at_s = np.concatenate(([0.0], np.cumsum(np.abs(np.diff(corners_V)) / rate_V_per_s)))
    # Corners on samples: otherwise the turning points would depend on the sampling period.
    at_s = np.round(at_s / Ts_s) * Ts_s
    return np.append(np.interp(clock(Ts_s, float(at_s[-1])), at_s, corners_V), low_V)


def plateaus(Ts_s: float, levels_V: Sequence[float], hold_s: float, travel_s: float) -> Floats:
    """Levels held for hold_s each, with smooth transitions of travel_s between them (0: plain steps).

    Use: creep and drift, with long holds; modes and delay, with short transitions: one of half a mode's period or less
    makes the mode ring. Begins at the first level, ends at the last. Returns (n,) in V.
    Raises SignalError without levels, or for a hold without samples.
    """
    if len(levels_V) == 0 or travel_s < 0:
        raise SignalError(f"plateaus: {len(levels_V)} levels, ways of {travel_s} s; give a level, and a time from 0 up")
    held = len(clock(Ts_s, hold_s))
    pieces: list[Floats] = [np.full(held, levels_V[0], dtype=np.float64)]
    for from_V, to_V in itertools.pairwise(levels_V):
        pieces += [travel(Ts_s, from_V, to_V, travel_s), np.full(held, to_V, dtype=np.float64)]
    return np.concatenate(pieces)


def multisine(
    Ts_s: float,
    low_Hz: float,
    high_Hz: float,
    period_s: float,
    periods: int,
    centre_V: float,
    amplitude_V: float,
    seed: int = 0,
) -> Floats:
    """Random-phase multisine: every multiple of 1/period_s in low_Hz .. high_Hz, equal amplitudes, whole periods.

        u(t) = centre + a sum_n cos(2 pi n t / period + phi_n),   phi_n uniform from `seed`

    amplitude_V is the largest |u - centre|.
    Use: frequency responses (lag, modes, delay) and, from the difference of the periods, the noise floor.
    The wave is rotated to begin and end where it crosses the centre, within one sample's step. Returns (n,) in V.
    Raises SignalError if no line lies in the band, or the period is not a whole number of samples.
    """
    require_resolved(Ts_s, high_Hz)
    n = len(clock(Ts_s, period_s))
    if abs(n * Ts_s - period_s) > 1e-6 * Ts_s:
        raise SignalError(f"period_s: {period_s} s is not a whole number of {Ts_s} s samples; round it")
    first, last = math.ceil(low_Hz * period_s - 1e-9), math.floor(high_Hz * period_s + 1e-9)
    if periods < 1 or not 1 <= first <= last:
        raise SignalError(
            f"multisine: no line of 1/{period_s} s in {low_Hz} .. {high_Hz} Hz; widen it, or lengthen period_s"
        )
    spectrum = np.zeros(n // 2 + 1, dtype=np.complex128)
    phases = np.random.default_rng(seed).uniform(0, 2 * np.pi, last - first + 1)
    spectrum[first : last + 1] = np.exp(1j * phases)
    wave = np.fft.irfft(spectrum, n)
    wave *= amplitude_V / np.abs(wave).max()
    rising = np.flatnonzero((wave >= 0) & (np.roll(wave, 1) < 0))
    start = rising[np.argmin(wave[rising])]
    return np.asarray(centre_V + np.tile(np.roll(wave, -start), periods), dtype=np.float64)


def chirp(Ts_s: float, low_Hz: float, high_Hz: float, duration_s: float, centre_V: float, amplitude_V: float) -> Floats:
    """Sine whose frequency rises exponentially from low_Hz to high_Hz, faded in and out over a tenth of the time.

        u(t) = centre + amplitude fade(t) sin(2 pi low T / ln(high/low) ((high/low)^(t/T) - 1))

    Use: frequencies and damping of modes, with equal time in every octave. Begins and ends at centre_V.
    Returns (n,) in V. Raises SignalError for a band that is empty, too short or not resolved.
    """
    require_resolved(Ts_s, high_Hz)
    if not 0 < low_Hz < high_Hz:
        raise SignalError(
            f"chirp: the band {low_Hz} .. {high_Hz} Hz is empty; low_Hz must be above 0 and below high_Hz"
        )
    t = clock(Ts_s, duration_s)
    if duration_s * low_Hz < 1:
        raise SignalError(f"duration_s: {duration_s} s is less than one period of {low_Hz} Hz; give it more")
    T_s, octaves = float(t[-1]), math.log(high_Hz / low_Hz)
    turns = low_Hz * T_s / octaves * np.expm1(octaves * t / T_s)
    edge = np.clip(np.minimum(t, T_s - t) / (0.1 * T_s), 0.0, 1.0)
    fade = 0.5 * (1.0 - np.cos(np.pi * edge))
    return np.asarray(centre_V + amplitude_V * fade * np.sin(2 * np.pi * turns), dtype=np.float64)

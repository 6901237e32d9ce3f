"""Driving voltages as arrays: joined with limited jumps, excitations for identification, and the signals of the paper.

An excitation begins and ends at a stated level; `safe` adds the ways from and to rest. The docstring of a signal of
the paper, sections 4.1 to 4.3, states what the paper leaves open.
"""

import itertools
import math
from collections.abc import Sequence
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from hysgen.errors import HysgenError

Floats = NDArray[np.float64]


class SignalError(HysgenError):
    """A signal does not exist at the sampling period, or jumps by more than allowed."""


def clock(Ts_s: float, duration_s: float) -> Floats:
    """Instants k Ts_s of the samples in [0, duration_s): (round(duration_s / Ts_s),) in s. Raises SignalError."""
    _require_period(Ts_s)
    if not (math.isfinite(duration_s) and duration_s >= Ts_s / 2):
        raise SignalError(f"duration_s: {duration_s} s holds no sample of {Ts_s} s; ask for a longer signal")
    return Ts_s * np.arange(round(duration_s / Ts_s), dtype=np.float64)


def require_resolved(Ts_s: float, f_Hz: float) -> None:
    """Raise SignalError unless a period of f_Hz has 4 samples; with fewer, no sample is near an extreme."""
    _require_period(Ts_s)
    if not (math.isfinite(f_Hz) and 0 < f_Hz <= 0.25 / Ts_s * (1 + 1e-9)):
        limit = 0.25 / Ts_s
        raise SignalError(f"f_Hz: {f_Hz} Hz is not resolved by samples of {Ts_s} s; choose above 0, up to {limit:g} Hz")


def travel(Ts_s: float, from_V: float, to_V: float, duration_s: float) -> Floats:
    """Half a period of a cosine from one level to another, (n,), without the last point; n may be 0."""
    steps = round(duration_s / Ts_s)
    share = np.arange(steps, dtype=np.float64) / max(steps, 1)
    return from_V + (to_V - from_V) * 0.5 * (1.0 - np.cos(math.pi * share))


def _require_period(Ts_s: float) -> None:
    if not (math.isfinite(Ts_s) and Ts_s > 0):
        raise SignalError(f"Ts_s: {Ts_s} s is no sampling period; give a time above 0")


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


Part = Literal["identification", "validation"]

# Half peak-to-peak of each period of Fig. 5, V. The validation's amplitudes are others and stay inside the range.
FIG5_AMPLITUDES_V = {
    "identification": (20.0, 17.0, 14.0, 11.0, 8.0, 5.0, 6.5, 9.5, 12.5, 15.5, 18.5, 20.0),
    "validation": (19.0, 16.0, 13.0, 10.0, 7.0, 4.0, 6.0, 9.0, 12.0, 15.0, 18.0, 19.5),
}
FIG5_LOW_V, FIG5_HZ = 30.0, 100.0


def fig5(Ts_s: float, part: Part) -> Floats:
    """Fig. 5: sinusoidal profile of 100 Hz whose amplitude changes from period to period.

        u(t) = 30 V + A_j (1 - cos(2 pi 100 t)) in the j-th period,  A_j: FIG5_AMPLITUDES_V

    Use: the paper's rate-independent case, one frequency, nested loops, 12 periods (0.12 s). The paper prints no
    formula; a common lowest voltage and 30..70 V are chosen here because Appendix A, run as a system, holds 0.66 um at
    31 V and 3.74 um at 68 V. Begins and ends at 30 V, at rest. Returns (n,) in V.
    Raises SignalError for another part, or a sampling period that does not resolve 100 Hz.
    """
    if part not in FIG5_AMPLITUDES_V:
        raise SignalError(f"part: {part!r} is not in Fig. 5; choose identification or validation")
    amplitudes_V = np.array(FIG5_AMPLITUDES_V[part])
    require_resolved(Ts_s, FIG5_HZ)
    t_s = clock(Ts_s, len(amplitudes_V) / FIG5_HZ)
    period = np.floor(t_s * FIG5_HZ).astype(np.intp)
    u_V = FIG5_LOW_V + amplitudes_V[period] * (1.0 - np.cos(2 * np.pi * FIG5_HZ * t_s))
    return np.append(u_V, FIG5_LOW_V)


def fig8(Ts_s: float, part: Part, duration_s: float = 1.0) -> Floats:
    """Fig. 8, as printed in section 4.2: frequency and amplitude fall exponentially.

        u_idt(t) = 15 exp(-2 t)   (sin(120 pi exp(-t)     t) + 1) + 30
        u_val(t) = 15 exp(-2.5 t) (sin(120 pi exp(-1.2 t) t) + 1) + 30

    Use: the paper's rate-dependent case, 60 Hz falling to 0 while the loops shrink. Begins at 45 V.
    Returns (n,) in V. Raises SignalError for another part.
    """
    if part not in ("identification", "validation"):
        raise SignalError(f"part: {part!r} is not in Fig. 8; choose identification or validation")
    fading, slowing = (2.0, 1.0) if part == "identification" else (2.5, 1.2)
    require_resolved(Ts_s, 60.0)
    t = clock(Ts_s, duration_s)
    u_V: Floats = 15.0 * np.exp(-fading * t) * (np.sin(120 * np.pi * np.exp(-slowing * t) * t) + 1.0) + 30.0
    return u_V


def fig11_sine(Ts_s: float, duration_s: float = 0.1) -> Floats:
    """Fig. 11(a): single-frequency signal, u(t) = 45 V + 12 V sin(2 pi 100 t).

    Use: a model fitted to Fig. 8 at a frequency outside its record. The paper prints 100 Hz and no amplitude; this one
    stays inside the voltages of Fig. 8. Begins at 45 V. Returns (n,) in V.
    """
    require_resolved(Ts_s, 100.0)
    u_V: Floats = 45.0 + 12.0 * np.sin(2 * np.pi * 100.0 * clock(Ts_s, duration_s))
    return u_V


def fig11_non_harmonic(Ts_s: float, duration_s: float = 0.4) -> Floats:
    """Fig. 11(b): non-harmonic signal, three sines whose frequencies have no common period.

        u(t) = 45 V + 5 sin(2 pi 20 t) + 4 sin(2 pi 20 sqrt(2) t) + 3 sin(2 pi 20 sqrt(5) t)

    Use: a model fitted to Fig. 8 on minor loops in another order. The paper prints no formula; this signal stays inside
    the voltages of Fig. 8. Begins at 45 V. Returns (n,) in V.
    """
    require_resolved(Ts_s, 20.0 * 5**0.5)
    t = clock(Ts_s, duration_s)
    lines_Hz = 20.0 * np.sqrt(np.array([1.0, 2.0, 5.0]))
    first, second, third = (np.sin(2 * np.pi * f_Hz * t) for f_Hz in lines_Hz)
    u_V: Floats = 45.0 + 5.0 * first + 4.0 * second + 3.0 * third
    return u_V


def tracking_reference(Ts_s: float, f_Hz: float, duration_s: float = 0.1) -> Floats:
    """Reference of section 4.3, y_d(t) = 2.0 + 0.6 sin(2 pi f t); the paper has f = 50 Hz and 100 Hz.

    Use: tracking; (n,) displacement in um, begins at 2.0 um. Raises SignalError if f_Hz is not resolved.
    """
    require_resolved(Ts_s, f_Hz)
    y_um: Floats = 2.0 + 0.6 * np.sin(2 * np.pi * f_Hz * clock(Ts_s, duration_s))
    return y_um

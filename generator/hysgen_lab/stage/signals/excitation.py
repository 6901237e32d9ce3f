"""Excitations that identify a piezo stage: each excites dynamics that a single sine does not.

Each begins and ends at a stated level, so that signals can be joined; `joining.safe` adds the ways from and to rest.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from hysgen_lab.stage.signals.joining import SignalError, clock, require_resolved, travel

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

"""The voltage to play next: what a record cannot tell, as pieces of a waveform inside the limits of the user.

A cause shows under one kind of voltage (`Cause.experiment`). The kinds that the record lacks, or that a cause needs
which the record does not excite or hides, are played one after the other in the part that is identified from, then once
more, upside down and faster, in the part that is held out.
"""

from __future__ import annotations

import enum
import math
from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from hysgen.diagnosis.error_map import turning_points
from hysgen.errors import HysgenError
from hysgen.record.series import plateaus

Floats = NDArray[np.float64]

PLAYED_FIRST = 0.65
"""Share of the time for the first playing: `diagnose` identifies from as many rows, where nothing else is asked."""

LATE = 1.1
"""Time that the moves between the pieces may add to that of the pieces."""

FEWEST_TURNS = 12
"""Turning points that the command needs to distinguish memory from a nonlinear curve."""

ALIKE = 0.7
"""Swings count as equal if the size below which a fifth of the way lies is more than this share of the size above which
another fifth lies; durations likewise, with the time in place of the way."""

AMPLITUDES = (1.0, 0.8, 0.6, 0.4, 0.2)
"""Nested strokes as shares of the range, falling; the same rise again."""

LEVELS = 12
"""Levels of the steps."""

BAND = 0.1
"""Highest frequency of the band as a share of the sampling rate: a mode there still has ten samples a period."""

BAND_RANGE = 0.2
"""Share of the range that the band takes: small strokes, so that the hysteresis moves little beside the modes."""


class Piece(enum.StrEnum):
    """A kind of voltage, as advice."""

    NESTED = "drive with nested amplitudes, 20 to 100 % of the range"
    RATES = "drive the same strokes at rates a decade apart, with plateaus between them"
    RESTS = "hold the input for a tenth of the record after full strokes"
    STEPS = "drive with steps"
    BAND = "drive with frequencies up to a tenth of the sampling rate"


@dataclass(frozen=True)
class Limits:
    """What the next voltage may not leave: low_V .. high_V, slew_V_s; it takes seconds at the period Ts_s."""

    low_V: float
    high_V: float
    slew_V_s: float
    seconds: float
    Ts_s: float

    def __post_init__(self) -> None:
        if not (math.isfinite(self.low_V) and math.isfinite(self.high_V) and self.low_V < self.high_V):
            raise HysgenError(f"range {self.low_V:g} .. {self.high_V:g} V: state the lower voltage first")
        if not (self.slew_V_s > 0.0 and self.seconds > 0.0 and self.Ts_s > 0.0):
            raise HysgenError("slew rate, length and period of an experiment are positive")

    @classmethod
    def of(cls, u_V: Floats, Ts_s: float) -> Limits:
        """Those that a record, (n,), has kept itself."""
        slew_V_s = float(np.max(np.abs(np.diff(u_V)), initial=0.0)) / Ts_s
        low_V, high_V = float(u_V.min()), float(u_V.max())
        return cls(low_V, high_V if high_V > low_V else low_V + 1.0, slew_V_s or 1.0 / Ts_s, len(u_V) * Ts_s, Ts_s)

    @property
    def range_V(self) -> float:
        """high_V - low_V."""
        return self.high_V - self.low_V

    @property
    def fastest_s(self) -> float:
        """Least time of a full stroke."""
        return self.range_V / self.slew_V_s


def lacking(u_V: Floats, needed: Collection[str]) -> tuple[Piece, ...]:
    """Pieces for the next voltage, in the order of `Piece`.

    u_V: (n,) of the identified part. needed: `Ability.lacks` of the causes.
    """
    turns = turning_points(u_V)
    # Rows that move: a rest makes no swing slower.
    moving = np.concatenate([[0], np.cumsum(np.diff(u_V) != 0.0)])
    swings_V, lengths = np.abs(np.diff(u_V[turns])), np.diff(moving[turns]).astype(np.float64)
    few = len(turns) < FEWEST_TURNS
    missing = {
        Piece.NESTED: few or _alike(swings_V),
        Piece.RATES: not few and _alike(lengths),
        Piece.RESTS: not plateaus(u_V),
    }
    return tuple(piece for piece in Piece if missing.get(piece) or piece in needed)


def _alike(sizes: Floats) -> bool:
    """Whether positive sizes, (n,), are alike, each with itself as its weight: many small ones weigh little."""
    rising = np.sort(sizes)
    below = np.cumsum(rising) / rising.sum()
    low, high = (float(rising[np.searchsorted(below, share)]) for share in (0.2, 0.8))
    return low > ALIKE * high


def in_words(pieces: Sequence[Piece], limits: Limits) -> str:
    """The pieces with their levels and times; empty without pieces."""
    if not pieces:
        return ""
    share_s = PLAYED_FIRST * limits.seconds / len(pieces)
    span = f"{limits.low_V:.3g} .. {limits.high_V:.3g} V"
    slow_s = _slow_leg_s(share_s)
    words = {
        Piece.NESTED: f"nested strokes, 20 to 100 % of {span}, to tell memory from lag",
        Piece.RATES: f"strokes of {span} in {slow_s:.2g} s and in {max(0.1 * slow_s, limits.fastest_s):.2g} s, "
        "to tell delay and modes from lag",
        Piece.RESTS: f"rests of {_rest_s(share_s):.2g} s at both ends and in the middle of {span}, "
        "to tell creep from drift",
        Piece.STEPS: f"{LEVELS} steps inside {span} at {limits.slew_V_s:.3g} V/s, to see a slew limit",
        Piece.BAND: f"all frequencies up to {BAND / limits.Ts_s:.3g} Hz at {100 * BAND_RANGE:.0f} % of {span}, "
        "to see modes",
    }
    return "drive with " + "; ".join(words[piece] for piece in pieces)


def voltage(pieces: Sequence[Piece], limits: Limits) -> Floats:
    """(n,) voltage that plays the pieces from low_V to low_V within the limits.

    Raises HysgenError without pieces, or if they do not fit into the time at this slew rate.
    """
    if not pieces:
        raise HysgenError("this record excites every cause: no further experiment is needed")
    u_V = _played_twice(pieces, limits)
    needed_s = len(u_V) * limits.Ts_s
    if needed_s > LATE * limits.seconds:
        raise HysgenError(
            f"at {limits.slew_V_s:.3g} V/s the pieces take {needed_s:.3g} s, not {limits.seconds:.3g} s: state more "
            "seconds or a faster slew rate"
        )
    return u_V


def with_time_for(pieces: Sequence[Piece], limits: Limits) -> Limits:
    """The limits with as many seconds, doubled from those stated, as the pieces need at the slew rate."""
    while pieces and len(_played_twice(pieces, limits)) * limits.Ts_s > LATE * limits.seconds:
        limits = replace(limits, seconds=2.0 * limits.seconds)
    return limits


def _played_twice(pieces: Sequence[Piece], limits: Limits) -> Floats:
    first = _played(pieces, replace(limits, seconds=PLAYED_FIRST * limits.seconds))
    again = _played(pieces[::-1], replace(limits, seconds=(1.0 - PLAYED_FIRST) * limits.seconds))
    mirrored = limits.low_V + limits.high_V - again
    over = _moved([limits.low_V, limits.high_V], [limits.fastest_s], limits.Ts_s)
    whole_V = np.concatenate([first, over, mirrored, over[-2::-1], [limits.low_V]])
    return np.asarray(np.clip(whole_V, limits.low_V, limits.high_V))


def _played(pieces: Sequence[Piece], limits: Limits) -> Floats:
    """The pieces, each in an equal share of the time, from low_V to low_V."""
    share_s = limits.seconds / len(pieces)
    return np.concatenate([PLAYED[piece](limits, share_s) for piece in pieces])


def _moved(levels_V: Sequence[float], legs_s: Sequence[float], Ts_s: float) -> Floats:
    """Straight moves through the levels, each in its time; the first level is left out."""
    rows = np.maximum(1, np.ceil(np.asarray(legs_s) / Ts_s - 1e-9)).astype(np.intp)
    moves = [np.linspace(a, b, n + 1)[1:] for a, b, n in zip(levels_V, levels_V[1:], rows, strict=False)]
    return np.concatenate(moves)


def _at_rate(limits: Limits, levels_V: Sequence[float], seconds: float) -> Floats:
    """Moves through the levels at one rate that takes the given time, or at the slew rate if that is slower."""
    ways_V = np.abs(np.diff(levels_V))
    rate_V_s = min(float(ways_V.sum()) / seconds, limits.slew_V_s)
    return _moved(levels_V, [*(ways_V / rate_V_s)], limits.Ts_s)


def _nested(limits: Limits, share_s: float) -> Floats:
    middle_V = 0.5 * (limits.low_V + limits.high_V)
    levels_V = [limits.low_V]
    for share in (*AMPLITUDES, *AMPLITUDES[-2::-1]):
        half_V = 0.5 * share * limits.range_V
        levels_V += [middle_V + half_V, middle_V - half_V]
    return _at_rate(limits, levels_V, share_s)


def _slow_leg_s(share_s: float) -> float:
    """Time of a slow stroke: two of them, ten in a tenth of the time, and two plateaus of a fifth take the share."""
    return share_s / 3.4


def _rates(limits: Limits, share_s: float) -> Floats:
    slow_s = _slow_leg_s(share_s)
    fast_s = max(0.1 * slow_s, limits.fastest_s)
    low_V, high_V = limits.low_V, limits.high_V
    levels_V = [low_V, high_V, high_V, low_V, low_V, *([high_V, low_V] * 5)]
    return _moved(levels_V, [slow_s, 0.2 * slow_s, slow_s, 0.2 * slow_s, *([fast_s] * 10)], limits.Ts_s)


def _rest_s(share_s: float) -> float:
    """Time of a rest: three of them take nine tenths of the share."""
    return 0.3 * share_s


def _rests(limits: Limits, share_s: float) -> Floats:
    low_V, high_V, rest_s = limits.low_V, limits.high_V, _rest_s(share_s)
    middle_V, move_s = 0.5 * (low_V + high_V), max(0.025 * share_s, limits.fastest_s)
    levels_V = [low_V, high_V, high_V, low_V, middle_V, middle_V, low_V, low_V]
    return _moved(levels_V, [move_s, rest_s, move_s, 0.5 * move_s, rest_s, 0.5 * move_s, rest_s], limits.Ts_s)


def _steps(limits: Limits, share_s: float) -> Floats:
    """Steps to the bit-reversed multiples of the range over LEVELS, from both halves of the range in turn."""
    reversed_bits = [int(f"{k:04b}"[::-1], 2) for k in range(1, 16)]
    levels_V = [limits.low_V + share / 15.0 * limits.range_V for share in reversed_bits[:LEVELS]] + [limits.low_V]
    legs_s, path_V, at_V = [], [limits.low_V], limits.low_V
    for level_V in levels_V:
        move_s = abs(level_V - at_V) / limits.slew_V_s
        path_V += [level_V, level_V]
        legs_s += [move_s, max(share_s / len(levels_V) - move_s, 0.0)]
        at_V = level_V
    return _moved(path_V, legs_s, limits.Ts_s)


def _band(limits: Limits, share_s: float) -> Floats:
    """A multisine of equal amplitudes and quadratic phases (Schroeder, 1970) about the middle of the range."""
    Ts_s = limits.Ts_s
    rows = max(16, round((share_s - limits.fastest_s) / Ts_s))
    highest = max(1, int(BAND * rows))
    spectrum = np.zeros(rows // 2 + 1, dtype=np.complex128)
    spectrum[1 : highest + 1] = np.exp(-1j * np.pi * np.arange(highest) ** 2 / highest)
    wave = np.fft.irfft(spectrum, rows)
    largest = min(
        0.5 * BAND_RANGE * limits.range_V / float(np.abs(wave).max()),
        limits.slew_V_s * Ts_s / float(np.abs(np.diff(wave, append=wave[0])).max()),
    )
    middle_V = 0.5 * (limits.low_V + limits.high_V)
    inside_V = middle_V + largest * wave
    ends_s = [abs(level - limits.low_V) / limits.slew_V_s for level in (inside_V[0], inside_V[-1])]
    there = _moved([limits.low_V, float(inside_V[0])], ends_s[:1], Ts_s)
    back = _moved([float(inside_V[-1]), limits.low_V], ends_s[1:], Ts_s)
    return np.concatenate([there, inside_V[1:], back])


PLAYED = {
    Piece.NESTED: _nested,
    Piece.RATES: _rates,
    Piece.RESTS: _rests,
    Piece.STEPS: _steps,
    Piece.BAND: _band,
}
"""The voltage of each piece: (limits, share_s) -> (n,), from low_V, which is left out, to low_V."""

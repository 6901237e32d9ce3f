"""Quantities of a positioning axis as ISO 230-2 and ASME B5.64 name them, from the levels that a record holds.

A level is a voltage that stays constant for HOLD_S or longer; its position is the mean of the last half of it; its
direction is the sign of the change of voltage from the hold before. Visits repeat each other if the hold before has the
same voltage too: other visits of a level differ by the hysteresis of the stage. With mean m and standard deviation s of
the positions of the visits of a level i from below (+) and from above (-), and d the deviation of m from the straight
line of all m over the voltage, which stands for the commanded positions that an open-loop stage does not have:

    reversal           B_i = m_i+ - m_i-;  hysteresis: largest |B_i|
    repeatability      R_i = max(2 s_i+ + 2 s_i- + |B_i|, 4 s_i+, 4 s_i-), largest over the levels
    positioning error  E = largest minus least d of all approaches (bidirectional, systematic)
    accuracy           A = largest d + 2 s minus least d - 2 s of all repeated approaches
    noise band         4 standard deviations of the readings about the mean within holds
    resolution         least step between successive holds that exceeds the noise band: an upper bound

docs/uncertainty.md lists the sources of these formulas.
"""

from __future__ import annotations

import itertools
from collections import defaultdict
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from hysgen.record import Record

HOLD_S: Final = 0.01
"""Shortest hold: several time constants of the lag of a stage, and 20 samples at 2 kHz."""

FEWEST_SAMPLES: Final = 16
APPROACHES: Final = 5
"""Approaches of a level from either side that ISO 230-2 demands; a smaller number stands beside the result."""

_SAME_LEVEL: Final = 1e-3
"""Voltages within this part of the range are one level."""


@dataclass(frozen=True)
class Hold:
    """One hold: voltage, mean position, standard deviation of its readings; from_V: of the hold before, if any."""

    u_V: float
    y_um: float
    noise_um: float
    from_V: float | None


@dataclass(frozen=True)
class Positions:
    """The quantities above in um; None where the record holds too little for one.

    approaches: fewest visits from one side among the levels that `repeatability_um` is of, 0 without one.

    spread_um: standard deviation of repeated visits about their mean, with `freedom` degrees of freedom.
    """

    levels: int
    holds: int
    positioning_um: float | None
    hysteresis_um: float | None
    repeatability_um: float | None
    accuracy_um: float | None
    approaches: int
    noise_band_um: float | None
    resolution_um: float | None
    spread_um: float | None
    freedom: float

    def rows(self) -> list[list[str]]:
        """Cells: quantity, value in um, what it needs where it is missing."""
        named = [
            ("positioning error", self.positioning_um, "three levels"),
            ("bidirectional repeatability", self.repeatability_um, "a repeated cycle of levels, up and down"),
            ("bidirectional accuracy", self.accuracy_um, "a repeated cycle of three levels"),
            ("hysteresis (reversal)", self.hysteresis_um, "levels approached from both sides"),
            ("resolution, at most", self.resolution_um, "small steps between holds"),
            ("noise band", self.noise_band_um, "holds of the voltage"),
        ]
        cells = [(name, "" if value is None else f"{value:.3g}", needs) for name, value, needs in named]
        rows = [[name, text, "" if text else f"needs {needs}"] for name, text, needs in cells]
        if 0 < self.approaches < APPROACHES:
            few = f"from {self.approaches} approaches; ISO 230-2 asks for {APPROACHES}"
            rows = [[name, text, few if text and "bidirectional" in name else note] for name, text, note in rows]
        return rows

    def to_json(self) -> dict[str, Any]:
        """Plain JSON values."""
        return dict(vars(self))


def positions(record: Record) -> Positions:
    """The quantities of a record; all None for one without holds."""
    found = holds(record)
    low, high = (min((h.u_V for h in found), default=0.0), max((h.u_V for h in found), default=0.0))
    scale = max(_SAME_LEVEL * (high - low), 1e-9)
    routes = _routes(found, scale)
    sides: dict[int, dict[int, list[float]]] = defaultdict(lambda: {1: [], -1: []})
    for (before, level), y in routes.items():
        side = 1 if level > before else -1
        if before != level and len(y) > len(sides[level][side]):
            sides[level][side] = y
    both = [each for each in sides.values() if each[1] and each[-1]]
    twice = [each for each in both if len(each[1]) > 1 and len(each[-1]) > 1]
    repeated = [np.asarray(y) for y in routes.values() if len(y) > 1]
    freedom = sum(y.size - 1 for y in repeated)
    power = sum(float(((y - y.mean()) ** 2).sum()) for y in repeated)
    volts = {round(hold.u_V / scale): hold.u_V for hold in found}
    approached = [(volts[level], np.asarray(y)) for (before, level), y in routes.items() if before != level]
    often = np.array([y.size > 1 for _, y in approached], dtype=bool)
    levels_often = {u for u, y in approached if y.size > 1}
    spreads = np.array([y.std(ddof=1) if y.size > 1 else 0.0 for _, y in approached])
    deviations = _about_a_line(np.array([(u, y.mean()) for u, y in approached])) if len(sides) >= 3 else np.zeros(0)
    band = 4.0 * float(np.sqrt(np.mean([hold.noise_um**2 for hold in found]))) if found else None
    return Positions(
        levels=len(sides),
        holds=len(found),
        positioning_um=_range(deviations) if len(sides) >= 3 else None,
        hysteresis_um=max((abs(_reversal(each)) for each in both), default=None),
        repeatability_um=max((_repeatability(each) for each in twice), default=None),
        accuracy_um=_range(deviations[often], 2.0 * spreads[often]) if twice and len(levels_often) >= 3 else None,
        approaches=min((len(y) for each in twice for y in each.values()), default=0),
        noise_band_um=band,
        resolution_um=None if band is None else _resolution(found, band),
        spread_um=float(np.sqrt(power / freedom)) if freedom else None,
        freedom=float(freedom),
    )


def holds(record: Record) -> list[Hold]:
    """Every hold of a record, in its order."""
    least = max(FEWEST_SAMPLES, round(HOLD_S / record.Ts_s))
    found: list[Hold] = []
    for segment in record.segments:
        last: float | None = None
        edges = np.flatnonzero(np.diff(segment.u_V)) + 1
        for start, stop in itertools.pairwise([0, *edges.tolist(), segment.samples]):
            if stop - start >= least:
                half = segment.y_um[start + (stop - start) // 2 : stop]
                level = float(segment.u_V[start])
                found.append(Hold(level, float(half.mean()), float(half.std(ddof=1)), last))
                last = level
    return found


def _routes(found: list[Hold], tolerance_V: float) -> dict[tuple[int, int], list[float]]:
    """Positions of all visits by (level before, level), in units of the tolerance."""
    routes: dict[tuple[int, int], list[float]] = defaultdict(list)
    for hold in found:
        if hold.from_V is not None:
            routes[round(hold.from_V / tolerance_V), round(hold.u_V / tolerance_V)].append(hold.y_um)
    return routes


def _reversal(each: dict[int, list[float]]) -> float:
    return float(np.mean(each[1]) - np.mean(each[-1]))


def _repeatability(each: dict[int, list[float]]) -> float:
    up, down = (float(np.std(each[side], ddof=1)) for side in (1, -1))
    return max(2.0 * (up + down) + abs(_reversal(each)), 4.0 * up, 4.0 * down)


def _about_a_line(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Deviation of each of (n, 2) points from their straight line."""
    u, y = points.T
    return np.asarray(y - np.polynomial.Polynomial.fit(u, y, 1)(u))


def _range(deviations: NDArray[np.float64], around: NDArray[np.float64] | float = 0.0) -> float:
    """Largest deviation, plus `around`, minus the least, less `around`."""
    return float((deviations + around).max() - (deviations - around).min())


def _resolution(found: list[Hold], band_um: float) -> float | None:
    steps = [abs(b.y_um - a.y_um) for a, b in itertools.pairwise(found)]
    return min((step for step in steps if step > band_um), default=None)

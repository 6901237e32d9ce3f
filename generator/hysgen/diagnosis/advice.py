"""What is left when every cause has had its say: nothing, something unknown, or something this record cannot tell."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hysgen.diagnosis.error_map import turning_points
from hysgen.diagnosis.prepare import Prepared
from hysgen.diagnosis.probe import rms
from hysgen.diagnosis.search import Found
from hysgen.record.noise import NoiseFloor
from hysgen.record.series import plateaus

Floats = NDArray[np.float64]

UNKNOWN_ABOVE = 0.001
"""Share of the span of y that the probe may leave: twice what hysteresis of any kind in the bank leaves."""

OVER_NOISE = 2.5

FEWEST_TURNS = 12
"""Turning points of the command below which memory cannot be told from a curve."""

ALIKE = 0.7
"""Swings are all alike if the small ones (20 %) reach this share of the large ones (80 %), in size or in length."""


def unexplained_structure(prepared: Prepared, found: Found, noise: NoiseFloor) -> str | None:
    """What the structure left looks like; None if the probe leaves no more than noise and inexact hysteresis."""
    rows = found.scene.rows
    left = found.fit.error[rows]
    level, span = rms(left), float(np.ptp(prepared.y_um[: prepared.cut]))
    if level < UNKNOWN_ABOVE * span or level < OVER_NOISE * noise.rms_um:
        return None
    words = residual_in_words(left, prepared, rows)
    return f"{1e3 * level:.3g} nm are left ({100 * level / span:.2g} % of the span), {words}"


def residual_in_words(left: Floats, prepared: Prepared, rows: NDArray[np.intp]) -> str:
    """The residual in words: jumps or smooth, fast or slow, where in the stroke, in which direction."""
    words = []
    moves = np.diff(left)
    typical = 1.4826 * float(np.median(np.abs(moves))) + 1e-300
    jumps = int(np.count_nonzero(np.abs(moves) > 8.0 * typical))
    if jumps > 5:
        words.append(f"{jumps} jumps")
    middle = left - left.mean()
    lag = max(1, len(left) // 200)
    memory = float(middle[lag:] @ middle[:-lag] / (middle @ middle + 1e-300))
    words.append("slow" if memory > 0.5 else "fast")
    y = prepared.y_um[rows]
    along = float(np.corrcoef(y, np.abs(middle))[0, 1])
    if abs(along) > 0.25:
        words.append("larger at high displacement" if along > 0 else "larger at low displacement")
    rising = np.gradient(prepared.u_V)[rows] > 0
    if rising.any() and (~rising).any():
        gap = abs(float(middle[rising].mean() - middle[~rising].mean()))
        if gap > 0.5 * rms(middle):
            words.append("depends on the direction")
    return ", ".join(words)


def next_experiment(prepared: Prepared) -> str:
    """How to drive the stage to learn what this record cannot tell; empty if it can tell everything."""
    u_V = prepared.u_V[: prepared.cut]
    turns = turning_points(u_V)
    swings_V, lengths = np.abs(np.diff(u_V[turns])), np.diff(turns)
    advice = []
    if len(turns) < FEWEST_TURNS:
        advice.append("more turning points: triangles or sines of falling amplitude")
    else:
        if np.quantile(swings_V, 0.2) > ALIKE * np.quantile(swings_V, 0.8):
            advice.append("nested amplitudes, 20 to 100 % of the range, to tell memory from lag")
        if np.quantile(lengths, 0.2) > ALIKE * np.quantile(lengths, 0.8):
            advice.append("two frequencies at least a decade apart, to tell delay and modes from lag")
    if not plateaus(u_V):
        advice.append("plateaus of a second or more after full strokes, to tell creep from drift")
    return "drive with " + "; ".join(advice) if advice else ""

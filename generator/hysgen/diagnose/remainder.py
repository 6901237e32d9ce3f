"""What is left when every cause has had its say: nothing, something unknown, or something this record cannot tell."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from hysgen.diagnose.noise import NoiseFloor, plateaus
from hysgen.diagnose.prepare import Prepared
from hysgen.diagnose.probe import rms
from hysgen.diagnose.search import Found

Floats = NDArray[np.float64]

UNKNOWN_ABOVE = 0.001
"""Share of the span of y that the probe may leave: twice what hysteresis of any kind in the bank leaves."""

OVER_NOISE = 2.5


def remainder(prepared: Prepared, found: Found, noise: NoiseFloor) -> str | None:
    """What the structure left looks like; None if the probe leaves no more than noise and inexact hysteresis."""
    rows = found.scene.rows
    left = found.fit.error[rows]
    level, span = rms(left), float(np.ptp(prepared.y_um[: prepared.cut]))
    if level < UNKNOWN_ABOVE * span or level < OVER_NOISE * noise.rms_um:
        return None
    return f"{1e3 * level:.3g} nm are left ({100 * level / span:.2g} % of the span), {appearance(left, prepared, rows)}"


def appearance(left: Floats, prepared: Prepared, rows: NDArray[np.intp]) -> str:
    """The remainder in words: jumps or smooth, fast or slow, where in the stroke, in which direction."""
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


def experiment_for(prepared: Prepared, named: Sequence[str]) -> str:
    """How to drive the stage to learn what this record cannot tell; empty if it can tell everything."""
    u_V = prepared.u_V[: prepared.cut]
    span_V = float(np.ptp(u_V))
    turns = np.flatnonzero(np.diff(np.sign(np.diff(u_V)[np.diff(u_V) != 0])) != 0)
    advice = []
    if len(turns) < 12:
        advice.append("more turning points: triangles or sines of falling amplitude")
    swings = np.abs(np.diff(u_V[np.diff(u_V, append=u_V[-1]) != 0][turns])) if len(turns) > 2 else np.zeros(0)
    large = swings[swings > 0.02 * span_V]
    if len(large) > 2 and np.quantile(large, 0.1) > 0.7 * np.quantile(large, 0.9):
        advice.append("nested amplitudes, 20 to 100 % of the range, to tell memory from lag")
    gaps = np.diff(turns)
    if len(gaps) > 2 and np.quantile(gaps, 0.9) < 2.0 * np.quantile(gaps, 0.1):
        advice.append("two frequencies at least a decade apart, to tell delay and modes from lag")
    if not plateaus(u_V):
        advice.append("plateaus of a second or more after full strokes, to tell creep from drift")
    return "drive with " + "; ".join(advice) if advice else ""

"""Structure in the residual of the probe that no cause explains, and the experiment that would identify more causes."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from hysgen.diagnosis.causes import Residual
from hysgen.diagnosis.error_map import turning_points
from hysgen.diagnosis.prepare import Prepared
from hysgen.diagnosis.probe import rms
from hysgen.record.noise import NoiseFloor
from hysgen.record.series import MEDIAN_TO_DEVIATION, plateaus

Floats = NDArray[np.float64]

UNKNOWN_ABOVE, OVER_NOISE = 0.0035, 2.5
"""Residual rms, as a share of the span of y and in noise floors, from both of which on the residual has structure.

Of 780 stages of the families of the laboratory without an effect outside the vocabulary the probe left more than this
share on two, and more than 0.25 % on seven. Small stick-slip leaves as little and is missed; jumps and changes of the
gain are parts of the probe and need no such limit.
"""

FEWEST_TURNS = 12
"""Turning points that the command needs to distinguish memory from a nonlinear curve."""

ALIKE = 0.7
"""Ratio of the 20 % to the 80 % quantile above which the sizes, or the durations, of the swings count as equal."""

JUMP = 8.0
"""Size of a jump in robust standard deviations of the residual's steps."""

WINDOW = 256
"""Samples of one spectrum of the residual."""


def unexplained_structure(prepared: Prepared, result: Residual, noise: NoiseFloor) -> str | None:
    """The structure in the residual of the probe's fit, in words; None if the residual is noise or negligible."""
    rows = result.scene.rows
    residual = result.fit.error[rows]
    level, span = rms(residual), float(np.ptp(prepared.y_um[: prepared.cut]))
    noise_um = min(noise.rms_um, unpredictable_um(residual))
    if level < UNKNOWN_ABOVE * span or level < OVER_NOISE * noise_um:
        return None
    words = residual_in_words(residual, prepared, rows)
    return f"{1e3 * level:.3g} nm are left ({100 * level / span:.2g} % of the stroke), {words}"


def unpredictable_um(residual: Floats) -> float:
    """Standard deviation of the part of a residual, (m,), that its past does not predict, median over windows.

    exp(mean over the frequencies of ln S + Euler's constant), with S the periodogram: a vibration of changing frequency
    raises S at few frequencies of each window (Kolmogorov, 1941). inf for a residual shorter than a window.
    """
    taper = np.hanning(WINDOW)
    starts = range(0, len(residual) - WINDOW + 1, WINDOW // 2)
    spectra = [np.abs(np.fft.rfft(_without_line(residual[at : at + WINDOW]) * taper))[3:-1] ** 2 for at in starts]
    levels = [float(np.mean(np.log(one + 1e-300))) + np.euler_gamma for one in spectra]
    return math.sqrt(math.exp(float(np.median(levels))) / float(taper @ taper)) if levels else math.inf


def _without_line(values: Floats) -> Floats:
    """The values, (m,), less the straight line of least squares."""
    time = np.arange(len(values)) - 0.5 * (len(values) - 1)
    return np.asarray(values - values.mean() - (time @ values) / (time @ time) * time)


def residual_in_words(residual: Floats, prepared: Prepared, rows: NDArray[np.intp]) -> str:
    """Jumps, slow or fast, dependence on displacement and direction of a residual, (m,), in um on the given rows."""
    words = []
    steps = np.diff(residual)
    typical = MEDIAN_TO_DEVIATION * float(np.median(np.abs(steps))) + 1e-300
    jumps = int(np.count_nonzero(np.abs(steps) > JUMP * typical))
    if jumps > 5:
        words.append(f"{jumps} jumps")
    centred = residual - residual.mean()
    lag = max(1, len(residual) // 200)
    autocorrelation = float(centred[lag:] @ centred[:-lag] / (centred @ centred + 1e-300))
    words.append("slow" if autocorrelation > 0.5 else "fast")
    y = prepared.y_um[rows]
    along = float(np.corrcoef(y, np.abs(centred))[0, 1])
    if abs(along) > 0.25:
        words.append("larger at high displacement" if along > 0 else "larger at low displacement")
    rising = np.gradient(prepared.u_V)[rows] > 0
    if rising.any() and (~rising).any():
        gap = abs(float(centred[rising].mean() - centred[~rising].mean()))
        if gap > 0.5 * rms(centred):
            words.append("depends on the direction")
    return ", ".join(words)


def next_experiment(prepared: Prepared) -> str:
    """The excitation that would distinguish causes which this record cannot distinguish; empty if there are none."""
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

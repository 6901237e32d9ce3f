"""Periodic: a line in the spectrum of the residual with constant phase that is no harmonic of the input."""

from __future__ import annotations

import functools
import math

import numpy as np
from numpy.typing import NDArray
from scipy.fft import rfft

from hysgen.diagnosis.causes.base import Cause, Effect, Estimate, Residual, Signature
from hysgen.diagnosis.excitation import Excitation
from hysgen.diagnosis.probe import Chain, Fit, RunSignals, Scene, standard_errors
from hysgen.display import decimal
from hysgen.model.disturbances.periodic import FEWEST_PERIODS, Periodic, same_phase
from hysgen.record.series import period_of

Floats = NDArray[np.float64]

MOST_LINES = 4
LEAST_PEAK = 10.0
"""Least ratio of a peak's power to the local background for a candidate line."""


class PeriodicCause(Cause):
    name = "periodic"
    rank = 80
    experiment = "record at least four periods"
    part = Periodic

    def admissible(self, scene: Scene, fit: Fit) -> bool:
        """Whether no line is a harmonic of the period of the command: what repeats with the command is the stage's."""
        starts_s = [run.time_s(scene.Ts_s)[:: _period(run)] for run in scene.runs if _period(run)]
        return not any(same_phase(line_Hz, at_s) for line_Hz in _lines_Hz(fit.chain) for at_s in starts_s)

    def without_one_part(self, chain: Chain) -> list[Chain]:
        lines = _lines_Hz(chain)
        fewer = [lines[:i] + lines[i + 1 :] for i in range(len(lines))]
        return [chain.having(Periodic(lines_kept)) if lines_kept else self.without(chain) for lines_kept in fewer]

    def requirement(self, seen: Excitation) -> tuple[bool, str]:
        duration_s = seen.record.samples * seen.record.Ts_s
        return True, f"lines above {FEWEST_PERIODS / duration_s:.3g} Hz and below {0.5 / seen.record.Ts_s:.4g} Hz"

    def proposals(self, residual: Residual) -> list[Chain]:
        chain = residual.fit.chain
        lines = _lines_Hz(chain)
        if len(lines) >= MOST_LINES:
            return []
        return [chain.having(Periodic(tuple(sorted((*lines, line_Hz))))) for line_Hz in _peaks(residual, 3)]

    def effect(self, residual: Residual) -> Effect:
        """Of a line at a twentieth of the sampling rate."""
        f_Hz = 0.05 / residual.scene.Ts_s
        return Effect(f"um at {f_Hz:.3g} Hz", np.sin(2.0 * np.pi * f_Hz * residual.scene.time_s))

    def signature(self, residual: Residual, rival: Fit) -> Signature:
        """Power of each line divided by the local background, and its phase in each quarter of the record."""
        chain = residual.fit.chain
        errors = standard_errors(residual.scene, residual.fit).coordinates
        parameters, texts = {}, []
        evidence = _line_evidence(residual)
        for i, (line_Hz, (amplitude_um, ratio, _)) in enumerate(zip(_lines_Hz(chain), evidence, strict=True)):
            suffix = "" if i == 0 else f"_{i + 1}"
            parameters[f"f{suffix}_Hz"] = Estimate(line_Hz, errors[f"periodic.{i}.f_Hz"])
            parameters[f"amplitude{suffix}_um"] = Estimate(amplitude_um, amplitude_um / np.sqrt(max(ratio, 1e-9)))
            texts.append(f"line at {line_Hz:.5g} Hz, {amplitude_um:.3g} um, {decimal(ratio, 2)} times its background")
        least, steady = min(ratio for _, ratio, _ in evidence), all(keeps for _, _, keeps in evidence)
        texts.append("phase kept throughout" if steady else "phase not kept")
        return Signature(float(np.sqrt(least)), "; ".join(texts), parameters)


@functools.lru_cache(maxsize=8)
def _period(run: RunSignals) -> int | None:
    """The period of the command of a run in samples, None if it has none."""
    return period_of(run.u_V)


def _lines_Hz(chain: Chain) -> tuple[float, ...]:
    """The lines of a chain; empty if the chain has no periodic part."""
    part = chain.get(Periodic)
    return () if part is None else part.f_Hz


def _line_evidence(residual: Residual) -> list[tuple[float, float, bool]]:
    """For each line: amplitude in um, ratio of its power to the local background, and whether its phase is constant."""
    chain, scene, weights = residual.fit.chain, residual.scene, residual.fit.weights
    first = scene.column_of(chain, Periodic)
    evidence = []
    for i, line_Hz in enumerate(_lines_Hz(chain)):
        cosine, sine = (float(weight) for weight in weights[first + 2 * i : first + 2 * i + 2])
        ratio, steady = _line_significance(residual, line_Hz, sine, cosine)
        evidence.append((math.hypot(sine, cosine), ratio, bool(steady)))
    return evidence


def _peaks(residual: Residual, count: int) -> list[float]:
    """Frequencies in Hz of the `count` lines that explain most of the residual power and exceed LEAST_PEAK."""
    scene = residual.scene
    longest = max(run.whole for run in scene.runs)
    power = _explained(residual, 2 * longest)
    ratio = power / (_local_median(power) + 1e-300)
    inner = power[1:-1]
    peaks = 1 + np.flatnonzero((inner >= power[:-2]) & (inner >= power[2:]) & (ratio[1:-1] > LEAST_PEAK))
    peaks = peaks[peaks >= 2 * FEWEST_PERIODS]
    best = peaks[np.argsort(power[peaks])[::-1][:count]]
    lines = []
    for at in best.tolist():
        a, b, c = np.log(power[at - 1 : at + 2] + 1e-300)
        shift = 0.5 * (a - c) / (a - 2 * b + c) if a - 2 * b + c < 0 else 0.0
        lines.append((at + float(shift)) / (2 * longest * scene.Ts_s))
    return lines


def _explained(residual: Residual, length: int) -> Floats:
    """(length/2 + 1,) fall of the sum of squares on the fitted rows by adding a line at each frequency j/(length Ts).

        b' G^-1 b,    b = (e . c, e . s),   G = (c, s)' P (c, s),   P the projector off the columns of the chain

    The weights of the other columns are fitted jointly with the line. All sums over rows are Fourier transforms q . w
    and e . w, with w = c - i s and q an orthonormal basis of the columns.
    """
    scene, rows = residual.scene, residual.scene.rows
    # The sample of each fitted row in its segment; the transforms of segments are added.
    sample = np.round(scene.time_s[rows] / scene.Ts_s).astype(np.intp)

    def transformed(signal: Floats) -> NDArray[np.complex128]:
        return np.asarray(rfft(np.bincount(sample, signal, length)))

    error = transformed(residual.fit.error[rows])
    cc = ss = np.full(error.size, 0.5 * len(rows))
    cs = np.zeros(error.size)
    for column in residual.projector.basis():
        seen = transformed(column)
        cc, ss, cs = cc - seen.real**2, ss - seen.imag**2, cs - seen.real * seen.imag
    determinant = cc * ss - cs * cs
    known = (determinant > 1e-2 * len(rows) ** 2 / 4) & (cc > 0)
    b, c = error.real, error.imag
    power = (ss * b * b - 2.0 * cs * b * c + cc * c * c) / np.where(known, determinant, np.inf)
    return np.asarray(power)


def _local_median(power: Floats) -> Floats:
    """Median power around each bin, over fewer bins at low frequencies; computed at 120 bins and interpolated."""
    at = np.unique(np.round(np.geomspace(1, len(power), 120)).astype(int)) - 1
    halves = np.maximum(16, at // 8)
    level = [np.median(power[max(0, i - half) : i + half + 1]) for i, half in zip(at, halves, strict=True)]
    return np.asarray(np.exp(np.interp(np.arange(len(power)), at, np.log(np.array(level) + 1e-300))))


def _line_significance(residual: Residual, line_Hz: float, sine: float, cosine: float) -> tuple[float, bool]:
    """Ratio of the line's power to that of the residual around it, and whether its phase is equal in all quarters."""
    scene, rows = residual.scene, residual.scene.rows
    time_s = scene.time_s[rows]
    wave = np.exp(-2j * np.pi * line_Hz * time_s)
    line = sine * np.sin(2 * np.pi * line_Hz * time_s) + cosine * np.cos(2 * np.pi * line_Hz * time_s)
    error = residual.fit.error[rows]
    around = []
    # The frequency resolution of the whole record, also for thinned rows.
    width = 1.0 / (scene.Ts_s * len(scene.dense))
    for step in (3, 4, 5, 6, 7, 8):
        for sign in (-1, 1):
            near = np.exp(-2j * np.pi * (line_Hz + sign * step * width) * time_s)
            around.append(abs(np.mean(error * near)) ** 2)
    whole = np.mean(line * wave)
    parts = [np.mean((line + error)[part] * wave[part]) for part in np.array_split(np.arange(len(rows)), 4)]
    steady = all(np.real(part * np.conj(whole)) > 0.5 * abs(whole) ** 2 for part in parts)
    return float(abs(whole) ** 2 / (np.mean(around) + 1e-300)), steady


CAUSE = PeriodicCause()

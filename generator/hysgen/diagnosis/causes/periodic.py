"""Periodic: a line in the spectrum of the residual with constant phase that is no harmonic of the input."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np
from numpy.typing import NDArray
from scipy.fft import rfft

from hysgen.diagnosis.causes.base import Cause, Effect, Estimate, Known, Residual, Signature
from hysgen.diagnosis.extension import Extension
from hysgen.diagnosis.probe import Chain, Extent, Fit, Part, RunSignals, Scene, ShapeParameter, standard_errors
from hysgen.display import decimal
from hysgen.model.disturbances.periodic import Periodic
from hysgen.record.series import period_of, turning_rows

Floats = NDArray[np.float64]

MOST_LINES = 4
FEWEST_PERIODS = 12.0
"""Least periods of a line in the record: three per quarter, whose phases are compared. Slower lines resemble misfit."""

LEAST_PEAK = 10.0
"""Least ratio of a peak's power to the local background for a candidate line."""

LINE = ShapeParameter(
    "lines_Hz",
    "Hz",
    lambda e: (FEWEST_PERIODS / e.span_s, 0.5 / e.Ts_s),
    step=lambda e: 1e-3 / e.span_s,
    order=3.0,
)

SMALLEST_SWING = 0.01
"""Least swing between two turning points of the command, as a share of its range."""

SAME_PHASE = 0.9
"""Mean of exp(i phase) for phases that are evenly spread over a quarter of a period: sinc(1/4)."""


@dataclass(frozen=True)
class PeriodicPart(Part):
    """Disturbing lines at `lines_Hz`: a sine and a cosine each as added columns."""

    cause: ClassVar[str] = "periodic"
    order: ClassVar[int] = 70
    timed: ClassVar[bool] = True
    lines_Hz: tuple[float, ...]

    @property
    def parameters(self) -> tuple[tuple[str, ShapeParameter], ...]:
        return tuple((f"periodic.{i}.f_Hz", LINE) for i, _ in enumerate(self.lines_Hz))

    @property
    def values(self) -> tuple[float, ...]:
        return self.lines_Hz

    def with_values(self, values: Sequence[float]) -> Self:
        return type(self)(tuple(values))

    @property
    def added(self) -> int:
        return 2 * len(self.lines_Hz)

    def apart(self, runs: Sequence[RunSignals], Ts_s: float) -> bool:
        return not any(_repeats_with_the_command(line_Hz, runs, Ts_s) for line_Hz in self.lines_Hz)

    def columns(self, run: RunSignals, extent: Extent, seen: Callable[[Floats], Floats]) -> list[Floats]:
        t_s = run.time_s(extent.Ts_s)
        return [wave(2 * np.pi * line_Hz * t_s) for line_Hz in self.lines_Hz for wave in (np.sin, np.cos)]


class PeriodicCause(Cause):
    name = "periodic"
    rank = 80
    experiment = "record at least twelve periods"
    part = PeriodicPart

    def admissible(self, scene: Scene, fit: Fit) -> bool:
        """Whether no line is a harmonic of the period of the command: what repeats with the command is the stage's."""
        starts_s = [run.time_s(scene.Ts_s)[:: _period(run)] for run in scene.runs if _period(run)]
        return not any(_same_phase(line_Hz, at_s) for line_Hz in _lines_Hz(fit.chain) for at_s in starts_s)

    def without_one_part(self, chain: Chain) -> list[Chain]:
        lines = _lines_Hz(chain)
        fewer = [lines[:i] + lines[i + 1 :] for i in range(len(lines))]
        return [chain.having(PeriodicPart(lines_kept)) if lines_kept else self.without(chain) for lines_kept in fewer]

    def proposals(self, residual: Residual) -> list[Chain]:
        chain = residual.fit.chain
        lines = _lines_Hz(chain)
        if len(lines) >= MOST_LINES:
            return []
        return [chain.having(PeriodicPart((*lines, line_Hz))) for line_Hz in _peaks(residual, 3)]

    experiment = "record at least twelve periods"

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

    def extension(self, residual: Residual) -> Extension:
        return Extension(term=Periodic(tuple(sorted(_lines_Hz(residual.fit.chain)))))

    def true_extension(self, known: Known) -> Extension:
        return Extension(term=Periodic((known.parameters["periodic.f_Hz"],)))


def _repeats_with_the_command(line_Hz: float, runs: Sequence[RunSignals], Ts_s: float) -> bool:
    """Whether a line has the same phase at all maxima of the command, as its harmonics have."""
    return _same_phase(line_Hz, np.concatenate([run.time_s(Ts_s)[_maxima(run)] for run in runs]))


def _same_phase(line_Hz: float, at_s: Floats) -> bool:
    """Whether a line has the same phase at all times at_s: |mean of exp(i phase)| > SAME_PHASE."""
    return len(at_s) > 1 and bool(abs(np.exp(2j * np.pi * line_Hz * at_s).mean()) > SAME_PHASE)


@functools.lru_cache(maxsize=8)
def _period(run: RunSignals) -> int | None:
    """The period of the command of a run in samples, None if it has none."""
    return period_of(run.u_V)


@functools.lru_cache(maxsize=8)
def _maxima(run: RunSignals) -> NDArray[np.intp]:
    """Every second turning point of the command of a run, as rows; each score of a line asks for them."""
    return turning_rows(run.u_V, SMALLEST_SWING * float(np.ptp(run.u_V)))[::2]


def _lines_Hz(chain: Chain) -> tuple[float, ...]:
    """The lines of a chain; empty if the chain has no periodic part."""
    part = chain.get(PeriodicPart)
    return () if part is None else part.lines_Hz


def _line_evidence(residual: Residual) -> list[tuple[float, float, bool]]:
    """For each line: amplitude in um, ratio of its power to the local background, and whether its phase is constant."""
    chain, scene, weights = residual.fit.chain, residual.scene, residual.fit.weights
    first = scene.column_of(chain, PeriodicPart)
    evidence = []
    for i, line_Hz in enumerate(_lines_Hz(chain)):
        sine, cosine = (float(weight) for weight in weights[first + 2 * i : first + 2 * i + 2])
        ratio, steady = _line_significance(residual, line_Hz, sine, cosine)
        evidence.append((math.hypot(sine, cosine), ratio, bool(steady)))
    return evidence


def _peaks(residual: Residual, count: int) -> list[float]:
    """Frequencies in Hz of the `count` lines that explain most of the residual power and exceed LEAST_PEAK."""
    scene = residual.scene
    longest = max(run.whole for run in scene.runs)
    power = _explained(residual, 2 * longest)
    ratio = power / (_local_median(power) + 1e-300)
    power[: 2 * int(FEWEST_PERIODS)] = 0.0
    inner = power[1:-1]
    peaks = 1 + np.flatnonzero((inner >= power[:-2]) & (inner >= power[2:]) & (ratio[1:-1] > LEAST_PEAK))
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

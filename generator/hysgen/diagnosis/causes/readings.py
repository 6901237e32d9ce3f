"""Periodic: a line in the spectrum of the residual with constant phase that is no harmonic of the input.

Coupling: another measured channel explains part of the residual beside the stage's own input.

Delay: the output is late by whole or fractional samples; its phase grows with frequency, its amplitude does not.
"""

import dataclasses
import functools
import math
from collections.abc import Iterable, Mapping

import numpy as np
from numpy.typing import NDArray
from scipy.fft import rfft

from hysgen.diagnosis.causes.base import Cause, Effect, Estimate, Residual, Signature
from hysgen.diagnosis.experiment import Piece
from hysgen.diagnosis.probe import Chain, Fit, RunSignals, Scene, standard_errors
from hysgen.diagnosis.remedy import POINTS, Advice, Motion, Seen, held, strokes, voltage_step
from hysgen.display import decimal
from hysgen.model.disturbances.coupling import Coupling
from hysgen.model.disturbances.periodic import FEWEST_PERIODS, Periodic, same_phase
from hysgen.model.path.delay import LEAST_FITTED, MOST_FITTED, Delay
from hysgen.record.series import period_of

Floats = NDArray[np.float64]
Complex = NDArray[np.complex128]

MAINS_HZ = (50, 60)

MOST_LINES = 4
LEAST_PEAK = 10.0
"""Least ratio of a peak's power to the local background for a candidate line."""


LIKELY = 64
"""Largest peaks of a long record's error at which the fall by a line is computed: 20 times as many as are proposed."""


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

    def advice(self, seen: Seen) -> Advice:
        f_Hz, size_um = seen.values["f_Hz"], seen.values["amplitude_um"]
        mains = next((base for base in MAINS_HZ if abs(f_Hz / base - round(f_Hz / base)) < 1e-3 * f_Hz / base), None)
        cure = f"something that turns at {60.0 * f_Hz:.4g} 1/min (fan, pump) or a floor that shakes: isolate it"
        if mains is not None:
            cure = f"the mains of {mains} Hz: one ground, a shielded cable, no loop of cables, a battery for the sensor"
        return Advice(
            f"a resting stage seems to move by {2.0 * size_um:.3g} um peak to peak at {f_Hz:.4g} Hz",
            f"{cure}; a mean over {1e3 / f_Hz:.3g} ms is free of it",
        )

    def motion(self, values: Mapping[str, float], Ts_s: float) -> Motion:
        return held(5.0 / values["f_Hz"])

    def motions_um(self, motion: Motion, seen: Seen) -> tuple[Floats, Floats]:
        line_um = seen.values["amplitude_um"] * np.sin(2.0 * np.pi * seen.values["f_Hz"] * motion.time_s)
        return line_um, np.zeros_like(line_um)


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

    def transformed(signal: Floats) -> Complex:
        return np.asarray(rfft(np.bincount(sample, signal, length)))

    error, basis = transformed(residual.fit.error[rows]), residual.projector.basis()
    if scene.complete:
        return _fall(error, map(transformed, basis), len(rows))
    # Of a long record, at the largest peaks of the error alone, which no other columns explain: its fall is no less.
    power = (error.real**2 + error.imag**2) / (0.5 * len(rows))
    peaks = 1 + np.flatnonzero((power[1:-1] >= power[:-2]) & (power[1:-1] >= power[2:]))
    peaks = peaks[np.argsort(power[peaks])[-LIKELY:]]
    at = np.unique([peaks - 1, peaks, peaks + 1])
    waves = np.exp(-2j * np.pi / length * np.multiply.outer(sample, at))
    power[at] = _fall(error[at], basis @ waves, len(rows))
    return np.asarray(power)


def _fall(error: Complex, columns: Iterable[Complex], rows: int) -> Floats:
    """The fall of `_explained` from the transforms of the error and of an orthonormal basis of the columns."""
    cc = ss = np.full(error.size, 0.5 * rows)
    cs = np.zeros(error.size)
    for seen in columns:
        cc, ss, cs = cc - seen.real**2, ss - seen.imag**2, cs - seen.real * seen.imag
    determinant = cc * ss - cs * cs
    known = (determinant > 1e-2 * rows**2 / 4) & (cc > 0)
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


TAPS = 32
"""Past samples of a channel in the form with several taps."""


class CouplingCause(Cause):
    name = "coupling"
    rank = 70
    experiment = "record the other axes, the temperature or the load as further columns"
    part = Coupling

    def without_one_part(self, chain: Chain) -> list[Chain]:
        part = chain.of(Coupling)
        ranges = part.ranges
        fewer = [{other: ranges[other] for other in ranges if other != name} for name in ranges]
        less = [chain.having(Coupling.of(own, part.taps)) if own else self.without(chain) for own in fewer]
        return less if part.taps == 1 else [*less, chain.having(dataclasses.replace(part, taps=1))]

    def proposals(self, residual: Residual) -> list[Chain]:
        chain, scene = residual.fit.chain, residual.scene
        part = chain.get(Coupling)
        names, taps = ((), 1) if part is None else (part.channels, part.taps)
        further = [name for name in scene.runs[0].aux if name not in names and _moves(residual, name)]
        sets = [((*names, name), taps) for name in further]
        # A channel that acts through the dynamics of the stage needs several taps.
        if taps == 1 and (further or names):
            sets.append(((*names, *further), TAPS))
        ranges = [({name: scene.range_of(name) for name in chosen}, count) for chosen, count in sets]
        return [chain.having(Coupling.of(own, count)) for own, count in ranges]

    def effect(self, residual: Residual) -> Effect | None:
        """Of the first further channel, per standard deviation of it."""
        moving = [name for name in residual.scene.runs[0].aux if _moves(residual, name)]
        if not moving:
            return None
        channel = np.concatenate([run.aux[moving[0]] for run in residual.scene.runs])
        column = (channel - channel.mean()) / float(np.std(channel))
        return Effect(f"um for a standard deviation of {moving[0]}", column)

    def signature(self, residual: Residual, rival: Fit) -> Signature:
        """The gain of each channel divided by its standard error, beside all columns of the own input.

        The gain of several taps is the sum of their weights; z is the root mean square of the weights in standard
        errors.
        """
        scene, chain = residual.scene, residual.fit.chain
        part = chain.of(Coupling)
        first, added = scene.column_of(chain, Coupling), chain.first_column(Coupling)
        weights = residual.fit.weights[first : first + part.added].reshape(-1, part.taps)
        errors = standard_errors(scene, residual.fit).added[added : added + part.added].reshape(-1, part.taps)
        z = np.sqrt(np.mean((weights / np.maximum(errors, 1e-15)) ** 2, axis=1))
        gains, gain_errors = weights.sum(axis=1), np.sqrt((errors**2).sum(axis=1))
        listed = ", ".join(
            f"{name} {gain:.4g} +- {error:.1g} um per unit"
            for name, gain, error in zip(part.channels, gains, gain_errors, strict=True)
        )
        return Signature(
            z=float(z.min()),
            text=f"the error follows {listed}" + (f", over {part.taps} samples" if part.taps > 1 else ""),
            parameters={
                f"{name}_um_per_unit": Estimate(float(gain), float(error))
                for name, gain, error in zip(part.channels, gains, gain_errors, strict=True)
            },
        )

    def advice(self, seen: Seen) -> Advice:
        name, gain = next(iter(seen.values.items()))
        name = name.removesuffix("_um_per_unit")
        return Advice(
            f"one unit of {name} moves the stage by {gain:.3g} um",
            f"keep {name} constant within {seen.noise_um / max(abs(gain), 1e-300):.2g} to stay at the noise; or log "
            "it and leave it in the model; decouple the axis, insulate the mount",
        )

    def motion(self, values: Mapping[str, float], Ts_s: float) -> Motion:
        return dataclasses.replace(strokes(1.0, 1.0 / POINTS, 2), words="the channel swings by one unit")

    def motions_um(self, motion: Motion, seen: Seen) -> tuple[Floats, Floats]:
        moved_um = next(iter(seen.values.values())) * motion.levels
        return moved_um, np.zeros_like(moved_um)


def _moves(residual: Residual, name: str) -> bool:
    return all(float(np.ptp(run.aux[name])) > 0.0 for run in residual.scene.runs)


class DelayCause(Cause):
    name = "delay"
    rank = 30
    experiment = Piece.RATES
    mistaken_for = ("resonance",)
    part = Delay

    def proposals(self, residual: Residual) -> list[Chain]:
        chain, Ts_s = residual.fit.chain, residual.scene.Ts_s
        if self.present(chain):
            return []
        # The fitted lag contains the delay; the starting values divide the lag between lag and delay in several ratios.
        candidates = []
        for share in (0.1, 0.4, 0.8):
            late = share * chain.lag_s / Ts_s
            if LEAST_FITTED < late < MOST_FITTED:
                candidates.append(dataclasses.replace(chain.having(Delay(late)), lag_s=(1.0 - share) * chain.lag_s))
        candidates.append(chain.having(Delay(0.5)))
        return candidates

    def effect(self, residual: Residual) -> Effect:
        late = residual.changed_by(residual.fit.chain.having(Delay(1.0)))
        return Effect("samples", late, most=MOST_FITTED)

    def signature(self, residual: Residual, rival: Fit) -> Signature:
        """The delay divided by its standard error; lag, modes and hysteresis are fitted jointly with the delay."""
        late = residual.fit.chain.delay
        error = standard_errors(residual.scene, residual.fit).coordinates["delay.samples"]
        z = late / max(error, 1e-12)
        return Signature(
            z=z,
            text=f"phase grows with frequency at constant gain: {late:.2f} +- {error:.2f} samples late",
            parameters={"delay_samples": Estimate(late, error)},
        )

    def advice(self, seen: Seen) -> Advice:
        late_s = seen.values["delay_samples"] * seen.model.Ts_s
        return Advice(
            f"the reading is {1e3 * late_s:.3g} ms late: in a sine over the stroke at 100 Hz it is wrong by up to "
            f"{100.0 * np.pi * late_s * seen.stroke_um:.2g} um, and a loop has {36e3 * late_s:.2g} degrees less there",
            "log voltage and reading at one instant, read the sensor right before the voltage is put out, widen its "
            "filter; what is left, the inverse of this model has as preview",
        )

    def motion(self, values: Mapping[str, float], Ts_s: float) -> Motion:
        return voltage_step(max(30.0, 12.0 * values["delay_samples"]) * Ts_s, Ts_s)

"""Learning over repeats: the voltage of the next repeat, from the records of those that were played.

    e = r - y,   next reference = m + Q e,   m = answer of the model to the voltage that was played

in the discrete cosine transform, whose basis is even at both ends. The voltage of the next reference is the inverse of
the model, so what is left of an error is (1 - (1 + D) Q) e, where D is the relative error of the model:

    Q(f) = 1 - s^2/S_e(f), 0 where S_e < NOISE_FACTOR s^2        S_e: power of e near f,  s^2: of what does not repeat
    |D(f)|^2 = S(dy - dm)/S(dm)                                  dy, dm: from one repeat to another voltage

Q is 0 where |D| > TRUSTED or where the error grew. Where all of it is 0, there is nothing to learn.
Source: Bristow, Tharayil and Alleyne, IEEE Control Systems 26 (2006) 96-114, plant inversion and the Q-filter.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.fft import dct, idct

from hysgen.errors import RecordError
from hysgen.model.model import Model
from hysgen.record import Record
from hysgen.record.read import Series
from hysgen.record.series import residual_noise
from hysgen.trajectory.inverse import own_response
from hysgen.trajectory.limits import Limits, limits_of
from hysgen.trajectory.plan import Learning, Waveform, lead_samples, plan
from hysgen.trajectory.reference import Sampled, at_rate

Floats = NDArray[np.float64]

NOISE_FACTOR = 2.0
"""Power of an error over that of the noise from which on it is learnt; less is noise by chance."""

TRUSTED = 0.8
"""Largest relative error of the model with which a repeat leaves less than it finds, with a margin of a fifth."""

GROWN = 1.5
"""Factor by which the power of an error has grown near a frequency where learning made it worse."""

WORSE = 1.1
"""Factor on the least error so far from which on the last repeat counts as worse, not as noise by chance."""

SAME_VOLTAGE = 1e-4
"""Rms difference of two voltages, as a share of their range, up to which they are one voltage played twice."""


def learn(
    model: Model, reference: Sampled, plays: Sequence[Record], given: Limits | None = None, loop: bool = False
) -> Waveform:
    """The next voltage for a reference after the plays so far, oldest first; plays of one voltage are averaged.

    loop: as for `plan`, and for the plays. Raises RecordError for a play that does not cover the reference.
    """
    stage, n = own_response(model), reference.values.size
    lead = lead_samples(stage, reference.values, limits_of(model, given), loop)
    volts: list[Floats] = []
    readings: list[Floats] = []
    answers: list[Floats] = []
    counts: list[int] = []
    scatter = 0.0
    for record in plays:
        u_V, y_um = _aligned(record, reference, lead, model.Ts_s)
        same_V = SAME_VOLTAGE * float(np.ptp(u_V))
        known = next((i for i, other in enumerate(volts) if np.sqrt(np.mean((u_V - other) ** 2)) <= same_V), None)
        if known is None:
            volts.append(u_V)
            readings.append(y_um)
            answers.append(stage.simulate(u_V)[lead:])
            counts.append(1)
        else:
            scatter += float(np.mean((y_um - readings[known]) ** 2)) * counts[known] / (counts[known] + 1)
            readings[known] = readings[known] + (y_um - readings[known]) / (counts[known] + 1)
            counts[known] += 1
    errors = [reference.values - y_um for y_um in readings]
    rms = [float(np.sqrt(np.mean(e**2))) for e in errors]
    repeated = sum(counts) - len(counts)
    noise_um = math.sqrt(scatter / repeated) if repeated else residual_noise(errors[-1])
    base = len(rms) - 1 if rms[-1] <= WORSE * min(rms) else int(np.argmin(rms))
    spectra = [np.asarray(dct(e, norm="ortho")) for e in errors]
    power, noise = _power(spectra[base]), noise_um**2 / counts[base]
    Q = np.where(power > NOISE_FACTOR * noise, 1.0 - noise / np.maximum(power, 1e-300), 0.0)
    # Over a whole repeat, above the noise and but for a constant.
    missed = max(float(np.var(readings[base] - answers[base])) - noise_um**2, 0.0)
    wrong = np.full(n, math.sqrt(missed / max(float(np.var(answers[base])), 1e-300)))
    for late, early in zip(range(len(volts) - 1, 0, -1), range(len(volts) - 2, -1, -1), strict=True):
        moved = np.asarray(dct(answers[late] - answers[early], norm="ortho"))
        apart = np.asarray(dct(readings[late] - readings[early], norm="ortho")) - moved
        change, unseen = _power(moved), noise_um**2 * (1.0 / counts[late] + 1.0 / counts[early])
        seen = change > NOISE_FACTOR * unseen
        wrong[seen] = np.sqrt(np.maximum(_power(apart)[seen] - unseen, 0.0) / change[seen])
        Q[(_power(spectra[late]) > GROWN * _power(spectra[early]) + NOISE_FACTOR * unseen) & (late > base)] = 0.0
    Q[wrong > TRUSTED] = 0.0
    learnt = np.flatnonzero(Q > 0.0)
    leaves = float((1.0 - Q + wrong * Q)[learnt].max()) if learnt.size else (1.0 if (wrong > TRUSTED).all() else 0.0)
    aim = answers[base] + np.asarray(idct(Q * spectra[base], norm="ortho"))
    wanted = Sampled(aim, reference.start_s, f"{reference.source}, next repeat", reference.remarks)
    highest = None if not learnt.size else float(learnt[-1]) / (2.0 * n * model.Ts_s)
    learning = Learning(tuple(rms), noise_um, base + 1, highest, leaves)
    return replace(plan(model, wanted, given, loop=loop), learning=learning)


def _aligned(record: Record, reference: Sampled, lead: int, Ts_s: float) -> tuple[Floats, Floats]:
    """Voltage from `lead` samples before the reference on, and displacement along it, at the period of the model.

    A record whose time begins at 0 begins with the first voltage.
    """
    segment, start_s = record.segments[0], reference.start_s - lead * Ts_s
    begin_s = segment.start_s if segment.start_s != 0.0 else start_s
    time_s = begin_s + record.Ts_s * np.arange(segment.samples, dtype=np.float64)
    u, y = (at_rate(Series(time_s, values, record.source, ()), Ts_s).values for values in (segment.u_V, segment.y_um))
    first, count = round((start_s - begin_s) / Ts_s), lead + reference.values.size
    if first < 0 or first + count > u.size:
        raise RecordError(
            f"{record.source}: holds {begin_s:.6g} .. {time_s[-1]:.6g} s, the voltage {start_s:.6g} .. "
            f"{start_s + (count - 1) * Ts_s:.6g} s; record the whole repeat, from its first voltage on"
        )
    return u[first : first + count], y[first + lead : first + count]


def _power(spectrum: Floats) -> Floats:
    """Mean of the squares near each frequency, over a width that rises with it: a sixteenth of it to both sides."""
    sums = np.concatenate([[0.0], np.cumsum(spectrum**2)])
    k = np.arange(spectrum.size)
    half = 2 + k // 16
    low, high = np.maximum(k - half, 0), np.minimum(k + half + 1, spectrum.size)
    return np.asarray((sums[high] - sums[low]) / (high - low))

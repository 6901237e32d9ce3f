"""Learning over repeats: the voltage of the next repeat, from the records of those that were played.

    e = r - y,   next reference = m + Q e,   m = answer of the model to the voltage that was played

The voltage of the next reference is the inverse of the model, so a stage P' whose model is P leaves (1 - Q T) e, T =
P'/P, noise apart:

    Q = q (1 - s^2/S_e), 0 where S_e < NOISE_FACTOR s^2        S_e(f): power of e near f, s^2: of what does not repeat

of the error mirrored at its end, so that it has none; q, which turns and scales e at each frequency, is that of
`passing`: what the plays say that the stage passes, as far as they do. Where all of Q is 0, there is nothing to learn.
At times where two repeats did not lower the error that they were to lower, and at most times did, as behind a limit
that the model lacks, e and m are those of the repeat with the least error there, and e is not learnt.
Source: Bristow, Tharayil and Alleyne, IEEE Control Systems 26 (2006) 96-114, plant inversion and the Q-filter.
"""

import math
from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np
import scipy  # its parts are imported where they work
from numpy.typing import NDArray
from scipy.fft import dct
from scipy.ndimage import maximum_filter1d

from hysgen.errors import RecordError
from hysgen.model.model import Model
from hysgen.model.residual import residual_noise
from hysgen.record import Record
from hysgen.trajectory.inverse import in_whole_samples, own_response
from hysgen.trajectory.limits import Limits, limits_of
from hysgen.trajectory.passing import learnt, mean_near, passing
from hysgen.trajectory.plan import Learning, Waveform, lead_samples, plan
from hysgen.trajectory.reference import Sampled, Series, at_rate

Floats = NDArray[np.float64]

NOISE_FACTOR = 2.0
"""Power of an error over that of the noise from which on it is learnt; less is noise by chance."""

TRUSTED = 0.8
"""Largest relative error of the model with which a repeat leaves less than it finds, with a margin of a fifth."""

FALLEN, FORESEEN = 0.8, 0.9
"""Share of the mean square near a time that stays where two repeats did not lower it; and that a repeat was to leave,
by the model, above which it does not matter: limits that the model knows leave it."""

MOST_LEFT = 0.99
"""Largest share of an error that is said to be left of what is learnt: the mean over the draws is less than all."""

NEAR = 1 / 16
"""Share of a repeat to both sides of a time over which an error is averaged: long beside lag and ringing of a stage
that is followed for some periods."""

WORSE = 1.1
"""Factor on the least error so far from which on the last repeat counts as worse, not as noise by chance."""

SAME_VOLTAGE = 1e-5
"""Rms difference of two voltages, as a share of their range, up to which they are one voltage played twice."""

MEDIAN = 0.4549
"""Median of the square of a normal number of variance 1."""


def learn(
    model: Model, reference: Sampled, plays: Sequence[Record], given: Limits | None = None, loop: bool = False
) -> Waveform:
    """The next voltage for a reference after the plays so far, oldest first; plays of one voltage are averaged.

    loop: as for `plan`, and for the plays. Raises RecordError for a play that does not cover the reference.
    """
    (stage, _), n = in_whole_samples(own_response(model)), reference.values.size
    lead = lead_samples(stage, reference.values, limits_of(model, given), loop)
    volts: list[Floats] = []
    courses: list[Floats] = []
    missed: list[Floats] = []
    counts: list[int] = []
    scatter = 0.0
    for record in plays:
        u_V, y_um = _aligned(record, reference, lead, model.Ts_s)
        course, same_V = stage.simulate(u_V), SAME_VOLTAGE * float(np.ptp(u_V))
        answer = course[lead:]
        known = next((i for i, other in enumerate(volts) if np.sqrt(np.mean((u_V - other) ** 2)) <= same_V), None)
        if known is None:
            volts.append(u_V)
            courses.append(course)
            missed.append(y_um - answer)
            counts.append(1)
        else:
            counts[known] += 1
            again = y_um - answer - missed[known]
            scatter += float(np.mean(again**2)) * (1.0 - 1.0 / counts[known])
            missed[known] = missed[known] + again / counts[known]
    answers = [course[lead:] for course in courses]
    errors = [reference.values - answer - wrong for answer, wrong in zip(answers, missed, strict=True)]
    rms = [float(np.sqrt(np.mean(e**2))) for e in errors]
    pairs = [(late, 1.0 / counts[late] + 1.0 / counts[late - 1]) for late in range(1, len(rms))]
    # What is white in an error, and in what changes of the model's error from one voltage to another.
    changes = [np.median(dct(missed[late] - missed[late - 1], norm="ortho") ** 2) / (MEDIAN * by) for late, by in pairs]
    repeated = sum(counts) - len(counts)
    noise_um = math.sqrt(scatter / repeated if repeated else min([residual_noise(errors[-1]) ** 2, *changes]))
    base = len(rms) - 1 if rms[-1] <= WORSE * min(rms) else int(np.argmin(rms))
    # What each voltage but the first was to leave, by the model, of the error before it: limits leave much.
    moved = [np.zeros(n), *(later - earlier for earlier, later in pairwise(answers))]
    foreseen = [e - change for e, change in zip([errors[0], *errors], moved, strict=False)]
    weights, trust = _by_time(errors, foreseen, base, noise_um)
    from_um, error_um = (np.sum(weights * rows, axis=0) for rows in (answers, errors))
    spectrum = np.asarray(dct(trust * error_um, norm="ortho"))
    power, noise = mean_near(spectrum**2, 2, 1 / 16), noise_um**2 / counts[base]
    passed = passing(model, courses, missed, counts, noise_um)
    share, remains = learnt(model, passed, np.arange(n + 1) / (2.0 * n * model.Ts_s))
    # Over a whole repeat, above the noise and but for a constant.
    wrong = float(np.var(missed[base])) - noise_um**2 > TRUSTED**2 * float(np.var(answers[base]))
    above = power > NOISE_FACTOR * noise
    Q = np.where(above & (not wrong), share[:n] * (1.0 - noise / np.maximum(power, 1e-300)), 0.0)
    rows, repeats, lost = np.flatnonzero(Q), power - noise, (1.0 - trust**2) * (error_um**2 - noise)
    parts = (np.sum(repeats[above & (Q == 0.0)]), np.sum(repeats[~above]), np.sum(lost))
    stays = sum(max(float(part), 0.0) for part in parts) / n
    mirrored = np.concatenate([trust * error_um, (trust * error_um)[::-1]])
    aim = from_um + np.fft.irfft(np.append(Q, 0.0) * np.fft.rfft(mirrored))[:n]
    wanted = Sampled(aim, reference.start_s, f"{reference.source}, next repeat", reference.remarks)
    highest = None if not rows.size else float(rows[-1]) / (2.0 * n * model.Ts_s)
    # What is learnt of one play holds its noise.
    after = np.minimum(
        remains[:n] ** 2 * power + (1.0 - noise / np.maximum(power, 1e-300)) ** 2 * noise, MOST_LEFT * power
    )
    leaves = float(np.sum(after[rows]) / max(np.sum(power[rows]), 1e-300))
    learning = Learning(tuple(rms), noise_um, base + 1, highest, 1.0 if wrong else math.sqrt(leaves), math.sqrt(stays))
    return replace(plan(model, wanted, given, loop=loop, last_V=volts[base]), learning=learning)


def _by_time(errors: Sequence[Floats], foreseen: Sequence[Floats], base: int, noise_um: float) -> tuple[Floats, Floats]:
    """Weights of the repeats, (repeats, n), of sum 1, and how far the error is learnt, (n,), at each time.

    All of `base`, and all is learnt, but where two repeats did not lower the mean square near a time as foreseen, nor
    the second that of the first, and at most times did: a model that is wrong at some frequencies is so at all times,
    and left to the spectra.
    """
    n = errors[0].size
    half = max(round(NEAR * n), 1)
    window = np.hanning(2 * half + 1)
    whole = scipy.signal.fftconvolve(np.ones(n), window, "same")

    def near(values: Floats) -> Floats:
        return np.asarray(scipy.signal.fftconvolve(values, window, "same") / whole)

    power, promised = (np.array([near(e**2) for e in courses]) for courses in (errors, foreseen))
    stays = np.zeros(n)
    for k in range(2, len(errors)):
        # The first step of a large error may spill into its neighbourhood: one repeat is not enough.
        least = power[: k - 1].min(axis=0)
        ratio = power[k - 1 : k + 1].min(axis=0) / (least + NOISE_FACTOR * noise_um**2)
        stays[
            (ratio > FALLEN)
            & (power[k] > FALLEN * power[k - 1])
            & (promised[k - 1 : k + 1].max(axis=0) < FORESEEN * least)
            & bool(np.median(ratio) < FALLEN)
        ] = 1.0
    # A window has no weight at its ends.
    back, reached = near(stays), maximum_filter1d(stays, 2 * half - 1, mode="constant")
    best = np.arange(len(errors))[:, None] == np.argmin(power, axis=0)
    weights = np.array([back * near(row.astype(np.float64)) for row in best])
    weights[base] += 1.0 - weights.sum(axis=0)
    return weights, 1.0 - near(reached)


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

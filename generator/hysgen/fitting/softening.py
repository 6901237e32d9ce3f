"""Identification of modes whose frequency follows a bounded amplitude, by output error of the free run.

    y = c + Re sum_m c_m,   c_m and the amplitude s as in `model.path.softening`

The start is the structure of all rows together, each segment weighted by what a model is expected to leave of it, with
more modes than its error supports: the amplitude takes away most of it. All numbers are refined jointly by
Levenberg-Marquardt with exact sensitivities. Rows that the fit leaves out decide whether the amplitude is wanted: every
third segment, or of fewer the last third of each.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve

from hysgen.fitting.structure import LAG, ModalForm, admitted_poles, identify_structure, steady_period
from hysgen.machine.kernels.operators import MOST_DRIVES, MOST_MODES, softening_slopes, softening_states
from hysgen.model.path.softening import MOST, Softening

Floats = NDArray[np.float64]

CHARGE: Final = 0.1
"""Part of Schwarz's charge for a mode of the start: what the amplitude explains hides the weaker ones."""
POWER: Final = 0.75
"""Power of the rms of a segment with which the error that is expected of it grows."""
PERIODS: Final = 4.0
"""Periods of the strongest mode in which the amplitude follows."""
START: Final = 0.3
"""Weight of the displacement in the amplitude at the start, in 1 / its largest rms."""
LARGEST = 0.9993
"""Largest |lam| at any amplitude: slower sensitivities do not settle before the fitted rows."""
SETTLED: Final = 3000
"""Rows of a steady period that run before it."""
MOST_ROWS: Final = 100_000
LEAST_FALL: Final = 0.05
"""Least fall of the error of rows left out by which an amplitude is worth its cycles."""
ROUGH, FINE, LEAST_STEP = 12, 25, 1e-3
"""Steps from the start, and from the numbers that the check found; relative fall of the squares that ends them."""


@dataclass(frozen=True, eq=False)
class Course:
    """A run: inputs v (n, M), displacement y of the last rows, `weight` of an error. y and v about the middles."""

    v: Floats
    y: Floats
    weight: float

    def part(self, first: float, last: float) -> "Course":
        """From the same start, with the rows from one share of those that are fitted to another."""
        start, stop = (round(share * self.y.size) for share in (first, last))
        return replace(self, v=self.v[: self.v.shape[0] - self.y.size + stop], y=self.y[start:stop])


@dataclass(frozen=True, eq=False)
class Numbers:
    """(N, 6 + 4 M) of `softening_states`, the constant in um, and the rate of the amplitude."""

    rows: Floats
    constant_um: float
    rate: float

    def run(self, course: Course) -> tuple[tuple[Floats, Floats], Floats]:
        """States and motion along a course, and the weighted error of its fitted rows."""
        states = softening_states(course.v, self.rows, self.rate, MOST)
        y = states[1][-course.y.size :, 0] + self.constant_um
        return states, np.nan_to_num((y - course.y) * course.weight, nan=1e9, posinf=1e9, neginf=-1e9)

    def power(self, courses: Sequence[Course]) -> float:
        return sum(float(e @ e) for e in (self.run(course)[1] for course in courses))

    def centred(self, courses: Sequence[Course]) -> "Numbers":
        """With the constant that leaves the least of the courses."""
        runs = [(course, self.run(course)[1]) for course in courses]
        mean = sum(course.weight * float(e.sum()) for course, e in runs)
        mean /= sum(course.weight**2 * e.size for course, e in runs)
        return replace(self, constant_um=self.constant_um - mean)

    def moved(self, step: Floats) -> "Numbers":
        """The numbers after a step, with poles that decay at every amplitude."""
        rows = self.rows + step[:-1].reshape(self.rows.shape)
        poles = admitted_poles(rows[:, 0] + 1j * rows[:, 1])
        rows[:, 0], rows[:, 1] = poles.real, np.copysign(poles.imag, rows[:, 1])
        # |lam + t s f| reaches its bound at one t > 0.
        lam, whole = rows[:, :2], MOST / (1.0 + MOST) * rows[:, 2:4]
        square, across = np.maximum((whole**2).sum(axis=1), 1e-30), (lam * whole).sum(axis=1)
        room = LARGEST**2 - (lam**2).sum(axis=1)
        rows[:, 2:4] *= np.minimum((-across + np.sqrt(across**2 + square * room)) / square, 1.0)[:, None]
        return replace(self, rows=rows, constant_um=self.constant_um + float(step[-1]))


def identify_softening(
    inputs: Sequence[Floats], y_um: Sequence[Floats], form: ModalForm, channels: Mapping[str, tuple[float, float]]
) -> ModalForm | None:
    """The modes with the amplitude that moves them; None if rows that were left out do not want it.

    inputs: (M, n), the command first, and y_um: (n,) of each segment. form: of all segments. channels: name and range
    of each other input. Deterministic.
    """
    middle = np.array([0.5 * (low + high) for low, high in _ranges(inputs, channels)])
    level = float(np.mean(np.concatenate(list(y_um))))
    weights = [1.0 / max(float(np.std(y)), 1e-12) ** POWER for y in y_um]
    scaled = [w / max(weights) for w in weights]
    start = identify_structure(
        [w * v for w, v in zip(scaled, inputs, strict=True)],
        [w * y for w, y in zip(scaled, y_um, strict=True)],
        form.Ts_s,
        CHARGE,
    )
    if start.poles.size > MOST_MODES or len(middle) > MOST_DRIVES:
        return None
    courses = [
        course_of((v - middle[:, None]).T, y - level, w, len(y_um))
        for v, y, w in zip(inputs, y_um, weights, strict=True)
    ]
    fitted, checked = _split(courses)
    rms_um = max(float(np.std(y)) for y in y_um)
    known, begun = (_start(modes, rms_um).centred(fitted) for modes in (form, start))
    numbers = _refined(begun, fitted, ROUGH)
    linear = min(known.power(checked), begun.power(checked))
    if not numbers.power(checked) < (1.0 - LEAST_FALL) ** 2 * linear:
        return None
    return _form(_refined(numbers, courses, FINE), courses, form.Ts_s, (middle, level), channels)


def _ranges(inputs: Sequence[Floats], channels: Mapping[str, tuple[float, float]]) -> list[tuple[float, float]]:
    own = np.concatenate([v[0] for v in inputs])
    return [(float(own.min()), float(own.max())), *channels.values()]


def course_of(v: Floats, y: Floats, weight: float, segments: int) -> Course:
    """A segment: the mean of its last periods behind a part of it, or its rows after the first, of unknown past."""
    period = steady_period(v.T)
    if period is None:
        rows = min(y.size, max(MOST_ROWS // segments, 1))
        return Course(v[:rows], y[min(SKIPPED, rows // 2) : rows], weight)
    count = y.size // period
    last = slice(y.size - (count - (count > 2)) * period, None)
    steady, mean = (x[last].reshape(-1, period, *x.shape[1:]).mean(axis=0) for x in (v, y))
    before = np.tile(steady, (SETTLED // period + 1, 1))[-SETTLED:]
    return Course(np.concatenate([before, steady]), mean, weight)


SKIPPED: Final = 512


def _split(courses: Sequence[Course]) -> tuple[list[Course], list[Course]]:
    """What is fitted, and what is left out: every third course, or of fewer the last third of each."""
    if len(courses) < 3:
        return [course.part(0.0, 2.0 / 3.0) for course in courses], [course.part(2.0 / 3.0, 1.0) for course in courses]
    return [c for i, c in enumerate(courses) if i % 3 != 1], [c for i, c in enumerate(courses) if i % 3 == 1]


def _start(form: ModalForm, rms_um: float) -> Numbers:
    """The modes of a form, which no amplitude moves yet."""
    shares = form.gains / (1.0 - form.poles)[:, None]
    strongest = int(np.argmax(np.abs(shares).max(axis=1) / (1.0 - np.abs(form.poles))))
    rows = np.zeros((form.poles.size, 6 + 4 * shares.shape[1]))
    rows[:, 0], rows[:, 1], rows[:, 4] = form.poles.real, form.poles.imag, START / rms_um
    rows[:, 6 : 6 + 2 * shares.shape[1]] = np.concatenate([shares.real, shares.imag], axis=1)
    samples = PERIODS * 2.0 * math.pi / abs(float(np.angle(form.poles[strongest])))
    return Numbers(rows, 0.0, 1.0 - math.exp(-1.0 / samples))


def _refined(numbers: Numbers, courses: Sequence[Course], steps: int) -> Numbers:
    """Levenberg-Marquardt over all numbers and the constant."""
    mu, power = 1e-2, numbers.power(courses)
    for _ in range(steps):
        square, product = _normal(numbers, courses)
        scale = np.sqrt(np.diag(square)) + 1e-30
        scaled, before = square / np.outer(scale, scale), power
        for _ in range(8):
            step = solve(scaled + mu * np.eye(scale.size), product / scale, assume_a="pos") / scale
            trial = numbers.moved(-step)
            error = trial.power(courses)
            if error < power:
                numbers, power, mu = trial, error, max(mu / 4.0, 1e-7)
                break
            mu *= 4.0
        if before - power < LEAST_STEP * before:
            break
    return numbers


def _normal(numbers: Numbers, courses: Sequence[Course]) -> tuple[Floats, Floats]:
    """J'J and J'e of all courses, float32 products added in float64."""
    size = numbers.rows.size + 1
    square, product = np.zeros((size, size)), np.zeros(size)
    for course in courses:
        states, error = numbers.run(course)
        J = np.empty((course.y.size, size), dtype=np.float32)
        J[:, :-1] = softening_slopes(course.v, numbers.rows, numbers.rate, states)[-course.y.size :]
        J[:, -1] = 1.0
        J *= np.float32(course.weight)
        square += J.T @ J
        product += J.T @ error.astype(np.float32)
    return square, product


def _form(
    numbers: Numbers,
    courses: Sequence[Course],
    Ts_s: float,
    about: tuple[Floats, float],
    channels: Mapping[str, tuple[float, float]],
) -> ModalForm:
    """The modes at no amplitude, in rising order, with their block, in um."""
    square, _ = _normal(numbers, courses)
    runs = [numbers.run(course) for course in courses]
    variance = sum(float(e @ e) for _, e in runs) / max(sum(e.size for _, e in runs) - len(square), 1)
    scale = np.sqrt(np.diag(square)) + 1e-30
    inverse = np.linalg.pinv(square / np.outer(scale, scale), 1e-9, hermitian=True)
    errors = np.sqrt(np.maximum(np.diag(inverse), 0.0) * variance) / scale
    order = np.argsort(np.abs(np.log(numbers.rows[:, 0] + 1j * numbers.rows[:, 1])), kind="stable")
    rows, errors = numbers.rows[order], errors[:-1].reshape(numbers.rows.shape)[order, :2]
    (middle, level), M = about, about[0].size
    # Modes turn backwards in a block, forwards in a form; one that turned backwards is the same, mirrored.
    places = ((0, 1), (2, 1), (4, 1), (6, M), (6 + 2 * M, M))
    turned = [np.asarray(rows[:, i : i + n] - 1j * rows[:, i + n : i + 2 * n], dtype=np.complex128) for i, n in places]
    mirrored = turned[0].imag > 0.0
    poles, fall, seen, Q, R = (
        np.asarray(np.where(mirrored, values.conj(), values), dtype=np.complex128) for values in turned
    )
    gain, level = float(Q[:, 0].real.sum()), level + numbers.constant_um
    unit = np.append(gain, np.ones(M - 1))  # of the input in um
    errors_um = np.concatenate([error / course.weight for course, (_, error) in zip(courses, runs, strict=True)])
    form = ModalForm(
        poles=np.conj(poles[:, 0]),
        gains=np.conj(Q * (1.0 - poles)),
        constant_um=level - gain * float(middle[0]),
        Ts_s=Ts_s,
        rms_um=float(np.sqrt(np.mean(errors_um**2))),
        errors=errors,
    )
    falls, weights, shares, swings = (_parts(values) for values in (fall / (poles * Ts_s), seen, Q / unit, R / unit))
    block = Softening(
        channels=tuple(channels),
        low=tuple(low for low, _ in channels.values()),
        high=tuple(high for _, high in channels.values()),
        f_Hz=tuple(form.f_Hz.tolist()),
        zeta=tuple(form.zeta.tolist()),
        fall=falls[0],
        fall_quadrature=falls[1],
        seen=weights[0],
        seen_quadrature=weights[1],
        share=shares[0],
        quadrature=shares[1],
        swing=swings[0],
        swing_quadrature=swings[1],
        env_s=-Ts_s / math.log1p(-numbers.rate),
        level_um=level,
        gain=gain,
        middle_V=float(middle[0]),
        lag_s=LAG * Ts_s,
        Ts_s=Ts_s,
    )
    amplitude = max(float(states[1][:, 2].max()) for states, _ in runs)
    return replace(form, softening=block, amplitude=amplitude)


def _parts(values: NDArray[np.complex128]) -> tuple[tuple[float, ...], tuple[float, ...]]:
    return tuple(values.real.ravel().tolist()), tuple(values.imag.ravel().tolist())

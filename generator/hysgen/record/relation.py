"""Relation of displacement and voltage: warnings about a sensor that is unplugged, inverted or logged at another time.

    c(L) = sum_k u(k) y(k + L) / sqrt(sum u^2 sum y^2),   u and y about their means,   |L| <= n/4

A stage follows its voltage: the largest |c| is near 1, positive, and at a lag that is small beside the period of the
excitation. Nothing is refused here: a resonance, a slow stage or a cross-coupled axis may break each of these rules.

Steps of the voltage that the displacement answers in their own row, where the model has it answer from the next on:

    d(k) = y(k) - 2 y(k-1) + y(k-2),   s = sum d(k) du(k) / (g sum du(k)^2)   over the rows k with a step du(k)

d is what the displacement moves beyond its motion before the step, g the gain of the record. s is 0 for
y(k+1) = f(y(k), u(k)), and the first sample of the answer to a step where both columns were written at the end of a
period: such a log is one row off, and the error at every step would be taken for a fault of the sensor.

Feedback: what is new in a row of the voltage, e(k) = A(z) u(k), A an autoregression of order PREDICTED, against the
displacement through the same filter. A stage answers e(k) later; a controller answers the noise of the sensor with e(k)
of the opposite sign, in the row of the reading or soon after (Box and Jenkins, 1970, section 11.2).
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.fft import irfft, next_fast_len, rfft

from hysgen.record.columns import split_unit
from hysgen.record.names import roles_in
from hysgen.record.segment import Segment
from hysgen.record.series import plateaus, resolution_um, white_noise
from hysgen.record.wrong_readings import unanswered

Floats = NDArray[np.float64]

FEWEST = 200
"""Fewest samples for which a correlation is significant."""

WINDOWS = 16
"""Windows of a coherence, which overlap by half."""

MOST = 400_000
"""Samples of the longest run that are correlated."""

PREDICTED, REACTION, REACTS = 20, 4, -0.1
"""Order of the prediction of the voltage, rows within which a controller reacts, and the correlation from which on it
does: open loops stay above -0.05, one of 400 rows at six standard errors above -0.3."""

FIRST_PEAK = 0.9
"""Height of a peak of |c|, relative to the highest, that makes it a candidate."""

UNRELATED = 0.4
"""Largest |c| up to which the displacement may not follow the voltage; c^2 is the share of variance explained."""

UNEXPLAINED = 0.05
"""Share of the variance that a linear response must explain; of a mirror with three drives, one explains 13 %."""

SLOW, STRONG = 0.02, 0.01
"""Share of the voltage's power, from the lowest frequency on, in which an inverted sensor is looked for; least power of
a frequency there, as a share of the largest."""

LATE, TOGETHER = 0.9, 0.5
"""The logs may not be aligned where c is at least LATE at the best lag and below TOGETHER at lag 0: a phase of more
than 60 degrees at one frequency. A time constant of 1 ms has 32 at 100 Hz, hysteresis of 20 % adds 12."""

LONGEST_STROKE_UM, SHORTEST_STROKE_UM = 1000.0, 2e-3
"""Strokes of piezo stages: flexure stages reach 1 mm, and 2 nm is the noise of a sensor."""

REPEATS, REGULAR, FEWEST_CHANGES = 0.4, 0.9, 20
"""Share of rows that repeat the displacement, share of equally long holds, and changes, from which on a sensor is
slower than the log."""

SLOWEST_HZ, FASTEST_HZ = 100.0, 20e6
"""Sampling rates outside of which the unit of the time is in doubt."""


@dataclass(frozen=True)
class Lag:
    """correlation: c at the peak, at the lag `samples`, which is positive if y follows u. at_zero: c(0)."""

    samples: int
    correlation: float
    at_zero: float

    @property
    def misaligned(self) -> bool:
        """Whether the lag is so large that the two logs may not be aligned."""
        return self.correlation >= LATE and self.at_zero < TOGETHER

    @property
    def way(self) -> str:
        """Where the displacement runs: behind the voltage or ahead of it."""
        return "behind" if self.samples > 0 else "ahead of"


def correlations(u_V: Floats, y_um: Floats) -> tuple[NDArray[np.int64], Floats] | None:
    """The lags L of up to a quarter of the run, and c(L); None for short or constant series."""
    n = min(u_V.size, MOST)
    u, y = (values[:n] - values[:n].mean() for values in (u_V, y_um))
    scale = float(np.sqrt((u @ u) * (y @ y)))
    if n < FEWEST or scale == 0.0:
        return None
    size = next_fast_len(n + n // 4 + 1, real=True)
    cross = irfft(np.conj(rfft(u, size)) * rfft(y, size), size) / scale
    lags = np.arange(-(n // 4), n // 4 + 1)
    return lags, cross[lags]


def lag_of(run: Segment) -> Lag | None:
    """The lag of the peak of |c| nearest to 0 among the high ones; None for short or constant channels."""
    found = correlations(run.u_V, run.y_um)
    if found is None:
        return None
    lags, c = found
    # A periodic input has a peak in every half period, of alternating sign: the first high one is the stage's.
    high = np.flatnonzero(np.abs(c) >= FIRST_PEAK * np.abs(c).max())
    near = int(high[np.argmin(np.abs(lags[high]))])
    bounds = np.flatnonzero(np.sign(c) != np.sign(c[near]))
    begin = int(bounds[bounds < near].max(initial=-1)) + 1
    end = int(bounds[bounds > near].min(initial=c.size))
    chosen = begin + int(np.argmax(np.abs(c[begin:end])))
    return Lag(int(lags[chosen]), float(c[chosen]), float(c[lags == 0][0]))


def misaligned(runs: Sequence[Segment]) -> Lag | None:
    """The lag of the longest run if it is so large that the two logs may not be aligned, else None."""
    lag = lag_of(max(runs, key=lambda one: one.u_V.size))
    return lag if lag is not None and lag.misaligned else None


def coherent_share(run: Segment) -> float:
    """Share of the variance of y that a linear response to u explains, 0 to 1.

        sum_f C(f) S_yy(f) / sum_f S_yy(f),   C = |S_uy|^2 / (S_uu S_yy),   less its bias 1/K for K windows

    A lightly damped mode under noise has a small correlation at every lag and a share near 1.
    """
    from scipy.signal import csd  # takes long to import, and few records need it

    n = min(run.u_V.size, MOST)
    length = max(16, n // WINDOWS)
    u, y = run.u_V[:n], run.y_um[:n]
    uu, yy, uy = (csd(*pair, nperseg=length, scaling="spectrum")[1] for pair in ((u, u), (y, y), (u, y)))
    explained = np.divide(np.abs(uy) ** 2, uu.real, out=np.zeros(uu.size), where=uu.real > 1e-12 * uu.real.max())
    share, bias = float(explained.sum() / max(float(yy.real.sum()), 1e-300)), 2.0 / ((n - length) // (length // 2) + 1)
    return max(share - bias, 0.0) / (1.0 - bias)


def unrelated(runs: Sequence[Segment]) -> float | None:
    """Share of the variance that a linear response explains if y does not follow u, on the longest run; else None."""
    run = max(runs, key=lambda segment: segment.u_V.size)
    lag = lag_of(run)
    share = 1.0 if lag is None or abs(lag.correlation) >= UNRELATED else coherent_share(run)
    return share if share < UNEXPLAINED else None


def fed_back(runs: Sequence[Segment]) -> float | None:
    """Least correlation of the displacement with what is new in the voltage thereafter, if it tells feedback; or None.

    On the longest run; of the sign of the gain, so that an inverted sensor does not look like a controller.
    """
    run = max(runs, key=lambda segment: segment.samples)
    n = min(run.samples, MOST)
    u, y = (values[:n] - values[:n].mean() for values in (run.u_V, run.y_um))
    if n < 2 * FEWEST:
        return None
    past = np.lib.stride_tricks.sliding_window_view(u, PREDICTED)[:-1]
    weights = np.linalg.lstsq(past, u[PREDICTED:], rcond=1e-12)[0]
    new, seen = (
        values[PREDICTED:] - np.lib.stride_tricks.sliding_window_view(values, PREDICTED)[:-1] @ weights
        for values in (u, y)
    )
    scale = math.sqrt(float(new @ new) * float(seen @ seen)) * np.sign(u @ y)
    if scale == 0.0:
        return None
    least = min(float(new[rows:] @ seen[: seen.size - rows]) / scale for rows in range(REACTION))
    return least if least < min(REACTS, -6.0 / math.sqrt(n)) else None


def slow_response(run: Segment) -> float:
    """Correlation of displacement and voltage at the lowest frequencies that hold SLOW of the voltage's power, -1 to 1.

    Above a resonance a sound displacement moves against the voltage; below, only one of an inverted sensor does.
    """
    n = min(run.u_V.size, MOST) // 64 * 64  # a number without large factors is transformed fast
    ramp = np.linspace(-1.0, 1.0, n)
    about = (values[:n] - values[:n].mean() for values in (run.u_V, run.y_um))
    u, y = (rfft(part - ramp * float(ramp @ part) / float(ramp @ ramp)) for part in about)
    # Where the voltage has little power, a drift of the displacement would decide.
    strong = np.flatnonzero(np.abs(u) ** 2 > STRONG * float(np.max(np.abs(u) ** 2)))
    power = np.cumsum(np.abs(u[strong]) ** 2)
    slow = strong[: int(np.searchsorted(power, SLOW * power[-1])) + 1]
    scale = float(np.sqrt(np.sum(np.abs(u[slow]) ** 2) * np.sum(np.abs(y[slow]) ** 2)))
    return float(np.sum(np.conj(u[slow]) * y[slow]).real) / scale if scale > 0.0 else 0.0


def relation(runs: Sequence[Segment], Ts_s: float | None) -> Iterator[str]:
    """A line for a displacement that does not follow the voltage, falls as it rises, or follows at another time.

    One for feedback, too. Judged on the longest run, and on the steps of all (`same_row`). Ts_s: sampling period in s,
    None if not known yet.
    """
    yield from same_row(runs)
    yield from lone_voltages(runs)
    if stuck := [*stands(runs)]:
        yield from stuck
        return
    reaction = fed_back(runs)
    if reaction is not None:
        yield (
            f"{runs[0].origin.source}: {runs[0].origin.voltage} reacts to {runs[0].origin.displacement} (correlation "
            f"{reaction:.2f} with its noise): recorded while a controller ran, which moves creep and drift from the "
            "displacement into the voltage; to tell them apart, record in open loop"
        )
    run = max(runs, key=lambda one: one.u_V.size)
    lag = lag_of(run)
    if lag is None:
        return
    names, drive = f"{run.origin.source}: {run.origin.displacement}", run.origin.voltage
    slow = slow_response(run)
    falls = slow < UNRELATED if lag.correlation <= -UNRELATED else slow < -UNRELATED and lag.correlation < UNRELATED
    if falls and coherent_share(run) > UNEXPLAINED:
        yield (
            f"{names} falls as {drive} rises slowly (correlation {slow:.2f}): an inverted sensor? Then --columns "
            f"displacement_unit=-1{run.quantities.output_unit} changes its sign"
        )
        return
    if abs(lag.correlation) < UNRELATED:
        share = unrelated([run])
        if share is not None:
            yield (
                f"{names} does not follow {drive}: largest correlation {lag.correlation:.2f}, a linear response "
                f"explains {100.0 * share:.0f} % of it; check that the sensor is connected and the columns are right"
                + "".join(f"; {name} follows it: --columns displacement={name}" for name in followers([run]))
            )
        return
    if lag.correlation > 0.0 and lag.misaligned:
        time = "" if Ts_s is None else f" ({abs(lag.samples) * Ts_s:.3g} s)"
        yield (
            f"{names} runs {abs(lag.samples)} samples{time} {lag.way} {drive}, lag and hysteresis of the stage "
            f"included: correlation {lag.correlation:.2f} there, {lag.at_zero:.2f} without a shift; if the stage is "
            f"faster, the logs are not aligned: --columns shift={-lag.samples} moves the displacement by all of it"
        )


SHORTEST_PACKET = 10
"""Equal readings that noise does not make."""

RARE, STUCK, SWEPT = 0.002, 0.05, 0.5
"""Share of rows whose voltage may be a wrong reading; of rows in which a displacement that stands is stuck, while the
voltage sweeps this share of its range."""


def lone_voltages(runs: Sequence[Segment]) -> Iterator[str]:
    """A line for a voltage that few rows have, farther off all others than they are from each other, or unanswered."""
    for run in runs:
        low, high = np.quantile(run.u_V, (RARE, 1.0 - RARE))
        rows = np.flatnonzero(np.maximum(low - run.u_V, run.u_V - high) > high - low)
        why = f"others {low:.6g} .. {high:.6g} V"
        if not rows.size and (spans := unanswered(run)):
            rows, why = np.arange(*spans[0]), f"and {run.origin.displacement} does not answer"
        if rows.size and high > low:
            what = f"{run.origin.voltage} is {run.u_V[rows[0]]:.6g} V ({rows.size} such rows)"
            yield f"{run.origin.at(int(rows[0]))}: {what}, {why}: wrong? Then correct it"


def stands(runs: Sequence[Segment]) -> Iterator[str]:
    """A line for a displacement that stands while the voltage sweeps SWEPT of its range, or where its noise stands too.

    With noise of more than half the resolution, equal readings are no rest, but a packet that a logger put twice.
    """
    for run in runs:
        noisy = white_noise(run.y_um) > 0.5 * resolution_um(run.y_um) > 0.0
        lengths = np.diff(np.flatnonzero(np.diff(run.y_um, prepend=np.nan, append=np.nan)))
        packet = max(SHORTEST_PACKET, 3.0 * float(np.quantile(lengths, 0.99))) if noisy else math.inf
        for start, stop in plateaus(run.y_um, SHORTEST_PACKET):
            swept = np.ptp(run.u_V[start:stop]) > SWEPT * np.ptp(run.u_V)
            if (swept and stop - start >= max(FEWEST, int(STUCK * run.samples))) or stop - start >= packet:
                what = f"{run.origin.displacement} stands at {run.y_um[start]:.6g} um for {stop - start} rows"
                how = "while the voltage moves" if swept else "without its noise"
                yield f"{run.origin.at(start)}: {what} {how}: is the sensor stuck? Leave them out"


def followers(runs: Sequence[Segment]) -> Iterator[str]:
    """The further columns that follow the voltage and may be the displacement, where the one chosen does not.

    They are named as it is, x_um beside y_um, or by a word or unit of a displacement.
    """
    run = max(runs, key=lambda segment: segment.samples)
    chosen = lag_of(run) if run.aux else None
    if chosen is None or abs(chosen.correlation) >= TOGETHER:
        return
    name = run.origin.displacement
    for other, values in run.aux.items():
        alike = len(other) == len(name) and split_unit(other)[1] == split_unit(name)[1]
        if alike or "displacement" in roles_in([other]):
            lag = lag_of(replace(run, y_um=values))
            if lag is not None and lag.correlation >= LATE:
                yield other


def held(runs: Sequence[Segment], Ts_s: float) -> Iterator[str]:
    """A line for a sensor that is read less often than the log is written: it holds each value for equally many rows.

    Rows at which the voltage rests do not count; a sensor of few bits changes by its resolution, at any row.
    """
    run = max(runs, key=lambda part: part.samples)
    steps, moves = np.diff(run.y_um), np.diff(run.u_V) != 0.0
    changes = np.flatnonzero(steps)
    repeats = float(np.mean(steps[moves] == 0.0)) if moves.any() else 0.0
    if repeats < REPEATS or changes.size < FEWEST_CHANGES:
        return
    holds = np.diff(changes)
    rows = int(np.median(holds))
    sizes = np.abs(steps[changes])
    regular = np.mean((holds % rows == 0) | ((rows > 2) & (np.abs(holds - rows) <= 1))) if rows > 1 else 0.0
    if regular >= REGULAR and np.mean(sizes < 1.5 * sizes.min()) < 0.5:
        ordinal = {2: "2nd", 3: "3rd"}.get(rows, f"{rows}th")
        yield (
            f"{run.origin.source}: {run.origin.displacement} repeats its last value in {100.0 * repeats:.0f} % of the "
            f"rows while {run.origin.voltage} moves: the sensor is read every {rows * Ts_s:.3g} s; take every "
            f"{ordinal} row, from {run.origin.locate(int(changes[0]) + 1)} on"
        )


def scale(runs: Sequence[Segment]) -> Iterator[str]:
    """A line for a stroke that no piezo stage has: the unit of the displacement is in doubt."""
    name = f"{runs[0].origin.source}: {runs[0].origin.displacement}"
    stroke_um = max(float(one.y_um.max()) for one in runs) - min(float(one.y_um.min()) for one in runs)
    for doubtful, what, unit in (
        (stroke_um > LONGEST_STROKE_UM, "more than a piezo stage moves; if it is in nm", "nm"),
        (0.0 < stroke_um < SHORTEST_STROKE_UM, "less than the noise of a sensor; if it is in mm or m", "mm"),
    ):
        if doubtful:
            yield f"{name} spans {stroke_um:.4g} um, {what}, give --columns displacement_unit={unit}"


def rate(source: str, Ts_s: float) -> Iterator[str]:
    """A line for a sampling rate at which the unit of the time is in doubt."""
    rate_Hz = 1.0 / Ts_s
    if rate_Hz < SLOWEST_HZ:
        units = {"ms": 1e3, "us": 1e6, "ns": 1e9}
        unit = next((unit for unit, factor in units.items() if SLOWEST_HZ <= rate_Hz * factor <= FASTEST_HZ), None)
        cures = [] if unit is None else [f"if the time is in {unit}, give --columns time_unit={unit}"]
        if unit != "ms":
            cures.append("if it counts samples or ticks, --columns time=,Ts_s=SECONDS")
        yield f"{source}: is sampled at {rate_Hz:.4g} Hz; {'; '.join(cures)}"
    elif rate_Hz > FASTEST_HZ:
        yield f"{source}: is sampled at {1e-6 * rate_Hz:.4g} MHz; check the unit of the time, --columns time_unit=s"


FEWEST_STEPS = 3
"""Fewest steps: a single one may coincide with a knock."""

STEP, BEFORE = 0.02, 0.1
"""Least step, as a share of the range, and largest change in each of the two rows before it, as a share of the step."""

LEAST_SHARE, CLEARLY = 0.01, 5.0
"""Least share of the answer in the step's own row, that of a lag of 100 samples, and its standard errors."""


def same_row(runs: Sequence[Segment]) -> Iterator[str]:
    """A line for a displacement that answers a step of the voltage in the row of the step."""
    du, d = (np.concatenate(parts) for parts in zip(*map(_own_rows, runs), strict=True))
    gain = float(np.mean([_gain(run) for run in runs]))
    power = float(du @ du)
    if len(du) < FEWEST_STEPS or gain == 0.0:
        return
    share = float(d @ du) / power
    error = float(np.sqrt(np.sum(((d - share * du) * du) ** 2))) / power
    if share / gain > LEAST_SHARE and abs(share) > CLEARLY * error:
        file = runs[0].origin
        yield (
            f"{file.source}: {file.displacement} answers {len(du)} steps of {file.voltage} in their own rows (with "
            f"{100.0 * share / gain:.0f} % of the answer), but a voltage acts from the next row on: if it is "
            "written a row early, --columns shift=1"
        )


def _own_rows(run: Segment) -> tuple[Floats, Floats]:
    """(m,) steps du(k) of a run and the moves d(k) of the displacement in their rows."""
    du = np.diff(run.u_V)
    size = np.abs(du)
    quiet = (size[:-2] <= BEFORE * size[2:]) & (size[1:-1] <= BEFORE * size[2:])
    at = 2 + np.flatnonzero(quiet & (size[2:] >= STEP * np.ptp(run.u_V)) & (size[2:] > 0.0))
    y = run.y_um
    return du[at], y[at + 1] - 2.0 * y[at] + y[at - 1]


def _gain(run: Segment) -> float:
    """Slope of the straight line through displacement over voltage, um/V; 0 for a constant voltage."""
    u = run.u_V - run.u_V.mean()
    power = float(u @ u)
    return float(u @ run.y_um) / power if power > 0.0 else 0.0

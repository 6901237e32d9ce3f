"""Checks of the values of a record, independent of its file format; a saturated sensor and exchanged columns.

A certain finding is refused, a likely one is a warning: a valid record must not be refused.
"""

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from hysgen.errors import RecordError
from hysgen.record.segment import Segment
from hysgen.record.series import plateaus, resolution_um, white_noise

ACCEPTABLE = ("constant", "saturation", "swapped")
"""Refusals that the caller may turn into warnings."""

SHORTEST = 3
"""Samples that a run needs: two steps are the least from which a sampling period and its variation follow."""

NO_READING = 1e30
"""Magnitude from which on a number is no reading: SCPI instruments write 9.9e37 for an overload, 9.91e37 for none."""

MARKED = 0.01
"""Share of the rows below which a value such as -9999, far off all others, marks rows without a reading."""

LIMITS = frozenset(2.0**bits - less for bits in (15, 16, 31, 32, 63, 64) for less in (0.0, 1.0))
"""Magnitudes at which integers end."""

STANDING, JUMP, LEAST_JUMP = 3, 10.0, 0.05
"""Equal readings in a row that stand for none, if they are entered and left by a jump; least jump in usual steps (the
95 % quantile of those that are not 0) and as a share of the stroke."""


def check_marks(runs: Sequence[Segment], unit_V: float = 1.0, unit_um: float = 1.0) -> None:
    """Refuse numbers that stand for an overload or a missing reading, with the first row.

    unit_V, unit_um: what one in the file is.
    """
    for run in runs:
        in_file = replace(run, u_V=run.u_V / unit_V, y_um=run.y_um / unit_um)
        for name, values in in_file.channels():
            rows = np.isfinite(values) & (np.abs(values) >= NO_READING)
            what = "as instruments write for an overload or for no reading"
            ends = values[np.isfinite(values)]
            for end in (ends.min(), ends.max()) if ends.size and not rows.any() else ():
                if _is_mark(values, float(end)):
                    rows, what = values == end, "far off all others, as loggers write for no reading"
            if name == run.origin.displacement and not rows.any():
                rows, what = _standing(run), "which stands between two jumps, as loggers write for no reading"
            if rows.any():
                row = int(np.argmax(rows))
                raise RecordError(
                    f"{run.origin.at(row)}: {name} is {values[row]:.10g} ({np.count_nonzero(rows)} such values), "
                    f"{what}; correct it, or delete the row and read the rest with --split-at-gaps"
                )


def _is_mark(values: NDArray[np.float64], end: float) -> bool:
    """Whether the extreme value `end` is all nines or a limit of an integer, in few rows and far off all others."""
    digits = f"{abs(end):.10g}".replace(".", "")
    if not (abs(end) in LIMITS or (len(digits) > 2 and set(digits) == {"9"})):
        return False
    rest = values[(values != end) & np.isfinite(values)]
    if not rest.size >= (1.0 - MARKED) * values.size:
        return False
    return max(float(rest.min()) - end, end - float(rest.max())) > float(np.ptp(rest))


def _standing(run: Segment) -> NDArray[np.bool_]:
    """(n,) readings of a value at which the displacement stands between two jumps, out and back, without one of u."""
    y, u, rows = run.y_um, run.u_V, np.zeros(run.samples, dtype=bool)
    steps, moves = np.diff(y), np.abs(np.diff(u))
    if not steps.any() or not np.isfinite(steps).all():
        return rows
    stroke = float(np.subtract(*np.quantile(y, (0.99, 0.01))))
    least = max(JUMP * float(np.quantile(np.abs(steps[steps != 0.0]), 0.95)), LEAST_JUMP * stroke)
    still_V = JUMP * float(np.quantile(moves, 0.95))
    for start, stop in plateaus(y, STANDING):
        if start > 0 and stop < y.size and moves[max(start - BEFORE, 0) : stop].max() <= still_V:
            out_um, back_um = steps[start - 1], steps[stop - 1]
            rows[start:stop] = min(abs(out_um), abs(back_um)) > least and out_um * back_um < 0.0
    return np.isin(y, y[rows])


def check_values(runs: Sequence[Segment], accept: Collection[str] = ()) -> tuple[str, ...]:
    """Refuse values that no model can be fitted to; return warnings about suspicious values.

    runs: of one file, in order. Refused, in this order: different lengths, NaN or infinity, fewer than 3 samples in a
    run, a constant input or output; exchanged columns and a saturated sensor if certain, else a warning.
    accept: names of refusals that become warnings. Raises RecordError with one line.
    """
    for name in accept:
        if name not in ACCEPTABLE:
            raise RecordError(f"accept: '{name}' is not known; choose from {', '.join(ACCEPTABLE)}")
    for run in runs:
        check_finite(run)
    warnings = []
    for check in (constant, swapped, saturation):
        for name, certain, line in check(runs):
            if certain and name not in accept:
                raise RecordError(f"{line}; if it is sound all the same, --accept {name}")
            warnings.append(line)
        if check is constant and warnings:
            break  # the other checks need channels that move
    return tuple(warnings)


def check_finite(run: Segment) -> None:
    """Refuse channels of different length, with NaN or infinity (naming the first row), or of fewer than 3 samples."""
    for name, values in run.channels():
        finite = np.isfinite(values)
        if not finite.all():
            row = int(np.argmin(finite))
            raise RecordError(
                f"{run.origin.at(row)}: {name} is {values[row]} ({np.count_nonzero(~finite)} such values: nan, null, a "
                "fill value); interpolate them, or cut the record there into segments"
            )
    if run.u_V.size < SHORTEST:
        where = run.origin.at(0) if run.samples else run.origin.source
        raise RecordError(f"{where}: holds a run of {run.samples} samples; record at least {SHORTEST} without a break")


def constant(runs: Sequence[Segment]) -> Iterator[tuple[str, bool, str]]:
    """("constant", True, message) for an input or output that is constant over all runs."""
    first, sensor = runs[0].origin, "check that the sensor is connected and the right column is named"
    for name, channels, cure in (
        (first.voltage, [run.u_V for run in runs], "drive the stage with a signal that moves"),
        (first.displacement, [run.y_um for run in runs], sensor),
    ):
        if min(values.min() for values in channels) == max(values.max() for values in channels):
            samples = sum(values.size for values in channels)
            line = f"{first.source}: {name} is constant at {channels[0][0]:g} in all {samples} samples; {cure}"
            yield "constant", True, line


Series = NDArray[np.float64]

FLAT = 5
"""Consecutive samples at exactly the extreme value that make a flat end."""
STILL = 8
"""Consecutive equal samples that do not occur with noise of half a quantum or more."""
BEFORE = 20
"""Samples before a flat end in which the voltage must not turn or be higher; allows delays up to this length."""
CYCLE = 64
"""Points per cycle of the input for the area of the loop; averaging down to them reduces the noise."""


def saturation(runs: Sequence[Segment]) -> Iterator[tuple[str, bool, str]]:
    """("saturation", certain, message) for a displacement that stays at exactly its extreme value.

    Certain (a saturated sensor) if y is constant for 8 samples and three times longer than at any other value, and
      - the noise of all other samples is absent there, or
      - y reached the value without slowing down while the voltage neither turned nor stopped.
    Likely if only the last condition holds, or if the voltage rises further, beyond its previous maximum, by an amount
    that corresponds (by the record's overall gain) to 4 quanta of the displacement and 0.5 % of its range.
    Plateaus of the input, slow signals within one quantum, stiction, and plays at a turning point thus do not count. A
    clipping amplifier is not mistaken for a saturated sensor: y settles to its value, and the sensor noise remains.
    """
    best: dict[str, _Flat] = {}
    for flat in _flats(runs):
        known = best.get(flat.name)
        if (flat.certain or flat.likely) and (known is None or flat.certain > known.certain):
            best[flat.name] = flat
    for flat in best.values():
        where = f"{flat.run.origin.at(flat.start)}: {flat.run.origin.displacement}"
        stays = f"{where} stays at its {flat.name} value {flat.end_um:.6g} for {flat.stop - flat.start} samples"
        end_of = "the sensor is at its end" if flat.certain else "the sensor or the amplifier may be at its end"
        yield "saturation", flat.certain, f"{stays}: {end_of}; drive less, or widen its range"


def at_end(runs: Sequence[Segment]) -> list[NDArray[np.bool_]]:
    """Flags of each run, (n_i,): samples at exactly an extreme value that `saturation` finds certain."""
    ends_um = {flat.end_um for flat in _flats(runs) if flat.certain}
    return [np.isin(run.y_um, list(ends_um)) for run in runs]


@dataclass(frozen=True)
class _Flat:
    """Samples start .. stop - 1 of a run at exactly its "highest" or "lowest" value, end_um, and their verdict."""

    name: str
    end_um: float
    run: Segment
    start: int
    stop: int
    certain: bool
    likely: bool


def _flats(runs: Sequence[Segment]) -> Iterator[_Flat]:
    """Every flat end of FLAT samples or more, those at the highest value first."""
    values = np.concatenate([run.y_um for run in runs])
    ends = (("highest", float(values.max())), ("lowest", float(values.min())))
    quantum = min(resolution_um(run.y_um) for run in runs)
    span, span_V = ends[0][1] - ends[1][1], float(np.ptp(np.concatenate([run.u_V for run in runs])))
    if span == 0.0 or span_V == 0.0:
        return
    gain = span / span_V
    noisy = max(white_noise(run.y_um) for run in runs) > max(0.5 * quantum, 1e-6 * span)
    # Slow sensors and stiction repeat values that are not extreme.
    inner = [b - a for run in runs for a, b in plateaus(run.y_um, 3) if run.y_um[a] not in (ends[0][1], ends[1][1])]
    still = max(STILL, 3 * max(inner, default=1))
    rising = 1.0 if _correlation(runs) >= 0.0 else -1.0
    for name, end, side in ((*ends[0], rising), (*ends[1], -rising)):
        for run in runs:
            for start, stop in plateaus(run.y_um, FLAT):
                if run.y_um[start] != end:
                    continue
                halted = _runs_into(run, start, stop, quantum)
                certain = stop - start >= still and (noisy or halted)
                likely = halted or _goes_on(side * run.u_V, start, stop, max(4.0 * quantum, 0.005 * span) / gain)
                yield _Flat(name, end, run, start, stop, certain, likely)


def _runs_into(run: Segment, start: int, stop: int, quantum: float) -> bool:
    """Whether y stopped within one sample at `start` after a steady approach, while u moved on in one direction."""
    y, u = run.y_um, run.u_V
    reach = FLAT
    while abs(y[start] - y[max(0, start - reach)]) < 8.0 * quantum and reach < stop - start:
        reach *= 2
    if start < 2 * reach or reach > stop - start:
        return False
    last, earlier = y[start] - y[start - reach], y[start - reach] - y[start - 2 * reach]
    if abs(last) < 8.0 * quantum or abs(last) < 0.5 * abs(earlier):
        return False
    pace = np.diff(u[max(0, start - max(BEFORE, reach)) : start + reach + 1])
    return bool(pace.min() * pace.max() > 0.0)


def _goes_on(towards: Series, start: int, stop: int, movement_V: float) -> bool:
    """Whether, in a flat end, the voltage exceeds its previous maximum (towards this end) by more than `movement_V`."""
    beyond = towards[start:stop] - towards[max(0, start - BEFORE) : start + 1].max()
    return bool(beyond.max() > movement_V and np.count_nonzero(beyond > beyond.max() / 2.0) >= 3)


def swapped(runs: Sequence[Segment]) -> Iterator[tuple[str, bool, str]]:
    """("swapped", certain, message) for a displacement that leads the voltage.

        w = -sum y du / (std(y) sum |du|) > 0  for every passive stage: y lags u, the loop dissipates energy

    Conditions: at least two cycles, nearly all with the wrong sense of rotation, and a correlation of u and y above
    0.7, which excludes signals above a resonance, where the phase is turned over.

    A voltage logged too late gives the same loops. The finding is therefore certain only if the voltage also has the
    noise of a sensor, and the displacement has none.
    """
    first = runs[0].origin
    correlation = _correlation(runs)
    loops = [_loops(run.u_V, run.y_um) for run in runs]
    areas = np.concatenate([area for area, _ in loops])
    path = sum(length for _, length in loops)
    if correlation < 0.7 or areas.size < 2 or areas.sum() > -0.01 * path:
        return
    if -areas[areas < 0.0].sum() < 0.95 * np.abs(areas).sum():
        return
    u_noise = max(white_noise(run.u_V) / _deviation(run.u_V) for run in runs)
    y_noise = max(white_noise(run.y_um) / _deviation(run.y_um) for run in runs)
    time, q = f"time={first.time}," if runs[0].stamps_s.size else "", runs[0].quantities
    units = f"input={q.input} [{q.input_unit}],output={q.output} [{q.output_unit}]"
    yield (
        "swapped",
        u_noise > max(5.0 * y_noise, 1e-6),
        f"{first.source}: {first.displacement} runs ahead of {first.voltage} in {areas.size} cycles; "
        "the two columns seem to be exchanged (or the voltage was logged late): "
        f'--columns "{time}voltage={first.displacement},displacement={first.voltage},'
        f'{units if q.other else "voltage_unit=V,displacement_unit=um"}" reads them so',
    )


def _loops(u: Series, y: Series) -> tuple[Series, float]:
    """-sum y du over each cycle of u, and sum |du| over all cycles; u and y scaled to unit standard deviation."""
    nothing = np.zeros(0), 0.0
    starts = _cycle_starts(u)
    if starts.size < 3:
        return nothing
    block = max(1, int((starts[-1] - starts[0]) / (starts.size - 1) / CYCLE))
    whole = u.size // block * block
    u, y = (values[:whole].reshape(-1, block).mean(axis=1) for values in (u, y))
    starts = _cycle_starts(u)
    if starts.size < 3:
        return nothing
    u, y = ((values - values.mean()) / _deviation(values) for values in (u, y))
    steps = np.diff(u)
    area = np.concatenate([[0.0], np.cumsum(-0.5 * (y[1:] + y[:-1]) * steps)])
    return np.diff(area[starts]), float(np.abs(steps[starts[0] : starts[-1]]).sum())


def _cycle_starts(u: Series) -> NDArray[np.int64]:
    """Samples at which u rises above mid-range + 15 % of its half range after having been below mid-range - 15 %."""
    middle, half = (u.max() + u.min()) / 2.0, (u.max() - u.min()) / 2.0
    outside = np.flatnonzero(np.abs(u - middle) > 0.15 * half)
    above = u[outside] > middle
    return np.asarray(outside[1:][above[1:] & ~above[:-1]], dtype=np.int64)


def _correlation(runs: Sequence[Segment]) -> float:
    """Correlation of voltage and displacement, each run about its own mean; 0 if one of them is constant."""
    uu = yy = uy = 0.0
    for run in runs:
        u, y = run.u_V - run.u_V.mean(), run.y_um - run.y_um.mean()
        uu, yy, uy = uu + float(u @ u), yy + float(y @ y), uy + float(u @ y)
    return uy / (uu * yy) ** 0.5 if uu * yy > 0.0 else 0.0


def _deviation(values: Series) -> float:
    return float(values.std()) or 1.0
